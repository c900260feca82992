//! A drag under way: the surface follows the hand live, one line is logged at the end, and Esc restores every bit.

mod cost;

use super::{Session, SessionError};
use crate::edit::{
    Edit, EditError, Follow, Kind, Move, Pull, Pulled, Region, Step, Turned, added, weighted_steps,
};
use crate::hierarchy::{Level, Slot};
use crate::surface::{Changes, Runs, Surface, Vector};

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
/// difference between the new integers and those already in the surface. What is coarser than dragged scaling coefficients
/// is analysed once, at the end; but where detail follows, which is turned back first and anew after, every time, for
/// some of that detail is coarser than the coefficients which move.
#[derive(Debug, Clone)]
pub(super) struct Stroke {
    dragged: Dragged,
    region: Region,
    /// Of scaling coefficients: the region's slots as runs, and the weights slot by slot.
    runs: Runs,
    weights: Vec<[f64; 3]>,
    /// Scratch space: what the hand's last move added.
    steps: Vec<Vector>,
    follow: Option<Follow>,
    turned: Turned,
    /// Whether the levels coarser than what is dragged have followed the hand at some time.
    coarser: bool,
    delta: Vector,
    /// The finest level that follows the hand; finer ones wait for the end.
    reach: Level,
    /// The coarsest level of the vertices that it moves.
    home: Level,
    /// Mirror images of a single coefficient that have no vertex near enough.
    without_partner: usize,
}

impl Stroke {
    fn begin(surface: &Surface, dragged: Dragged) -> Result<Self, EditError> {
        let (region, follow, home, without_partner) = match dragged {
            Dragged::Move(edit) => {
                let home = match edit.kind {
                    Kind::Scaling => Level(edit.level),
                    Kind::Wavelet => Level(edit.level).finer(),
                };
                let (region, alone) = Region::of(surface, &edit)?;
                (region, None, home, alone)
            }
            Dragged::Pull(edit) => {
                let pulled = Pulled::of(surface, &edit)?;
                let follow = edit.follow.then(|| Follow::new(Level(edit.level), edit.v));
                let home = pulled.level;
                let alone = pulled.without_partner;
                (Region::Pulled(pulled), follow, home, alone)
            }
        };
        let weighted: Vec<(Slot, [f64; 3])> = match &region {
            Region::Scaling(_, region) => region.clone(),
            Region::Pulled(pulled) => pulled.weights.clone(),
            Region::Wavelets(..) => Vec::new(),
        };
        let runs = Runs::of_slots(weighted.iter().map(|(slot, _)| slot.0).collect());
        let weights = weighted.into_iter().map(|(_, weights)| weights).collect();
        let reach = surface.finest();
        let (steps, turned, delta) = Default::default();
        let coarser = false;
        Ok(Self {
            dragged,
            region,
            runs,
            weights,
            steps,
            follow,
            turned,
            coarser,
            delta,
            reach,
            home,
            without_partner,
        })
    }

    /// Moves the surface from where the stroke has it to `delta`; unchanged if that is refused.
    fn follow(&mut self, surface: &mut Surface, delta: Vector) -> Result<Changes, EditError> {
        if self.delta == [0; 3]
            && delta != [0; 3]
            && let (Some(follow), Region::Pulled(pulled)) = (&mut self.follow, &self.region)
        {
            // Where the surface is as before, what will follow is noted.
            follow.note(surface, pulled, self.reach);
        }
        let mut changes = self.turn_back(surface);
        let before = self.delta;
        changes.join(self.add(surface, before, delta));
        let mut beyond = changes.beyond_limit;
        self.delta = delta;
        if !beyond {
            let turned = self.turn(surface);
            beyond = turned.beyond_limit;
            changes.join(turned);
        }
        if !beyond {
            return Ok(changes);
        }
        // Back to where the stroke was, which was in range.
        self.turn_back(surface);
        self.add(surface, delta, before);
        self.delta = before;
        self.turn(surface);
        Err(EditError::BeyondLimit)
    }

    /// Adds what is missing from one delta to another.
    fn add(&mut self, surface: &mut Surface, old: Vector, new: Vector) -> Changes {
        let level = match &self.region {
            Region::Scaling(level, _) => *level,
            Region::Pulled(pulled) if !pulled.details.is_empty() => {
                return surface.add_details_up_to(&pulled.details_between([old, new]), self.reach);
            }
            Region::Pulled(pulled) => pulled.level,
            Region::Wavelets(level, region) => {
                return surface.add_wavelets_up_to(*level, &added(region, [old, new]), self.reach);
            }
        };
        weighted_steps(&self.weights, [old, new], &mut self.steps);
        let mut changes = surface.raise_runs(level, (&self.runs, &self.steps), self.reach);
        if self.follow.is_some() {
            changes.join(surface.settle(level, &self.runs));
        }
        changes
    }

    /// Brings the coarser levels up to date.
    fn settle(&mut self, surface: &mut Surface) -> Changes {
        self.coarser = true;
        match &self.region {
            _ if self.follow.is_some() => Changes::nothing(surface),
            Region::Scaling(level, _) | Region::Pulled(Pulled { level, .. }) => {
                surface.settle(*level, &self.runs)
            }
            Region::Wavelets(..) => Changes::nothing(surface),
        }
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

impl Session {
    /// Begins a stroke: the edit without its delta. Ends one that is under way. Returns how many mirror images have no vertex
    /// near enough.
    ///
    /// # Errors
    /// Unknown level or vertex, or a radius that makes no sense.
    pub fn begin_stroke(&mut self, edit: Move) -> Result<usize, SessionError> {
        self.begin(Dragged::Move(edit))
    }

    /// Begins to pull: the edit without its delta. Ends a stroke that is under way. Returns how many mirror images of a
    /// single raw coefficient have no vertex near enough.
    ///
    /// # Errors
    /// Unknown level or vertex, or numbers that make no sense.
    pub fn begin_pull(&mut self, edit: Pull) -> Result<usize, SessionError> {
        self.begin(Dragged::Pull(edit))
    }

    fn begin(&mut self, dragged: Dragged) -> Result<usize, SessionError> {
        self.end_stroke();
        let stroke = Stroke::begin(&self.model.surface, dragged)?;
        let alone = stroke.without_partner;
        self.stroke = Some(stroke);
        Ok(alone)
    }

    /// Whether a stroke is under way.
    pub fn in_stroke(&self) -> bool {
        self.stroke.is_some() || self.brush.is_some() || self.equaliser.is_some()
    }

    /// Moves the stroke to a delta in model units, measured from its beginning. Levels coarser than dragged scaling
    /// coefficients wait for the stroke's end, unless detail follows. Cost: the support.
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

    /// Brings the levels coarser than what is dragged up to date in the middle of a stroke, for showing one of them. Cost:
    /// what depends on the dragged coefficients.
    pub fn settle_stroke(&mut self) -> Changes {
        let surface = &mut self.model.surface;
        self.stroke.as_mut().map_or_else(Changes::default, |stroke| stroke.settle(surface))
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

    /// The finest level that can follow the stroke under way as fast as the hand: a step moves no more vertices than
    /// 2^18, or 2^14 where detail follows too. Not coarser than [`Session::stroke_home`], however many that moves. The
    /// same stroke on the same hierarchy has the same answer everywhere. For [`Session::preview_stroke`].
    pub fn affordable_reach(&self) -> Option<Level> {
        self.stroke.as_ref().map(|stroke| stroke.affordable(&self.model.surface))
    }

    /// Whether ending the stroke under way is felt, because levels that waited are many vertices: more than 2^18, some 20 ms, or
    /// 2^16 where detail follows too, some 100 ms.
    pub fn ends_slowly(&self) -> bool {
        self.stroke.as_ref().is_some_and(|stroke| stroke.ends_slowly(&self.model.surface))
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
        if self.glimpse.is_some() {
            return self.end_glimpse();
        }
        if let Some(brush) = self.brush.take() {
            return self.end_brush(brush);
        }
        if let Some(equaliser) = self.equaliser.take() {
            return self.end_equaliser(equaliser);
        }
        let Some(mut stroke) = self.stroke.take() else { return Changes::default() };
        let surface = &mut self.model.surface;
        let finest = surface.finest();
        let mut changes =
            if stroke.reach == finest { Changes::default() } else { stroke.set_reach(surface, finest) };
        if stroke.delta == [0; 3] {
            return changes;
        }
        changes.join(stroke.settle(surface));
        if changes.beyond_limit {
            changes.join(stroke.follow(surface, [0; 3]).unwrap_or_default());
            changes.join(stroke.settle(surface));
            changes.beyond_limit = true;
            return changes;
        }
        let delta = surface.form().placement.shortest_decimals(stroke.delta);
        let edit = stroke.dragged.edit(delta);
        self.record_step(Step::applied(edit, stroke.region.moved_by(stroke.delta), stroke.turned));
        changes
    }

    /// Takes the stroke back, bit for bit.
    pub fn cancel_stroke(&mut self) -> Changes {
        if self.glimpse.is_some() {
            return self.end_glimpse();
        }
        if let Some(brush) = self.brush.take() {
            return brush.cancel(&mut self.model.surface);
        }
        if let Some(equaliser) = self.equaliser.take() {
            return equaliser.cancel(&mut self.model.surface);
        }
        let Some(mut stroke) = self.stroke.take() else { return Changes::default() };
        let surface = &mut self.model.surface;
        let mut changes = stroke.follow(surface, [0; 3]).unwrap_or_default();
        if stroke.coarser {
            changes.join(stroke.settle(surface));
        }
        changes
    }
}
