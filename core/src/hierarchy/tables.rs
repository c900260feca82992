//! `M^0 … M^J` together: one layout a level, and the triangles and edges of any level for drawing and export.

use super::{BaseMesh, Layout, Level, Site, Slot};
use std::sync::Arc;

/// The hierarchy of meshes over a base mesh, without positions.
#[derive(Debug, Clone)]
pub struct Hierarchy {
    base: Arc<BaseMesh>,
    layouts: Vec<Layout>,
}

/// Calls back for the triangles of `M^j` in one base face, as the slots of their corners; `rows` is room to work in.
pub(crate) fn for_each_triangle_of_face(
    layout: &Layout,
    face: u32,
    [lower, upper]: &mut [Vec<u32>; 2],
    mut found: impl FnMut([u32; 3]),
) {
    row_slots(layout, face, 0, lower);
    for r in 1..=layout.segments() {
        row_slots(layout, face, r, upper);
        let (pairs, last) = (upper.len() - 1, upper[upper.len() - 1]);
        let rows = lower.windows(3).zip(upper.windows(2));
        for (low, up) in rows {
            found([low[0], low[1], up[0]]);
            found([low[1], up[1], up[0]]);
        }
        found([lower[pairs], lower[pairs + 1], last]);
        std::mem::swap(lower, upper);
    }
}

impl Hierarchy {
    /// The hierarchy with finest level `J`, or `None` if `M^J` would have 2^31 vertices or more.
    pub fn new(base: Arc<BaseMesh>, finest: Level) -> Option<Self> {
        let layouts = (0..=finest.0).map(|j| Layout::checked(&base, Level(j))).collect::<Option<_>>()?;
        Some(Self { base, layouts })
    }

    /// The base mesh.
    pub fn base(&self) -> &Arc<BaseMesh> {
        &self.base
    }

    /// The finest level J.
    pub fn finest(&self) -> Level {
        Level(self.layouts.len() as u8 - 1)
    }

    /// The layout of a level up to J.
    pub fn layout(&self, level: Level) -> &Layout {
        &self.layouts[level.index()]
    }

    /// The number of faces of `M^j`.
    pub fn face_count(&self, level: Level) -> u64 {
        (self.base.faces().len() as u64) << (2 * u32::from(level.0))
    }

    /// The faces of `M^j` as slots, oriented, base face by base face, row by row. Linear in their number.
    pub fn triangles(&self, level: Level) -> Vec<[u32; 3]> {
        let mut triangles = Vec::with_capacity(self.face_count(level) as usize);
        self.for_each_triangle(level, |corners| triangles.push(corners));
        triangles
    }

    /// Calls back for [`Hierarchy::triangles`], none of which is kept.
    pub fn for_each_triangle(&self, level: Level, mut found: impl FnMut([u32; 3])) {
        let mut rows = Default::default();
        for face in 0..self.base.faces().len() as u32 {
            for_each_triangle_of_face(self.layout(level), face, &mut rows, &mut found);
        }
    }

    /// The edges of `M^j` as the slots of their ends. Linear in their number.
    pub fn edges(&self, level: Level) -> Vec<[u32; 2]> {
        let layout = self.layout(level);
        if level == Level::BASE {
            return self.base.edges().to_vec();
        }
        let mut edges = Vec::new();
        for e in 0..self.base.edges().len() as u32 {
            let slot = |t| layout.slot(layout.along_edge(e, t)).0;
            edges.extend((0..layout.segments()).map(|t| [slot(t), slot(t + 1)]));
        }
        let n = layout.segments();
        let (mut lower, mut upper) = (Vec::new(), Vec::new());
        for face in 0..self.base.faces().len() as u32 {
            row_slots(layout, face, 0, &mut lower);
            for r in 1..=n {
                row_slots(layout, face, r, &mut upper);
                // Inner edges only: along the row, and the two slanted families without the face's own border.
                edges.extend(upper.windows(2).map(|w| [w[0], w[1]]));
                for i in 0..upper.len() {
                    if i > 0 {
                        edges.push([lower[i], upper[i]]);
                    }
                    if i + 1 < upper.len() {
                        edges.push([lower[i + 1], upper[i]]);
                    }
                }
                std::mem::swap(&mut lower, &mut upper);
            }
        }
        edges
    }

    /// The edges of `M^j` as they run over `M^shown`: pairs of neighbouring slots of level `shown ≥ level`. Linear in
    /// their number, `2^(shown − level)` for each edge.
    pub fn edges_shown_on(&self, level: Level, shown: Level) -> Vec<[u32; 2]> {
        let layout = self.layout(shown);
        let n = layout.segments();
        let step = 1 << (shown.0 - level.0);
        let mut segments = Vec::new();
        for e in 0..self.base.edges().len() as u32 {
            let slot = |t| layout.slot(layout.along_edge(e, t)).0;
            segments.extend((0..n).map(|t| [slot(t), slot(t + 1)]));
        }
        for face in 0..self.base.faces().len() as u32 {
            for c in 0..3 {
                // Lines parallel to the edge opposite corner c, the edge itself left out.
                for across in (step..n).step_by(step as usize) {
                    let slot = |along: u32| {
                        let mut b = [0; 3];
                        b[c] = across;
                        b[(c + 1) % 3] = along;
                        b[(c + 2) % 3] = n - across - along;
                        layout.slot(layout.site_at(face, b)).0
                    };
                    segments.extend((0..n - across).map(|along| [slot(along), slot(along + 1)]));
                }
            }
        }
        segments
    }

    /// The slot, at a finer level `to`, of a vertex of level `from`.
    pub fn refine_slot(&self, from: Level, to: Level, slot: Slot) -> Slot {
        let mut site = self.layout(from).site(slot);
        for _ in from.0..to.0 {
            site = Layout::refine(site);
        }
        self.layout(to).slot(site)
    }

    /// The sites of a level in slot order.
    pub fn sites(&self, level: Level) -> impl Iterator<Item = Site> + '_ {
        let layout = self.layout(level);
        (0..layout.len()).map(|s| layout.site(Slot(s)))
    }
}

/// The slots of row `r` of a face's whole grid, borders included: `n − r + 1` of them.
pub fn row_slots(layout: &Layout, face: u32, r: u32, row: &mut Vec<u32>) {
    let n = layout.segments();
    row.clear();
    if r == 0 || r + 1 >= n {
        row.extend((0..=n - r).map(|i| layout.slot(layout.site_at(face, [n - r - i, i, r])).0));
        return;
    }
    let first = layout.row(face, r).0;
    row.push(layout.slot(layout.site_at(face, [n - r, 0, r])).0);
    row.extend(first..first + (n - r - 1));
    row.push(layout.slot(layout.site_at(face, [0, n - r, r])).0);
}
