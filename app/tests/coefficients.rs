//! The coefficients that the program writes are those of the explicit inverse of `[P|Q]`, for every wavelet, on meshes
//! whose vertices and faces come in no order at all.

mod explicit_filter_bank;
mod program;
mod random;

use bozzetto_core::mesh::{TriangleMesh, shapes};
use explicit_filter_bank::{Meshes, WrongWeight};
use program::Workplace;
use random::Random;
use std::collections::BTreeMap;
use std::fmt::Write;

/// How far a coefficient may be from the explicit inverse, for vertices anywhere in a cube of side 2.
const AGREEMENT: f64 = 1e-5;
/// Levels above the base mesh.
const LEVELS: usize = 3;

#[test]
fn octahedron() {
    agrees_with_the_explicit_inverse(&shapes::octahedron(), 1);
}

#[test]
fn tetrahedron() {
    agrees_with_the_explicit_inverse(&shapes::tetrahedron(), 2);
}

/// Valences 6 and 9 and no valence below.
#[test]
fn genus_2() {
    agrees_with_the_explicit_inverse(&shapes::double_torus(), 3);
}

#[test]
fn open_disc() {
    agrees_with_the_explicit_inverse(&shapes::disc(5), 4);
}

/// A file whose vertices and faces are shuffled and whose faces start anywhere.
struct Shuffled {
    meshes: Meshes,
    positions: Vec<[f64; 3]>,
    /// For each vertex of the file the vertex of `meshes` it is.
    vertex_of_line: Vec<usize>,
    obj: String,
}

impl Shuffled {
    fn new(base: &TriangleMesh, random: &mut Random) -> Self {
        let meshes = Meshes::subdivide(&base.faces, LEVELS);
        let count = meshes.counts[LEVELS];
        let positions: Vec<[f64; 3]> = (0..count).map(|_| random.point()).collect();
        let mut vertex_of_line: Vec<usize> = (0..count).collect();
        random.shuffle(&mut vertex_of_line);
        let mut line_of_vertex = vec![0; count];
        vertex_of_line.iter().enumerate().for_each(|(line, &vertex)| line_of_vertex[vertex] = line);
        let mut faces = meshes.faces[LEVELS].clone();
        random.shuffle(&mut faces);

        let mut obj = String::new();
        for &vertex in &vertex_of_line {
            let [x, y, z] = positions[vertex];
            writeln!(obj, "v {x} {y} {z}").expect("strings grow");
        }
        for mut face in faces {
            face.rotate_left(random.below(3));
            let [a, b, c] = face.map(|vertex| line_of_vertex[vertex] + 1);
            writeln!(obj, "f {a} {b} {c}").expect("strings grow");
        }
        Self { meshes, positions, vertex_of_line, obj }
    }
}

/// A row of the table, its ids replaced by vertices of the test's own numbering.
struct Row {
    level: Option<usize>,
    parents: Option<[usize; 2]>,
    coefficient: [f64; 3],
}

fn agrees_with_the_explicit_inverse(base: &TriangleMesh, usual_seed: u64) {
    let shuffled = Shuffled::new(base, &mut Random::seeded(usual_seed));
    let work = Workplace::new();
    work.write("in.obj", &shuffled.obj);
    for (name, k) in [("lazy", None), ("0", Some(0)), ("1", Some(1)), ("2", Some(2))] {
        let report = work.json(&["import", "in.obj", "-o", "out.boz", "--wavelet", name]);
        assert_eq!(report["levels"], LEVELS, "wavelet {name}");
        assert_eq!(report["base_faces"], base.faces.len(), "wavelet {name}");
        assert_eq!(work.succeeds(&["coefficients", "out.boz", "--csv", "out.csv"]), "");
        let rows = rows(&work.text("out.csv"), &shuffled.vertex_of_line);
        check_places(&rows, &shuffled.meshes);

        let difference = |wrong| difference(&rows, &shuffled.meshes.analyse(&shuffled.positions, k, wrong));
        let found = difference(None);
        println!("wavelet {name}: {} rows, largest difference {found:.1e}", rows.len());
        assert!(found <= AGREEMENT, "wavelet {name}: {found:e} from the explicit inverse");
        let wrong = WrongWeight { odd: shuffled.meshes.counts[LEVELS - 1], error: 0.02 };
        // The comparison would notice one wrong weight of one wavelet.
        assert!(difference(Some(wrong)) > 10.0 * AGREEMENT, "wavelet {name}: a wrong weight goes unseen");
    }
}

/// The rows by vertex. Every row has a source, and no two have the same.
fn rows(csv: &str, vertex_of_line: &[usize]) -> BTreeMap<usize, Row> {
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some("kind,level,vertex,parent_a,parent_b,source,x,y,z"));
    let table: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    let vertex_of = |fields: &[&str]| vertex_of_line[fields[5].parse::<usize>().expect("a source")];
    let vertex_by_id: BTreeMap<&str, usize> = table.iter().map(|row| (row[2], vertex_of(row))).collect();
    assert_eq!(vertex_by_id.len(), table.len(), "every id once");

    let mut rows = BTreeMap::new();
    for fields in &table {
        assert_eq!(fields.len(), 9, "{fields:?}");
        let coefficient = [6, 7, 8].map(|at| fields[at].parse().expect("a number"));
        let row = match fields[0] {
            "scaling" => {
                assert_eq!(fields[1..2], ["0"], "scaling coefficients are those of level 0");
                assert_eq!(fields[3..5], ["", ""], "base vertices have no parents");
                Row { level: None, parents: None, coefficient }
            }
            "wavelet" => {
                let mut parents = [fields[3], fields[4]].map(|id| vertex_by_id[id]);
                parents.sort_unstable();
                Row { level: Some(fields[1].parse().expect("a level")), parents: Some(parents), coefficient }
            }
            other => panic!("{other} is no kind"),
        };
        assert!(rows.insert(vertex_of(fields), row).is_none(), "every source once");
    }
    rows
}

/// Every vertex has its row, with the level and the parents that its edge gives.
fn check_places(rows: &BTreeMap<usize, Row>, meshes: &Meshes) {
    assert_eq!(rows.len(), meshes.counts[LEVELS], "a row for every vertex");
    for (&vertex, row) in rows {
        let level = (0..LEVELS).find(|&j| vertex < meshes.counts[j + 1] && vertex >= meshes.counts[j]);
        assert_eq!(row.level, level, "level of vertex {vertex}");
        assert_eq!(row.parents, level.map(|_| meshes.parents[vertex]), "parents of vertex {vertex}");
    }
}

/// The largest difference of any coordinate of any coefficient.
fn difference(rows: &BTreeMap<usize, Row>, expected: &[Vec<f64>]) -> f64 {
    let of_row = |(vertex, row): (&usize, &Row)| {
        let expected = &expected[*vertex];
        (0..3).map(|c| (row.coefficient[c] - expected[c]).abs()).fold(0.0, f64::max)
    };
    rows.iter().map(of_row).fold(0.0, f64::max)
}

/// A mesh that is its own base mesh has no subdivision connectivity, and so no column to look its vertices up by.
#[test]
fn without_subdivision_connectivity_there_is_no_source() {
    let work = Workplace::new();
    work.write("in.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    work.succeeds(&["import", "in.obj", "-o", "out.boz", "--remesh", "never"]);
    work.succeeds(&["coefficients", "out.boz", "--csv", "out.csv"]);
    let table = work.text("out.csv");
    let rows: Vec<&str> = table.lines().skip(1).collect();
    assert_eq!(rows.len(), 3, "{table}");
    assert!(rows.iter().all(|row| row.starts_with("scaling,0,") && row.contains(",,,,")), "{table}");
}
