//! A drag under way: the surface follows the hand live, one line is logged at the end, and Esc restores every bit.

use super::{Session, SessionError};
use crate::edit::{Edit, EditError, Kind, Move, Plan, Region, Step};
use crate::hierarchy::Level;
use crate::surface::{Changes, Surface, Vector};

/// A stroke between its beginning and its end. Its edit is additive, so following the hand means adding the
/// difference between the new integers and those already in the surface.
#[derive(Debug, Clone)]
pub(super) struct Stroke {
    edit: Move,
    region: Region,
    applied: Plan,
    delta: Vector,
    /// The finest level that follows the hand; finer ones wait for the end.
    reach: Level,
}

impl Stroke {
    fn begin(surface: &Surface, edit: Move) -> Result<Self, EditError> {
        if edit.v != 1 {
            return Err(EditError::UnknownVersion { version: edit.v });
        }
        let region = Region::of(surface, &edit)?;
        Ok(Self { edit, applied: region.moved_by([0; 3]), region, delta: [0; 3], reach: surface.finest() })
    }

    /// Moves the surface from where the stroke has it to `delta`; unchanged if that is refused.
    fn follow(&mut self, surface: &mut Surface, delta: Vector) -> Result<Changes, EditError> {
        let wanted = self.region.moved_by(delta);
        let mut changes = add(surface, &difference(&wanted, &self.applied), self.reach);
        if changes.beyond_limit {
            changes.join(add(surface, &difference(&self.applied, &wanted), self.reach));
            return Err(EditError::BeyondLimit);
        }
        self.applied = wanted;
        self.delta = delta;
        Ok(changes)
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
        Plan::Details(..) => unreachable!("a stroke is additive"),
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
        self.end_stroke();
        self.stroke = Some(Stroke::begin(&self.model.surface, edit)?);
        Ok(())
    }

    /// Whether a stroke is under way.
    pub fn in_stroke(&self) -> bool {
        self.stroke.is_some()
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

    /// Lets only the levels up to `reach` follow the hand until the stroke ends, for surfaces too large to follow whole.
    /// Coarser than the edited coefficients is as coarse as they are. What the other levels show is then old.
    pub fn preview_stroke(&mut self, reach: Level) -> Changes {
        let surface = &mut self.model.surface;
        let Some(stroke) = &mut self.stroke else { return Changes::default() };
        let home = match stroke.edit.kind {
            Kind::Scaling => Level(stroke.edit.level),
            Kind::Wavelet => Level(stroke.edit.level).finer(),
        };
        stroke.set_reach(surface, reach.clamp(home, surface.finest()))
    }

    /// Ends the stroke: one line, one undo step, all levels up to date. A stroke that moved nothing leaves neither. If
    /// a level that had not followed would leave the range of coordinates, the stroke is taken back instead and the
    /// changes say `beyond_limit`.
    pub fn end_stroke(&mut self) -> Changes {
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
        let edit = Edit::Move(Move { delta, ..stroke.edit });
        self.record.edit(&mut self.model.surface, Step::applied(edit, stroke.applied));
        self.committed_edit(edit);
        changes
    }

    /// Takes the stroke back, bit for bit.
    pub fn cancel_stroke(&mut self) -> Changes {
        match self.stroke.take() {
            Some(mut stroke) => stroke.follow(&mut self.model.surface, [0; 3]).unwrap_or_default(),
            None => Changes::default(),
        }
    }
}
