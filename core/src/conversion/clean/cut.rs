//! Orientation, and cuts where faces meet that are no surface together.

use super::disjoint_sets::DisjointSets;
use super::{Ask, CleanReport, STRIDE};
use crate::conversion::simplify::Cancelled;
use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// The half-edges (`3 face + k`) of all faces, each after the ends of its edge, sorted: those of one edge stand together.
fn half_edges_by_edge(faces: &[[u32; 3]]) -> Vec<([u32; 2], u32)> {
    let mut sides: Vec<([u32; 2], u32)> = faces
        .par_iter()
        .enumerate()
        .flat_map_iter(|(f, face)| {
            (0..3).map(move |k| {
                let (a, b) = (face[k], face[(k + 1) % 3]);
                ([a.min(b), a.max(b)], (3 * f + k) as u32)
            })
        })
        .collect();
    sides.par_sort_unstable();
    sides
}

/// Orients the faces, chooses which go together at edges of more than two, then gives every fan of faces round a vertex
/// a vertex of its own.
///
/// Returns whether there were such edges; without them the result is a manifold.
///
/// # Errors
/// `ask` did not want to go on.
pub(super) fn cut(
    positions: &mut Vec<[f64; 3]>,
    faces: &mut [[u32; 3]],
    report: &mut CleanReport,
    ask: Ask<'_>,
) -> Result<bool, Cancelled> {
    let mut twins = vec![u32::MAX; 3 * faces.len()];
    let before = report.cut_edges;
    let half_edges = half_edges_by_edge(faces);
    ask()?;
    for sides in half_edges.chunk_by(|one, other| one.0 == other.0) {
        match *sides {
            [_] => {}
            [(_, one), (_, other)] => {
                twins[one as usize] = other;
                twins[other as usize] = one;
            }
            _ => report.cut_edges += 1,
        }
    }
    drop(half_edges);
    let many = report.cut_edges > before;
    ask()?;
    orient(faces, &mut twins, report, ask)?;
    if many {
        stitch(positions, faces, &mut twins);
    }

    // Corners glued across an edge are one vertex.
    let mut glued = DisjointSets::new(3 * faces.len());
    for (f, face) in faces.iter().enumerate() {
        if f.is_multiple_of(STRIDE) {
            ask()?;
        }
        for k in 0..3 {
            let twin = twins[3 * f + k];
            if twin == u32::MAX {
                continue;
            }
            let (g, start) = ((twin / 3) as usize, face[k]);
            let corner =
                |v: u32| 3 * g + faces[g].iter().position(|&w| w == v).expect("twins share both ends");
            glued.join(3 * f + k, corner(start));
            glued.join(3 * f + (k + 1) % 3, corner(face[(k + 1) % 3]));
        }
    }
    let mut owner: Vec<u32> = vec![u32::MAX; positions.len()];
    let mut copies = FxHashMap::default();
    for corner in 0..3 * faces.len() {
        if corner.is_multiple_of(3 * STRIDE) {
            ask()?;
        }
        let v = faces[corner / 3][corner % 3];
        let class = glued.find(corner);
        if owner[v as usize] == u32::MAX {
            owner[v as usize] = class as u32;
        }
        if owner[v as usize] != class as u32 {
            let copy = *copies.entry(class).or_insert_with(|| {
                positions.push(positions[v as usize]);
                report.cut_vertices += 1;
                positions.len() as u32 - 1
            });
            faces[corner / 3][corner % 3] = copy;
        }
    }
    Ok(many)
}

/// Turns faces so that glued neighbours agree, most of each component keeping its side; edges where that is
/// impossible are unglued. Half-edge numbers of a turned face go on naming the same edges.
fn orient(
    faces: &mut [[u32; 3]],
    twins: &mut [u32],
    report: &mut CleanReport,
    ask: Ask<'_>,
) -> Result<(), Cancelled> {
    let ends: Vec<[u32; 2]> = faces.iter().flat_map(|f| (0..3).map(|k| [f[k], f[(k + 1) % 3]])).collect();
    let mut turned: Vec<Option<bool>> = vec![None; faces.len()];
    for seed in 0..faces.len() {
        if turned[seed].is_some() {
            continue;
        }
        turned[seed] = Some(false);
        let mut component = vec![seed];
        let mut at = 0;
        while at < component.len() {
            let f = component[at];
            at += 1;
            if at.is_multiple_of(STRIDE) {
                ask()?;
            }
            for h in 3 * f..3 * f + 3 {
                let twin = twins[h];
                if twin == u32::MAX {
                    continue;
                }
                let g = twin as usize / 3;
                let wanted = Some(turned[f].expect("visited") ^ (ends[h] == ends[twin as usize]));
                match turned[g] {
                    None => {
                        turned[g] = wanted;
                        component.push(g);
                    }
                    found if found != wanted => {
                        twins[h] = u32::MAX;
                        twins[twin as usize] = u32::MAX;
                        report.one_sided += 1;
                    }
                    _ => {}
                }
            }
        }
        let against = component.iter().filter(|&&f| turned[f] == Some(true)).count();
        let other_way = 2 * against > component.len();
        for &f in &component {
            if turned[f].expect("visited") != other_way {
                report.turned += 1;
                // Corners 0 and 1 change places: edge 0 stays edge 0, edges 1 and 2 change places.
                faces[f].swap(0, 1);
                twins.swap(3 * f + 1, 3 * f + 2);
                for h in [3 * f + 1, 3 * f + 2] {
                    if twins[h] != u32::MAX {
                        twins[twins[h] as usize] = h as u32;
                    }
                }
            }
        }
    }
    Ok(())
}

/// Cosine between two faces at an edge, seen along it, from which on they go on in each other: 150°.
const GOES_ON: f64 = -0.866;
/// Faces at an edge up to which pairs are looked for; beyond it, all are cut apart.
const MOST_AT_AN_EDGE: usize = 64;

/// Glues pairs of faces at edges of more than two, those that are one surface there: first two of one sheet, joined
/// by a way over other edges, then two that go on in each other. So a fin leaves no crack in what it stands on.
fn stitch(positions: &[[f64; 3]], faces: &[[u32; 3]], twins: &mut [u32]) {
    let mut sheets = DisjointSets::new(faces.len());
    for (h, &twin) in twins.iter().enumerate().filter(|(_, twin)| **twin != u32::MAX) {
        sheets.join(h / 3, twin as usize / 3);
    }
    for sides in half_edges_by_edge(faces).chunk_by(|one, other| one.0 == other.0) {
        if !(3..=MOST_AT_AN_EDGE).contains(&sides.len()) {
            continue;
        }
        let around: Vec<(usize, bool, DVec3)> = sides
            .iter()
            .map(|&([low, high], h)| {
                let (face, k) = (faces[h as usize / 3], h as usize % 3);
                let [p, q, r] = [low, high, face[(k + 2) % 3]].map(|v| DVec3::from(positions[v as usize]));
                let along = (q - p).normalize_or_zero();
                let away = (r - p) - along * along.dot(r - p);
                (h as usize, face[k] == low, away.normalize_or_zero())
            })
            .collect();
        let mut pairs = Vec::new();
        for (i, one) in around.iter().enumerate() {
            for other in around[i + 1..].iter().filter(|other| other.1 != one.1) {
                let apart = sheets.find(one.0 / 3) != sheets.find(other.0 / 3);
                let cosine = one.2.dot(other.2);
                if !apart || cosine < GOES_ON {
                    pairs.push((apart, cosine, one.0, other.0));
                }
            }
        }
        pairs.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then((a.2, a.3).cmp(&(b.2, b.3))));
        for (_, _, one, other) in pairs {
            if twins[one] == u32::MAX && twins[other] == u32::MAX {
                twins[one] = other as u32;
                twins[other] = one as u32;
            }
        }
    }
}

/// The faces, beyond the second, at edges that still have more.
pub(super) fn edges_of_many(faces: &[[u32; 3]]) -> std::collections::BTreeSet<usize> {
    half_edges_by_edge(faces)
        .chunk_by(|one, other| one.0 == other.0)
        .flat_map(|sides| sides.iter().skip(2).map(|(_, h)| *h as usize / 3))
        .collect()
}
