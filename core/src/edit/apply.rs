//! Applying a plan, and taking it back: the steps of the undo record.

use super::{Edit, EditError, Plan};
use crate::hierarchy::{Level, Odd, Slot};
use crate::surface::{Changes, Surface, Vector};

/// An applied edit with what is needed to undo and redo it exactly.
#[derive(Debug, Clone)]
pub struct Step {
    edit: Edit,
    effect: Effect,
    first_pass: Option<Changes>,
}

#[derive(Debug, Clone)]
enum Effect {
    /// Undone by subtracting the same integers.
    Scaling(Level, Vec<(Slot, Vector)>),
    /// Undone by subtracting the same integers.
    Wavelets(Level, Vec<(Odd, Vector)>),
    /// Not additive: holds the coefficients that are *not* in the surface now, to be exchanged.
    Details(Level, Vec<Vector>),
}

impl Step {
    /// Applies a plan to the surface. On refusal the surface is as it was, to the bit.
    ///
    /// # Errors
    /// [`EditError::BeyondLimit`] alone.
    pub fn apply(surface: &mut Surface, edit: Edit, plan: Plan) -> Result<(Self, Changes), EditError> {
        let mut effect = Effect::from(plan);
        let changes = effect.act(surface, Direction::Forwards);
        if changes.beyond_limit {
            effect.act(surface, Direction::Backwards);
            return Err(EditError::BeyondLimit);
        }
        Ok((Self { edit, effect, first_pass: Some(changes.clone()) }, changes))
    }

    /// The step of a stroke that is already in the surface.
    pub(crate) fn applied(edit: Edit, plan: Plan) -> Self {
        Self { edit, effect: plan.into(), first_pass: Some(Changes::default()) }
    }

    /// The edit as it was asked for.
    pub fn edit(&self) -> &Edit {
        &self.edit
    }
}

impl From<Plan> for Effect {
    fn from(plan: Plan) -> Self {
        match plan {
            Plan::Scaling(level, deltas) => Effect::Scaling(level, deltas),
            Plan::Wavelets(level, deltas) => Effect::Wavelets(level, deltas),
            Plan::Details(level, details) => Effect::Details(level, details),
        }
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Direction {
    Forwards,
    Backwards,
}

impl Effect {
    fn act(&mut self, surface: &mut Surface, direction: Direction) -> Changes {
        fn turned<T: Copy>(deltas: &[(T, Vector)], direction: Direction) -> Vec<(T, Vector)> {
            let turn = |v: Vector| if direction == Direction::Forwards { v } else { v.map(|x| -x) };
            deltas.iter().map(|&(at, v)| (at, turn(v))).collect()
        }
        match self {
            Effect::Scaling(level, deltas) => surface.add_scaling(*level, &turned(deltas, direction)),
            Effect::Wavelets(level, deltas) => surface.add_wavelets(*level, &turned(deltas, direction)),
            Effect::Details(level, details) => {
                let (old, changes) = surface.replace_wavelets(*level, std::mem::take(details));
                *details = old;
                changes
            }
        }
    }
}

impl undo::Edit for Step {
    type Target = Surface;
    type Output = Changes;

    /// The first time the edit is already in the surface; afterwards this is a redo.
    fn edit(&mut self, surface: &mut Surface) -> Changes {
        match self.first_pass.take() {
            Some(changes) => changes,
            None => self.effect.act(surface, Direction::Forwards),
        }
    }

    fn undo(&mut self, surface: &mut Surface) -> Changes {
        self.effect.act(surface, Direction::Backwards)
    }
}
