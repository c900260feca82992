//! A level finished in lanes: what it tells is what [`super::finish`] tells, each of a vertex's parts in a lane of its own.

use super::{EXPECTED, PLACES, Parts, class_of, place, within};
use crate::file::progressive::lanes::{KINDS, Kinds, Lanes, MOST_RAW};
use crate::file::progressive::visit::{Place, visit};

/// Vertices of a run.
const RUN: u32 = 1 << 14;
/// The last kind of a magnitude says that its class follows, in so many bits.
const ESCAPE: usize = KINDS - 1;
const ESCAPE_BITS: u32 = 6;
/// Of what is known down to a plane, at most so many bits have a model.
const TOP: u32 = 4;

/// The models of residuals. All levels share them.
#[derive(Debug)]
pub(super) struct Models {
    /// Of a magnitude, by class and by what it is expected to be.
    size: Box<[[Kinds; EXPECTED]; 2]>,
    /// The highest unknown bits of a component that is known not to be zero: by class, place and how many.
    refined: Box<[[[Kinds; TOP as usize]; PLACES]; 2]>,
}

/// How likely magnitudes are at first, from seven classes below the one expected on.
const AT_FIRST: [u32; 24] = [
    1900, 2700, 3800, 5400, 7600, 10_500, 14_000, 16_000, 13_500, 8400, 4200, 1900, 800, 320, 130, 50, 20, 8,
    3, 1, 1, 1, 1, 1,
];
/// What is expected is of the class of so many less: it is some sixteen times a magnitude.
const TIMES: usize = 8;

impl Default for Models {
    fn default() -> Self {
        let size = |expected: usize| {
            let most = expected.saturating_sub(2 * shift(expected) as usize);
            Kinds::new(std::array::from_fn(|kind| {
                AT_FIRST[(kind + TIMES + 7 - most).min(AT_FIRST.len() - 1)]
            }))
        };
        let refined = |bits: usize| Kinds::new(std::array::from_fn(|kind| u32::from(kind >> bits == 0)));
        Self {
            size: Box::new([std::array::from_fn(size); 2]),
            refined: Box::new([[std::array::from_fn(|bits| refined(bits + 1)); PLACES]; 2]),
        }
    }
}

/// How many of a magnitude's low bits have no model, where so much is expected.
#[inline(always)]
fn shift(expected: usize) -> u32 {
    (expected as u32 / 2).saturating_sub(7)
}

/// Codes the block; or says which odd vertex is the first that is not all there.
pub(super) fn finish<L: Lanes>(lanes: &mut L, models: &mut Models, level: &mut Parts) -> Result<(), u32> {
    let (coarse, fine) = (level.coarse, level.fine);
    visit(coarse, fine, |place| {
        if place.odd.is_multiple_of(RUN) && place.odd > 0 {
            lanes.next_run();
        }
        lanes.together(|lanes| vertex(lanes, models, level, place))
    })
}

#[inline(always)]
fn vertex<L: Lanes>(lanes: &mut L, models: &mut Models, level: &mut Parts, place: Place) -> Result<(), u32> {
    let truth = if L::WRITES { level.truth[place.odd as usize] } else { [0; 3] };
    let beside = level.beside(&place);
    let mut value = level.known.get(place.slot as usize).copied().unwrap_or_default();
    let mut residual = [0i32; 3];
    for c in 0..3 {
        let class = c.min(1);
        let (at, plane) = (beside.at(c), level.from[class]);
        if plane > 0 {
            value[c] = if value[c] == 0 {
                let expected = beside.expected(c, &residual);
                let at = within(at, plane);
                let model = &mut models.size[class][expected];
                at.wrapping_add(off(lanes, c, model, shift(expected), truth[c].wrapping_sub(at)))
            } else {
                refined(lanes, c, &mut models.refined[class], at, plane, value[c], truth[c])
            };
        }
        residual[c] = value[c].wrapping_sub(at);
    }
    if lanes.is_exhausted() {
        return Err(place.odd);
    }
    level.tell(&place, value, residual);
    Ok(())
}

/// What a component is off by.
#[inline(always)]
fn off<L: Lanes>(lanes: &mut L, lane: usize, model: &mut Kinds, shift: u32, off: i32) -> i32 {
    let size = off.unsigned_abs();
    let class = if L::WRITES { class_of(u64::from(size >> shift)) } else { 0 };
    let kind = lanes.kind(lane, model, class.min(ESCAPE));
    if kind == ESCAPE {
        return far_off(lanes, lane, shift, off, class);
    }
    let (least, below) = octave(kind);
    let signed = u32::from(kind > 0 || shift > 0);
    let tail = (size - (least << shift) * u32::from(L::WRITES)) << 1 | u32::from(off < 0);
    let tail = lanes.raw(lane, (below + shift) * signed + signed, tail * signed * u32::from(L::WRITES));
    let size = ((least << shift) + (tail >> 1)) as i32;
    let sign = -((tail & 1) as i32);
    (size ^ sign) - sign
}

/// [`off`] for what is much larger than expected.
#[cold]
#[inline(never)]
fn far_off<L: Lanes>(lanes: &mut L, lane: usize, shift: u32, off: i32, class: usize) -> i32 {
    let class = ESCAPE + lanes.raw(lane, ESCAPE_BITS, (class.max(ESCAPE) - ESCAPE) as u32) as usize;
    let (least, below) = octave(class.min(63));
    let least = u64::from(least) << shift;
    let tail = (u64::from(off.unsigned_abs()).wrapping_sub(least)) << 1 | u64::from(off < 0);
    let count = below + shift + 1;
    let low = lanes.raw(lane, MOST_RAW.min(count), (tail & ((1 << MOST_RAW.min(count)) - 1)) as u32);
    let rest = count - MOST_RAW.min(count);
    let high = lanes.raw(lane, rest, (tail >> MOST_RAW & ((1 << rest) - 1)) as u32);
    let tail = u64::from(high) << MOST_RAW | u64::from(low);
    let size = least.wrapping_add(tail >> 1) as i32;
    if tail & 1 == 1 { size.wrapping_neg() } else { size }
}

/// The least number of a class, and how many bits all of its have below: see [`class_of`].
#[inline(always)]
fn octave(class: usize) -> (u32, u32) {
    let class = class as u32;
    let below = (class >> 1).saturating_sub(1);
    (if class < 2 { class } else { (2 | class & 1) << below }, below)
}

/// A component of which some bits are known.
#[inline(always)]
fn refined<L: Lanes>(
    lanes: &mut L,
    lane: usize,
    models: &mut [[Kinds; TOP as usize]; PLACES],
    at: i32,
    plane: u32,
    known: i32,
    truth: i32,
) -> i32 {
    let top = plane.min(TOP);
    let model = &mut models[place(at, plane, known)][top as usize - 1];
    let low = truth.unsigned_abs() & ((1u64 << plane) - 1) as u32;
    // A forged stream may name more than there are.
    let first = lanes.kind(lane, model, (low >> (plane - top)) as usize) as u32 & ((1 << top) - 1);
    let rest = lanes.raw(lane, plane - top, low & ((1u64 << (plane - top)) - 1) as u32);
    let size = known.unsigned_abs() | first << (plane - top) | rest;
    if known < 0 { (size as i32).wrapping_neg() } else { size as i32 }
}
