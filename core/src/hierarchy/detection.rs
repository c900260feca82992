//! Detection of subdivision connectivity: which base mesh, split how often, gives this triangle list?
//!
//! One coarsening step labels vertices even or odd: from a start vertex, two straight steps through a regular odd
//! vertex lead from even to even (after Taubin's and others' observation that regular vertices leave no choice).
//! The step holds if the labels agree everywhere, every extraordinary vertex is even, and the coarse faces form a
//! simplicial manifold. It is repeated as often as it holds.

use super::{BaseMesh, Hierarchy, Layout, Level, NotABaseMesh, Slot, base_mesh};
use crate::mesh::Abandoned;
use crate::mesh::connectivity::{Connectivity, NONE, NotManifold, previous};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::sync::Arc;

/// What detection found.
#[derive(Debug, Clone)]
pub struct Detected {
    /// The hierarchy over the base mesh; J is at least 1.
    pub hierarchy: Hierarchy,
    /// For every slot of level J the index of the vertex in the triangle list.
    pub source: Vec<u32>,
}

/// Looks for subdivision connectivity, at most `most_levels` deep. `Ok(None)`: a manifold without it. Vertices of
/// no face are passed over. Linear in the faces.
///
/// # Errors
/// The list is not an orientable manifold.
pub fn detect(
    vertex_count: u32,
    faces: &[[u32; 3]],
    most_levels: u8,
) -> Result<Option<Detected>, NotManifold> {
    detect_while(vertex_count, faces, most_levels, &|| true).unwrap_or(Ok(None))
}

/// [`detect`], asking now and then, after some hundredths of a second, whether to go on.
///
/// # Errors
/// The answer was no.
pub fn detect_while(
    vertex_count: u32,
    faces: &[[u32; 3]],
    most_levels: u8,
    go_on: &dyn Fn() -> bool,
) -> Result<Result<Option<Detected>, NotManifold>, Abandoned> {
    let mut at = match Connectivity::build_while(vertex_count, faces, go_on)? {
        Ok(built) => built,
        Err(why) => return Ok(Err(why)),
    };
    let mut steps: Vec<Midpoints> = Vec::new();
    while steps.len() < usize::from(most_levels.min(super::FINEST_LEVEL)) {
        match coarsen(at, go_on)? {
            Coarsened::Done(coarse, midpoints) => {
                at = coarse;
                steps.push(midpoints);
            }
            Coarsened::Not(same) => {
                at = same;
                break;
            }
        }
    }
    Ok(Ok((!steps.is_empty()).then(|| assemble(&at, &steps)).flatten()))
}

/// Makes a mesh its own base mesh, J = 0; the slots' sources are all vertices in order.
///
/// # Errors
/// See [`NotABaseMesh`].
pub fn own_base(vertex_count: u32, faces: &[[u32; 3]]) -> Result<Detected, NotABaseMesh> {
    let base = BaseMesh::new(vertex_count, faces.to_vec(), &[])?;
    let hierarchy =
        Hierarchy::new(Arc::new(base), Level::BASE).expect("level 0 has as many vertices as the mesh");
    Ok(Detected { hierarchy, source: (0..vertex_count).collect() })
}

/// The odd vertex on each coarse edge after its ends (low, high), in the triangle list's indices. Sorted: a table would take
/// three times the memory.
struct Midpoints(Vec<[u32; 3]>);

impl Midpoints {
    fn between(&self, a: u32, b: u32) -> Option<u32> {
        let ends = [a.min(b), a.max(b)];
        let at = self.0.binary_search_by(|edge| edge[..2].cmp(&ends)).ok()?;
        Some(self.0[at][2])
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Label {
    Unknown,
    Even,
    Odd,
}

/// What came of one step back.
enum Coarsened<'f> {
    /// The coarser mesh, and the vertices between its own.
    Done(Connectivity<'f>, Midpoints),
    /// The mesh as it was.
    Not(Connectivity<'f>),
}

/// One step back. Vertex indices stay those of the triangle list. The relations of the finer mesh are let go before those of
/// the coarser are made, for together they would take more memory than all else.
fn coarsen<'f>(mesh: Connectivity<'f>, go_on: &dyn Fn() -> bool) -> Result<Coarsened<'f>, Abandoned> {
    let middles = match middle_faces(&mesh, go_on) {
        Ok(middles) => middles,
        Err(Without::Connectivity) => return Ok(Coarsened::Not(mesh)),
        Err(Without::Answer) => return Err(Abandoned),
    };
    let (vertex_count, finer) = (mesh.vertex_count(), mesh.into_faces());
    if let Some(midpoints) = middles.midpoints(&finer)
        && let Ok(coarse) = Connectivity::build_while(vertex_count, middles.coarse, go_on)?
        && base_mesh::is_simplicial(&coarse)
    {
        return Ok(Coarsened::Done(coarse, midpoints));
    }
    let again = Connectivity::build_while(vertex_count, finer, go_on)?;
    Ok(Coarsened::Not(again.expect("it was built of these faces before")))
}

/// Why there are no labels.
enum Without {
    /// There are none that agree.
    Connectivity,
    /// Nobody waits for them any more.
    Answer,
}

/// The faces between three midpoints.
struct Middles {
    faces: Vec<u32>,
    /// The coarse face around each: its corner `k` is opposite edge `k` of the middle face.
    coarse: Vec<[u32; 3]>,
    /// Midpoints on the boundary, in order.
    on_boundary: Vec<u32>,
}

/// The faces that lie in the middle of coarse ones, if all do or beside one that does.
fn middle_faces(mesh: &Connectivity, go_on: &dyn Fn() -> bool) -> Result<Middles, Without> {
    if !mesh.faces().len().is_multiple_of(4) {
        return Err(Without::Connectivity);
    }
    let labels = label(mesh, go_on)?;
    let count = mesh.faces().len() / 4;
    let mut middles = Middles {
        faces: Vec::with_capacity(count),
        coarse: Vec::with_capacity(count),
        on_boundary: Vec::new(),
    };
    let mut corners_used = 0usize;
    for (f, face) in mesh.faces().iter().enumerate() {
        match face.iter().filter(|&&v| labels[v as usize] == Label::Even).count() {
            1 => corners_used += 1,
            0 => {
                let mut coarse = [0; 3];
                for (k, corner) in coarse.iter_mut().enumerate() {
                    // The face across edge k holds the coarse corner opposite it.
                    let across = mesh.twin((3 * f + k) as u32);
                    if across == NONE {
                        return Err(Without::Connectivity);
                    }
                    *corner = mesh.origin(previous(across));
                    if labels[*corner as usize] != Label::Even {
                        return Err(Without::Connectivity);
                    }
                }
                middles.faces.push(f as u32);
                middles.coarse.push(coarse);
                middles.on_boundary.extend(face.iter().filter(|&&v| mesh.is_boundary(v)));
            }
            _ => return Err(Without::Connectivity),
        }
    }
    middles.on_boundary.sort_unstable();
    if corners_used == 3 * middles.faces.len() { Ok(middles) } else { Err(Without::Connectivity) }
}

impl Middles {
    /// The midpoints of the coarse edges; `None` if two edges have the same ends, which makes no simplicial mesh.
    fn midpoints(&self, finer: &[[u32; 3]]) -> Option<Midpoints> {
        let inner = (3 * self.coarse.len()).saturating_sub(self.on_boundary.len());
        let mut midpoints = Vec::with_capacity(inner / 2 + self.on_boundary.len());
        for (&middle, coarse) in self.faces.iter().zip(&self.coarse) {
            // Edge k of the middle face joins corners k and k + 1; corner k + 1 is shared by edges k and k + 1, so it halves
            // the coarse edge between the corners opposite those edges.
            for k in 0..3 {
                let (a, b) = (coarse[k], coarse[(k + 1) % 3]);
                let middle = finer[middle as usize][(k + 1) % 3];
                // Of the two sides of an inner edge one goes up.
                if a < b || self.on_boundary.binary_search(&middle).is_ok() {
                    midpoints.push([a.min(b), a.max(b), middle]);
                }
            }
        }
        midpoints.par_sort_unstable();
        let twice = midpoints.windows(2).any(|pair| pair[0][..2] == pair[1][..2]);
        (!twice).then_some(Midpoints(midpoints))
    }
}

/// Even vertices that are gone through between two questions whether to go on.
const STRIDE: usize = 1 << 16;

/// Even and odd labels of all vertices that faces use, where a consistent labelling exists.
fn label(mesh: &Connectivity, go_on: &dyn Fn() -> bool) -> Result<Vec<Label>, Without> {
    let mut labels = vec![Label::Unknown; mesh.vertex_count() as usize];
    let mut queue = Vec::new();
    let mut seen = 0usize;
    for start in starts(mesh) {
        labels[start as usize] = Label::Even;
        queue.push(start);
        while let Some(v) = queue.pop() {
            seen += 1;
            if seen.is_multiple_of(STRIDE) && !go_on() {
                return Err(Without::Answer);
            }
            for h in mesh.fan(v) {
                spread(mesh, h, &mut labels, &mut queue).ok_or(Without::Connectivity)?;
            }
            if let Some(h) = last_boundary_edge(mesh, v) {
                spread_back(mesh, h, &mut labels, &mut queue).ok_or(Without::Connectivity)?;
            }
        }
    }
    let consistent = (0..mesh.vertex_count()).all(|v| {
        mesh.outgoing(v) == NONE
            || match labels[v as usize] {
                Label::Even => true,
                Label::Odd => is_regular(mesh, v),
                Label::Unknown => false,
            }
    });
    if consistent { Ok(labels) } else { Err(Without::Connectivity) }
}

/// One vertex per component: the lowest extraordinary, else the lowest on the boundary, else the lowest.
fn starts(mesh: &Connectivity) -> Vec<u32> {
    let mut best: Vec<Option<(u8, u32)>> = vec![None; mesh.components() as usize];
    for v in 0..mesh.vertex_count() {
        let h = mesh.outgoing(v);
        if h == NONE {
            continue;
        }
        let rank = match (is_regular(mesh, v), mesh.is_boundary(v)) {
            (false, _) => 0,
            (true, true) => 1,
            (true, false) => 2,
        };
        let slot = &mut best[mesh.component_of_face(h / 3) as usize];
        *slot = Some(slot.map_or((rank, v), |found| found.min((rank, v))));
    }
    best.into_iter().flatten().map(|(_, v)| v).collect()
}

fn is_regular(mesh: &Connectivity, v: u32) -> bool {
    mesh.face_valence(v) == if mesh.is_boundary(v) { 3 } else { 6 }
}

/// Two straight steps along a half-edge out of an even vertex.
fn spread(mesh: &Connectivity, h: u32, labels: &mut [Label], queue: &mut Vec<u32>) -> Option<()> {
    let odd = mesh.target(h);
    mark_odd(mesh, odd, labels)?;
    let even = if mesh.is_boundary(odd) {
        // Straight on along the boundary; an inner edge cannot lead from an even vertex to a boundary midpoint.
        if mesh.twin(h) != NONE {
            return None;
        }
        mesh.target(mesh.outgoing(odd))
    } else {
        let mut ahead = mesh.twin(h);
        for _ in 0..3 {
            ahead = mesh.rotate(ahead);
        }
        mesh.target(ahead)
    };
    mark_even(even, labels, queue)
}

/// The boundary half-edge that ends at a boundary vertex (its face's half-edge), if there is one.
fn last_boundary_edge(mesh: &Connectivity, v: u32) -> Option<u32> {
    if !mesh.is_boundary(v) {
        return None;
    }
    let last = mesh.fan(v).last()?;
    Some(previous(last))
}

/// Two steps against the boundary's direction.
fn spread_back(mesh: &Connectivity, h: u32, labels: &mut [Label], queue: &mut Vec<u32>) -> Option<()> {
    let odd = mesh.origin(h);
    mark_odd(mesh, odd, labels)?;
    let before = last_boundary_edge(mesh, odd)?;
    mark_even(mesh.origin(before), labels, queue)
}

fn mark_odd(mesh: &Connectivity, v: u32, labels: &mut [Label]) -> Option<()> {
    let slot = &mut labels[v as usize];
    if *slot == Label::Even || !is_regular(mesh, v) {
        return None;
    }
    *slot = Label::Odd;
    Some(())
}

fn mark_even(v: u32, labels: &mut [Label], queue: &mut Vec<u32>) -> Option<()> {
    match labels[v as usize] {
        Label::Odd => None,
        Label::Even => Some(()),
        Label::Unknown => {
            labels[v as usize] = Label::Even;
            queue.push(v);
            Some(())
        }
    }
}

/// Numbers the base mesh by ascending source index and follows the midpoints up to level J.
fn assemble(base: &Connectivity, steps: &[Midpoints]) -> Option<Detected> {
    let used: Vec<u32> = (0..base.vertex_count()).filter(|&v| base.outgoing(v) != NONE).collect();
    let number: FxHashMap<u32, u32> = used.iter().zip(0..).map(|(&v, id)| (v, id)).collect();
    let faces = base.faces().iter().map(|f| f.map(|v| number[&v])).collect();
    let base = BaseMesh::new(used.len() as u32, faces, &[]).ok()?;
    let hierarchy = Hierarchy::new(Arc::new(base), Level(steps.len() as u8))?;

    let mut source = used;
    for (j, midpoints) in steps.iter().rev().enumerate() {
        let (coarse, fine) = (hierarchy.layout(Level(j as u8)), hierarchy.layout(Level(j as u8 + 1)));
        let mut finer = vec![0; fine.len() as usize];
        for s in 0..fine.len() {
            let site = fine.site(Slot(s));
            finer[s as usize] = match Layout::coarsen(site) {
                Some(even) => source[coarse.slot(even).index()],
                None => {
                    let [a, b] = coarse.parents(site).map(|p| source[coarse.slot(p).index()]);
                    midpoints.between(a, b)?
                }
            };
        }
        source = finer;
    }
    Some(Detected { hierarchy, source })
}
