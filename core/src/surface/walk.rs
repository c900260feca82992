//! From a vertex to the place of the surface near a point, step by step.
//!
//! Where many neighbouring places are asked for, each lies next to the one before, and a few steps find it. Unlike
//! [`Surface::nearest`] this ends in a local minimum: it never jumps to another sheet.

use super::bounds::{closest_within, meet};
use super::{Nearest, Surface};
use crate::hierarchy::{Site, Subtriangle};
use glam::DVec3;

impl Surface {
    /// Goes from a vertex of the finest level to ever closer neighbours of a point, in steps; the vertex where none is
    /// closer, and the closest place in the triangles around it. Cost: the way, and nothing else.
    pub(crate) fn walk(&self, from: Site, point: [f64; 3]) -> (Site, Nearest) {
        let layout = self.hierarchy().layout(self.finest());
        let positions = self.scaling(self.finest());
        let p = DVec3::from_array(point);
        let distance = |site: Site| {
            let at = positions[layout.slot(site).index()];
            (DVec3::from_array(at.map(f64::from)) - p).length_squared()
        };
        let mut best = (distance(from), from);
        loop {
            let mut next = best;
            layout.for_each_neighbour(best.1, |site| {
                // Of neighbours equally far the first in the layout's order counts.
                let there = (distance(site), site);
                if there.0 < next.0 || (there.0 == next.0 && next.1 != best.1 && there.1 < next.1) {
                    next = there;
                }
            });
            if next.1 == best.1 {
                break;
            }
            best = next;
        }
        let mut found: Option<(f64, Subtriangle)> = None;
        let mut look = |triangle| {
            let squared = closest_within(layout, positions, p, triangle).1;
            if found.is_none_or(|(least, _)| squared < least) {
                found = Some((squared, triangle));
            }
        };
        match best.1 {
            Site::Face { face, i, r } => {
                Subtriangle::around(face, i, r, layout.segments()).for_each(&mut look);
            }
            site => Subtriangle::incident(layout, site).into_iter().for_each(&mut look),
        }
        let (_, triangle) = found.expect("a vertex has triangles");
        (best.1, meet(layout, positions, p, triangle))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hierarchy::{BaseMesh, Hierarchy, Level, Slot};
    use crate::mesh::shapes;
    use crate::surface::FormOptions;
    use std::sync::Arc;

    /// On a ball there is one minimum near a point outside, and the way leads there over base edges and base vertices.
    #[test]
    fn on_a_ball_the_way_ends_at_the_nearest_place() {
        let mesh = shapes::octahedron();
        let base = Arc::new(BaseMesh::new(6, mesh.faces.clone(), &[]).expect("a base mesh"));
        let hierarchy = Hierarchy::new(base, Level(4)).expect("small");
        let layout = hierarchy.layout(Level(4));
        let positions: Vec<[f64; 3]> = (0..layout.len())
            .map(|slot| {
                let (face, b) = layout.chart(layout.site(Slot(slot)));
                let corners = hierarchy.base().faces()[face as usize].map(|v| mesh.positions[v as usize]);
                let p: DVec3 = (0..3).map(|k| DVec3::from_array(corners[k]) * f64::from(b[k])).sum::<DVec3>();
                p.normalize().to_array()
            })
            .collect();
        let surface = Surface::from_positions(hierarchy.clone(), &positions, &FormOptions::default());
        let surface = surface.expect("a ball");
        let radius = f64::from(1 << 24);
        for k in 0..200u32 {
            let (turn, height) = (f64::from(k) * 0.7, f64::from(k % 21) * 0.09 - 0.9);
            let p = [turn.cos(), height, turn.sin()].map(|x| x * radius * 0.8);
            let start = layout.site(Slot(k * 37 % layout.len()));
            let (_, walked) = surface.walk(start, p);
            let nearest = surface.nearest(p);
            assert_eq!(walked.point, nearest.point, "{k}");
            assert_eq!(walked.squared_distance, nearest.squared_distance, "{k}");
        }
    }
}
