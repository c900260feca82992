use proptest::prelude::*;

use super::*;
use crate::mesh::sampling::SplitMix64;

fn random_point(random: &mut SplitMix64) -> [f64; 3] {
    [random.unit(), random.unit(), random.unit()]
}

/// Triangles of every size in a unit cube, a tenth of them degenerate.
fn soup(faces: u32, seed: u64) -> TriangleMesh {
    let mut random = SplitMix64::at(seed, 0);
    let mut mesh = TriangleMesh::default();
    for face in 0..faces {
        let corner = random_point(&mut random);
        let size = random.unit().powi(4);
        let next = |random: &mut SplitMix64| {
            let offset = random_point(random);
            [0, 1, 2].map(|axis| corner[axis] + size * (offset[axis] - 0.5))
        };
        let (second, third) = (next(&mut random), next(&mut random));
        mesh.positions.extend([corner, second, third]);
        let third = match face % 20 {
            0 => 1,
            1 => 0,
            _ => 2,
        };
        mesh.faces.push([3 * face, 3 * face + 1, 3 * face + third]);
    }
    mesh
}

fn by_trying_all(mesh: &TriangleMesh, query: [f64; 3]) -> f64 {
    let squared = |face: u32| {
        let corners = mesh.corners(FaceIndex(face)).map(DVec3::from);
        closest_on_triangle(query.into(), &corners).1
    };
    (0..mesh.faces.len() as u32).map(squared).fold(f64::INFINITY, f64::min)
}

#[test]
fn the_tree_agrees_with_trying_all_triangles() {
    for (faces, seed) in [(1, 1), (3, 2), (5, 3), (40, 4), (700, 5)] {
        let mesh = soup(faces, seed);
        let tree = BoundingVolumes::build(&mesh).unwrap();
        let mut random = SplitMix64::at(seed, 1 << 32);
        let mut cursor = tree.cursor();
        for _ in 0..300 {
            let query = random_point(&mut random).map(|x| 3.0 * x - 1.0);
            let expected = by_trying_all(&mesh, query);
            for found in [tree.closest(query), cursor.closest(query)] {
                let error = (found.squared_distance - expected).abs();
                assert!(error <= 1e-14 * expected, "{faces} faces: {found:?} for {query:?}, not {expected}");
                let reached = (DVec3::from(found.point) - DVec3::from(query)).length_squared();
                assert!((reached - expected).abs() <= 1e-12 * (1.0 + expected));
            }
        }
    }
}

#[test]
fn faces_that_are_not_allowed_are_as_if_left_out() {
    let mesh = soup(300, 11);
    let allowed = |face: FaceIndex| face.0.is_multiple_of(3);
    let rest = TriangleMesh::new(mesh.positions.clone(), mesh.faces.iter().step_by(3).copied().collect());
    let tree = BoundingVolumes::build(&mesh).unwrap();
    let mut cursor = tree.cursor();
    let mut random = SplitMix64::at(12, 0);
    for _ in 0..300 {
        let query = random_point(&mut random);
        let nearest = by_trying_all(&rest, query);
        let found = cursor.closest_where(query, f64::INFINITY, &allowed).unwrap();
        assert!(allowed(found.face));
        assert_eq!(found.squared_distance, nearest);
        let short = nearest.sqrt() * 0.999;
        assert!(cursor.closest_where(query, short, &allowed).is_none());
    }
}

#[test]
fn each_face_within_a_radius_is_shown_once() {
    let mesh = soup(300, 11);
    let tree = BoundingVolumes::build(&mesh).unwrap();
    let mut cursor = tree.cursor();
    let mut random = SplitMix64::at(13, 0);
    for _ in 0..300 {
        let query = random_point(&mut random);
        let distance = |f: &u32| {
            closest_on_triangle(query.into(), &mesh.corners(FaceIndex(*f)).map(DVec3::from)).1.sqrt()
        };
        let radius = cursor.closest(query).squared_distance.sqrt() * 1.5;
        let expected: Vec<u32> = (0..mesh.faces.len() as u32).filter(|f| distance(f) < radius).collect();
        let mut shown = Vec::new();
        cursor.each_within(query, radius, |f| shown.push(f.0));
        shown.sort_unstable();
        assert_eq!(shown, expected);
    }
}

#[test]
fn the_named_face_holds_the_point() {
    let mesh = soup(200, 9);
    let tree = BoundingVolumes::build(&mesh).unwrap();
    let mut random = SplitMix64::at(9, 1 << 32);
    for _ in 0..200 {
        let found = tree.closest(random_point(&mut random));
        let corners = mesh.corners(found.face).map(DVec3::from);
        assert!(closest_on_triangle(found.point.into(), &corners).1.sqrt() < 1e-14);
    }
}

#[test]
fn a_mesh_without_faces_has_no_tree() {
    assert!(BoundingVolumes::build(&TriangleMesh::default()).is_none());
}

#[test]
fn a_tree_follows_its_vertices() {
    let mesh = soup(300, 21);
    let mut tree = BoundingVolumes::build(&mesh).unwrap();
    let mut random = SplitMix64::at(22, 0);
    let mut moved = mesh.clone();
    for position in &mut moved.positions {
        let offset = random_point(&mut random);
        *position = [0, 1, 2].map(|axis| position[axis] + 3.0 * offset[axis]);
    }
    tree.refit(&moved);
    let mut cursor = tree.cursor();
    for _ in 0..300 {
        let query = random_point(&mut random).map(|x| 6.0 * x - 1.0);
        cursor.start_at(FaceIndex(random.bits() as u32 % 300));
        assert_eq!(cursor.closest(query).squared_distance, by_trying_all(&moved, query));
    }
}

#[test]
fn triangles_in_one_place_are_still_split() {
    // All centres coincide, so only halving can tell them apart.
    let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mesh = TriangleMesh::new(positions, vec![[0, 1, 2]; 5000]);
    let tree = BoundingVolumes::build(&mesh).unwrap();
    assert_eq!(tree.closest([0.25, 0.25, 3.0]).squared_distance, 9.0);
    assert!(tree.nodes.len() < 5000, "{} nodes", tree.nodes.len());
}

#[test]
fn sizes_that_double_each_time_stay_within_the_stack() {
    // A geometric series of triangles makes a binned split peel off a few at a time.
    let mut mesh = TriangleMesh::default();
    for face in 0..1000u32 {
        let x = 2f64.powi(face as i32 % 180 - 90);
        mesh.positions.extend([[x, 0.0, 0.0], [1.1 * x, 0.0, 0.0], [x, 0.1 * x, 0.0]]);
        mesh.faces.push([3 * face, 3 * face + 1, 3 * face + 2]);
    }
    let tree = BoundingVolumes::build(&mesh).unwrap();
    assert_eq!(tree.closest([-1.0, 0.0, 0.0]).squared_distance, by_trying_all(&mesh, [-1.0, 0.0, 0.0]));
}

proptest! {
    #[test]
    fn coincident_and_collinear_corners_never_mislead(
        corners in prop::collection::vec(prop::array::uniform3(-2i32..3), 3..30),
        query in prop::array::uniform3(-3i32..4),
    ) {
        let positions: Vec<[f64; 3]> = corners.iter().map(|corner| corner.map(f64::from)).collect();
        let last = positions.len() as u32 - 2;
        let faces = (0..last).map(|vertex| [vertex, vertex + 1, vertex + 2]).collect();
        let mesh = TriangleMesh::new(positions, faces);
        let query = query.map(f64::from);
        let found = BoundingVolumes::build(&mesh).unwrap().closest(query);
        prop_assert!((found.squared_distance - by_trying_all(&mesh, query)).abs() < 1e-12);
    }
}
