//! The last block of a level: every bit that is missing of it, told as what a smooth surface through `M^j` does not say.
//!
//! Based on: Weinberger, Seroussi, Sapiro, "The LOCO-I Lossless Image Compression Algorithm", IEEE TIP 9(8), 2000, for
//! correcting a prediction by what was off beside it and for contexts from magnitudes of residuals. The prediction is
//! [`super::butterfly`]'s, or nothing where the transform has that in it.

mod by_lanes;

use super::range_coder::{Coder, Model};
use super::visit::{Place, visit};
use crate::hierarchy::Layout;
use crate::surface::Vector;

/// Classes of what magnitude a residual is expected to have: half octaves.
const EXPECTED: usize = 40;
const LENGTHS: usize = 32;
/// Where a prediction lies in the interval in which a component is known to be.
const PLACES: usize = 6;

/// The models of residuals. All levels share them.
#[derive(Debug)]
struct Models {
    length: Box<[[[Model; LENGTHS]; EXPECTED]; 2]>,
    /// The bit below a magnitude's highest.
    second: [[Model; LENGTHS]; 2],
    /// The highest unknown bit of a component that is known not to be zero.
    refined: [[Model; PLACES]; 2],
}

impl Default for Models {
    fn default() -> Self {
        // The sums are some sixteen times a magnitude.
        let length = |expected: usize, length: usize| {
            let likely = (expected / 2).saturating_sub(3);
            let one = [8000, 20_000, 38_000, 54_000, 61_000][(likely + 2).saturating_sub(length).min(4)];
            Model::new(one, 1)
        };
        let classes: [[Model; LENGTHS]; EXPECTED] =
            std::array::from_fn(|e| std::array::from_fn(|l| length(e, l)));
        Self {
            length: Box::new([classes; 2]),
            second: [[Model::new(28_000, 4); LENGTHS]; 2],
            refined: [[8000, 16_000, 26_000, 36_000, 46_000, 50_000].map(|one| Model::new(one, 2)); 2],
        }
    }
}

/// What a finishing block reads and writes: components by slot of `M^{j+1}` where nothing else is said.
pub(super) struct Parts<'a> {
    pub(super) coarse: &'a Layout,
    pub(super) fine: &'a Layout,
    /// Empty where all are zero and nobody will ask.
    pub(super) known: &'a mut [Vector],
    /// How far components are from their predictions; at first all zero.
    pub(super) residuals: &'a mut [Vector],
    /// Those of level j − 1, by slot of `M^j`; empty where that level is not finished.
    pub(super) parents: &'a [Vector],
    /// By odd vertex; empty for nothing.
    pub(super) predicted: &'a [Vector],
    /// What components are in the end, by odd vertex; empty when reading.
    pub(super) truth: &'a [Vector],
    /// The plane of each class.
    pub(super) from: [u32; 2],
}

/// The models of finishing, by the range coder and in lanes.
#[derive(Debug, Default)]
pub(super) struct Finishing {
    by_range: Models,
    by_lanes: by_lanes::Models,
}

impl Finishing {
    /// Codes a block; or says which odd vertex is the first that is not all there.
    pub(super) fn code<C: Coder>(
        &mut self,
        coder: &mut C,
        in_lanes: bool,
        level: &mut Parts,
    ) -> Result<(), u32> {
        if in_lanes {
            coder.in_lanes(|lanes| by_lanes::finish(lanes, &mut self.by_lanes, level))
        } else {
            finish(coder, &mut self.by_range, level)
        }
    }
}

fn finish<C: Coder>(coder: &mut C, models: &mut Models, level: &mut Parts) -> Result<(), u32> {
    let (coarse, fine) = (level.coarse, level.fine);
    visit(coarse, fine, |place| coder.together(|coder| vertex(coder, models, level, place)))
}

#[inline(always)]
fn sizes(v: &Vector) -> [u64; 2] {
    let [n, b, c] = v.map(|x| u64::from(x.unsigned_abs()));
    [n, b + c]
}

/// What lies beside an odd vertex.
struct Beside {
    predicted: Vector,
    /// The sum of the neighbours' residuals.
    around: [i64; 3],
    /// By class, what magnitude its residual is expected to have, some sixteen times.
    expected: [u64; 2],
}

impl Parts<'_> {
    #[inline(always)]
    fn beside(&self, place: &Place) -> Beside {
        let predicted = self.predicted.get(place.odd as usize).copied().unwrap_or_default();
        let (mut around, mut expected) = ([0i64; 3], sizes(&predicted).map(|x| 2 * x));
        expected[1] *= 2;
        for &slot in place.near {
            let residual = &self.residuals[slot as usize];
            let size = sizes(residual);
            for c in 0..3 {
                around[c] += i64::from(residual[c]);
            }
            for class in 0..2 {
                expected[class] += 4 * size[class];
            }
        }
        for slot in place.parents {
            if let Some(residual) = self.parents.get(slot as usize) {
                let size = sizes(residual);
                for class in 0..2 {
                    expected[class] += size[class];
                }
            }
        }
        Beside { predicted, around, expected }
    }

    #[inline(always)]
    fn tell(&mut self, place: &Place, value: Vector, residual: Vector) {
        if let Some(known) = self.known.get_mut(place.slot as usize) {
            *known = value;
        }
        self.residuals[place.slot as usize] = residual;
    }
}

impl Beside {
    /// What a component is expected to be off, with those of the vertex that were found before it.
    #[inline(always)]
    fn expected(&self, c: usize, residual: &Vector) -> usize {
        let own = match c {
            0 => return half_octave(self.expected[0]),
            1 => u64::from(residual[0].unsigned_abs()),
            _ => u64::from(residual[0].unsigned_abs() >> 1) + u64::from(residual[1].unsigned_abs()),
        };
        half_octave((self.expected[1] + 4 * own) >> 1)
    }

    /// What a component is expected to be.
    #[inline(always)]
    fn at(&self, c: usize) -> i32 {
        self.predicted[c].wrapping_add(((5 * self.around[c]) >> 4) as i32)
    }
}

#[inline(always)]
fn vertex<C: Coder>(coder: &mut C, models: &mut Models, level: &mut Parts, place: Place) -> Result<(), u32> {
    let truth = if C::WRITES { level.truth[place.odd as usize] } else { [0; 3] };
    let beside = level.beside(&place);
    let mut value = level.known.get(place.slot as usize).copied().unwrap_or_default();
    let mut residual = [0i32; 3];
    for c in 0..3 {
        let class = c.min(1);
        let at = beside.at(c);
        let plane = level.from[class];
        if plane > 0 {
            value[c] = match value[c] {
                0 => zero(coder, models, class, beside.expected(c, &residual), at, plane, truth[c]),
                known => refined(coder, &mut models.refined[class], at, plane, known, truth[c]),
            };
        }
        residual[c] = value[c].wrapping_sub(at);
    }
    if coder.is_exhausted() {
        return Err(place.odd);
    }
    level.tell(&place, value, residual);
    Ok(())
}

/// The class of a number: 0, 1, then two classes for each power of two.
#[inline(always)]
fn class_of(number: u64) -> usize {
    if number < 2 {
        return number as usize;
    }
    let bits = 64 - number.leading_zeros() as usize;
    2 * bits - 2 + ((number >> (bits - 2)) & 1) as usize
}

/// The class of a sum.
#[inline(always)]
fn half_octave(sum: u64) -> usize {
    class_of(sum).min(EXPECTED - 1)
}

/// A prediction of a component of which all known bits are zero, as near as that can be.
#[inline(always)]
fn within(at: i32, plane: u32) -> i32 {
    let most = (1i32 << plane) - 1;
    at.clamp(-most, most)
}

/// A component of which all known bits are zero, by what its prediction is off.
#[inline(always)]
fn zero<C: Coder>(
    coder: &mut C,
    models: &mut Models,
    class: usize,
    expected: usize,
    at: i32,
    plane: u32,
    truth: i32,
) -> i32 {
    let at = within(at, plane);
    let off = truth.wrapping_sub(at);
    let size = off.unsigned_abs();
    let bits = if C::WRITES { 32 - size.leading_zeros() } else { 0 };
    let length = coder.ones(&mut models.length[class][expected], bits);
    if length == 0 {
        return at;
    }
    let (mut left, mut below) = (length - 1, 0);
    if left > 0 {
        left -= 1;
        let second = coder.bit(&mut models.second[class][length as usize - 1], size >> left & 1 == 1);
        below = u32::from(second) << left;
    }
    // The sign goes with the bits that are as likely 1 as 0.
    let tail = coder.long_raw(left + 1, (size & ((1u64 << left) - 1) as u32) << 1 | u32::from(off < 0));
    let size = 1 << (length - 1) | below | tail >> 1;
    if tail & 1 == 1 { at.wrapping_sub(size as i32) } else { at.wrapping_add(size as i32) }
}

/// Where a prediction lies in the interval that a component is known to be in: before it, in a quarter of it, or behind.
#[inline(always)]
fn place(at: i32, plane: u32, known: i32) -> usize {
    let along = if known < 0 { -i64::from(at) } else { i64::from(at) };
    (((4 * (along - i64::from(known.unsigned_abs()))) >> plane).clamp(-1, 4) + 1) as usize
}

/// A component of which some bits are known.
#[inline(always)]
fn refined<C: Coder>(
    coder: &mut C,
    models: &mut [Model; PLACES],
    at: i32,
    plane: u32,
    known: i32,
    truth: i32,
) -> i32 {
    let size = known.unsigned_abs();
    let place = place(at, plane, known);
    let low = truth.unsigned_abs() & ((1u64 << plane) - 1) as u32;
    let first = coder.bit(&mut models[place], low >> (plane - 1) & 1 == 1);
    let rest = coder.long_raw(plane - 1, low & ((1u64 << (plane - 1)) - 1) as u32);
    let size = size | u32::from(first) << (plane - 1) | rest;
    if known < 0 { (size as i32).wrapping_neg() } else { size as i32 }
}
