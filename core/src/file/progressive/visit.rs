//! Every odd vertex of a level with what lies around it, by rising id.

use crate::hierarchy::{Layout, Site, row_slots};
use crate::memory::Buffer;
use bytemuck::Pod;
use rayon::prelude::*;
use std::convert::Infallible;

/// An odd vertex and its surroundings, by slot.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place<'a> {
    pub(super) odd: u32,
    /// In `M^{j+1}`, as those near.
    pub(super) slot: u32,
    /// Its neighbours in `M^{j+1}` that are odd: all but its parents.
    pub(super) near: &'a [u32],
    /// In `M^j`.
    pub(super) parents: [u32; 2],
}

/// Calls back for every odd vertex of a level until one is refused, and says which. `O(n_{j+1})`; inside base faces
/// everything is found along rows.
#[inline(always)]
pub(super) fn visit(
    coarse: &Layout,
    fine: &Layout,
    mut each: impl FnMut(Place) -> Result<(), u32>,
) -> Result<(), u32> {
    let (n, base) = (coarse.segments(), coarse.base().clone());
    for edge in 0..base.edges().len() as u32 {
        for s in 0..n {
            let site = Site::Edge { edge, t: 2 * s + 1 };
            let (mut near, mut count) = ([0; 4], 0);
            fine.for_each_neighbour(site, |site| {
                if is_odd(site) {
                    near[count] = fine.slot(site).0;
                    count += 1;
                }
            });
            let parents = on_edge(coarse, edge, s);
            each(Place { odd: edge * n + s, slot: fine.slot(site).0, near: &near[..count], parents })?;
        }
    }
    let mut rows = Rows::default();
    for face in 0..base.faces().len() as u32 {
        rows.in_face(coarse, fine, face, |odd, along, [down, row, up], i, parents| {
            let near = match (along, i % 2) {
                (Along::EveryOther, _) => [down[i], down[i + 1], up[i], up[i - 1]],
                (Along::All, 1) => [row[i - 1], row[i + 1], down[i], up[i]],
                (Along::All, _) => [row[i - 1], row[i + 1], down[i + 1], up[i - 1]],
            };
            each(Place { odd, slot: row[i], near: &near, parents })
        })?;
    }
    Ok(())
}

/// A value for each odd vertex of a level, by its slot in `M^{j+1}` and its parents' in `M^j`. `O(n_{j+1})`, in parallel over
/// base faces.
pub(super) fn of_odds<T: Pod + Send + Sync>(
    coarse: &Layout,
    fine: &Layout,
    make: impl Fn(u32, u32, [u32; 2]) -> T + Sync,
) -> Buffer<T> {
    of_odds_by_face(coarse, fine, |_, &mut ()| (), |&(), odd, slot, parents| make(odd, slot, parents))
}

/// [`of_odds`] with something prepared for each base face before its odd vertices are asked for; for those on edges nothing is.
pub(super) fn of_odds_by_face<T: Pod + Send + Sync, P: Default>(
    coarse: &Layout,
    fine: &Layout,
    prepare: impl Fn(u32, &mut P) + Sync,
    make: impl Fn(&P, u32, u32, [u32; 2]) -> T + Sync,
) -> Buffer<T> {
    let mut values = Buffer::zeroed(coarse.odd_len() as usize);
    let n = coarse.segments() as usize;
    let (on_edges, inside) = values.split_at_mut(n * coarse.base().edges().len());
    on_edges.par_chunks_mut(n).enumerate().with_min_len(1024 / n + 1).for_each(|(edge, values)| {
        let (edge, prepared) = (edge as u32, P::default());
        for (s, value) in (0..n as u32).zip(values) {
            let slot = fine.slot(Site::Edge { edge, t: 2 * s + 1 }).0;
            *value = make(&prepared, edge * n as u32 + s, slot, on_edge(coarse, edge, s));
        }
    });
    let faces = inside.par_chunks_mut((3 * n * (n - 1) / 2).max(1)).enumerate();
    faces.with_min_len(1024 / (n * n) + 1).for_each_init(
        <(Rows, P)>::default,
        |(rows, prepared), (face, values)| {
            prepare(face as u32, prepared);
            let mut values = values.iter_mut();
            let Ok(()) = rows.in_face(coarse, fine, face as u32, |odd, _, [_, row, _], i, parents| {
                *values.next().expect("as many as odd vertices") = make(prepared, odd, row[i], parents);
                Ok::<(), Infallible>(())
            });
        },
    );
    values
}

/// Whether a vertex of `M^{j+1}` is odd.
fn is_odd(site: Site) -> bool {
    match site {
        Site::Base(_) => false,
        Site::Edge { t, .. } => t % 2 == 1,
        Site::Face { i, r, .. } => i % 2 == 1 || r % 2 == 1,
    }
}

/// Which vertices of a row are odd.
#[derive(Debug, Clone, Copy)]
enum Along {
    All,
    EveryOther,
}

/// The parents of the odd vertex after `s` edges of `M^j` along a base edge.
fn on_edge(coarse: &Layout, edge: u32, s: u32) -> [u32; 2] {
    [s, s + 1].map(|t| coarse.slot(coarse.along_edge(edge, t)).0)
}

/// Slots of whole rows of a face's grid, borders included.
#[derive(Default)]
struct Rows {
    /// Of `M^{j+1}`: one row, the one before it and the one after.
    fine: [Vec<u32>; 3],
    /// Of `M^j`: the row at or before that row, and the one after.
    coarse: [Vec<u32>; 2],
}

impl Rows {
    /// Calls back for every odd vertex inside a face until one is refused: with the slots of the row before its own, its own
    /// and the one after, with which vertices of the row are odd, with its place along it, and with its parents.
    #[inline(always)]
    fn in_face<E>(
        &mut self,
        coarse: &Layout,
        fine: &Layout,
        face: u32,
        mut each: impl FnMut(u32, Along, [&[u32]; 3], usize, [u32; 2]) -> Result<(), E>,
    ) -> Result<(), E> {
        let n = coarse.segments();
        let mut odd = coarse.odd_face_start(face);
        (0..2).for_each(|r| row_slots(fine, face, r, &mut self.fine[r as usize]));
        row_slots(coarse, face, 0, &mut self.coarse[1]);
        for r in 1..2 * n - 1 {
            row_slots(fine, face, r + 1, &mut self.fine[2]);
            if r % 2 == 1 {
                self.coarse.rotate_left(1);
                row_slots(coarse, face, r / 2 + 1, &mut self.coarse[1]);
            }
            let last = (2 * n - r - 1) as usize;
            let rows = [&self.fine[0][..last + 3], &self.fine[1][..last + 2], &self.fine[2][..last + 1]];
            let [before, after] = [&self.coarse[0], &self.coarse[1]];
            if r % 2 == 1 {
                for i in 1..=last {
                    let parents = [before[i.div_ceil(2)], after[i / 2]];
                    each(odd, Along::All, rows, i, parents)?;
                    odd += 1;
                }
            } else {
                for i in (1..=last).step_by(2) {
                    each(odd, Along::EveryOther, rows, i, [after[i / 2], after[i / 2 + 1]])?;
                    odd += 1;
                }
            }
            self.fine.rotate_left(1);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hierarchy::{BaseMesh, Hierarchy, Level, Odd};
    use crate::mesh::shapes;
    use std::sync::Arc;

    /// An odd vertex: its slot, its neighbours' in ascending order, and its parents' in ascending order.
    type Found = (u32, Vec<u32>, [u32; 2]);

    fn sorted<const N: usize>(mut slots: [u32; N]) -> [u32; N] {
        slots.sort_unstable();
        slots
    }

    /// Read off one vertex at a time.
    fn plainly(coarse: &Layout, fine: &Layout, odd: Odd) -> Found {
        let site = coarse.odd_site(odd);
        let parents = coarse.parents(site).map(Layout::refine);
        let around = fine.ring(site).around.into_iter().filter(|site| !parents.contains(site));
        let mut near: Vec<u32> = around.map(|site| fine.slot(site).0).collect();
        near.sort_unstable();
        (fine.slot(site).0, near, sorted(coarse.parents(site).map(|site| coarse.slot(site).0)))
    }

    #[test]
    fn rows_give_what_single_vertices_have() {
        for (name, mesh) in shapes::awkward() {
            let base = BaseMesh::new(mesh.positions.len() as u32, mesh.faces.clone(), &[]).expect(name);
            let hierarchy = Hierarchy::new(Arc::new(base), Level(4)).expect("small");
            for j in 0..4 {
                let (coarse, fine) = (hierarchy.layout(Level(j)), hierarchy.layout(Level(j + 1)));
                let wanted: Vec<Found> =
                    (0..coarse.odd_len()).map(|odd| plainly(coarse, fine, Odd(odd))).collect();
                let mut visited = Vec::new();
                let end = visit(coarse, fine, |Place { odd, slot, near, parents }| {
                    assert_eq!(odd as usize, visited.len(), "{name}, level {j}: in order");
                    let mut near = near.to_vec();
                    near.sort_unstable();
                    visited.push((slot, near, sorted(parents)));
                    Ok(())
                });
                assert!(end.is_ok() && visited == wanted, "{name}, level {j}");
                let made = of_odds(coarse, fine, |odd, slot, parents| [[odd, slot], sorted(parents)]);
                let wanted: Vec<[[u32; 2]; 2]> =
                    (0..).zip(wanted).map(|(odd, (slot, _, parents))| [[odd, slot], parents]).collect();
                assert!(made[..] == wanted, "{name}, level {j}");
            }
        }
    }

    #[test]
    fn a_vertex_that_is_refused_is_the_last() {
        let mesh = shapes::octahedron();
        let base = BaseMesh::new(6, mesh.faces, &[]).expect("a base mesh");
        let hierarchy = Hierarchy::new(Arc::new(base), Level(3)).expect("small");
        let (coarse, fine) = (hierarchy.layout(Level(2)), hierarchy.layout(Level(3)));
        // On an edge, at the beginning of a face and inside one.
        for refused in [7, coarse.odd_face_start(0), coarse.odd_face_start(3) + 5] {
            let mut seen = 0;
            let end = visit(coarse, fine, |place| {
                seen += 1;
                if place.odd == refused { Err(place.odd) } else { Ok(()) }
            });
            assert_eq!((end, seen), (Err(refused), refused + 1));
        }
    }
}
