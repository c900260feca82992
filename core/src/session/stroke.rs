//! A drag under way: the surface follows the hand live, one line is logged at the end, and Esc restores every bit.

use super::{Session, SessionError};
use crate::edit::{Edit, EditError, Follow, Kind, Move, Plan, Pull, Pulled, Region, Step, Turned, trial_of};
use crate::hierarchy::Level;
use crate::surface::{Changes, Surface, Vector};

/// What is dragged.
#[derive(Debug, Clone, Copy)]
enum Dragged {
    Move(Move),
    Pull(Pull),
}

impl Dragged {
    fn edit(self, delta: [f64; 3]) -> Edit {
        match self {
            Dragged::Move(edit) => Edit::Move(Move { delta, ..edit }),
            Dragged::Pull(edit) => Edit::Pull(Pull { delta, ..edit }),
        }
    }
}

/// A stroke between its beginning and its end. Its edit is additive, so following the hand means adding the
/// difference between the new integers and those already in the surface. Detail that follows is turned back first, and
/// anew after.
#[derive(Debug, Clone)]
pub(super) struct Stroke {
    dragged: Dragged,
    region: Region,
    follow: Option<Follow>,
    applied: Plan,
    turned: Turned,
    delta: Vector,
    /// The finest level that follows the hand; finer ones wait for the end.
    reach: Level,
    /// The coarsest level of the vertices that it moves.
    home: Level,
}

impl Stroke {
    fn begin(surface: &mut Surface, dragged: Dragged) -> Result<Self, EditError> {
        let (region, follow, home) = match dragged {
            Dragged::Move(edit) => {
                if edit.v != 1 {
                    return Err(EditError::UnknownVersion { version: edit.v });
                }
                let home = match edit.kind {
                    Kind::Scaling => Level(edit.level),
                    Kind::Wavelet => Level(edit.level).finer(),
                };
                (Region::of(surface, &edit)?, None, home)
            }
            Dragged::Pull(edit) => {
                let pulled = Pulled::of(surface, &edit)?;
                let trial = edit.follow.then(|| trial_of(surface, &pulled));
                let follow = trial.map(|trial| Follow::new(surface, Level(edit.level), &trial));
                let home = pulled.level;
                (Region::Pulled(pulled), follow, home)
            }
        };
        let applied = region.moved_by([0; 3]);
        let reach = surface.finest();
        Ok(Self { dragged, region, follow, applied, turned: Vec::new(), delta: [0; 3], reach, home })
    }

    /// Moves the surface from where the stroke has it to `delta`; unchanged if that is refused.
    fn follow(&mut self, surface: &mut Surface, delta: Vector) -> Result<Changes, EditError> {
        let mut changes = self.turn_back(surface);
        let (wanted, before) = (self.region.moved_by(delta), self.delta);
        changes.join(add(surface, &difference(&wanted, &self.applied), self.reach));
        let mut beyond = changes.beyond_limit;
        if !beyond {
            self.applied = wanted;
            self.delta = delta;
            let turned = self.turn(surface);
            beyond = turned.beyond_limit;
            changes.join(turned);
        } else {
            changes.join(add(surface, &difference(&self.applied, &wanted), self.reach));
        }
        if !beyond {
            return Ok(changes);
        }
        // Back to where the stroke was, which was in range.
        self.turn_back(surface);
        let home = self.region.moved_by(before);
        add(surface, &difference(&home, &self.applied), self.reach);
        self.applied = home;
        self.delta = before;
        self.turn(surface);
        Err(EditError::BeyondLimit)
    }

    fn turn(&mut self, surface: &mut Surface) -> Changes {
        let Some(follow) = &self.follow else { return Changes::nothing(surface) };
        if self.delta == [0; 3] {
            return Changes::nothing(surface);
        }
        let (turned, changes) = follow.turn(surface, self.reach);
        self.turned = turned;
        changes
    }

    fn turn_back(&mut self, surface: &mut Surface) -> Changes {
        let mut changes = Changes::nothing(surface);
        let mut back = std::mem::take(&mut self.turned);
        for (_, v) in back.iter_mut().flat_map(|(_, deltas)| deltas) {
            *v = v.map(i32::wrapping_neg);
        }
        changes.join(surface.add_details_up_to(&back, self.reach));
        changes.beyond_limit = false;
        changes
    }

    /// Takes the stroke back and makes it again up to another level.
    fn set_reach(&mut self, surface: &mut Surface, reach: Level) -> Changes {
        let delta = self.delta;
        let mut changes = self.follow(surface, [0; 3]).unwrap_or_default();
        self.reach = reach;
        match self.follow(surface, delta) {
            Ok(made) => changes.join(made),
            // A finer level may leave the range of coordinates where the coarser did not.
            Err(_) => changes.beyond_limit = true,
        }
        changes
    }
}

fn add(surface: &mut Surface, plan: &Plan, reach: Level) -> Changes {
    match plan {
        Plan::Scaling(level, deltas) => surface.add_scaling_up_to(*level, deltas, reach),
        Plan::Wavelets(level, deltas) => surface.add_wavelets_up_to(*level, deltas, reach),
        _ => unreachable!("a stroke is additive"),
    }
}

/// `a − b`, for two plans over the same region.
fn difference(a: &Plan, b: &Plan) -> Plan {
    fn minus<T: Copy>(a: &[(T, Vector)], b: &[(T, Vector)]) -> Vec<(T, Vector)> {
        a.iter().zip(b).map(|(&(at, a), &(_, b))| (at, std::array::from_fn(|c| a[c] - b[c]))).collect()
    }
    match (a, b) {
        (Plan::Scaling(level, a), Plan::Scaling(_, b)) => Plan::Scaling(*level, minus(a, b)),
        (Plan::Wavelets(level, a), Plan::Wavelets(_, b)) => Plan::Wavelets(*level, minus(a, b)),
        _ => unreachable!("both plans come from one region"),
    }
}

impl Session {
    /// Begins a stroke: the edit without its delta. Ends one that is under way.
    ///
    /// # Errors
    /// Unknown level or vertex, or a radius that makes no sense.
    pub fn begin_stroke(&mut self, edit: Move) -> Result<(), SessionError> {
        self.begin(Dragged::Move(edit))
    }

    /// Begins to pull: the edit without its delta. Ends a stroke that is under way. Returns how many mirror images of a
    /// single raw coefficient have no vertex near enough.
    ///
    /// # Errors
    /// Unknown level or vertex, or numbers that make no sense.
    pub fn begin_pull(&mut self, edit: Pull) -> Result<usize, SessionError> {
        self.begin(Dragged::Pull(edit))?;
        Ok(match self.stroke.as_ref().map(|stroke| &stroke.region) {
            Some(Region::Pulled(pulled)) => pulled.without_partner,
            _ => 0,
        })
    }

    fn begin(&mut self, dragged: Dragged) -> Result<(), SessionError> {
        self.end_stroke();
        self.stroke = Some(Stroke::begin(&mut self.model.surface, dragged)?);
        Ok(())
    }

    /// Whether a stroke is under way.
    pub fn in_stroke(&self) -> bool {
        self.stroke.is_some() || self.brush.is_some() || self.equaliser.is_some()
    }

    /// Moves the stroke to a delta in model units, measured from its beginning. Cost: the support.
    ///
    /// # Errors
    /// The delta is not finite or too large; the stroke stays where it was.
    pub fn drag_to(&mut self, delta: [f64; 3]) -> Result<Changes, SessionError> {
        let surface = &mut self.model.surface;
        let steps = surface.form().placement.vector_to_steps(delta).ok_or(EditError::Delta)?;
        match &mut self.stroke {
            Some(stroke) => Ok(stroke.follow(surface, steps)?),
            None => Ok(Changes::default()),
        }
    }

    /// How far the stroke has moved, in model units.
    pub fn stroke_delta(&self) -> Option<[f64; 3]> {
        let placement = &self.model.surface.form().placement;
        self.stroke.as_ref().map(|stroke| placement.vector_to_model(stroke.delta))
    }

    /// The coarsest level whose vertices the stroke moves by itself.
    pub fn stroke_home(&self) -> Option<Level> {
        self.stroke.as_ref().map(|stroke| stroke.home)
    }

    /// Lets only the levels up to `reach` follow the hand until the stroke ends, for surfaces too large to follow whole.
    /// Coarser than the edited coefficients is as coarse as they are. What the other levels show is then old.
    pub fn preview_stroke(&mut self, reach: Level) -> Changes {
        let surface = &mut self.model.surface;
        let Some(stroke) = &mut self.stroke else { return Changes::default() };
        let home = stroke.home;
        stroke.set_reach(surface, reach.clamp(home, surface.finest()))
    }

    /// Ends the stroke: one line, one undo step, all levels up to date. A stroke that moved nothing leaves neither. If
    /// a level that had not followed would leave the range of coordinates, the stroke is taken back instead and the
    /// changes say `beyond_limit`.
    pub fn end_stroke(&mut self) -> Changes {
        if let Some(brush) = self.brush.take() {
            return self.end_brush(brush);
        }
        if let Some(equaliser) = self.equaliser.take() {
            return self.end_equaliser(equaliser);
        }
        let Some(mut stroke) = self.stroke.take() else { return Changes::default() };
        let finest = self.model.surface.finest();
        let changes = if stroke.reach == finest {
            Changes::default()
        } else {
            stroke.set_reach(&mut self.model.surface, finest)
        };
        if stroke.delta == [0; 3] {
            return changes;
        }
        let delta = self.model.surface.form().placement.shortest_decimals(stroke.delta);
        let edit = stroke.dragged.edit(delta);
        self.record_step(Step::applied(edit, stroke.applied, stroke.turned));
        changes
    }

    /// Takes the stroke back, bit for bit.
    pub fn cancel_stroke(&mut self) -> Changes {
        if let Some(brush) = self.brush.take() {
            return brush.cancel(&mut self.model.surface);
        }
        if let Some(equaliser) = self.equaliser.take() {
            return equaliser.cancel(&mut self.model.surface);
        }
        match self.stroke.take() {
            Some(mut stroke) => stroke.follow(&mut self.model.surface, [0; 3]).unwrap_or_default(),
            None => Changes::default(),
        }
    }
}
