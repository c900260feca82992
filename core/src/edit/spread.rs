//! A smooth spread: how a pull on coefficients of one level bends the finer ones.
//!
//! A hat makes a tent with creases. The smooth spread refines the pull instead by the rules of Loop subdivision (C. Loop,
//! "Smooth Subdivision Surfaces Based on Triangles", University of Utah, 1987) with Warren's weights, and by those of
//! Hoppe and others ("Piecewise Smooth Surface Reconstruction", SIGGRAPH 1994) on sharp edges and boundaries, which keep
//! creases creases. Rational weights alone, summed in the order of rings: the same bits everywhere.

use crate::hierarchy::{Hierarchy, Layout, Level, Ring, Site, Slot};
use rustc_hash::FxHashMap;

/// Levels over which a pull is refined smoothly; beyond them the level's faces are too small to be seen as flat.
pub(super) const SMOOTH_LEVELS: u8 = 6;

/// A weight for each axis.
pub(super) type Weights = [f64; 3];

/// The weights of a level's vertices, where they are not all zero, refined to a finer level. Cost: the support there.
pub(super) fn refined(
    hierarchy: &Hierarchy,
    from: Level,
    weights: Vec<(Slot, Weights)>,
    to: Level,
) -> Vec<(Slot, Weights)> {
    let layout = hierarchy.layout(from);
    let mut sites: Vec<(Site, Weights)> =
        weights.into_iter().map(|(slot, w)| (layout.site(slot), w)).collect();
    for level in (from.0..to.0).map(Level) {
        sites = one_finer(hierarchy.layout(level), hierarchy.layout(level.finer()), &sites);
    }
    let layout = hierarchy.layout(to);
    let mut by_slot: Vec<(Slot, Weights)> =
        sites.into_iter().map(|(site, w)| (layout.slot(site), w)).collect();
    by_slot.sort_unstable_by_key(|&(slot, _)| slot);
    by_slot
}

fn one_finer(coarse: &Layout, fine: &Layout, weights: &[(Site, Weights)]) -> Vec<(Site, Weights)> {
    let values: FxHashMap<Slot, Weights> = weights.iter().map(|&(s, w)| (coarse.slot(s), w)).collect();
    let at = |site: Site| values.get(&coarse.slot(site)).copied().unwrap_or_default();
    let mut seen: FxHashMap<Slot, ()> = FxHashMap::default();
    let mut finer = Vec::with_capacity(4 * weights.len() + 64);
    let mut odd =
        |finer: &mut Vec<(Site, Weights)>, site: Site, a: Site, b: Site, beside: [Option<Site>; 2]| {
            if seen.insert(fine.slot(site), ()).is_none() {
                finer.push((site, odd_value(coarse, site, [a, b], beside, &at)));
            }
        };
    let mut evens: FxHashMap<Slot, ()> = FxHashMap::default();
    for &(site, _) in weights {
        let ring = coarse.ring(site);
        let count = ring.around.len();
        for even in std::iter::once(site).chain(ring.around.iter().copied()) {
            if evens.insert(coarse.slot(even), ()).is_none() {
                finer.push((Layout::refine(even), even_value(coarse, even, &at)));
            }
        }
        let next = |k: usize| (k + 1 < count || ring.closed).then(|| ring.around[(k + 1) % count]);
        let before = |k: usize| (k > 0 || ring.closed).then(|| ring.around[(k + count - 1) % count]);
        for (k, &neighbour) in ring.around.iter().enumerate() {
            let middle = coarse.midpoint(site, neighbour);
            odd(&mut finer, middle, site, neighbour, [next(k), before(k)]);
            if let Some(other) = next(k) {
                // The edge opposite the vertex: this vertex is one of those beside it.
                let middle = coarse.midpoint(neighbour, other);
                let beyond = beside(coarse, [neighbour, other]).into_iter().flatten().find(|&s| s != site);
                odd(&mut finer, middle, neighbour, other, [Some(site), beyond]);
            }
        }
    }
    finer.retain(|(_, w)| *w != [0.0; 3]);
    finer
}

/// The vertices that make a face with the ends of an edge.
pub(super) fn beside(layout: &Layout, [u, w]: [Site; 2]) -> [Option<Site>; 2] {
    let Ring { around, closed } = layout.ring(u);
    let Some(k) = around.iter().position(|&s| s == w) else { return [None; 2] };
    let count = around.len();
    let next = (k + 1 < count || closed).then(|| around[(k + 1) % count]);
    let before = (k > 0 || closed).then(|| around[(k + count - 1) % count]);
    [next, before]
}

fn is_crease(layout: &Layout, edge: u32) -> bool {
    layout.base().is_sharp(edge) || layout.base().is_boundary_edge(edge)
}

fn odd_value(
    coarse: &Layout,
    odd: Site,
    [u, w]: [Site; 2],
    beside: [Option<Site>; 2],
    at: &impl Fn(Site) -> Weights,
) -> Weights {
    let (u, w) = (at(u), at(w));
    let crease = matches!(odd, Site::Edge { edge, .. } if is_crease(coarse, edge));
    match beside {
        [Some(a), Some(b)] if !crease => {
            // The order in which two sides are met does not matter: their sum is taken first.
            let (a, b) = (at(a), at(b));
            std::array::from_fn(|c| 0.375 * (u[c] + w[c]) + 0.125 * (a[c] + b[c]))
        }
        _ => std::array::from_fn(|c| 0.5 * (u[c] + w[c])),
    }
}

fn even_value(coarse: &Layout, even: Site, at: &impl Fn(Site) -> Weights) -> Weights {
    let own = at(even);
    let (creases, ring) = match even {
        Site::Face { .. } => (Vec::new(), coarse.ring(even)),
        Site::Edge { edge, t } if is_crease(coarse, edge) => {
            (vec![coarse.along_edge(edge, t - 1), coarse.along_edge(edge, t + 1)], coarse.ring(even))
        }
        Site::Edge { .. } => (Vec::new(), coarse.ring(even)),
        Site::Base(v) => {
            let ring = coarse.ring(even);
            let along = |&site: &Site| {
                let edge = match site {
                    Site::Edge { edge, .. } => edge,
                    Site::Base(w) => coarse
                        .base()
                        .edges()
                        .binary_search(&[v.min(w), v.max(w)])
                        .expect("neighbours share an edge") as u32,
                    Site::Face { .. } => return false,
                };
                is_crease(coarse, edge)
            };
            (ring.around.iter().copied().filter(along).collect(), ring)
        }
    };
    match creases.as_slice() {
        [] | [_] if ring.closed => {
            let count = ring.around.len() as f64;
            let share = if ring.around.len() == 3 { 3.0 / 16.0 } else { 3.0 / (8.0 * count) };
            let sum = ring.around.iter().fold([0.0; 3], |sum: Weights, &site| {
                let value = at(site);
                std::array::from_fn(|c| sum[c] + value[c])
            });
            std::array::from_fn(|c| (1.0 - count * share) * own[c] + share * sum[c])
        }
        [a, b] => {
            let (a, b) = (at(*a), at(*b));
            std::array::from_fn(|c| 0.75 * own[c] + 0.125 * (a[c] + b[c]))
        }
        _ => own,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hierarchy::BaseMesh;
    use crate::mesh::shapes;
    use std::sync::Arc;

    fn hierarchy(mesh: &crate::mesh::TriangleMesh, sharp: &[[u32; 2]], levels: u8) -> Hierarchy {
        let base =
            BaseMesh::new(mesh.positions.len() as u32, mesh.faces.clone(), sharp).expect("a base mesh");
        Hierarchy::new(Arc::new(base), Level(levels)).expect("small")
    }

    /// Pulling everything alike moves everything alike: the weights of all vertices add up to one.
    #[test]
    fn all_spreads_together_are_one_everywhere() {
        for (name, mesh) in shapes::awkward() {
            let sharp: Vec<[u32; 2]> = mesh.faces.iter().take(2).map(|f| [f[0], f[1]]).collect();
            let hierarchy = hierarchy(&mesh, &sharp, 3);
            let all = (0..hierarchy.layout(Level(1)).len()).map(|s| (Slot(s), [1.0, 0.5, 0.0])).collect();
            let finer = refined(&hierarchy, Level(1), all, Level(3));
            assert_eq!(finer.len(), hierarchy.layout(Level(3)).len() as usize, "{name}");
            for (slot, w) in finer {
                assert!(
                    (w[0] - 1.0).abs() < 1e-12 && (w[1] - 0.5).abs() < 1e-12 && w[2] == 0.0,
                    "{name}, {slot:?}"
                );
            }
        }
    }

    /// One vertex after another gives what both together give, whatever the order.
    #[test]
    fn spreads_add_up_and_do_not_depend_on_order() {
        for (name, mesh) in shapes::awkward() {
            let hierarchy = hierarchy(&mesh, &[], 4);
            let last = Slot(hierarchy.layout(Level(1)).len() - 1);
            let spread = |of: Vec<(Slot, Weights)>| refined(&hierarchy, Level(1), of, Level(4));
            let (a, b) = ((Slot(0), [1.0; 3]), (last, [0.25, 0.5, -1.0]));
            let together = spread(vec![a, b]);
            assert!(together == spread(vec![b, a]), "{name}");
            let mut sum = vec![[0.0; 3]; hierarchy.layout(Level(4)).len() as usize];
            for (slot, w) in spread(vec![a]).into_iter().chain(spread(vec![b])) {
                sum[slot.index()] = std::array::from_fn(|c| sum[slot.index()][c] + w[c]);
            }
            for (slot, w) in &together {
                assert!((0..3).all(|c| (sum[slot.index()][c] - w[c]).abs() < 1e-12), "{name}, {slot:?}");
            }
        }
    }

    /// A crease stays where it is when something beside it is pulled.
    #[test]
    fn creases_follow_their_own_vertices_alone() {
        let mesh = shapes::octahedron();
        let hierarchy = hierarchy(&mesh, &[[0, 2], [0, 3], [1, 3], [1, 2]], 4);
        let finer = refined(&hierarchy, Level(0), vec![(Slot(4), [1.0; 3])], Level(4));
        let layout = hierarchy.layout(Level(4));
        for edge in 0..12 {
            if hierarchy.base().is_sharp(edge) {
                for t in 1..layout.segments() {
                    let slot = layout.slot(Site::Edge { edge, t });
                    assert!(finer.iter().all(|&(s, _)| s != slot), "edge {edge}, {t}");
                }
            }
        }
        assert!(finer.len() > 100);
    }
}
