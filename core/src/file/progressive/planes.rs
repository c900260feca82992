//! One block of the stream: a class of components of one level, carried from one bit plane down to another.
//!
//! Based on: Shapiro, "Embedded Image Coding Using Zerotrees of Wavelet Coefficients", IEEE TSP 41(12), 1993, for planes
//! over a hierarchy; Taubman, "High Performance Scalable Image Compression with EBCOT", IEEE TIP 9(7), 2000, for
//! contexts from neighbours; Khodakovsky, Schröder, Sweldens, "Progressive Geometry Compression", SIGGRAPH 2000, for
//! local frames. Whether a component is significant is coded under a model chosen by the magnitudes known around it: of
//! its neighbours on the level, of its parents' coefficients one level coarser, and of its own other components.

use super::range_coder::{Coder, Model};
use super::visit::{Place, visit};
use crate::hierarchy::Layout;
use crate::surface::Vector;

/// The two classes of components: along the normal, and the two in the surface.
pub(super) const CLASSES: [std::ops::Range<usize>; 2] = [0..1, 1..3];

const NEAR: usize = 10;
const PARENT: usize = 7;
const OWN: usize = 5;
/// Of a magnitude, how many of the bits of its length have models.
const LENGTHS: usize = 12;

/// The models of components. All levels share them.
#[derive(Debug)]
pub(super) struct Models {
    significant: Box<[[[[Model; OWN]; PARENT]; NEAR]; 2]>,
    sign: [Model; 5],
    length: [[[Model; LENGTHS]; NEAR]; 2],
    /// The bit below a magnitude's highest, by class and length.
    second: [[Model; LENGTHS]; 2],
    /// The first bit by which a component that was 1 is refined.
    refined: [Model; 2],
}

/// How likely, of 2^16, a component is significant at first: sums of three parts.
const AT_FIRST: ([u16; NEAR], [u16; PARENT], [u16; OWN]) = (
    [1000, 5000, 8000, 11_000, 14_000, 18_000, 22_000, 26_000, 30_000, 32_000],
    [0, 700, 1500, 3000, 6000, 10_000, 13_000],
    [0, 1500, 3000, 6000, 9000],
);

impl Default for Models {
    fn default() -> Self {
        let mut significant = Box::new([[[[Model::EVEN; OWN]; PARENT]; NEAR]; 2]);
        for class in significant.iter_mut() {
            for (near, class) in AT_FIRST.0.iter().zip(class) {
                for (parent, class) in AT_FIRST.1.iter().zip(class) {
                    for (own, model) in AT_FIRST.2.iter().zip(class) {
                        *model = Model::new((near + parent + own).min(1 << 15), 2);
                    }
                }
            }
        }
        Self {
            significant,
            sign: [Model::new(1 << 15, 4); 5],
            length: [[[Model::new(22_000, 2); LENGTHS]; NEAR]; 2],
            second: [[Model::new(28_000, 4); LENGTHS]; 2],
            refined: [Model::new(28_000, 4); 2],
        }
    }
}

/// A block: which class, and from which plane to which. A component known at plane p is known but for its p lowest bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Block {
    pub(super) class: usize,
    pub(super) from: u32,
    pub(super) to: u32,
}

/// What a block reads and writes: components by slot of `M^{j+1}`.
pub(super) struct Level<'a> {
    pub(super) coarse: &'a Layout,
    pub(super) fine: &'a Layout,
    /// Those of level j. Slots of even vertices hold zero.
    pub(super) known: &'a mut [Vector],
    /// Those of level j − 1, by slot of `M^j`; empty where that level has not begun.
    pub(super) parents: &'a [Vector],
    /// What they are in the end, by odd vertex; empty when reading.
    pub(super) truth: &'a [Vector],
}

/// Magnitudes beside a component, in units of the block's lower plane.
#[derive(Debug, Clone, Copy, Default)]
struct Context {
    near: usize,
    parent: usize,
    sign: i32,
}

impl Level<'_> {
    /// The magnitudes around an odd vertex: of the neighbours' components, and of the parents'.
    #[inline(always)]
    fn context(&self, block: Block, near: &[u32], parents: [u32; 2]) -> Context {
        let size = |v: &Vector| match block.class {
            0 => u64::from(v[0].unsigned_abs()),
            _ => u64::from(v[1].unsigned_abs()) + u64::from(v[2].unsigned_abs()),
        };
        let (mut sum, mut sign) = (0, 0);
        for &slot in near {
            let v = &self.known[slot as usize];
            sum += size(v);
            sign += v[0].signum();
        }
        let parent: u64 = parents.iter().filter_map(|&slot| self.parents.get(slot as usize)).map(size).sum();
        Context {
            near: usize::from(STEPS[((sum >> block.to) as usize).min(STEPS.len() - 1)]),
            parent: bits(parent >> block.to).min(PARENT - 1),
            sign: sign.clamp(-2, 2),
        }
    }
}

/// The class of a sum of magnitudes.
const STEPS: [u8; 64] = {
    let mut steps = [0; 64];
    let mut sum = 0;
    while sum < 64 {
        steps[sum] = match sum {
            0..=3 => sum as u8,
            4..=5 => 4,
            6..=8 => 5,
            9..=13 => 6,
            14..=25 => 7,
            26..=62 => 8,
            _ => 9,
        };
        sum += 1;
    }
    steps
};

/// How many bits a number has.
fn bits(x: u64) -> usize {
    (64 - x.leading_zeros()) as usize
}

/// Codes a block; or says which odd vertex is the first that is not all there.
pub(super) fn code<C: Coder>(
    coder: &mut C,
    models: &mut Models,
    block: Block,
    level: &mut Level,
) -> Result<(), u32> {
    let (coarse, fine) = (level.coarse, level.fine);
    visit(coarse, fine, |place| vertex(coder, models, block, level, place))
}

#[inline(always)]
fn vertex<C: Coder>(
    coder: &mut C,
    models: &mut Models,
    block: Block,
    level: &mut Level,
    place: Place,
) -> Result<(), u32> {
    let Place { odd, slot, near, parents } = place;
    let context = level.context(block, near, parents);
    let truth = if C::WRITES { level.truth[odd as usize] } else { [0; 3] };
    let mut value = level.known[slot as usize];
    for c in CLASSES[block.class].clone() {
        let own = match c {
            0 => 0,
            1 => value[0].unsigned_abs() >> block.to >> 1,
            _ => (value[0].unsigned_abs() >> block.to >> 1) + 2 * (value[1].unsigned_abs() >> block.to),
        };
        let own = bits(u64::from(own)).min(OWN - 1);
        value[c] = component(coder, models, block, context, own, value[c], truth[c]);
    }
    if coder.is_exhausted() {
        return Err(odd);
    }
    level.known[slot as usize] = value;
    Ok(())
}

#[inline(always)]
fn component<C: Coder>(
    coder: &mut C,
    models: &mut Models,
    block: Block,
    context: Context,
    own: usize,
    known: i32,
    truth: i32,
) -> i32 {
    let count = block.from - block.to;
    let size = truth.unsigned_abs() >> block.to;
    if known != 0 {
        let low = size & ((1u64 << count) - 1) as u32;
        let low = if known.unsigned_abs() >> block.from == 1 {
            let first = coder.bit(&mut models.refined[block.class], low >> (count - 1) != 0);
            u32::from(first) << (count - 1) | coder.long_raw(count - 1, low & ((1 << (count - 1)) - 1))
        } else {
            coder.long_raw(count, low)
        };
        let size = known.unsigned_abs() | low << block.to;
        return if known < 0 { (size as i32).wrapping_neg() } else { size as i32 };
    }
    let model = &mut models.significant[block.class][context.near][context.parent][own];
    if !coder.bit(model, size != 0) {
        return 0;
    }
    let size = magnitude(coder, models, block.class, context.near, size, count);
    let negative = if block.class == 0 {
        coder.bit(&mut models.sign[(context.sign + 2) as usize], truth < 0)
    } else {
        coder.raw(1, u32::from(truth < 0)) == 1
    };
    let size = (size << block.to) as i32;
    if negative { -size } else { size }
}

/// A magnitude from 1 to `2^count − 1`: its length in unary, then the bits below the highest.
#[inline(always)]
fn magnitude<C: Coder>(
    coder: &mut C,
    models: &mut Models,
    class: usize,
    near: usize,
    size: u32,
    count: u32,
) -> u32 {
    let below = if C::WRITES { 31 - size.leading_zeros() } else { 0 };
    let mut length = 0;
    while length + 1 < count {
        let model = &mut models.length[class][near][(length as usize).min(LENGTHS - 1)];
        if !coder.bit(model, below > length) {
            break;
        }
        length += 1;
    }
    if length == 0 {
        return 1;
    }
    let model = &mut models.second[class][(length as usize).min(LENGTHS - 1)];
    let second = coder.bit(model, C::WRITES && size >> (length - 1) & 1 == 1);
    let rest = coder.long_raw(length - 1, size & ((1 << (length - 1)) - 1));
    1 << length | u32::from(second) << (length - 1) | rest
}
