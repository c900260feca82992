//! Repair before conversion: any triangle list becomes an oriented manifold, and every change is counted.
//!
//! Guarantees: the result is an orientable 2-manifold without doubled faces; a vertex moves only by a weld within the
//! tolerance; the same input gives the same result.
//! Non-guarantees: holes are not filled, self-intersections and slivers of distinct corners stay.

use super::simplify::Cancelled;
use crate::mesh::connectivity::{Connectivity, NotManifold};
use crate::mesh::{Abandoned, TriangleMesh};
use cut::{cut, edges_of_many};
use disjoint_sets::DisjointSets;
use glam::DVec3;
use marks::Marks;
use rustc_hash::{FxHashMap, FxHashSet};

mod cut;
pub(super) mod disjoint_sets;
mod marks;
pub(super) mod weld;

/// Components with less area than this fraction of the squared diagonal are dropped: nothing of them can be seen, and
/// nothing can be fitted to them.
const ISLAND_AREA: f64 = 1e-14;

/// Rounds of taking out faces that still stand in the way after cutting.
const LAST_RESORT_ROUNDS: usize = 64;

/// What was repaired, in numbers.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct CleanReport {
    /// Vertices merged with another at the same place.
    pub welded: usize,
    /// Faces with a repeated corner.
    pub degenerate: usize,
    /// Faces with the corners of an earlier face.
    pub doubled: usize,
    /// Faces turned round.
    pub turned: usize,
    /// Edges of more than two faces, cut apart.
    pub cut_edges: usize,
    /// Edges cut because the surface was one-sided there.
    pub one_sided: usize,
    /// Vertices copied so that each has one fan.
    pub cut_vertices: usize,
    /// Faces taken out because no cut made them manifold.
    pub dropped: usize,
    /// Components too small to be seen or fitted.
    pub islands: usize,
    /// Vertices no face uses.
    pub unreferenced: usize,
}

impl CleanReport {
    /// One sentence for each kind of repair that was made.
    pub fn sentences(&self) -> Vec<String> {
        let kinds = [
            (self.welded, "vertex was", "vertices were", "merged with another at the same place"),
            (
                self.degenerate,
                "face with a repeated corner was",
                "faces with a repeated corner were",
                "left out",
            ),
            (self.doubled, "face that doubled another was", "faces that doubled another were", "left out"),
            (self.turned, "face was", "faces were", "turned round to agree with the rest"),
            (
                self.cut_edges,
                "edge of more than two faces was",
                "edges of more than two faces were",
                "cut apart",
            ),
            (self.one_sided, "edge was", "edges were", "cut where the surface was one-sided"),
            (
                self.cut_vertices,
                "vertex was",
                "vertices were",
                "doubled where sheets touch in it or along a cut",
            ),
            (self.dropped, "face was", "faces were", "left out where no cut made the surface manifold"),
            (
                self.islands,
                "island too small to be seen was",
                "islands too small to be seen were",
                "left out",
            ),
            (
                self.unreferenced,
                "vertex that no face uses was",
                "vertices that no face uses were",
                "left out",
            ),
        ];
        let made = kinds.into_iter().filter(|(count, ..)| *count > 0);
        made.map(|(count, one, many, done)| format!("{count} {} {done}", if count == 1 { one } else { many }))
            .collect()
    }
}

/// A manifold mesh and what was done to get it.
#[derive(Debug, Clone)]
pub struct Cleaned {
    /// Positions of the vertices, all of them used.
    pub positions: Vec<[f64; 3]>,
    /// The faces, oriented, and their neighbours.
    pub connectivity: Connectivity<'static>,
    /// The edges that are marked as sharp.
    pub sharp_edges: Vec<[u32; 2]>,
    /// What was repaired.
    pub report: CleanReport,
}

impl Cleaned {
    /// The mesh as positions, faces and marks.
    pub fn to_mesh(&self) -> TriangleMesh {
        TriangleMesh::new(self.positions.clone(), self.connectivity.faces().to_vec())
            .with_sharp_edges(self.sharp_edges.clone())
    }
}

/// Repairs a mesh. Vertices no further apart than `weld` (model units; 0 for exact duplicates) become one. `None` if
/// no face is left. Time and memory linear in the faces, for a `weld` below the typical edge length.
///
/// Panics if a face refers to a vertex that does not exist.
pub fn clean(mesh: &TriangleMesh, weld: f64) -> Option<Cleaned> {
    clean_while(mesh, weld, &|| true).unwrap_or(None)
}

/// [`clean`], asking after some hundredths of a second each time whether to go on.
///
/// # Errors
/// The answer was no.
pub(super) fn clean_while(
    mesh: &TriangleMesh,
    weld: f64,
    go_on: &dyn Fn() -> bool,
) -> Result<Option<Cleaned>, Cancelled> {
    let ask = || if go_on() { Ok(()) } else { Err(Cancelled) };
    let mut report = CleanReport::default();
    let mut used = vec![false; mesh.positions.len()];
    mesh.faces.iter().flatten().for_each(|&v| used[v as usize] = true);
    report.unreferenced = used.iter().filter(|used| !**used).count();

    let merged = match weld > 0.0 {
        true => weld::within(&mesh.positions, &used, weld),
        false => weld::equal(&mesh.positions, &used),
    };
    report.welded = (0u32..).zip(&merged).filter(|(v, other)| v != *other).count();
    ask()?;
    let marks = Marks::new(mesh, &merged);
    let mut faces: Vec<[u32; 3]> = mesh.faces.iter().map(|f| f.map(|v| merged[v as usize])).collect();
    drop_degenerate_and_doubled(&mut faces, &mut report, &ask)?;

    let mut positions = mesh.positions.clone();
    for _ in 0..LAST_RESORT_ROUNDS {
        if !cut(&mut positions, &mut faces, &mut report, &ask)? {
            break;
        }
        ask()?;
        let obstacles = edges_of_many(&faces);
        if obstacles.is_empty() {
            break;
        }
        // Sheets that meet along the edge and again round both its ends: the latest faces give way.
        let before = faces.len();
        let mut at = 0..;
        faces.retain(|_| !obstacles.contains(&at.next().expect("the count has no end")));
        report.dropped += before - faces.len();
    }
    ask()?;
    drop_islands(&positions, &mut faces, &mut report);
    if faces.is_empty() {
        return Ok(None);
    }
    // Cutting leaves a manifold; should it ever not, the faces in the way are dropped one place at a time.
    while !faces.is_empty() {
        ask()?;
        let (positions, numbered) = compact(&positions, &faces);
        match Connectivity::build_while(positions.len() as u32, numbered.clone(), go_on) {
            Err(Abandoned) => return Err(Cancelled),
            Ok(Ok(connectivity)) => {
                let sharp_edges = marks.found(&positions, &connectivity);
                return Ok(Some(Cleaned { positions, connectivity, sharp_edges, report }));
            }
            Ok(Err(obstacle)) => {
                let mut kept = numbered.iter().map(|face| !stands_in_the_way(face, &obstacle, &numbered));
                let before = faces.len();
                faces.retain(|_| kept.next().expect("as many as faces"));
                report.dropped += before - faces.len();
            }
        }
    }
    Ok(None)
}

/// Whether to go on.
type Ask<'a> = &'a dyn Fn() -> Result<(), Cancelled>;

/// Faces or corners that are gone through between two questions.
const STRIDE: usize = 1 << 17;

fn stands_in_the_way(face: &[u32; 3], obstacle: &NotManifold, faces: &[[u32; 3]]) -> bool {
    match *obstacle {
        NotManifold::Edge { a, b } | NotManifold::NotOrientable { a, b } => {
            face.contains(&a) && face.contains(&b)
        }
        NotManifold::Vertex { vertex } => face.contains(&vertex),
        NotManifold::MissingVertex { face: at, .. } | NotManifold::Degenerate { face: at, .. } => {
            *face == faces[at as usize]
        }
    }
}

fn drop_degenerate_and_doubled(
    faces: &mut Vec<[u32; 3]>,
    report: &mut CleanReport,
    ask: Ask<'_>,
) -> Result<(), Cancelled> {
    let mut seen = FxHashSet::default();
    let mut kept = 0;
    for at in 0..faces.len() {
        if at.is_multiple_of(STRIDE) {
            ask()?;
        }
        let face = faces[at];
        let [a, b, c] = face;
        if a == b || b == c || c == a {
            report.degenerate += 1;
            continue;
        }
        let mut key = face;
        key.sort_unstable();
        if seen.insert(key) {
            faces[kept] = face;
            kept += 1;
        } else {
            report.doubled += 1;
        }
    }
    faces.truncate(kept);
    Ok(())
}

fn drop_islands(positions: &[[f64; 3]], faces: &mut Vec<[u32; 3]>, report: &mut CleanReport) {
    let mut sets = DisjointSets::new(positions.len());
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for f in faces.iter() {
        sets.join(f[0] as usize, f[1] as usize);
        sets.join(f[0] as usize, f[2] as usize);
        for &v in f {
            low = low.min(positions[v as usize].into());
            high = high.max(positions[v as usize].into());
        }
    }
    // In a box of side 1, so that no square is out of range, however large or small the model is.
    let side = (high - low).max_element();
    let mut areas: FxHashMap<usize, f64> = FxHashMap::default();
    for f in faces.iter() {
        let [a, b, c] = f.map(|v| (DVec3::from(positions[v as usize]) - low) / side);
        *areas.entry(sets.find(f[0] as usize)).or_default() += (b - a).cross(c - a).length() * 0.5;
    }
    let floor = ISLAND_AREA * ((high - low) / side).length_squared();
    let flat = |area: &f64| area.is_nan() || *area <= floor;
    report.islands += areas.values().filter(|area| flat(area)).count();
    faces.retain(|f| !flat(&areas[&sets.find(f[0] as usize)]));
}

/// Leaves out vertices no face uses; the others keep their order.
fn compact(positions: &[[f64; 3]], faces: &[[u32; 3]]) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let mut number = vec![u32::MAX; positions.len()];
    faces.iter().flatten().for_each(|&v| number[v as usize] = 0);
    let mut kept = Vec::new();
    for (v, number) in number.iter_mut().enumerate().filter(|(_, number)| **number == 0) {
        *number = kept.len() as u32;
        kept.push(positions[v]);
    }
    (kept, faces.iter().map(|f| f.map(|v| number[v as usize])).collect())
}

#[cfg(test)]
mod tests;
