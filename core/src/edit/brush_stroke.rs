//! A brush stroke under way: dab after dab onto the surface, one step of the history at its end.
//!
//! A dab is planned from the surface as the dabs before have left it, applied, and taken back if it leaves the range of
//! coordinates. What the stroke has changed is known from the values it met first, so that it can be cancelled, and
//! undone, bit for bit.

use super::brushes::{Plane, displacement};
use super::copying::copied;
use super::details::{brushed, smooth_detail};
use super::plan::{EditError, existing_level};
use super::reach::{Steps, Touched, plus, steps, times, touched};
use super::stroke::{Dab, MOST_DABS, Stroke, Tool};
use super::vocabulary::{Falloff, Kind};
use super::{Deltas, Edit, Step};
use crate::hierarchy::{Address, Layout, Level, Odd, Slot};
use crate::surface::{Changes, LIMIT, Marks, Moved, Runs, Surface, Vector};
use rustc_hash::FxHashMap;

/// A stroke under way.
#[derive(Debug, Clone)]
pub struct BrushStroke {
    words: Stroke,
    /// The level whose vertices move; for detail the coarsest level of wavelets.
    level: Level,
    /// The finest level of the wavelets that change.
    to: Level,
    vertices: Met<Slot>,
    wavelets: Vec<Met<Odd>>,
    mask: Vec<(Slot, u8)>,
    mask_met: Marks,
    marks: Marks,
}

/// What a stroke has met of a kind, with the values from before.
#[derive(Debug, Clone)]
struct Met<T> {
    seen: Vec<u64>,
    before: Vec<(T, Vector)>,
}

impl<T> Default for Met<T> {
    fn default() -> Self {
        Self { seen: Vec::new(), before: Vec::new() }
    }
}

impl<T> Met<T> {
    fn note(&mut self, at: u32, len: u32, what: T, value: Vector) {
        if self.seen.is_empty() {
            self.seen.resize(len.div_ceil(64) as usize, 0);
        }
        let (word, bit) = (&mut self.seen[at as usize / 64], 1u64 << (at % 64));
        if *word & bit == 0 {
            *word |= bit;
            self.before.push((what, value));
        }
    }
}

fn difference(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|c| a[c].wrapping_sub(b[c]))
}

fn negated<T: Copy>(deltas: &[(T, Vector)]) -> Vec<(T, Vector)> {
    deltas.iter().map(|&(at, v)| (at, v.map(i32::wrapping_neg))).collect()
}

fn rounded(v: Steps) -> Option<Vector> {
    let v = v.map(f64::round);
    v.iter().all(|x| x.abs() <= f64::from(LIMIT)).then(|| v.map(|x| x as i32))
}

impl BrushStroke {
    /// A stroke that has not touched yet; dabs among the words are left to [`BrushStroke::dab`].
    ///
    /// # Errors
    /// Numbers that mean nothing, an unknown level or version.
    pub fn begin(surface: &Surface, words: Stroke) -> Result<Self, EditError> {
        if !(1..=words.tool.latest_version()).contains(&words.v) {
            return Err(EditError::UnknownVersion { version: words.v });
        }
        if !words.is_sensible() {
            return Err(EditError::Stroke);
        }
        let level = existing_level(surface, Kind::Scaling, words.level)?;
        let finest = surface.finest();
        let (mut level, mut to) = (level, finest);
        if words.tool.acts_on_detail() {
            if finest == Level::BASE {
                return Err(EditError::NoWavelets);
            }
            // The finest level has no wavelets of its own: its brushes take those that lead to it.
            level = level.min(Level(finest.0 - 1));
            to = Level(finest.0 - 1);
            if let Some(wanted) = words.to {
                to = existing_level(surface, Kind::Wavelet, wanted)?.max(level);
            }
        }
        if words.tool == Tool::Copy && words.from.is_none() {
            return Err(EditError::NoSource);
        }
        let words = Stroke { dabs: Vec::new(), ..words };
        Ok(Self {
            words,
            level,
            to,
            vertices: Met::default(),
            wavelets: vec![Met::default(); usize::from(to.0 + 1)],
            mask: Vec::new(),
            mask_met: Marks::default(),
            marks: Marks::default(),
        })
    }

    /// The words so far.
    pub fn words(&self) -> &Stroke {
        &self.words
    }

    /// Whether another dab fits.
    pub fn has_room(&self) -> bool {
        self.words.dabs.len() < MOST_DABS
    }

    /// Touches the surface. Cost: what the brush reaches, on all levels that follow.
    ///
    /// # Errors
    /// A dab that means nothing, one too many, or one that would leave the range of coordinates; nothing has changed.
    pub fn dab(&mut self, surface: &mut Surface, dab: Dab) -> Result<Changes, EditError> {
        self.words.dabs.push(dab);
        let changes =
            if self.words.is_sensible() { self.touch(surface, dab) } else { Err(EditError::Stroke) };
        if changes.is_err() {
            self.words.dabs.pop();
        }
        changes
    }

    fn touch(&mut self, surface: &mut Surface, dab: Dab) -> Result<Changes, EditError> {
        let placement = &surface.form().placement;
        let radius = self.words.radius * dab.size / placement.step;
        let strength = self.words.strength * dab.strength;
        let images: Vec<(Address, Steps)> = self
            .words
            .mirror
            .unwrap_or_default()
            .images(dab.at)
            .into_iter()
            .map(|(point, signs)| {
                let at = std::array::from_fn(|c| (point[c] - placement.origin[c]) / placement.step);
                (surface.nearest(at).address, signs)
            })
            .collect();
        match self.words.tool {
            Tool::Smooth | Tool::Sharpen | Tool::Erase => {
                self.touch_detail(surface, &images, radius, strength)
            }
            Tool::Mask => Ok(self.touch_mask(surface, &images, radius, strength)),
            _ => self.touch_vertices(surface, &images, radius, strength),
        }
    }

    fn falloff(&self) -> Falloff {
        self.words.falloff.unwrap_or_default()
    }

    // ---- brushes that move vertices -----------------------------------------------------------------------

    /// The level whose vertices move: copied detail is finer than the level, so it goes to the finest.
    pub fn moving_level(&self, surface: &Surface) -> Level {
        if self.words.tool == Tool::Copy { surface.finest() } else { self.level }
    }

    fn touch_vertices(
        &mut self,
        surface: &mut Surface,
        images: &[(Address, Steps)],
        radius: f64,
        strength: f64,
    ) -> Result<Changes, EditError> {
        let level = self.moving_level(surface);
        let falloff = self.falloff();
        let tool = self.words.tool;
        let mut moved: Vec<(Slot, f64, Steps)> = Vec::new();
        for &(address, signs) in images {
            let region = touched(surface, level, address, radius, falloff, &mut self.marks);
            if tool == Tool::Copy {
                let offset = self.source_offset(surface, signs);
                let ways = copied(surface, self.level, self.words.v, &region, (address, offset));
                let share = strength.clamp(-1.0, 1.0);
                moved.extend(region.iter().zip(ways).map(|(t, way)| (t.slot, t.weight, times(way, share))));
                continue;
            }
            let plane = Plane::under(surface, level, &region);
            moved.extend(region.iter().map(|t| {
                (t.slot, t.weight, displacement(surface, level, tool, &plane, t, (radius, strength)))
            }));
        }
        let deltas = joined_images(surface, level, moved, images.len() > 1)?;
        let layout_len = surface.hierarchy().layout(level).len();
        for &(slot, _) in &deltas {
            self.vertices.note(slot.0, layout_len, slot, surface.scaling(level)[slot.index()]);
        }
        let mut changes = surface.raise(level, &deltas);
        if changes.beyond_limit {
            changes.join(surface.raise(level, &negated(&deltas)));
            return Err(EditError::BeyondLimit);
        }
        Ok(changes)
    }

    /// From the first dab to where its detail comes from, in steps.
    fn source_offset(&self, surface: &Surface, signs: Steps) -> Steps {
        let (Some(from), Some(first)) = (self.words.from, self.words.dabs.first()) else { return [0.0; 3] };
        let step = surface.form().placement.step;
        std::array::from_fn(|c| (from[c] - first.at[c]) / step * signs[c])
    }

    // ---- brushes that change detail -----------------------------------------------------------------------

    fn touch_detail(
        &mut self,
        surface: &mut Surface,
        images: &[(Address, Steps)],
        radius: f64,
        strength: f64,
    ) -> Result<Changes, EditError> {
        let mut changes = Changes::default();
        let mut made: Vec<(Level, Vec<(Odd, Vector)>)> = Vec::new();
        for level in (self.level.0..=self.to.0).map(Level) {
            let planned = self.plan_detail(surface, level, images, radius, strength);
            let beyond = match planned {
                Ok(deltas) => {
                    let step = surface.add_wavelets(level, &deltas);
                    made.push((level, deltas));
                    let beyond = step.beyond_limit;
                    changes.join(step);
                    beyond
                }
                Err(_) => true,
            };
            if beyond {
                for (level, deltas) in made.iter().rev() {
                    surface.add_wavelets(*level, &negated(deltas));
                }
                return Err(EditError::BeyondLimit);
            }
        }
        for (level, deltas) in made {
            let len = surface.hierarchy().layout(level).odd_len();
            for (odd, delta) in deltas {
                let before = difference(surface.wavelets(level)[odd.index()], delta);
                self.wavelets[level.index()].note(odd.0, len, odd, before);
            }
        }
        Ok(changes)
    }

    fn plan_detail(
        &mut self,
        surface: &Surface,
        level: Level,
        images: &[(Address, Steps)],
        radius: f64,
        strength: f64,
    ) -> Result<Vec<(Odd, Vector)>, EditError> {
        let hierarchy = surface.hierarchy();
        let (coarse, fine) = (hierarchy.layout(level), hierarchy.layout(level.finer()));
        let mut reached: Vec<(Odd, Touched)> = Vec::new();
        for &(address, _) in images {
            let region = touched(surface, level.finer(), address, radius, self.falloff(), &mut self.marks);
            let odd = |t: &Touched| Layout::coarsen(t.site).is_none().then(|| (coarse.odd_at(t.site), *t));
            reached.extend(region.iter().filter_map(odd));
        }
        if images.len() > 1 {
            // The image that reaches furthest counts.
            reached
                .sort_unstable_by(|a, b| (a.0, b.1.weight).partial_cmp(&(b.0, a.1.weight)).expect("finite"));
            reached.dedup_by_key(|(odd, _)| *odd);
        }
        let (tool, positions) = (self.words.tool, surface.scaling(level));
        let (tool, strength) = match tool {
            Tool::Smooth if strength < 0.0 => (Tool::Sharpen, -strength),
            Tool::Sharpen if strength < 0.0 => (Tool::Smooth, -strength),
            _ => (tool, strength),
        };
        let mut deltas = Vec::with_capacity(reached.len());
        for (odd, t) in reached {
            let amount = strength * t.weight.min(1.0) * surface.freedom(level.finer(), fine.slot(t.site));
            let before = surface.wavelets(level)[odd.index()];
            let smooth =
                if tool == Tool::Erase { [0.0; 3] } else { smooth_detail(coarse, positions, t.site) };
            let after =
                rounded(brushed(tool, steps(before), smooth, amount)).ok_or(EditError::BeyondLimit)?;
            deltas.push((odd, difference(after, before)));
        }
        Ok(deltas)
    }

    // ---- the mask -----------------------------------------------------------------------------------------

    fn touch_mask(
        &mut self,
        surface: &mut Surface,
        images: &[(Address, Steps)],
        radius: f64,
        strength: f64,
    ) -> Changes {
        let finest = surface.finest();
        let len = surface.hierarchy().layout(finest).len();
        let mut wanted: FxHashMap<Slot, f64> = FxHashMap::default();
        for &(address, _) in images {
            for t in touched(surface, finest, address, radius, self.falloff(), &mut self.marks) {
                let weight = wanted.entry(t.slot).or_default();
                *weight = weight.max(t.weight.min(1.0));
            }
        }
        if self.mask_met.members().is_empty() {
            self.mask_met.reset(len);
        }
        let mut slots = Vec::with_capacity(wanted.len());
        for (slot, weight) in wanted {
            let old = surface.mask().value(slot);
            let new = (f64::from(old) + (255.0 * strength * weight).round()).clamp(0.0, 255.0) as u8;
            if new != old {
                surface.mask_mut().put(slot, new, len as usize);
                let site = surface.hierarchy().layout(finest).site(slot);
                if self.mask_met.insert(slot.0, site) {
                    self.mask.push((slot, old));
                }
                slots.push(slot.0);
            }
        }
        let mut changes = Changes::nothing(surface);
        if !slots.is_empty() {
            changes.masked = Moved::Some(Runs::of_slots(slots));
        }
        changes
    }

    // ---- the end ------------------------------------------------------------------------------------------

    /// Whether the stroke has changed anything.
    pub fn is_empty(&self) -> bool {
        self.vertices.before.is_empty()
            && self.wavelets.iter().all(|met| met.before.is_empty())
            && self.mask.is_empty()
    }

    /// Takes everything back, bit for bit.
    pub fn cancel(self, surface: &mut Surface) -> Changes {
        let level = self.moving_level(surface);
        let deltas = self.deltas(surface);
        let mut changes = Changes::nothing(surface);
        if let Some((_, deltas)) = &deltas.scaling {
            changes.join(surface.raise(level, &negated(deltas)));
        }
        for (level, deltas) in deltas.wavelets.iter().rev() {
            changes.join(surface.add_wavelets(*level, &negated(deltas)));
        }
        let len = surface.scaling(surface.finest()).len();
        for &(slot, old) in &self.mask {
            surface.mask_mut().put(slot, old, len);
        }
        if !self.mask.is_empty() {
            changes.masked = Moved::Some(Runs::of_slots(self.mask.iter().map(|(slot, _)| slot.0).collect()));
        }
        changes
    }

    /// Ends the stroke: the coarser levels follow, and what was done becomes a step.
    ///
    /// # Errors
    /// A coarser coefficient would leave its range; the stroke is then taken back.
    pub fn finish(self, surface: &mut Surface) -> Result<(Step, Changes), EditError> {
        let level = self.moving_level(surface);
        let deltas = self.deltas(surface);
        let mut changes = Changes::nothing(surface);
        if let Some((_, deltas)) = &deltas.scaling {
            let slots = Runs::of_slots(deltas.iter().map(|&(slot, _)| slot.0).collect());
            changes = surface.settle(level, &slots);
            if changes.beyond_limit {
                self.cancel(surface);
                surface.settle(level, &slots);
                return Err(EditError::BeyondLimit);
            }
        }
        let mask = self.mask.iter().map(|&(slot, old)| (slot, old, surface.mask().value(slot))).collect();
        Ok((Step::brushed(Edit::Stroke(self.words), deltas, mask), changes))
    }

    /// What the stroke has added so far.
    fn deltas(&self, surface: &Surface) -> Deltas {
        let level = self.moving_level(surface);
        let now = |slot: Slot| surface.scaling(level)[slot.index()];
        let mut vertices: Vec<(Slot, Vector)> = self
            .vertices
            .before
            .iter()
            .map(|&(slot, before)| (slot, difference(now(slot), before)))
            .collect();
        vertices.retain(|(_, delta)| *delta != [0; 3]);
        vertices.sort_unstable_by_key(|&(slot, _)| slot);
        let mut wavelets = Vec::new();
        for (met, level) in self.wavelets.iter().zip((0..).map(Level)) {
            let now = |odd: Odd| surface.wavelets(level)[odd.index()];
            let mut deltas: Vec<(Odd, Vector)> =
                met.before.iter().map(|&(odd, before)| (odd, difference(now(odd), before))).collect();
            deltas.retain(|(_, delta)| *delta != [0; 3]);
            deltas.sort_unstable_by_key(|&(odd, _)| odd);
            if !deltas.is_empty() {
                wavelets.push((level, deltas));
            }
        }
        let scaling = (!vertices.is_empty()).then_some((level, vertices));
        Deltas { scaling, wavelets, hidden: Vec::new() }
    }
}

/// Rounded deltas of what the images of a dab do. Where several reach a vertex, it moves by their mean, as far as the
/// one that reaches it most.
fn joined_images(
    surface: &Surface,
    level: Level,
    mut moved: Vec<(Slot, f64, Steps)>,
    several: bool,
) -> Result<Vec<(Slot, Vector)>, EditError> {
    let delta = |slot: Slot, by: Steps| {
        let by = times(by, surface.freedom(level, slot));
        Ok((slot, rounded(by).ok_or(EditError::BeyondLimit)?))
    };
    if !several {
        return moved.into_iter().map(|(slot, weight, by)| delta(slot, times(by, weight))).collect();
    }
    moved.sort_by_key(|&(slot, ..)| slot);
    moved
        .chunk_by(|a, b| a.0 == b.0)
        .filter_map(|of_slot| {
            let sum = of_slot.iter().fold(0.0, |sum, (_, weight, _)| sum + weight);
            let most = of_slot.iter().fold(0.0, |most: f64, (_, weight, _)| most.max(*weight));
            let by = of_slot.iter().fold([0.0; 3], |all, (_, weight, by)| plus(all, times(*by, *weight)));
            (sum > 0.0).then(|| delta(of_slot[0].0, times(by, most / sum)))
        })
        .collect()
}
