//! The adaptive triangulation: large triangles where a surface is nearly flat, small ones where it is not, and no cracks.
//!
//! Based on: DeRose, Lounsbery, Stollnitz, Eck, Hoppe et al., "Multiresolution Surfaces for Compression, Display, and
//! Editing" (triangles are split where there is detail); red and green splits after Bank, Sherman, Weiser, "Refinement
//! Algorithms and Data Structures for Regular Local Mesh Refinement" (1983).
//!
//! What is chosen is edges to be halved, level by level. A face all of whose edges are halved falls into four; one with one or two
//! such edges, next to smaller faces, into two or three. If any edge of a face is halved, its parent falls into
//! four: so no edge of a face that does not is halved more than once, and neighbours meet edge by edge.

use crate::hierarchy::{Hierarchy, Layout, Level, Odd, PublicId, Site, Slot, Subtriangle};
use crate::mesh::TriangleMesh;
use crate::surface::{Surface, Vector};
use rayon::prelude::*;

/// Triangles whose corners are vertices of `M^J` and lie on the surface, which is nowhere further from them than `tolerance`,
/// in model units. Corners are numbered by ascending public id. With a tolerance of zero only faces that lie flat, but for the
/// rounding of midpoints, are joined. Cost: `O(n_J)`; memory: 16 bytes a vertex. The same bits for any number of threads.
pub fn adaptive_triangulation(surface: &Surface, tolerance: f64) -> TriangleMesh {
    let halved = halved_edges(surface, tolerance / surface.form().placement.step);
    let hierarchy = surface.hierarchy();
    let (positions, numbers) = corners(surface, &halved);
    let faces = (0..hierarchy.base().faces().len() as u32)
        .into_par_iter()
        .flat_map_iter(|face| {
            let mut faces = Vec::new();
            let own = hierarchy.base().faces()[face as usize];
            let split = Split { surface, halved: &halved };
            split.emit(Level::BASE, Subtriangle::whole(face), own, &mut faces);
            faces
        })
        .map(|corners: [u32; 3]| corners.map(|id| numbers[id as usize]))
        .collect();
    TriangleMesh::new(positions, faces)
}

/// Which odd vertices of every level below J are corners.
type Halved = Vec<Vec<bool>>;

/// The odd vertices at the middle of a triangle's edges; edge k joins corners k and k + 1.
fn middles(hierarchy: &Hierarchy, level: Level, triangle: Subtriangle) -> [Odd; 3] {
    let (coarse, fine) = (hierarchy.layout(level), hierarchy.layout(level.finer()));
    let corners = triangle.corners();
    std::array::from_fn(|k| {
        let (a, b) = (corners[k], corners[(k + 1) % 3]);
        coarse.odd_at(site(fine, triangle.face, [a[0] + b[0], a[1] + b[1]]))
    })
}

fn site(layout: &Layout, face: u32, [i, r]: [u32; 2]) -> Site {
    layout.site_at(face, [layout.segments() - i - r, i, r])
}

/// Chooses the edges, finest level first. The tolerance is in steps.
fn halved_edges(surface: &Surface, tolerance: f64) -> Halved {
    let hierarchy = surface.hierarchy();
    let base_faces = hierarchy.base().faces().len() as u32;
    let mut halved: Halved = Vec::new();
    // How far the surface may be from a face, and whether a smaller face asks for its splitting.
    let mut finer: Vec<f64> = Vec::new();
    let mut wanted: Vec<bool> = Vec::new();
    for level in (0..surface.finest().0).rev().map(Level) {
        let n = level.segments();
        let look = |face: u32| {
            let finer = &finer;
            Subtriangle::all_in_face(face, n).map(move |triangle| {
                let bend = bend(surface, level, triangle);
                let below = match finer.is_empty() {
                    true => 0.0,
                    false => {
                        triangle.children().map(|t| finer[t.index(2 * n)]).into_iter().fold(0.0, f64::max)
                    }
                };
                // Next to smaller faces a face is split by a corner that is up to a bend away.
                (bend + below, 2.0 * bend + below > tolerance)
            })
        };
        let (distances, bent): (Vec<f64>, Vec<bool>) =
            (0..base_faces).into_par_iter().flat_map_iter(look).unzip();
        let mut of_level = vec![false; hierarchy.layout(level).odd_len() as usize];
        let triangles = || (0..base_faces).flat_map(|face| Subtriangle::all_in_face(face, n)).zip(0..);
        for (triangle, at) in triangles() {
            if bent[at] || wanted.get(at).is_some_and(|&wanted| wanted) {
                middles(hierarchy, level, triangle).iter().for_each(|odd| of_level[odd.index()] = true);
            }
        }
        if level > Level::BASE {
            wanted = vec![false; distances.len() / 4];
            for (triangle, _) in triangles() {
                if middles(hierarchy, level, triangle).iter().any(|odd| of_level[odd.index()]) {
                    wanted[triangle.parent().index(n / 2)] = true;
                }
            }
        }
        halved.push(of_level);
        finer = distances;
    }
    halved.reverse();
    halved
}

/// How far, in steps, the middles of a triangle's edges are from the surface's points there; half a step, which rounding
/// a midpoint leaves, is nothing.
fn bend(surface: &Surface, level: Level, triangle: Subtriangle) -> f64 {
    let finest = surface.finest();
    let layout = surface.hierarchy().layout(finest);
    let positions = surface.scaling(finest);
    let depth = finest.0 - level.0 - 1;
    let at = |place: [u32; 2]| -> Vector {
        positions[layout.slot(site(layout, triangle.face, place.map(|x| x << depth))).index()]
    };
    let corners = triangle.corners();
    let ends = corners.map(|corner| at(corner.map(|x| 2 * x)));
    let off = |k: usize| {
        let (a, b) = (corners[k], corners[(k + 1) % 3]);
        let middle = at([a[0] + b[0], a[1] + b[1]]);
        let twice: [i64; 3] = std::array::from_fn(|c| {
            let off = 2 * i64::from(middle[c]) - i64::from(ends[k][c]) - i64::from(ends[(k + 1) % 3][c]);
            if off.abs() > 1 { off } else { 0 }
        });
        // Exact in f64: squares of coordinates up to 2^30 fit an i64 three times over.
        twice.iter().map(|x| x * x).sum::<i64>()
    };
    ((0..3).map(off).max().unwrap_or_default() as f64).sqrt() / 2.0
}

/// The positions of the corners by ascending public id, and the number of every id that is one.
fn corners(surface: &Surface, halved: &Halved) -> (Vec<[f64; 3]>, Vec<u32>) {
    let (hierarchy, finest) = (surface.hierarchy(), surface.finest());
    let mut numbers = vec![u32::MAX; hierarchy.layout(finest).len() as usize];
    let mut positions = Vec::new();
    for v in 0..hierarchy.base().vertex_count() {
        numbers[v as usize] = v;
        positions.push(surface.position(finest, hierarchy.refine_slot(Level::BASE, finest, Slot(v))));
    }
    for (level, of_level) in (0..).map(Level).zip(halved) {
        let (coarse, fine) = (hierarchy.layout(level), hierarchy.layout(level.finer()));
        for odd in (0..of_level.len() as u32).filter(|&odd| of_level[odd as usize]).map(Odd) {
            let slot = hierarchy.refine_slot(level.finer(), finest, fine.slot(coarse.odd_site(odd)));
            numbers[surface.wavelet_id(level, odd).0 as usize] = positions.len() as u32;
            positions.push(surface.position(finest, slot));
        }
    }
    (positions, numbers)
}

/// Edges chosen, faces to be made of them.
struct Split<'a> {
    surface: &'a Surface,
    halved: &'a Halved,
}

impl Split<'_> {
    /// The triangles, by public ids, that a triangle with the given corners falls into.
    fn emit(&self, level: Level, triangle: Subtriangle, corners: [u32; 3], faces: &mut Vec<[u32; 3]>) {
        if level == self.surface.finest() {
            faces.push(corners);
            return;
        }
        let odds = middles(self.surface.hierarchy(), level, triangle);
        let split = odds.map(|odd| self.halved[level.index()][odd.index()]);
        let middle = odds.map(|odd| self.surface.wavelet_id(level, odd).0);
        let turned = |k: usize| [0, 1, 2].map(|c| ((c + k) % 3, corners[(c + k) % 3]));
        match split.iter().filter(|&&split| split).count() {
            0 => faces.push(corners),
            1 => {
                let k = split.iter().position(|&split| split).expect("one is");
                let [(k, p), (_, q), (_, r)] = turned(k);
                faces.extend([[p, middle[k], r], [middle[k], q, r]]);
            }
            2 => {
                let k = split.iter().position(|&split| !split).expect("one is not");
                let [(_, p), (after, q), (before, r)] = turned(k);
                let (m, o) = (middle[after], middle[before]);
                faces.push([m, r, o]);
                // The shorter diagonal of the other four corners.
                if self.apart(p, m) <= self.apart(q, o) {
                    faces.extend([[p, q, m], [p, m, o]]);
                } else {
                    faces.extend([[p, q, o], [q, m, o]]);
                }
            }
            _ => {
                let [a, b, c] = corners;
                let [ab, bc, ca] = middle;
                // The inner triangle points the other way, and its first corner is another.
                let inner = if triangle.down { [ca, ab, bc] } else { [ab, bc, ca] };
                let parts = [[a, ab, ca], [ab, b, bc], [ca, bc, c], inner];
                for (child, corners) in triangle.children().into_iter().zip(parts) {
                    self.emit(level.finer(), child, corners, faces);
                }
            }
        }
    }

    /// The squared distance of two vertices, in steps.
    fn apart(&self, a: u32, b: u32) -> i64 {
        let layout = self.surface.hierarchy().layout(self.surface.finest());
        let [p, q] = [a, b].map(|id| {
            let slot = layout.slot(layout.site_of(PublicId(id)));
            self.surface.scaling(self.surface.finest())[slot.index()].map(i64::from)
        });
        (0..3).map(|c| (p[c] - q[c]) * (p[c] - q[c])).sum()
    }
}
