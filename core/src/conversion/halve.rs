//! One half of a nearly symmetric surface, cut along the mirror plane x = 0, and the whole that it makes with its mirror
//! image.
//!
//! Vertices close to the plane are put on it, triangles across it are cut. The seam is the part of the half's boundary that
//! lies in the plane because of the cut. An edge that joins two vertices of the seam without being part of it would be
//! there twice in the whole; such edges are halved here, and none is made after (see `collapse`, `edge_flips`, `base_flips`).
//!
//! Guarantees: the whole has the components, the Euler characteristic and the boundary loops of the surface, and is its own mirror
//! image to the last bit. Non-guarantees: it lies as far from the surface as that is from being symmetric.

use super::clean::disjoint_sets::DisjointSets;
use super::creases::Creases;
use crate::mesh::TriangleMesh;
use crate::mesh::connectivity::{Connectivity, NONE};
use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

/// A half and the whole it makes.
pub(super) struct Half {
    /// The part at x ≥ 0.
    pub(super) mesh: TriangleMesh,
    pub(super) connectivity: Connectivity<'static>,
    /// For each vertex of it whether it lies on the seam.
    pub(super) seam: Vec<bool>,
    /// The half's vertices and faces, then the others.
    pub(super) whole: TriangleMesh,
    pub(super) whole_connectivity: Connectivity<'static>,
}

/// How a surface is cut.
#[derive(Clone, Copy)]
struct Cut {
    /// Whether the part at x ≤ 0 is kept, mirrored.
    other_side: bool,
    /// Vertices nearer to the plane than this part of their shortest edge are put on it.
    snap: f64,
    /// Parts of one side that reach no further than this over to the other, over the diagonal, count as on that.
    lap: f64,
}

/// Tried one after another until the topology is right: where sheets touch, or lie nearly in the plane, one may lap over it.
const CUTS: [Cut; 8] = {
    const fn cut(other_side: bool, snap: f64, lap: f64) -> Cut {
        Cut { other_side, snap, lap }
    }
    [
        cut(false, 0.2, 0.0),
        cut(true, 0.2, 0.0),
        cut(false, 0.2, 2e-3),
        cut(true, 0.2, 2e-3),
        cut(false, 0.2, 1e-2),
        cut(true, 0.2, 1e-2),
        cut(false, 0.0, 2e-3),
        cut(true, 0.0, 2e-3),
    ]
};

impl Half {
    /// Cuts a surface in a box of diagonal 1 about along its mirror plane x = 0. `None` where what that makes has another
    /// topology, whichever half is kept. Linear in the faces.
    pub(super) fn of(mesh: &TriangleMesh, connectivity: &Connectivity) -> Option<Self> {
        let figures = |c: &Connectivity| (c.components(), c.euler_characteristic(), c.boundary_loops());
        CUTS.iter()
            .filter_map(|&cut| Self::cut(mesh, connectivity, cut))
            .find(|half| figures(&half.whole_connectivity) == figures(connectivity))
    }

    fn cut(mesh: &TriangleMesh, connectivity: &Connectivity, cut: Cut) -> Option<Self> {
        let pieces = Pieces::of(mesh, connectivity, cut)?;
        let mut half = pieces.mesh;
        let (mut connectivity, mut seam);
        loop {
            connectivity = Connectivity::build(half.positions.len() as u32, half.faces.clone()).ok()?;
            seam = vec![false; half.positions.len()];
            for [a, b] in seam_edges(&half, &connectivity, &pieces.open) {
                seam[a as usize] = true;
                seam[b as usize] = true;
            }
            if !halve_bridges(&mut half, &connectivity, &seam, &pieces.open) {
                break;
            }
        }
        let whole = doubled(&half, &seam);
        let whole_connectivity =
            Connectivity::build(whole.positions.len() as u32, whole.faces.clone()).ok()?;
        Some(Self { mesh: half, connectivity, seam, whole, whole_connectivity })
    }

    /// The creases of the whole as those of the half. Where they or the boundary meet the seam is a corner; those along the
    /// seam stay.
    pub(super) fn creases(&self, whole: &Creases) -> Creases {
        let count = self.mesh.positions.len();
        let inside = |&w: &u32| (w as usize) < count;
        let ends: Vec<Vec<u32>> =
            whole.ends[..count].iter().map(|ends| ends.iter().copied().filter(inside).collect()).collect();
        let corners = (0..count).map(|v| {
            let leaves = ends[v].iter().any(|&w| !self.seam[w as usize]);
            let open = self.whole_connectivity.is_boundary(v as u32);
            whole.corners[v] || (self.seam[v] && (leaves || open))
        });
        Creases { corners: corners.collect(), ends }
    }
}

/// What is left of a surface on one side.
struct Pieces {
    mesh: TriangleMesh,
    /// Edges in the plane where the surface has its own boundary, ends ascending.
    open: FxHashSet<[u32; 2]>,
}

impl Pieces {
    /// `None` if nothing is left.
    fn of(mesh: &TriangleMesh, connectivity: &Connectivity, cut: Cut) -> Option<Self> {
        let mut positions: Vec<DVec3> = mesh
            .positions
            .iter()
            .map(|&[x, y, z]| DVec3::new(if cut.other_side { 0.0 - x } else { x }, y, z))
            .collect();
        let lapped = lap(&mut positions, &mesh.faces, cut.lap);
        snap(&mut positions, &mesh.faces, &lapped, cut.snap);
        let mut across: FxHashMap<[u32; 2], u32> = FxHashMap::default();
        let mut faces = Vec::with_capacity(mesh.faces.len() / 2 + 16);
        for &face in &mesh.faces {
            let [a, b, c] = if cut.other_side { [face[0], face[2], face[1]] } else { face };
            let x = [a, b, c].map(|v| positions[v as usize].x);
            if x.iter().all(|&x| x <= 0.0) {
                continue;
            }
            if x.iter().all(|&x| x >= 0.0) {
                faces.push([a, b, c]);
                continue;
            }
            // What is in front of the plane, corner by corner.
            let mut polygon: Vec<u32> = Vec::with_capacity(4);
            for (k, v) in [a, b, c].into_iter().enumerate() {
                let (w, [from, to]) = ([a, b, c][(k + 1) % 3], [x[k], x[(k + 1) % 3]]);
                if from >= 0.0 {
                    polygon.push(v);
                }
                if (from > 0.0 && to < 0.0) || (from < 0.0 && to > 0.0) {
                    let ends = [v.min(w), v.max(w)];
                    polygon.push(*across.entry(ends).or_insert_with(|| {
                        let [p, q] = ends.map(|v| positions[v as usize]);
                        positions.push((p + (q - p) * (p.x / (p.x - q.x))).with_x(0.0));
                        positions.len() as u32 - 1
                    }));
                }
            }
            let at = |k: usize| positions[polygon[k] as usize];
            match polygon[..] {
                [a, b, c] => faces.push([a, b, c]),
                [a, b, c, d] if at(0).distance_squared(at(2)) <= at(1).distance_squared(at(3)) => {
                    faces.extend([[a, b, c], [a, c, d]]);
                }
                [a, b, c, d] => faces.extend([[b, c, d], [b, d, a]]),
                _ => {}
            }
        }
        if faces.is_empty() {
            return None;
        }
        let sharp = mesh.sharp_edges.iter().filter_map(|ends| {
            let x = ends.map(|v| positions[v as usize].x);
            match across.get(ends) {
                Some(&middle) => Some([ends[usize::from(x[0] < 0.0)], middle]),
                None => (x[0] >= 0.0 && x[1] >= 0.0).then_some(*ends),
            }
        });
        let open = (0..3 * mesh.faces.len() as u32)
            .filter(|&h| connectivity.twin(h) == NONE)
            .map(|h| [connectivity.origin(h), connectivity.target(h)])
            .filter(|ends| ends.iter().all(|&v| positions[v as usize].x == 0.0));
        Some(Self::compact(&positions, faces, sharp.collect(), open.collect()))
    }

    /// Numbers what faces use, in the order there is.
    fn compact(positions: &[DVec3], faces: Vec<[u32; 3]>, sharp: Vec<[u32; 2]>, open: Vec<[u32; 2]>) -> Self {
        let mut number = vec![NONE; positions.len()];
        faces.iter().flatten().for_each(|&v| number[v as usize] = 0);
        let mut kept = Vec::new();
        for (number, position) in number.iter_mut().zip(positions).filter(|(number, _)| **number == 0) {
            *number = kept.len() as u32;
            kept.push(position.to_array());
        }
        let renumbered = |edges: Vec<[u32; 2]>| -> Vec<[u32; 2]> {
            let edges = edges.into_iter().map(|ends| ends.map(|v| number[v as usize]));
            edges.filter(|ends| !ends.contains(&NONE)).map(|[a, b]| [a.min(b), a.max(b)]).collect()
        };
        let faces = faces.into_iter().map(|face| face.map(|v| number[v as usize])).collect();
        Self {
            mesh: TriangleMesh::new(kept, faces).with_sharp_edges(renumbered(sharp)),
            open: renumbered(open).into_iter().collect(),
        }
    }
}

/// Mirrors connected parts of either side that reach no further than `most` from the plane; returns which vertices those are.
fn lap(positions: &mut [DVec3], faces: &[[u32; 3]], most: f64) -> Vec<bool> {
    if most <= 0.0 {
        return vec![false; positions.len()];
    }
    let in_front = |v: u32| positions[v as usize].x >= 0.0;
    let mut parts = DisjointSets::new(positions.len());
    for face in faces {
        for (a, b) in [(face[0], face[1]), (face[1], face[2]), (face[2], face[0])] {
            if in_front(a) == in_front(b) {
                parts.join(a as usize, b as usize);
            }
        }
    }
    let mut reach = vec![0.0f64; positions.len()];
    for (v, position) in positions.iter().enumerate() {
        let part = parts.find(v);
        reach[part] = reach[part].max(position.x.abs());
    }
    let lapped: Vec<bool> = (0..positions.len()).map(|v| reach[parts.find(v)] <= most).collect();
    for (position, _) in positions.iter_mut().zip(&lapped).filter(|(_, lapped)| **lapped) {
        position.x = if position.x >= 0.0 { (-position.x).min(-LEAST) } else { (-position.x).max(LEAST) };
    }
    lapped
}

/// What is mirrored lies at least this far from the plane.
const LEAST: f64 = 1e-6;

/// Puts vertices on the plane that are nearer to it than a part of their shortest edge, but for those lapped over.
fn snap(positions: &mut [DVec3], faces: &[[u32; 3]], lapped: &[bool], part: f64) {
    let mut shortest = vec![f64::INFINITY; positions.len()];
    for face in faces {
        for k in 0..3 {
            let ends = [face[k], face[(k + 1) % 3]].map(|v| v as usize);
            let length = positions[ends[0]].distance(positions[ends[1]]);
            ends.iter().for_each(|&v| shortest[v] = shortest[v].min(length));
        }
    }
    for ((position, shortest), lapped) in positions.iter_mut().zip(shortest).zip(lapped) {
        if !lapped && position.x.abs() <= part * shortest {
            position.x = 0.0;
        }
    }
}

/// The edges of a half that lie in the plane where it was cut.
fn seam_edges<'a>(
    half: &'a TriangleMesh,
    connectivity: &'a Connectivity,
    open: &'a FxHashSet<[u32; 2]>,
) -> impl Iterator<Item = [u32; 2]> + 'a {
    (0..3 * half.faces.len() as u32)
        .filter(|&h| connectivity.twin(h) == NONE)
        .map(|h| [connectivity.origin(h), connectivity.target(h)])
        .filter(|ends| ends.iter().all(|&v| half.positions[v as usize][0] == 0.0))
        .filter(|&[a, b]| !open.contains(&[a.min(b), a.max(b)]))
}

/// Halves edges that join two vertices of the seam and are no part of it, one in a face; whether there was any.
fn halve_bridges(
    half: &mut TriangleMesh,
    connectivity: &Connectivity,
    seam: &[bool],
    open: &FxHashSet<[u32; 2]>,
) -> bool {
    let mut taken = vec![false; half.faces.len()];
    let mut found = false;
    for h in 0..3 * taken.len() as u32 {
        let (a, b, twin) = (connectivity.origin(h), connectivity.target(h), connectivity.twin(h));
        let own = twin == NONE && open.contains(&[a.min(b), a.max(b)]);
        let bridge = seam[a as usize] && seam[b as usize] && (own || (twin != NONE && h < twin));
        let sides = || [h, twin].into_iter().filter(|&h| h != NONE);
        if !bridge || sides().any(|h| taken[h as usize / 3]) {
            continue;
        }
        found = true;
        let middle = half.positions.len() as u32;
        let [p, q] = [a, b].map(|v| DVec3::from(half.positions[v as usize]));
        half.positions.push(p.midpoint(q).to_array());
        for h in sides() {
            let (f, k) = (h as usize / 3, h as usize % 3);
            taken[f] = true;
            // The face is there as the connectivity has turned it.
            let face = connectivity.faces()[f];
            let (from, to, apex) = (face[k], face[(k + 1) % 3], face[(k + 2) % 3]);
            half.faces[f] = [from, middle, apex];
            half.faces.push([middle, to, apex]);
        }
    }
    found
}

/// The half and its mirror image, joined along the seam.
fn doubled(half: &TriangleMesh, seam: &[bool]) -> TriangleMesh {
    let mut positions = half.positions.clone();
    let image: Vec<u32> = half
        .positions
        .iter()
        .zip(seam)
        .enumerate()
        .map(|(v, (&[x, y, z], &seam))| {
            if seam {
                return v as u32;
            }
            positions.push([0.0 - x, y, z]);
            positions.len() as u32 - 1
        })
        .collect();
    let mirrored = half.faces.iter().map(|&[a, b, c]| [a, c, b].map(|v| image[v as usize]));
    let faces = half.faces.iter().copied().chain(mirrored).collect();
    let sharp = half.sharp_edges.iter().flat_map(|&ends| [ends, ends.map(|v| image[v as usize])]);
    TriangleMesh::new(positions, faces).with_sharp_edges(sharp.collect())
}

#[cfg(test)]
mod tests;
