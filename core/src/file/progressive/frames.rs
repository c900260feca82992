//! Local frames: what part of a wavelet coefficient lies along the surface's normal, and what part in the surface.
//!
//! A frame is read off positions that the reader has when a level begins, and turns a coefficient by two lifting steps,
//! so it is undone exactly: with `a` the axis nearest to the normal `n`, `ν = d·n / |n_a|` and the two other components
//! less their share of `ν n`. An error of `ν` moves a vertex along the normal, one of the others in the surface.

use super::visit::of_odds_by_face;
use crate::hierarchy::{Hierarchy, Layout, Level, for_each_triangle_of_face};
use crate::memory::Buffer;
use crate::surface::Vector;
use bytemuck::{Pod, Zeroable};

/// Bits of a slope's fraction.
const BITS: u32 = 14;

/// The frame of one odd vertex.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Frame {
    /// `n_b / n_a` and `n_c / n_a`, where b and c follow a.
    slopes: [i16; 2],
    /// `n_a n_b` and `n_a n_c` for the unit normal.
    shares: [i16; 2],
    axis: u8,
    /// 0 or 1.
    reversed: u8,
}

impl Frame {
    /// The frame about a normal of any length.
    fn about(normal: [i64; 3]) -> Self {
        let size = normal.map(i64::unsigned_abs);
        let axis = (1..3).fold(0, |axis, c| if size[c] > size[axis] { c } else { axis });
        if size[axis] == 0 {
            return Self::default();
        }
        let shift = (64 - size[axis].leading_zeros()).saturating_sub(31);
        let [a, b, c] = [0, 1, 2].map(|k| normal[(axis + k) % 3] >> shift);
        let slopes = [b, c].map(|x| quotient(x << BITS, a));
        let square = (1 << (2 * BITS)) + slopes[0] * slopes[0] + slopes[1] * slopes[1];
        let shares = slopes.map(|x| quotient(x << (2 * BITS), square));
        Self {
            slopes: slopes.map(|x| x as i16),
            shares: shares.map(|x| x as i16),
            axis: axis as u8,
            reversed: u8::from(a < 0),
        }
    }

    #[inline]
    fn along(self, b: i32, c: i32) -> i32 {
        let [p, q] = self.slopes.map(i64::from);
        ((p * i64::from(b) + q * i64::from(c) + (1 << (BITS - 1))) >> BITS) as i32
    }

    #[inline]
    fn share(self, k: usize, normal: i32) -> i32 {
        ((i64::from(self.shares[k]) * i64::from(normal) + (1 << (BITS - 1))) >> BITS) as i32
    }

    /// A coefficient as normal part and two tangential parts.
    #[inline]
    pub(super) fn turn(self, d: Vector) -> Vector {
        let [a, b, c] = [0, 1, 2].map(|k| d[(usize::from(self.axis) + k) % 3]);
        let normal = a.wrapping_add(self.along(b, c));
        let tangential = [b.wrapping_sub(self.share(0, normal)), c.wrapping_sub(self.share(1, normal))];
        [if self.reversed == 1 { normal.wrapping_neg() } else { normal }, tangential[0], tangential[1]]
    }

    /// The way back, exactly.
    #[inline]
    pub(super) fn turn_back(self, local: Vector) -> Vector {
        let normal = if self.reversed == 1 { local[0].wrapping_neg() } else { local[0] };
        let b = local[1].wrapping_add(self.share(0, normal));
        let c = local[2].wrapping_add(self.share(1, normal));
        let mut d = [0; 3];
        for (k, x) in [normal.wrapping_sub(self.along(b, c)), b, c].into_iter().enumerate() {
            d[(usize::from(self.axis) + k) % 3] = x;
        }
        d
    }
}

/// `x / y` towards zero for `|x| < 2^46`, `|y| < 2^32` and a result of some 2^14: several times faster than dividing integers,
/// and the same. Both are exact as `f64`, the quotient is rounded by less than 2^−37, and one that is no integer is 2^−32 or
/// more from the next.
#[inline(always)]
fn quotient(x: i64, y: i64) -> i64 {
    (x as f64 / y as f64) as i64
}

/// The frames of the odd vertices of a level, from positions of its vertices by slot: each about the sum of its parents'
/// normals. A vertex's normal is the sum of `(b − a) × (c − a)` over its faces, modulo 2^64. `O(n_j)`; of the normals only those
/// on base edges and of a base face at a time are kept.
pub(super) fn frames(hierarchy: &Hierarchy, level: Level, positions: &[Vector]) -> Buffer<Frame> {
    let layout = hierarchy.layout(level);
    let borders = layout.row(0, 1).index();
    let mut on_borders = vec![[0i64; 3]; borders];
    hierarchy.for_each_triangle(level, |corners| {
        if corners.iter().any(|&slot| (slot as usize) < borders) {
            let cross = cross(positions, corners);
            let on_border = corners.into_iter().filter(|&slot| (slot as usize) < borders);
            on_border.for_each(|slot| add(&mut on_borders[slot as usize], cross));
        }
    });
    let inside = |face: u32, of_face: &mut OfFace| of_face.collect(layout, face, positions);
    of_odds_by_face(layout, hierarchy.layout(level.finer()), inside, |of_face, _, _, parents| {
        let normal =
            |slot: u32| on_borders.get(slot as usize).copied().unwrap_or_else(|| of_face.normal(slot));
        let [u, w] = parents.map(normal);
        Frame::about([0, 1, 2].map(|c| u[c].wrapping_add(w[c])))
    })
}

/// The normals inside a base face.
#[derive(Default)]
struct OfFace {
    /// The slot of the first.
    first: u32,
    normals: Vec<[i64; 3]>,
    rows: [Vec<u32>; 2],
}

impl OfFace {
    fn collect(&mut self, layout: &Layout, face: u32, positions: &[Vector]) {
        let n = layout.segments() as usize;
        self.first = layout.row(face, 1).0;
        self.normals.clear();
        self.normals.resize((n - 1) * n.saturating_sub(2) / 2, [0; 3]);
        if self.normals.is_empty() {
            return;
        }
        for_each_triangle_of_face(layout, face, &mut self.rows, |corners| {
            let cross = cross(positions, corners);
            // What lies on borders lies before all faces.
            for slot in corners {
                if let Some(normal) = self.normals.get_mut(slot.wrapping_sub(self.first) as usize) {
                    add(normal, cross);
                }
            }
        });
    }

    fn normal(&self, slot: u32) -> [i64; 3] {
        self.normals[(slot - self.first) as usize]
    }
}

fn cross(positions: &[Vector], corners: [u32; 3]) -> [i64; 3] {
    let [a, b, c] = corners.map(|slot| positions[slot as usize].map(i64::from));
    let [p, q] = [b, c].map(|x| [0, 1, 2].map(|k| x[k] - a[k]));
    [0, 1, 2].map(|k| {
        let (l, m) = ((k + 1) % 3, (k + 2) % 3);
        p[l].wrapping_mul(q[m]).wrapping_sub(p[m].wrapping_mul(q[l]))
    })
}

fn add(normal: &mut [i64; 3], cross: [i64; 3]) {
    *normal = [0, 1, 2].map(|k| normal[k].wrapping_add(cross[k]));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hierarchy::{BaseMesh, Odd};
    use crate::mesh::shapes;
    use proptest::prelude::*;
    use std::sync::Arc;

    /// Face by face the frames are those of normals that are summed around each vertex.
    #[test]
    fn frames_are_about_the_sums_of_normals() {
        for (name, mesh) in shapes::awkward() {
            let base = BaseMesh::new(mesh.positions.len() as u32, mesh.faces.clone(), &[]).expect(name);
            let hierarchy = Hierarchy::new(Arc::new(base), Level(4)).expect("small");
            for level in (0..4).map(Level) {
                let layout = hierarchy.layout(level);
                let mixed = |k: u32| (k.wrapping_mul(0x9e37_79b9) ^ k << 13) as i32 >> 3;
                let positions: Vec<Vector> =
                    (0..layout.len()).map(|v| [3 * v, 3 * v + 1, 3 * v + 2].map(mixed)).collect();
                let mut normals = vec![[0i64; 3]; positions.len()];
                for corners in hierarchy.triangles(level) {
                    corners
                        .into_iter()
                        .for_each(|slot| add(&mut normals[slot as usize], cross(&positions, corners)));
                }
                for (odd, frame) in (0..).zip(frames(&hierarchy, level, &positions).iter()) {
                    let parents = layout.parents(layout.odd_site(Odd(odd)));
                    let [u, w] = parents.map(|p| normals[layout.slot(p).index()]);
                    let sum = [0, 1, 2].map(|c| u[c].wrapping_add(w[c]));
                    assert_eq!(*frame, Frame::about(sum), "{name}, level {level}, {odd}");
                }
            }
        }
    }

    proptest! {
        /// Turning is undone to the bit, whatever the normal and the coefficient.
        #[test]
        fn turning_back_undoes_turning(normal: [i64; 3], shift in 0u32..64, d: Vector) {
            let frame = Frame::about(normal.map(|x| x >> shift));
            prop_assert_eq!(frame.turn_back(frame.turn(d)), d);
            prop_assert_eq!(frame.turn(frame.turn_back(d)), d);
        }

        /// The quotients of frames are those of integers, for sizes that just divide too.
        #[test]
        fn quotients_are_exact(y in 1i64..1 << 31, share in -16_400i64..=16_400, off in -2i64..=2, down: bool) {
            for y in [y, (1 << 31) - (y >> 20), 1 << 30] {
                let (x, y) = (share * y + off, if down { -y } else { y });
                prop_assert_eq!(quotient(x, y), x / y);
            }
        }

        /// A coefficient along the normal has a normal part alone, and it points outwards.
        #[test]
        fn a_normal_coefficient_is_normal(normal: [i16; 3], size in 1i32..1000) {
            prop_assume!(normal != [0; 3]);
            let frame = Frame::about(normal.map(i64::from));
            let d = normal.map(|x| i32::from(x) * size);
            let local = frame.turn(d);
            let largest = d.iter().map(|x| x.abs()).max().expect("three");
            prop_assert!(local[0] > 0 && local[0] >= largest);
            let little = 2 + (largest >> 10);
            prop_assert!(local[1].abs() <= little && local[2].abs() <= little, "{:?}", local);
        }
    }
}
