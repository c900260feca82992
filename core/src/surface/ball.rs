//! A ball, to be measured, tested and shown.

use super::{FormOptions, Surface};
use crate::hierarchy::{BaseMesh, Hierarchy, Level, Slot};
use crate::mesh::shapes;
use rayon::prelude::*;
use std::sync::Arc;

impl Surface {
    /// A ball over an octahedron, its corners on the axes, whose radius is a function of the direction from its middle, a unit
    /// vector. `4^(levels + 1) + 2` vertices; linear in them.
    ///
    /// # Panics
    /// If there are more levels than a surface can have, or a radius is not finite.
    pub fn ball(levels: u8, radius: impl Fn([f64; 3]) -> f64 + Sync) -> Self {
        let mesh = shapes::octahedron();
        let base = Arc::new(BaseMesh::new(6, mesh.faces.clone(), &[]).expect("a base mesh"));
        let hierarchy = Hierarchy::new(base, Level(levels)).expect("levels that fit");
        let layout = hierarchy.layout(Level(levels));
        let place = |slot: u32| {
            let (face, b) = layout.chart(layout.site(Slot(slot)));
            let corners = hierarchy.base().faces()[face as usize].map(|v| mesh.positions[v as usize]);
            let p: [f64; 3] = std::array::from_fn(|c| (0..3).map(|k| f64::from(b[k]) * corners[k][c]).sum());
            let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
            let radius = radius(p.map(|x| x / length));
            p.map(|x| x / length * radius)
        };
        let positions: Vec<[f64; 3]> = (0..layout.len()).into_par_iter().map(place).collect();
        Self::from_positions(hierarchy, &positions, &FormOptions::default()).expect("a ball")
    }
}
