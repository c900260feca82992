//! Applying a plan, and taking it back: the steps of the undo record.

use super::{BrushStroke, Dab, Deltas, Edit, EditError, Follow, MaskChange, Packed, Plan, Pulled, Turned};
use crate::hierarchy::{Level, Odd, Slot};
use crate::surface::{Changes, Moved, Runs, Surface, Vector};

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
    /// Undone by subtracting the same integers; of the mask, by the values before.
    Packed(Packed),
}

impl Step {
    /// Applies a plan to the surface. On refusal the surface is as it was, to the bit.
    ///
    /// # Errors
    /// [`EditError::BeyondLimit`] alone.
    pub fn apply(surface: &mut Surface, edit: Edit, plan: Plan) -> Result<(Self, Changes), EditError> {
        if let Plan::Stroke(stroke, dabs) = plan {
            return Self::brush(surface, *stroke, dabs);
        }
        if let Plan::Follow(level, pulled, delta) = plan {
            return Self::pull(surface, edit, level, &pulled, delta);
        }
        let mut effect = Effect::from(plan);
        let changes = effect.act(surface, Direction::Forwards);
        if changes.beyond_limit {
            effect.act(surface, Direction::Backwards);
            return Err(EditError::BeyondLimit);
        }
        Ok((Self { edit, effect, first_pass: Some(changes.clone()) }, changes))
    }

    /// The step of a stroke that is already in the surface, with the details that followed it.
    pub(crate) fn applied(edit: Edit, plan: Plan, turned: Turned) -> Self {
        let effect = match plan {
            Plan::Scaling(level, scaling) if !turned.is_empty() || scaling.len() > WORTH_PACKING => {
                Effect::Packed(Packed::new(
                    &Deltas { scaling: Some((level, scaling)), wavelets: turned },
                    &[],
                ))
            }
            plan => plan.into(),
        };
        Self { edit, effect, first_pass: Some(Changes::default()) }
    }

    fn pull(
        surface: &mut Surface,
        edit: Edit,
        level: Level,
        pulled: &Pulled,
        delta: Vector,
    ) -> Result<(Self, Changes), EditError> {
        let trial = trial_of(surface, pulled);
        let follow = Follow::new(surface, level, &trial);
        let scaling = pulled.moved_by(delta);
        let mut changes = surface.add_scaling(pulled.level, &scaling);
        let mut wavelets = Vec::new();
        if !changes.beyond_limit && delta != [0; 3] {
            let (turned, turning) = follow.turn(surface, surface.finest());
            changes.join(turning);
            wavelets = turned;
        }
        let packed = Packed::new(&Deltas { scaling: Some((pulled.level, scaling)), wavelets }, &[]);
        if changes.beyond_limit {
            act_packed(surface, &packed, Direction::Backwards);
            return Err(EditError::BeyondLimit);
        }
        Ok((Self { edit, effect: Effect::Packed(packed), first_pass: Some(changes.clone()) }, changes))
    }

    /// The step of a brush stroke that is already in the surface.
    pub(super) fn brushed(edit: Edit, deltas: Deltas, mask: Vec<MaskChange>) -> Self {
        let effect = Effect::Packed(Packed::new(&deltas, &mask));
        Self { edit, effect, first_pass: Some(Changes::default()) }
    }

    fn brush(
        surface: &mut Surface,
        mut stroke: BrushStroke,
        dabs: Vec<Dab>,
    ) -> Result<(Self, Changes), EditError> {
        let mut changes = Changes::nothing(surface);
        for dab in dabs {
            match stroke.dab(surface, dab) {
                Ok(touched) => changes.join(touched),
                Err(error) => {
                    stroke.cancel(surface);
                    return Err(error);
                }
            }
        }
        let (mut step, settled) = stroke.finish(surface)?;
        changes.join(settled);
        step.first_pass = Some(changes.clone());
        Ok((step, changes))
    }

    /// What the step keeps in a packed form, if it does.
    pub fn packed(&self) -> Option<&Packed> {
        match &self.effect {
            Effect::Packed(packed) => Some(packed),
            _ => None,
        }
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
            Plan::Follow(..) | Plan::Stroke(..) => unreachable!("these make their own steps"),
        }
    }
}

/// What a pull may move: the changes of a trial, taken back again.
pub fn trial_of(surface: &mut Surface, pulled: &Pulled) -> Changes {
    let mut there = pulled.moved_by([TRIAL; 3]);
    let changes = surface.add_scaling(pulled.level, &there);
    there.iter_mut().for_each(|(_, delta)| *delta = delta.map(i32::wrapping_neg));
    surface.add_scaling(pulled.level, &there);
    changes
}

/// Steps of a trial: far enough that no weight that matters rounds to nothing.
const TRIAL: i32 = 1 << 22;
/// Steps with more coefficients are kept packed.
const WORTH_PACKING: usize = 256;

#[derive(Clone, Copy, PartialEq)]
enum Direction {
    Forwards,
    Backwards,
}

impl Effect {
    fn act(&mut self, surface: &mut Surface, direction: Direction) -> Changes {
        match self {
            Effect::Scaling(level, deltas) => surface.add_scaling(*level, &turned(deltas, direction)),
            Effect::Wavelets(level, deltas) => surface.add_wavelets(*level, &turned(deltas, direction)),
            Effect::Packed(packed) => act_packed(surface, packed, direction),
            Effect::Details(level, details) => {
                let (old, changes) = surface.replace_wavelets(*level, std::mem::take(details));
                *details = old;
                changes
            }
        }
    }
}

fn turned<T: Copy>(deltas: &[(T, Vector)], direction: Direction) -> Vec<(T, Vector)> {
    let turn = |v: Vector| if direction == Direction::Forwards { v } else { v.map(i32::wrapping_neg) };
    deltas.iter().map(|&(at, v)| (at, turn(v))).collect()
}

/// Scaling coefficients first, then wavelets from coarse to fine; backwards the other way round.
fn act_packed(surface: &mut Surface, packed: &Packed, direction: Direction) -> Changes {
    let (deltas, mask) = packed.unpack().expect("what was kept of a step can be read");
    let mut changes = Changes::nothing(surface);
    let add_scaling = |surface: &mut Surface, changes: &mut Changes| {
        if let Some((level, deltas)) = &deltas.scaling {
            changes.join(surface.add_scaling(*level, &turned(deltas, direction)));
        }
    };
    let add_wavelets = |surface: &mut Surface, changes: &mut Changes, at: usize| {
        let (level, deltas) = &deltas.wavelets[at];
        changes.join(surface.add_wavelets(*level, &turned(deltas, direction)));
    };
    let count = deltas.wavelets.len();
    match direction {
        Direction::Forwards => {
            add_scaling(surface, &mut changes);
            (0..count).for_each(|at| add_wavelets(surface, &mut changes, at));
        }
        Direction::Backwards => {
            (0..count).rev().for_each(|at| add_wavelets(surface, &mut changes, at));
            add_scaling(surface, &mut changes);
        }
    }
    let len = surface.scaling(surface.finest()).len();
    for &(slot, before, after) in &mask {
        let value = if direction == Direction::Forwards { after } else { before };
        surface.mask_mut().put(slot, value, len);
    }
    if !mask.is_empty() {
        changes.masked = Moved::Some(Runs::of_slots(mask.iter().map(|(slot, ..)| slot.0).collect()));
    }
    changes
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
