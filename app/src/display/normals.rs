//! Vertex normals by rows: a vertex's faces' normals, weighted by area, made unit length.
//!
//! Around a vertex `c` of the regular lattice with neighbours `p0 … p5` the six cross products of neighbouring edges fold
//! into three: `(p0−p2)×(p1−c) + (p2−p4)×(p3−c) + (p4−p0)×(p5−c)`. Inside a base face they are taken for a whole row
//! at once; elsewhere around each vertex alone.

use bozzetto_core::hierarchy::{Layout, Site, Slot};
use bozzetto_core::memory::Buffer;
use glam::DVec3;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use std::ops::Range;

/// Fewer vertices are not worth a thread.
const WORTH_THREADS: usize = 1 << 14;

/// The normals of all vertices. Linear in their number.
pub(super) fn all(layout: &Layout, positions: &[[f32; 3]]) -> Buffer<[f32; 3]> {
    let mut normals = Buffer::zeroed(positions.len());
    refresh_all(layout, positions, &mut normals);
    normals
}

/// [`all`] into given storage.
pub(super) fn refresh_all(layout: &Layout, positions: &[[f32; 3]], normals: &mut [[f32; 3]]) {
    let rows = rows_of(layout, std::iter::once(0..layout.len()));
    refresh(layout, positions, &rows, normals);
}

/// A run of slots within one row of storage.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Row {
    /// On base vertices or edges.
    Border(Range<u32>),
    /// Inside a base face: face, row, columns.
    Inside(u32, u32, Range<u32>),
}

impl Row {
    /// The slots.
    pub(super) fn slots(&self, layout: &Layout) -> Range<u32> {
        match self {
            Row::Border(slots) => slots.clone(),
            Row::Inside(face, r, columns) => {
                let first = layout.row(*face, *r).0;
                first + columns.start - 1..first + columns.end - 1
            }
        }
    }
}

/// Cuts sorted runs of slots into rows.
pub(super) fn rows_of(layout: &Layout, runs: impl Iterator<Item = Range<u32>>) -> Vec<Row> {
    let borders = layout.row(0, 1).0;
    let n = layout.segments();
    let mut rows = Vec::new();
    for mut run in runs {
        if run.start < borders {
            rows.push(Row::Border(run.start..run.end.min(borders)));
            run.start = run.end.min(borders);
        }
        while !run.is_empty() {
            let Site::Face { face, i, r } = layout.site(Slot(run.start)) else {
                unreachable!("inside a face")
            };
            let end = (i + run.len() as u32).min(n - r);
            rows.push(Row::Inside(face, r, i..end));
            run.start += end - i;
        }
    }
    rows
}

/// Rows and all vertices next to them.
pub(super) fn widened(layout: &Layout, rows: &[Row]) -> Vec<Row> {
    let n = layout.segments();
    let (mut borders, mut inside) = (Vec::new(), Vec::new());
    let mut beside = |slot: u32| {
        let site = layout.site(Slot(slot));
        let mut add = |site| match site {
            Site::Face { face, i, r } => inside.push((face, r, i..i + 1)),
            _ => borders.push(layout.slot(site).0),
        };
        add(site);
        layout.for_each_neighbour(site, add);
    };
    let mut wide = Vec::new();
    for row in rows {
        match row {
            Row::Border(slots) => slots.clone().for_each(&mut beside),
            Row::Inside(face, r, columns) => {
                let Range { start, end } = columns.clone();
                for (r, start, end) in
                    [(r - 1, start, end + 1), (*r, start - 1, end + 1), (r + 1, start - 1, end)]
                {
                    let columns = start.max(1)..end.min(n.saturating_sub(r).max(1));
                    if r > 0 && !columns.is_empty() {
                        wide.push((*face, r, columns));
                    }
                }
                let first = layout.row(*face, *r).0 - 1;
                let on_border = |i: &u32| *r == 1 || *i == 1 || i + r == n - 1;
                if *r == 1 {
                    columns.clone().for_each(|i| beside(first + i));
                } else {
                    [start, end - 1].iter().filter(|i| on_border(i)).for_each(|i| beside(first + i));
                }
            }
        }
    }
    inside.extend(wide);
    inside.sort_unstable_by_key(|(face, r, columns)| (*face, *r, columns.start));
    borders.sort_unstable();
    borders.dedup();
    let mut joined: Vec<Row> =
        borders.chunk_by(|a, b| a + 1 == *b).map(|run| Row::Border(run[0]..run[run.len() - 1] + 1)).collect();
    for (face, r, columns) in inside {
        match joined.last_mut() {
            Some(Row::Inside(f, s, last)) if (*f, *s) == (face, r) && columns.start <= last.end => {
                last.end = last.end.max(columns.end);
            }
            _ => joined.push(Row::Inside(face, r, columns)),
        }
    }
    joined
}

/// Computes the normals of some rows, sorted and apart, anew.
pub(super) fn refresh(layout: &Layout, positions: &[[f32; 3]], rows: &[Row], normals: &mut [[f32; 3]]) {
    // The rows as disjoint parts of the array.
    let mut parts = Vec::with_capacity(rows.len());
    let (mut rest, mut passed, mut size) = (normals, 0, 0);
    for row in rows {
        let slots = row.slots(layout);
        let (part, after) =
            std::mem::take(&mut rest)[(slots.start - passed) as usize..].split_at_mut(slots.len());
        (rest, passed) = (after, slots.end);
        size += part.len();
        parts.push((row, part));
    }
    let arch = Arch::new();
    let one = |(row, normals): (&Row, &mut [[f32; 3]])| refresh_row(layout, positions, arch, row, normals);
    if size > WORTH_THREADS {
        parts.into_par_iter().with_min_len(8).for_each(one);
    } else {
        parts.into_iter().for_each(one);
    }
}

fn refresh_row(layout: &Layout, positions: &[[f32; 3]], arch: Arch, row: &Row, normals: &mut [[f32; 3]]) {
    let (face, r, columns) = match row {
        Row::Border(slots) => {
            for (slot, normal) in slots.clone().zip(normals) {
                *normal = alone(layout, Slot(slot), positions);
            }
            return;
        }
        Row::Inside(face, r, columns) => (*face, *r, columns.clone()),
    };
    // Columns whose neighbours all lie inside the face.
    let n = layout.segments();
    let (from, to) = (columns.start.max(2), columns.end.min(n.saturating_sub(r + 1)));
    let (from, to) = if r < 2 || from >= to { (columns.end, columns.end) } else { (from, to) };
    let first = layout.row(face, r).0 - 1;
    for i in (columns.start..from).chain(to..columns.end) {
        normals[(i - columns.start) as usize] = alone(layout, Slot(first + i), positions);
    }
    if from < to {
        let part = |r: u32, from: u32, to: u32| {
            let first = layout.row(face, r).index() - 1;
            &positions[first + from as usize..first + to as usize]
        };
        arch.dispatch(RowNormals {
            before: part(r - 1, from, to + 1),
            own: part(r, from - 1, to + 1),
            after: part(r + 1, from - 1, to),
            normals: &mut normals[(from - columns.start) as usize..(to - columns.start) as usize],
        });
    }
}

/// The normals of a run of vertices from the rows before and after it: `before` begins at the first vertex's own
/// column, `own` and `after` one earlier.
struct RowNormals<'a> {
    before: &'a [[f32; 3]],
    own: &'a [[f32; 3]],
    after: &'a [[f32; 3]],
    normals: &'a mut [[f32; 3]],
}

/// Vertices that are computed together.
const BLOCK: usize = 16;

impl WithSimd for RowNormals<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { before, own, after, normals } = self;
        for (block, normals) in normals.chunks_mut(BLOCK).enumerate() {
            let at = block * BLOCK;
            let (p5, p4) = (taken_apart(before, at + 1), taken_apart(before, at));
            let (p3, c, p0) = (taken_apart(own, at), taken_apart(own, at + 1), taken_apart(own, at + 2));
            let (p2, p1) = (taken_apart(after, at), taken_apart(after, at + 1));
            let mut sum = [[0.0; BLOCK]; 3];
            add_cross(&mut sum, [&p0, &p2], [&p1, &c]);
            add_cross(&mut sum, [&p2, &p4], [&p3, &c]);
            add_cross(&mut sum, [&p4, &p0], [&p5, &c]);
            let [x, y, z] = &mut sum;
            for l in 0..BLOCK {
                let length = (x[l] * x[l] + y[l] * y[l] + z[l] * z[l]).sqrt();
                let scale = 1.0 / length;
                let flat = length.is_nan() || length <= 0.0;
                (x[l], y[l], z[l]) = (x[l] * scale, y[l] * scale, z[l] * scale);
                (x[l], y[l], z[l]) = (
                    if flat { 0.0 } else { x[l] },
                    if flat { 1.0 } else { y[l] },
                    if flat { 0.0 } else { z[l] },
                );
            }
            for (l, normal) in normals.iter_mut().enumerate() {
                *normal = [x[l], y[l], z[l]];
            }
        }
    }
}

/// A block's vertices by coordinate; beyond the row's end whatever stands at its end.
#[inline(always)]
fn taken_apart(row: &[[f32; 3]], at: usize) -> [[f32; BLOCK]; 3] {
    let mut apart = [[0.0; BLOCK]; 3];
    if let Some(block) = row[at..].first_chunk::<BLOCK>() {
        for (l, p) in block.iter().enumerate() {
            (apart[0][l], apart[1][l], apart[2][l]) = (p[0], p[1], p[2]);
        }
    } else {
        for (l, p) in row[at..].iter().enumerate() {
            (apart[0][l], apart[1][l], apart[2][l]) = (p[0], p[1], p[2]);
        }
    }
    apart
}

/// Adds `(a − b) × (c − d)`.
#[inline(always)]
fn add_cross(sum: &mut [[f32; BLOCK]; 3], [a, b]: [&[[f32; BLOCK]; 3]; 2], [c, d]: [&[[f32; BLOCK]; 3]; 2]) {
    let mut u = [[0.0; BLOCK]; 3];
    let mut w = [[0.0; BLOCK]; 3];
    for k in 0..3 {
        for l in 0..BLOCK {
            u[k][l] = a[k][l] - b[k][l];
            w[k][l] = c[k][l] - d[k][l];
        }
    }
    for (k, sum) in sum.iter_mut().enumerate() {
        let (next, last) = ((k + 1) % 3, (k + 2) % 3);
        for l in 0..BLOCK {
            sum[l] += u[next][l] * w[last][l] - u[last][l] * w[next][l];
        }
    }
}

/// The normal of one vertex, wherever it lies.
fn alone(layout: &Layout, slot: Slot, positions: &[[f32; 3]]) -> [f32; 3] {
    let ring = layout.ring(layout.site(slot));
    let at = |s: usize| DVec3::from_array(positions[layout.slot(ring.around[s]).index()].map(f64::from));
    let centre = DVec3::from_array(positions[slot.index()].map(f64::from));
    let sum: DVec3 = (0..ring.faces())
        .map(|k| (at(k) - centre).cross(at((k + 1) % ring.around.len()) - centre))
        .fold(DVec3::ZERO, |sum, n| sum + n);
    sum.normalize_or(DVec3::Y).as_vec3().to_array()
}

#[cfg(test)]
mod tests {
    use super::*;
    use bozzetto_core::hierarchy::{BaseMesh, Hierarchy, Level};
    use bozzetto_core::mesh::shapes;
    use std::sync::Arc;

    fn bumpy(count: usize) -> Vec<[f32; 3]> {
        (0..count).map(|at| [1u32, 7, 31].map(|k| ((at as u32 * k) as f32 * 0.7).sin())).collect()
    }

    /// Row by row or alone, a normal is the same but for rounding, and rows change nothing else.
    #[test]
    fn rows_agree_with_single_vertices() {
        for (name, mesh) in shapes::awkward() {
            let base =
                BaseMesh::new(mesh.positions.len() as u32, mesh.faces.clone(), &[]).expect("a base mesh");
            let level = Level(if mesh.faces.len() > 30 { 3 } else { 5 });
            let hierarchy = Hierarchy::new(Arc::new(base), level).expect("small");
            let layout = hierarchy.layout(level);
            let positions = bumpy(layout.len() as usize);
            for (slot, normal) in all(layout, &positions).iter().enumerate() {
                let expected = alone(layout, Slot(slot as u32), &positions);
                let apart = (0..3).map(|c| (normal[c] - expected[c]).abs()).fold(0.0, f32::max);
                assert!(apart < 1e-3, "{name}, slot {slot}: {normal:?}, alone {expected:?}");
            }
        }
    }

    /// The rows next to some slots are those of the one-rings, no more and no fewer.
    #[test]
    fn widened_rows_are_the_one_rings() {
        let (_, mesh) = shapes::awkward().swap_remove(2);
        let base = BaseMesh::new(mesh.positions.len() as u32, mesh.faces.clone(), &[]).expect("a base mesh");
        let hierarchy = Hierarchy::new(Arc::new(base), Level(3)).expect("small");
        let layout = hierarchy.layout(Level(3));
        for first in 0..layout.len() {
            for len in [1, 2, 5, 17] {
                let run = first..(first + len).min(layout.len());
                let mut expected: Vec<u32> = run
                    .clone()
                    .flat_map(|s| {
                        layout.ring_slots(layout.site(Slot(s))).chain([Slot(s)]).collect::<Vec<_>>()
                    })
                    .map(|s| s.0)
                    .collect();
                expected.sort_unstable();
                expected.dedup();
                let wide = widened(layout, &rows_of(layout, std::iter::once(run.clone())));
                let found: Vec<u32> = wide.iter().flat_map(|row| row.slots(layout)).collect();
                assert_eq!(found, expected, "{run:?}");
            }
        }
    }
}
