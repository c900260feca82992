//! Base meshes that are their own mirror image, of shapes whose triangles are not.

mod mirrored;

use bozzetto_core::conversion::remesh::{RemeshError, RemeshOptions, Remeshed, remesh};
use bozzetto_core::conversion::{Axis, ConversionOptions, convert};
use bozzetto_core::mesh::{Connectivity, TriangleMesh, shapes};
use glam::DVec3;
use std::collections::BTreeMap;

/// Where all shapes have their mirror plane.
const PLANE: f64 = 0.3;
/// Cells of the grid that shapes are taken out of, and their size.
const CELLS: i64 = 42;
const CELL: f64 = 0.1;

/// The zero set of a function of (|x − PLANE|, y, z), in tetrahedra that lie askew to the plane.
fn shape(inside: impl Fn(DVec3) -> f64) -> TriangleMesh {
    let corner = |[i, j, k]: [i64; 3]| {
        let [u, v, w] = [i, j, k].map(|n| (n - CELLS / 2) as f64 * CELL);
        DVec3::new(u + 0.21 * v + 0.037, v - 0.13 * w + 0.011, w + 0.17 * u - 0.023)
    };
    let value = |at: [i64; 3]| {
        let p = corner(at);
        inside(DVec3::new((p.x - PLANE).abs(), p.y, p.z))
    };
    let mut mesh = TriangleMesh::default();
    let mut between: BTreeMap<[[i64; 3]; 2], u32> = BTreeMap::new();
    let mut cut = |a: [i64; 3], b: [i64; 3], mesh: &mut TriangleMesh| {
        *between.entry([a.min(b), a.max(b)]).or_insert_with(|| {
            let (mut low, mut high) = (0.0, 1.0);
            let sign = value(a) < 0.0;
            let place = |t: f64| corner(a).lerp(corner(b), t);
            for _ in 0..30 {
                let t = 0.5 * (low + high);
                let p = place(t);
                let same = (inside(DVec3::new((p.x - PLANE).abs(), p.y, p.z)) < 0.0) == sign;
                if same { low = t } else { high = t }
            }
            // No two vertices at one place.
            mesh.positions.push(place((0.5 * (low + high)).clamp(0.02, 0.98)).to_array());
            mesh.positions.len() as u32 - 1
        })
    };
    let orders = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
    for cell in 0..CELLS.pow(3) {
        let at = [cell % CELLS, cell / CELLS % CELLS, cell / CELLS / CELLS];
        for order in orders {
            // From one corner of the cell to the other along its edges.
            let mut corners = [at; 4];
            for step in 0..3 {
                corners[step + 1] = corners[step];
                corners[step + 1][order[step]] += 1;
            }
            let (within, without): (Vec<_>, Vec<_>) = corners.iter().partition(|&&c| value(c) < 0.0);
            let polygon: Vec<u32> = match (&within[..], &without[..]) {
                ([a, b], [c, d]) => {
                    [(a, c), (a, d), (b, d), (b, c)].map(|(&p, &q)| cut(p, q, &mut mesh)).to_vec()
                }
                ([a], others) | (others, [a]) => others.iter().map(|&b| cut(*a, b, &mut mesh)).collect(),
                _ => continue,
            };
            let places: Vec<DVec3> = polygon.iter().map(|&v| mesh.positions[v as usize].into()).collect();
            let out = corner(without[0]) - corner(within[0]);
            for k in 1..polygon.len() - 1 {
                let normal = (places[k] - places[0]).cross(places[k + 1] - places[0]);
                let [b, c] = if normal.dot(out) > 0.0 { [k, k + 1] } else { [k + 1, k] };
                mesh.faces.push([polygon[0], polygon[b], polygon[c]]);
            }
        }
    }
    mesh
}

fn ball(p: DVec3, centre: [f64; 3], radius: f64) -> f64 {
    p.distance(centre.into()) - radius
}

/// A ring about the z axis.
fn ring(p: DVec3, centre: [f64; 3], radii: [f64; 2]) -> f64 {
    let q = p - DVec3::from(centre);
    let around = q.truncate().length() - radii[0];
    (around * around + q.z * q.z).sqrt() - radii[1]
}

fn blended(a: f64, b: f64) -> f64 {
    let h = (0.25 - (a - b).abs()).max(0.0) / 0.25;
    a.min(b) - h * h * 0.0625
}

/// A head with two ears and a snout.
fn head(p: DVec3) -> f64 {
    let ears = ball(p, [0.6, 0.75, 0.0], 0.3);
    let snout = ball(p, [0.0, -0.1, 0.8], 0.3);
    blended(blended(ball(p, [0.0, 0.0, 0.0], 0.8), ears), snout)
}

/// The part of a mesh above a plane across z.
fn above(mesh: &TriangleMesh, z: f64) -> TriangleMesh {
    let mut out = TriangleMesh::new(mesh.positions.clone(), Vec::new());
    let mut across: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    for face in &mesh.faces {
        let mut polygon = Vec::new();
        for k in 0..3 {
            let (v, w) = (face[k], face[(k + 1) % 3]);
            let [p, q] = [v, w].map(|v| DVec3::from(mesh.positions[v as usize]));
            if p.z > z {
                polygon.push(v);
            }
            if (p.z > z) != (q.z > z) {
                polygon.push(*across.entry([v.min(w), v.max(w)]).or_insert_with(|| {
                    out.positions.push(p.lerp(q, (z - p.z) / (q.z - p.z)).to_array());
                    out.positions.len() as u32 - 1
                }));
            }
        }
        (2..polygon.len()).for_each(|k| out.faces.push([polygon[0], polygon[k - 1], polygon[k]]));
    }
    out
}

fn shapes_to_mirror() -> Vec<(&'static str, TriangleMesh)> {
    let whole = shape(head);
    vec![
        ("handle through the plane", shape(|p| blended(head(p), ring(p, [0.0, 0.8, 0.0], [0.45, 0.17])))),
        (
            "a handle on each side",
            shape(|p| blended(ball(p, [0.0; 3], 0.7), ring(p, [0.95, 0.0, 0.1], [0.38, 0.16]))),
        ),
        ("open below", above(&whole, -0.45)),
        ("a part on each side", shape(|p| ball(p, [0.0, 0.0, 0.1], 0.5).min(ball(p, [1.1, 0.2, 0.0], 0.4)))),
        ("head", whole),
    ]
}

fn converted(mesh: &TriangleMesh, symmetric: Option<Axis>) -> Result<Remeshed, RemeshError> {
    let options =
        RemeshOptions { base_faces: Some(160), levels: Some(3), symmetric, ..RemeshOptions::default() };
    remesh(mesh, &options, &|_, _| true)
}

fn figures(mesh: &TriangleMesh) -> (u32, u32, u32) {
    let own = Connectivity::build(mesh.positions.len() as u32, mesh.faces.clone()).expect("a manifold");
    (own.genus(), own.components(), own.boundary_loops())
}

#[test]
fn bases_are_their_own_mirror_image() {
    for (name, mesh) in shapes_to_mirror() {
        let made = converted(&mesh, Some(Axis::X)).expect(name);
        let base = made.hierarchy.base();
        assert_eq!((base.genus(), base.components(), base.boundary_loops()), figures(&mesh), "{name}");
        assert!(base.faces().len() <= 160 && base.faces().len() > 100, "{name}: {}", base.faces().len());
        let on_seam = mirrored::check(name, &made.hierarchy, &made.positions, PLANE, 0.0);
        assert!(on_seam >= 3, "{name}: {on_seam} vertices lie in the plane");
        let without = converted(&mesh, None).expect(name).measured;
        let with = made.measured;
        assert!(with.rms < 1.5 * without.rms, "{name}: {} and {} without", with.rms, without.rms);
    }
}

/// The same shape with its other axes in the mirror plane, elsewhere and larger.
#[test]
fn every_axis_can_be_mirrored() {
    let mesh = shape(head);
    let straight = converted(&mesh, Some(Axis::X)).expect("a conversion");
    for (axis, turns) in [(Axis::Y, 1), (Axis::Z, 2)] {
        let mut turned = mesh.clone();
        turned.positions.iter_mut().for_each(|p| p.rotate_right(turns));
        let mut made = converted(&turned, Some(axis)).expect("a conversion");
        made.positions.iter_mut().for_each(|p| p.rotate_left(turns));
        mirrored::check("turned", &made.hierarchy, &made.positions, PLANE, 0.0);
        assert_eq!(made.hierarchy.base().faces().len(), straight.hierarchy.base().faces().len());
    }
}

#[test]
fn a_little_unevenness_is_no_obstacle() {
    let mut mesh = shape(head);
    for p in &mut mesh.positions {
        // One ear is longer, and everything is a little askew.
        let ear = (1.0 - DVec3::from(*p).distance(DVec3::new(PLANE - 0.7, 1.0, 0.0)) / 0.5).max(0.0);
        p[1] += 0.12 * ear * ear + 0.01 * (5.0 * p[0]).sin();
    }
    let made = converted(&mesh, Some(Axis::X)).expect("a conversion");
    mirrored::check("uneven", &made.hierarchy, &made.positions, PLANE, 0.13);
    let without = converted(&mesh, None).expect("a conversion").measured;
    assert!(made.measured.rms < 2.0 * without.rms, "{} and {}", made.measured.rms, without.rms);
    assert!(made.measured.max < 4.0 * without.max, "{} and {}", made.measured.max, without.max);
}

#[test]
fn what_is_not_symmetric_is_refused() {
    let mesh = shape(head);
    match converted(&mesh, Some(Axis::Z)) {
        Err(RemeshError::NotSymmetric { axis: Axis::Z, rms }) => assert!(rms > 0.01, "{rms}"),
        other => panic!("{:?}", other.map(|made| made.measured)),
    }
    // A hole on one side.
    let mut open = mesh;
    let beside = |face: &[u32; 3]| face.iter().all(|&v| open.positions[v as usize][0] > PLANE + 0.2);
    let hole = open.faces.iter().position(beside).expect("a face on that side");
    open.faces.remove(hole);
    let refused = converted(&open, Some(Axis::X)).map(|made| made.measured);
    assert_eq!(refused, Err(RemeshError::SidesDiffer { axis: Axis::X }));
}

#[test]
fn any_number_of_threads_gives_the_same_symmetric_base() {
    let mesh = shape(head);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let made = pool.install(|| converted(&mesh, Some(Axis::X))).expect("a conversion");
        let bits: Vec<u64> = made.positions.iter().flatten().map(|x| x.to_bits()).collect();
        (made.hierarchy.base().faces().to_vec(), bits)
    };
    let one = run(1);
    assert!(one == run(2) && one == run(5));
}

/// Vertices that are kept cannot be mirrored, and that is said.
#[test]
fn a_mesh_that_keeps_its_vertices_says_that_it_is_not_mirrored() {
    let mesh = shapes::subdivide(&shapes::octahedron(), 2);
    let options = ConversionOptions { symmetric: Some(Axis::X), ..ConversionOptions::default() };
    let converted = convert(&mesh, &options).expect("a conversion");
    assert!(converted.source.is_some());
    assert!(converted.cleaned.iter().any(|sentence| sentence.contains("not made symmetric along x")));
}
