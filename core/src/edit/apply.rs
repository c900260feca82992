//! Applying a plan, and taking it back: the steps of the undo record.

use super::equalise::differences;
use super::extent;
use super::levels::{Before, reshaped};
use super::{BrushStroke, Dab, Deltas, Edit, EditError, Follow, MaskChange, Packed, Plan, Pulled, Turned};
use crate::hierarchy::{Level, Odd, Slot};
use crate::surface::{Changes, Moved, Runs, Surface, Vector};

/// How many coefficients of which levels a step changes.
#[derive(Debug, Clone)]
pub(super) struct Sizes {
    pub(super) scaling: Option<(Level, usize)>,
    pub(super) wavelets: Vec<(Level, usize)>,
}

/// An applied edit with what is needed to undo and redo it exactly.
#[derive(Debug, Clone)]
pub struct Step {
    /// The edit for people; its words are packed.
    title: String,
    /// Undone by subtracting the same integers; of the mask, by the values before.
    packed: Packed,
    pub(super) sizes: Sizes,
    /// For a change of levels: undone first, redone instead of what is packed.
    levels: Option<Before>,
    first_pass: Option<Changes>,
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
        if let Plan::Follow(follow, pulled, delta) = plan {
            return Self::pull(surface, edit, follow, &pulled, delta);
        }
        if let Plan::Levels(reshaped) = plan {
            return Ok(Self::reshape(surface, edit, *reshaped));
        }
        let deltas = deltas_of(surface, plan);
        let changes = act(surface, &deltas, &[], Direction::Forwards);
        if changes.beyond_limit {
            act(surface, &deltas, &[], Direction::Backwards);
            return Err(EditError::BeyondLimit);
        }
        Ok((Self::new(&edit, &deltas, &[], changes.clone()), changes))
    }

    fn new(edit: &Edit, deltas: &Deltas, mask: &[MaskChange], first_pass: Changes) -> Self {
        let words = serde_json::to_vec(edit).expect("edits are plain data");
        let packed = Packed::new(&words, deltas, mask);
        let scaling = deltas.scaling.as_ref().map(|(level, of_level)| (*level, of_level.len()));
        let wavelets = deltas.wavelets.iter().map(|(level, of_level)| (*level, of_level.len())).collect();
        let sizes = Sizes { scaling, wavelets };
        Self { title: edit.to_string(), packed, sizes, levels: None, first_pass: Some(first_pass) }
    }

    fn reshape(surface: &mut Surface, edit: Edit, reshaped: Surface) -> (Self, Changes) {
        let Edit::Levels(words) = edit else { unreachable!("only these have such a plan") };
        let before = Before { edit: words, hierarchy: surface.hierarchy().clone() };
        let old = std::mem::replace(surface, reshaped);
        // What is lost on the way there and back.
        let back = before.restored(surface);
        let all = (0..old.finest().0).map(|j| (Level(j), back.wavelets(Level(j))));
        let wavelets = differences(all, |level| old.wavelets(level));
        let (mut mask, mut hidden) = (Vec::new(), Vec::new());
        for slot in (0..old.scaling(old.finest()).len() as u32).map(Slot) {
            let [now, then] = [&back, &old].map(|s| s.mask().value(slot));
            if now != then {
                mask.push((slot, then, now));
            }
            if back.mask().is_hidden(slot) != old.mask().is_hidden(slot) {
                hidden.push(slot);
            }
        }
        let changes = reshaped_changes(surface);
        let deltas = Deltas { scaling: None, wavelets: negated(wavelets), hidden };
        let edit = Edit::Levels(words);
        let step = Self { levels: Some(before), ..Self::new(&edit, &deltas, &mask, changes.clone()) };
        (step, changes)
    }

    /// The step of a stroke that is already in the surface, with the details that followed it.
    pub(crate) fn applied(edit: Edit, plan: Plan, turned: Turned) -> Self {
        let mut deltas = deltas_of_additive(plan);
        add_turned(&mut deltas, turned);
        Self::new(&edit, &deltas, &[], Changes::default())
    }

    fn pull(
        surface: &mut Surface,
        edit: Edit,
        mut follow: Follow,
        pulled: &Pulled,
        delta: Vector,
    ) -> Result<(Self, Changes), EditError> {
        let finest = surface.finest();
        follow.note(surface, pulled, finest);
        let mut deltas = pulled.deltas(delta);
        let mut changes = add_up_to(surface, &deltas, finest, Direction::Forwards, Settling::Coarser);
        if !changes.beyond_limit && delta != [0; 3] {
            let (turned, turning) = follow.turn(surface, finest);
            changes.join(turning);
            add_turned(&mut deltas, turned);
        }
        if changes.beyond_limit {
            act(surface, &deltas, &[], Direction::Backwards);
            return Err(EditError::BeyondLimit);
        }
        Ok((Self::new(&edit, &deltas, &[], changes.clone()), changes))
    }

    /// The step of a brush stroke that is already in the surface.
    pub(super) fn brushed(edit: Edit, deltas: Deltas, mask: Vec<MaskChange>) -> Self {
        Self::new(&edit, &deltas, &mask, Changes::default())
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

    /// What the step keeps to undo and redo.
    pub fn packed(&self) -> &Packed {
        &self.packed
    }

    /// The edit in a few words.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// The edit as it was asked for.
    ///
    /// # Errors
    /// It was moved out of memory and cannot be read.
    pub fn edit(&self) -> std::io::Result<Edit> {
        Ok(serde_json::from_slice(&self.packed.words()?)?)
    }

    /// About how many finest vertices move when it is undone or redone; no more than there are.
    pub fn moves(&self, surface: &Surface) -> u64 {
        let finest = surface.finest();
        let all = surface.scaling(finest).len() as u64;
        if self.levels.is_some() {
            return all;
        }
        let Sizes { scaling, wavelets } = &self.sizes;
        let hats =
            scaling.iter().map(|&(level, count)| extent::of_hats(surface, level, count as u64, finest));
        let details =
            wavelets.iter().map(|&(level, count)| extent::of_wavelets(surface, level, count as u64, finest));
        hats.chain(details).fold(0, u64::saturating_add).min(all)
    }

    /// Whether it changed the levels there are.
    pub fn reshapes(&self) -> bool {
        self.levels.is_some()
    }
}

/// What a plan adds to the surface as it is.
fn deltas_of(surface: &Surface, plan: Plan) -> Deltas {
    match plan {
        Plan::Details(blocks) => {
            let now = blocks.iter().map(|&(level, _)| (level, surface.wavelets(level)));
            let new = |level: Level| {
                let of_level = blocks.iter().find(|(l, _)| *l == level);
                &of_level.expect("one of the plan's levels").1[..]
            };
            Deltas { wavelets: differences(now, new), ..Deltas::default() }
        }
        Plan::Hidden(hidden) => Deltas { hidden, ..Deltas::default() },
        plan => deltas_of_additive(plan),
    }
}

/// Joins what followed, coarse to fine.
fn add_turned(deltas: &mut Deltas, turned: Turned) {
    deltas.wavelets.extend(turned);
    deltas.wavelets.sort_by_key(|&(level, _)| level);
}

fn deltas_of_additive(plan: Plan) -> Deltas {
    let mut deltas = Deltas::default();
    match plan {
        Plan::Pulled(of_pull) => deltas = of_pull,
        Plan::Scaling(level, mut of_level) => {
            of_level.sort_unstable_by_key(|&(slot, _)| slot);
            deltas.scaling = Some((level, of_level));
        }
        Plan::Wavelets(level, mut of_level) => {
            of_level.sort_unstable_by_key(|&(odd, _)| odd);
            deltas.wavelets.push((level, of_level));
        }
        _ => unreachable!("these make their own steps"),
    }
    deltas
}

/// Changes after which nothing known of the surface holds.
fn reshaped_changes(surface: &Surface) -> Changes {
    Changes { reshaped: true, hidden: true, masked: Moved::Everything, ..Changes::all(surface) }
}

/// What a pull may move up to a level: the changes of a trial, taken back again.
pub(super) fn trial_of(surface: &mut Surface, pulled: &Pulled, reach: Level) -> Changes {
    let mut there = pulled.deltas([TRIAL; 3]);
    let mut add = |deltas: &Deltas| {
        let mut changes = Changes::nothing(surface);
        if let Some((level, scaling)) = &deltas.scaling {
            changes.join(surface.add_scaling_up_to(*level, scaling, reach));
        }
        // Level by level, so that no more is said to move than does.
        for (level, details) in &deltas.wavelets {
            changes.join(surface.add_wavelets_up_to(*level, details, reach));
        }
        changes
    };
    let changes = add(&there);
    let scaling = there.scaling.iter_mut().flat_map(|(_, deltas)| deltas.iter_mut().map(|(_, v)| v));
    let details = there.wavelets.iter_mut().flat_map(|(_, deltas)| deltas.iter_mut().map(|(_, v)| v));
    scaling.chain(details).for_each(|v| *v = v.map(i32::wrapping_neg));
    add(&there);
    changes
}

/// Steps of a trial: far enough that no weight that matters rounds to nothing.
const TRIAL: i32 = 1 << 22;

/// Which way a step is gone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Direction {
    /// As it was made, and redone.
    Forwards,
    /// Undone.
    Backwards,
}

fn turned<T: Copy>(deltas: &[(T, Vector)], direction: Direction) -> Vec<(T, Vector)> {
    let turn = |v: Vector| if direction == Direction::Forwards { v } else { v.map(i32::wrapping_neg) };
    deltas.iter().map(|&(at, v)| (at, turn(v))).collect()
}

fn negated(deltas: Vec<(Level, Vec<(Odd, Vector)>)>) -> Vec<(Level, Vec<(Odd, Vector)>)> {
    deltas.into_iter().map(|(level, d)| (level, turned(&d, Direction::Backwards))).collect()
}

/// Which levels coarser than scaling coefficients follow them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Settling {
    /// None: they are read again only when the coefficients are back.
    Nothing,
    /// All.
    Coarser,
}

/// Scaling coefficients first, then wavelets from coarse to fine; backwards the other way round. Levels finer than `reach`
/// stay as they are.
pub(super) fn add_up_to(
    surface: &mut Surface,
    deltas: &Deltas,
    reach: Level,
    direction: Direction,
    settling: Settling,
) -> Changes {
    let mut changes = Changes::nothing(surface);
    let add_scaling = |surface: &mut Surface, changes: &mut Changes| {
        if let Some((level, deltas)) = &deltas.scaling {
            let deltas = turned(deltas, direction);
            changes.join(match settling {
                Settling::Nothing => surface.raise_up_to(*level, &deltas, reach),
                Settling::Coarser => surface.add_scaling_up_to(*level, &deltas, reach),
            });
        }
    };
    match direction {
        Direction::Forwards => {
            add_scaling(surface, &mut changes);
            changes.join(surface.add_details_up_to(&deltas.wavelets, reach));
        }
        Direction::Backwards => {
            changes.join(surface.add_details_up_to(&negated(deltas.wavelets.clone()), reach));
            add_scaling(surface, &mut changes);
        }
    }
    changes
}

/// All that a step does, or takes back.
fn act(surface: &mut Surface, deltas: &Deltas, mask: &[MaskChange], direction: Direction) -> Changes {
    let mut changes = add_up_to(surface, deltas, surface.finest(), direction, Settling::Coarser);
    let len = surface.scaling(surface.finest()).len();
    for &(slot, before, after) in mask {
        let value = if direction == Direction::Forwards { after } else { before };
        surface.mask_mut().put(slot, value, len);
    }
    if !mask.is_empty() {
        changes.masked = Moved::Some(Runs::of_slots(mask.iter().map(|(slot, ..)| slot.0).collect()));
    }
    deltas.hidden.iter().for_each(|&slot| surface.mask_mut().flip_hidden(slot, len));
    changes.hidden = !deltas.hidden.is_empty();
    changes
}

impl Step {
    fn act(&self, surface: &mut Surface, direction: Direction) -> Changes {
        match (&self.levels, direction) {
            (Some(before), Direction::Forwards) => {
                *surface = reshaped(surface, &before.edit).expect("it was possible before");
                return reshaped_changes(surface);
            }
            (Some(before), Direction::Backwards) => *surface = before.restored(surface),
            (None, _) => {}
        }
        let (deltas, mask) = self.packed.unpack().expect("what was kept of a step can be read");
        let changes = act(surface, &deltas, &mask, direction);
        if self.levels.is_some() { reshaped_changes(surface) } else { changes }
    }
}

impl undo::Edit for Step {
    type Target = Surface;
    type Output = Changes;

    /// The first time the edit is already in the surface; afterwards this is a redo.
    fn edit(&mut self, surface: &mut Surface) -> Changes {
        match self.first_pass.take() {
            Some(changes) => changes,
            None => self.act(surface, Direction::Forwards),
        }
    }

    fn undo(&mut self, surface: &mut Surface) -> Changes {
        self.act(surface, Direction::Backwards)
    }
}
