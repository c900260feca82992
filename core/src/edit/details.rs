//! What the brushes that change detail do to wavelet coefficients.
//!
//! Smooth and sharpen work between a coefficient and the value that a smooth surface through `c^j` would have there,
//! that of the butterfly scheme (Dyn, Levin, Gregory, "A Butterfly Subdivision Scheme for Surface Interpolation with
//! Tension Control", ACM Transactions on Graphics 9(2), 1990): so smoothing ends in a smooth surface, not in the flat
//! faces of a level.

use super::reach::{Steps, minus, plus, steps, times};
use super::spread::beside;
use super::stroke::Tool;
use crate::hierarchy::{Layout, Site};
use crate::surface::Vector;

/// The wavelet coefficient of a smooth surface at an odd vertex: the butterfly's weights 1/8 and −1/16 without the mean of
/// the parents; four points along a boundary. Zero where the neighbourhood is cut off.
pub(super) fn smooth_detail(coarse: &Layout, positions: &[Vector], odd: Site) -> Steps {
    let at = |site: Site| steps(positions[coarse.slot(site).index()]);
    if let Some(inside) = butterfly_inside(coarse, odd) {
        let [sides, wings] = inside;
        let near = plus(at(sides[0]), at(sides[1]));
        let far = wings.into_iter().fold([0.0; 3], |sum, site| plus(sum, at(site)));
        return times(minus(times(near, 2.0), far), 1.0 / 16.0);
    }
    let [u, w] = coarse.parents(odd);
    let (around_u, around_w) = (coarse.ring(u), coarse.ring(w));
    let place = |ring: &[Site], site: Site| ring.iter().position(|&s| s == site);
    let (Some(k), Some(m)) = (place(&around_u.around, w), place(&around_w.around, u)) else {
        return [0.0; 3];
    };
    let along = |ring: &crate::hierarchy::Ring<Site>, at: usize, by: isize| {
        let len = ring.around.len() as isize;
        let to = at as isize + by;
        match ring.closed {
            true => Some(ring.around[to.rem_euclid(len) as usize]),
            false => usize::try_from(to).ok().and_then(|to| ring.around.get(to)).copied(),
        }
    };
    let [a, b] = [1, -1].map(|by| along(&around_u, k, by));
    if a.is_none() || b.is_none() {
        return along_boundary(coarse, positions, [u, w]);
    }
    let wings =
        [along(&around_u, k, 2), along(&around_u, k, -2), along(&around_w, m, 2), along(&around_w, m, -2)];
    let (Some(a), Some(b)) = (a, b) else { return [0.0; 3] };
    let mut far = [0.0; 3];
    for wing in wings {
        let Some(wing) = wing else { return [0.0; 3] };
        far = plus(far, at(wing));
    }
    times(minus(times(plus(at(a), at(b)), 2.0), far), 1.0 / 16.0)
}

/// Four points on a boundary: `(−1, 9, 9, −1)/16` without the mean of the parents.
fn along_boundary(coarse: &Layout, positions: &[Vector], [u, w]: [Site; 2]) -> Steps {
    let at = |site: Site| steps(positions[coarse.slot(site).index()]);
    let beyond = |site: Site, not: Site| {
        let ring = coarse.ring(site);
        let ends = [ring.around[0], ring.around[ring.around.len() - 1]];
        (!ring.closed).then(|| ends.into_iter().find(|&end| end != not)).flatten()
    };
    match (beyond(u, w), beyond(w, u)) {
        (Some(before), Some(after)) => {
            let (near, far) = (plus(at(u), at(w)), plus(at(before), at(after)));
            times(minus(near, far), 1.0 / 16.0)
        }
        _ => [0.0; 3],
    }
}

/// The vertices beside the edge that an odd vertex halves; on a boundary the edge's low end stands for the one missing.
pub(super) fn opposite(coarse: &Layout, odd: Site) -> Option<[Site; 2]> {
    if let Site::Face { face, i, r } = odd {
        let (n, i, r) = (2 * coarse.segments() as i32, i as i32, r as i32);
        let sides = match (i % 2, r % 2) {
            (1, 0) => [(-1, 2), (1, -2)],
            (0, 1) => [(2, -1), (-2, 1)],
            _ => [(1, 1), (-1, -1)],
        };
        // Inside a face the two lie in it, borders included.
        return Some(sides.map(|(di, dr)| {
            let (i, r) = ((i + di) as u32 / 2, (r + dr) as u32 / 2);
            coarse.site_at(face, [n as u32 / 2 - i - r, i, r])
        }));
    }
    let [u, w] = coarse.parents(odd);
    match beside(coarse, [u, w]) {
        [Some(a), Some(b)] => Some([a, b]),
        [Some(a), None] => Some([a, u]),
        [None, Some(b)] => Some([u, b]),
        [None, None] => None,
    }
}

/// The two vertices opposite an edge and the four wings, by arithmetic, where all lie inside the base face.
fn butterfly_inside(coarse: &Layout, odd: Site) -> Option<[Vec<Site>; 2]> {
    let Site::Face { face, i, r } = odd else { return None };
    let fine = 2 * coarse.segments() as i32;
    let (i, r) = (i as i32, r as i32);
    // Offsets, at level j + 1, of an even vertex beside the edge and of the wings on its side.
    let (sides, wings) = match (i % 2, r % 2) {
        (1, 0) => ([(-1, 2), (1, -2)], [(-3, 2), (1, 2), (3, -2), (-1, -2)]),
        (0, 1) => ([(2, -1), (-2, 1)], [(2, -3), (2, 1), (-2, 3), (-2, -1)]),
        _ => ([(1, 1), (-1, -1)], [(3, -1), (-1, 3), (1, -3), (-3, 1)]),
    };
    let inside = |&(di, dr): &(i32, i32)| i + di > 0 && r + dr > 0 && i + di + r + dr < fine;
    if !sides.iter().chain(&wings).all(inside) {
        return None;
    }
    let site = |(di, dr): (i32, i32)| Site::Face { face, i: ((i + di) / 2) as u32, r: ((r + dr) / 2) as u32 };
    Some([sides.into_iter().map(site).collect(), wings.into_iter().map(site).collect()])
}

/// The new value of a wavelet coefficient under a brush, in steps before rounding. `amount` is strength times weight.
pub(super) fn brushed(tool: Tool, detail: Steps, smooth: Steps, amount: f64) -> Steps {
    match tool {
        Tool::Smooth => plus(smooth, times(minus(detail, smooth), 1.0 - amount.min(1.0))),
        Tool::Sharpen => plus(smooth, times(minus(detail, smooth), 1.0 + amount)),
        _ => times(detail, 1.0 - amount.min(1.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hierarchy::{BaseMesh, Hierarchy, Level, Odd, Slot};
    use crate::mesh::shapes;
    use std::sync::Arc;

    /// Inside and across base edges alike: the stencil found by arithmetic is the one found by rings.
    #[test]
    fn arithmetic_and_rings_give_the_same_stencil() {
        for (name, mesh) in shapes::awkward() {
            let base = BaseMesh::new(mesh.positions.len() as u32, mesh.faces.clone(), &[]).expect(name);
            let hierarchy = Hierarchy::new(Arc::new(base), Level(4)).expect("small");
            let coarse = hierarchy.layout(Level(3));
            for odd in (0..coarse.odd_len()).map(Odd) {
                let site = coarse.odd_site(odd);
                let Some([sides, wings]) = butterfly_inside(coarse, site) else { continue };
                let [u, w] = coarse.parents(site);
                let common = |a: Site, b: Site| {
                    let other = coarse.ring(b).around;
                    coarse.ring(a).around.into_iter().filter(|s| other.contains(s)).collect::<Vec<_>>()
                };
                let mut opposite = common(u, w);
                let mut found = sides.clone();
                let key = |s: &Site| coarse.slot(*s);
                opposite.sort_unstable_by_key(key);
                found.sort_unstable_by_key(key);
                assert_eq!(found, opposite, "{name}, {site:?}");
                let mut sides_alone = super::opposite(coarse, site).expect("inside").to_vec();
                sides_alone.sort_unstable_by_key(key);
                assert_eq!(found, sides_alone, "{name}, {site:?}");
                for wing in wings {
                    let touches = [u, w].into_iter().any(|end| {
                        sides.iter().any(|&side| common(end, side).contains(&wing) && wing != u && wing != w)
                    });
                    assert!(touches, "{name}, {site:?}: {wing:?}");
                }
            }
        }
    }

    /// A plane has no detail, and neither has what lies straight along its boundary.
    #[test]
    fn flat_surfaces_have_no_smooth_detail_inside() {
        let (_, mesh) = shapes::awkward().into_iter().find(|(n, _)| *n == "open disc").expect("a known mesh");
        let base = BaseMesh::new(mesh.positions.len() as u32, mesh.faces.clone(), &[]).expect("a base mesh");
        let hierarchy = Hierarchy::new(Arc::new(base), Level(4)).expect("small");
        let coarse = hierarchy.layout(Level(3));
        // Linear within base faces: only stencils inside one see a plane.
        let corner = |v: u32| [v as i32 * 4096, (v * v) as i32 * 1024, -(v as i32) * 512];
        let positions: Vec<Vector> = (0..coarse.len())
            .map(|slot| {
                let (face, b) = coarse.chart(coarse.site(Slot(slot)));
                let corners = coarse.base().faces()[face as usize].map(corner);
                std::array::from_fn(|c| (0..3).map(|k| b[k] as i32 * corners[k][c] / 8).sum())
            })
            .collect();
        let mut seen = 0;
        for odd in (0..coarse.odd_len()).map(Odd) {
            let site = coarse.odd_site(odd);
            if butterfly_inside(coarse, site).is_some() {
                assert_eq!(smooth_detail(coarse, &positions, site), [0.0; 3], "{site:?}");
                seen += 1;
            }
        }
        assert!(seen > 20);
    }
}
