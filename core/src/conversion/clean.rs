//! Repair before conversion: any triangle list becomes an oriented manifold, and every change is counted.
//!
//! Guarantees: the result is an orientable 2-manifold without doubled faces; a vertex moves only by a weld within the
//! tolerance; the same input gives the same result.
//! Non-guarantees: holes are not filled, self-intersections and slivers of distinct corners stay.

use crate::mesh::TriangleMesh;
use crate::mesh::connectivity::{Connectivity, NotManifold};
use rustc_hash::FxHashMap;

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
    /// Components without area.
    pub islands: usize,
    /// Vertices no face uses.
    pub unreferenced: usize,
}

impl CleanReport {
    /// One sentence for each kind of repair that was made.
    pub fn sentences(&self) -> Vec<String> {
        let kinds = [
            (self.welded, "vertices were merged with another at the same place"),
            (self.degenerate, "faces with a repeated corner were left out"),
            (self.doubled, "faces that doubled another were left out"),
            (self.turned, "faces were turned round to agree with their neighbours"),
            (self.cut_edges, "edges of more than two faces were cut apart"),
            (self.one_sided, "edges were cut where the surface was one-sided"),
            (self.cut_vertices, "vertices were doubled where sheets touch in one vertex or along a cut"),
            (self.dropped, "faces were left out where no cut made them manifold"),
            (self.islands, "islands without area were left out"),
            (self.unreferenced, "vertices that no face uses were left out"),
        ];
        kinds.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")).collect()
    }
}

/// A manifold mesh and what was done to get it.
#[derive(Debug, Clone)]
pub struct Cleaned {
    /// Positions of the vertices, all of them used.
    pub positions: Vec<[f64; 3]>,
    /// The faces, oriented, and their neighbours.
    pub connectivity: Connectivity,
    /// What was repaired.
    pub report: CleanReport,
}

impl Cleaned {
    /// The mesh as positions and faces.
    pub fn to_mesh(&self) -> TriangleMesh {
        TriangleMesh { positions: self.positions.clone(), faces: self.connectivity.faces().to_vec() }
    }
}

/// Repairs a mesh. Vertices no further apart than `weld` (model units; 0 for exact duplicates) become one. `None` if
/// no face is left. Time and memory linear in the faces, for a `weld` below the typical edge length.
///
/// Panics if a face refers to a vertex that does not exist.
pub fn clean(mesh: &TriangleMesh, weld: f64) -> Option<Cleaned> {
    let mut report = CleanReport::default();
    let diagonal = mesh.diagonal();
    let mut used = vec![false; mesh.positions.len()];
    mesh.faces.iter().flatten().for_each(|&v| used[v as usize] = true);
    report.unreferenced = used.iter().filter(|used| !**used).count();

    let merged = weld_vertices(&mesh.positions, &used, weld, &mut report);
    let mut faces: Vec<[u32; 3]> = mesh.faces.iter().map(|f| f.map(|v| merged[v as usize])).collect();
    drop_degenerate_and_doubled(&mut faces, &mut report);

    let mut positions = mesh.positions.clone();
    for _ in 0..LAST_RESORT_ROUNDS {
        cut(&mut positions, &mut faces, &mut report);
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
    drop_islands(&positions, &mut faces, diagonal, &mut report);
    if faces.is_empty() {
        return None;
    }
    // Cutting leaves a manifold; should it ever not, the faces in the way are dropped one place at a time.
    while !faces.is_empty() {
        let (positions, numbered) = compact(&positions, &faces);
        match Connectivity::build(positions.len() as u32, numbered.clone()) {
            Ok(connectivity) => return Some(Cleaned { positions, connectivity, report }),
            Err(obstacle) => {
                let mut kept = numbered.iter().map(|face| !stands_in_the_way(face, &obstacle, &numbered));
                let before = faces.len();
                faces.retain(|_| kept.next().expect("as many as faces"));
                report.dropped += before - faces.len();
            }
        }
    }
    None
}

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

/// For every vertex the lowest one it is merged with.
fn weld_vertices(positions: &[[f64; 3]], used: &[bool], weld: f64, report: &mut CleanReport) -> Vec<u32> {
    let mut merged: Vec<u32> = (0..positions.len() as u32).collect();
    // Adding 0 makes −0 and 0 the same.
    let cell = |p: &[f64; 3]| match weld > 0.0 {
        true => p.map(|x| (x / weld).floor().to_bits()),
        false => p.map(|x| (x + 0.0).to_bits()),
    };
    let mut cells: FxHashMap<[u64; 3], Vec<u32>> = FxHashMap::default();
    for (v, p) in positions.iter().enumerate().filter(|(v, _)| used[*v]) {
        let key = cell(p);
        let near = |q: &[f64; 3]| (0..3).map(|k| (p[k] - q[k]) * (p[k] - q[k])).sum::<f64>() <= weld * weld;
        let found = if weld > 0.0 {
            neighbouring_cells(p, weld)
                .filter_map(|key| cells.get(&key))
                .flatten()
                .copied()
                .find(|&other| near(&positions[other as usize]))
        } else {
            cells.get(&key).map(|others| others[0])
        };
        match found {
            Some(other) => {
                merged[v] = other;
                report.welded += 1;
            }
            None => cells.entry(key).or_default().push(v as u32),
        }
    }
    merged
}

fn neighbouring_cells(p: &[f64; 3], size: f64) -> impl Iterator<Item = [u64; 3]> {
    let centre = p.map(|x| (x / size).floor());
    (0..27).map(move |n| {
        let offset = [n % 3, n / 3 % 3, n / 9].map(|o| f64::from(o) - 1.0);
        std::array::from_fn(|k| (centre[k] + offset[k] + 0.0).to_bits())
    })
}

fn drop_degenerate_and_doubled(faces: &mut Vec<[u32; 3]>, report: &mut CleanReport) {
    let mut seen = FxHashMap::default();
    faces.retain(|&[a, b, c]| {
        if a == b || b == c || c == a {
            report.degenerate += 1;
            return false;
        }
        let mut key = [a, b, c];
        key.sort_unstable();
        let fresh = seen.insert(key, ()).is_none();
        report.doubled += usize::from(!fresh);
        fresh
    });
}

/// The half-edges (`3 face + k`) at every undirected edge, edges in order of first appearance.
fn half_edges_by_edge(faces: &[[u32; 3]]) -> Vec<([u32; 2], Vec<u32>)> {
    let mut index = FxHashMap::default();
    let mut edges: Vec<([u32; 2], Vec<u32>)> = Vec::new();
    for (f, face) in faces.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (face[k], face[(k + 1) % 3]);
            let key = [a.min(b), a.max(b)];
            let at = *index.entry(key).or_insert_with(|| {
                edges.push((key, Vec::with_capacity(2)));
                edges.len() - 1
            });
            edges[at].1.push((3 * f + k) as u32);
        }
    }
    edges
}

/// Orients the faces, then gives every fan of faces round a vertex a vertex of its own.
fn cut(positions: &mut Vec<[f64; 3]>, faces: &mut [[u32; 3]], report: &mut CleanReport) {
    let mut twins = vec![u32::MAX; 3 * faces.len()];
    for (_, sides) in half_edges_by_edge(faces) {
        match sides[..] {
            [_] => {}
            [one, other] => {
                twins[one as usize] = other;
                twins[other as usize] = one;
            }
            _ => report.cut_edges += 1,
        }
    }
    orient(faces, &mut twins, report);

    // Corners glued across an edge are one vertex.
    let mut glued = DisjointSets::new(3 * faces.len());
    for (f, face) in faces.iter().enumerate() {
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
}

/// Turns faces so that glued neighbours agree, most of each component keeping its side; edges where that is
/// impossible are unglued. Half-edge numbers of a turned face go on naming the same edges.
fn orient(faces: &mut [[u32; 3]], twins: &mut [u32], report: &mut CleanReport) {
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
}

/// The faces, beyond the second, at edges that still have more.
fn edges_of_many(faces: &[[u32; 3]]) -> std::collections::BTreeSet<usize> {
    half_edges_by_edge(faces)
        .iter()
        .flat_map(|(_, sides)| sides.iter().skip(2).map(|h| *h as usize / 3))
        .collect()
}

fn drop_islands(positions: &[[f64; 3]], faces: &mut Vec<[u32; 3]>, diagonal: f64, report: &mut CleanReport) {
    let mut sets = DisjointSets::new(positions.len());
    for f in faces.iter() {
        sets.join(f[0] as usize, f[1] as usize);
        sets.join(f[0] as usize, f[2] as usize);
    }
    let mut areas: FxHashMap<usize, f64> = FxHashMap::default();
    for f in faces.iter() {
        let [a, b, c] = f.map(|v| glam::DVec3::from(positions[v as usize]));
        *areas.entry(sets.find(f[0] as usize)).or_default() += (b - a).cross(c - a).length() * 0.5;
    }
    let floor = ISLAND_AREA * diagonal * diagonal;
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

/// Union–find with path halving; the lowest element stands for its set.
struct DisjointSets {
    parent: Vec<u32>,
}

impl DisjointSets {
    fn new(len: usize) -> Self {
        Self { parent: (0..len as u32).collect() }
    }

    fn find(&mut self, mut at: usize) -> usize {
        while self.parent[at] as usize != at {
            self.parent[at] = self.parent[self.parent[at] as usize];
            at = self.parent[at] as usize;
        }
        at
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.find(a), self.find(b));
        self.parent[a.max(b)] = a.min(b) as u32;
    }
}

#[cfg(test)]
mod tests;
