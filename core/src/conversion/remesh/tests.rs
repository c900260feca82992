use super::*;
use crate::mesh::{BoundingVolumes, Connectivity, FaceIndex, shapes};

/// A smooth-ish bumpy version of a shape with irregular connectivity left as it is.
fn bumpy(mesh: &TriangleMesh, times: u32) -> TriangleMesh {
    let mut fine = shapes::subdivide(mesh, times);
    for p in &mut fine.positions {
        let bump = 0.03 * ((3.0 * p[0]).sin() + (4.0 * p[1]).cos() + (2.5 * p[2]).sin());
        *p = [p[0] + bump, p[1] - 0.5 * bump, p[2] + 0.7 * bump];
    }
    fine
}

fn figures(vertices: usize, faces: &[[u32; 3]]) -> (u32, u32, u32) {
    let connectivity = Connectivity::build(vertices as u32, faces.to_vec()).expect("a manifold");
    (connectivity.genus(), connectivity.components(), connectivity.boundary_loops())
}

fn options(base_faces: usize, levels: u8) -> RemeshOptions {
    RemeshOptions { base_faces: Some(base_faces), levels: Some(levels), ..RemeshOptions::default() }
}

/// Faces whose normal is against that of the nearest point of the input.
fn turned(input: &TriangleMesh, result: &TriangleMesh) -> usize {
    let tree = BoundingVolumes::build(input).expect("faces");
    let normal = |mesh: &TriangleMesh, f: FaceIndex| {
        let [a, b, c] = mesh.corners(f).map(DVec3::from);
        (b - a).cross(c - a)
    };
    (0..result.faces.len() as u32)
        .filter(|&f| {
            let [a, b, c] = result.corners(FaceIndex(f)).map(DVec3::from);
            let nearest = tree.closest(((a + b + c) / 3.0).to_array()).face;
            normal(result, FaceIndex(f)).dot(normal(input, nearest)) <= 0.0
        })
        .count()
}

/// A ball with two thin horns, bent cones fifteen times as long as they are wide.
fn horned() -> TriangleMesh {
    let mut mesh = shapes::subdivide(&shapes::octahedron(), 6);
    for p in &mut mesh.positions {
        let at = DVec3::from(*p).normalize();
        let horn = (1.0 - at.truncate().length() / 0.15).max(0.0);
        let way = DVec3::new(horn, 0.0, at.z.signum()) * (2.0 * horn);
        *p = (at + way).to_array();
    }
    mesh
}

#[test]
fn thin_horns_are_kept_to_their_tips() {
    let input = horned();
    let result = remesh(&input, &options(60, 3), &|_, _| true).expect("a conversion");
    let tips = [1.0, -1.0].map(|side| {
        let tip = DVec3::new(2.0, 0.0, 3.0 * side);
        result.positions.iter().map(|&p| tip.distance(p.into())).fold(f64::INFINITY, f64::min)
    });
    assert!(tips.iter().all(|off| *off < 0.15), "the tips are {tips:?} off");
}

#[test]
fn topology_is_kept_and_the_surfaces_are_close() {
    for (name, mesh, base_faces) in [
        ("sphere", shapes::octahedron(), 24),
        ("torus", shapes::torus(12, 16), 60),
        ("pretzel", shapes::pretzel(2), 150),
        ("disc", shapes::disc(7), 12),
        ("bipyramid", shapes::bipyramid(12), 30),
        ("two components", shapes::together(&[shapes::octahedron(), shapes::disc(7)]), 30),
    ] {
        let input = bumpy(&mesh, 3);
        let result = remesh(&input, &options(base_faces, 3), &|_, _| true).expect(name);
        let faces = result.hierarchy.triangles(Level(3));
        assert!(result.hierarchy.base().faces().len() <= base_faces, "{name}");
        let expected = figures(input.positions.len(), &input.faces);
        assert_eq!(figures(result.positions.len(), &faces), expected, "{name}");
        assert!(result.measured.rms < 5e-3, "{name}: rms {}", result.measured.rms);
        let out = TriangleMesh::new(result.positions, faces);
        assert!(turned(&input, &out) * 500 <= out.faces.len(), "{name}: {} turned", turned(&input, &out));
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let input = bumpy(&shapes::pretzel(2), 2);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| remesh(&input, &options(120, 2), &|_, _| true)).expect("a conversion").positions
    };
    let bits =
        |positions: Vec<[f64; 3]>| positions.into_iter().flatten().map(f64::to_bits).collect::<Vec<_>>();
    let one = bits(run(1));
    assert!(one == bits(run(2)) && one == bits(run(7)));
}

#[test]
fn the_tolerance_is_compared_with_what_was_measured() {
    let input = bumpy(&shapes::octahedron(), 4);
    let with = |tolerance| RemeshOptions { tolerance: Some(tolerance), ..options(40, 3) };
    let met = |tolerance| remesh(&input, &with(tolerance), &|_, _| true).expect("a conversion").tolerance_met;
    assert_eq!((met(0.5), met(1e-9)), (Some(true), Some(false)));
}

#[test]
fn every_phase_can_be_cancelled() {
    let input = bumpy(&shapes::octahedron(), 4);
    for stop in [Phase::Clean, Phase::Simplify, Phase::Resample, Phase::Relax, Phase::Fit, Phase::Measure] {
        let result = remesh(&input, &options(40, 3), &|phase, _| phase != stop);
        let cancelled =
            matches!(result, Err(RemeshError::Cancelled | RemeshError::Measure(CompareError::Cancelled)));
        assert!(cancelled, "{stop:?}");
    }
}

/// Whatever question gets the answer no is the last.
#[test]
fn the_first_no_ends_the_conversion() {
    let input = shapes::subdivide(&shapes::octahedron(), 3);
    for symmetric in [None, Some(Axis::X)] {
        let options = RemeshOptions { symmetric, ..options(16, 2) };
        let asked = std::cell::Cell::new(0);
        let up_to = |last: u32| {
            asked.set(0);
            remesh(&input, &options, &|_, _| asked.replace(asked.get() + 1) < last).map(|_| ())
        };
        up_to(u32::MAX).expect("a conversion");
        let all = asked.get();
        assert!(all > 100, "{all}");
        for last in (0..all).step_by(all as usize / 40) {
            let result = up_to(last);
            let cancelled =
                matches!(result, Err(RemeshError::Cancelled | RemeshError::Measure(CompareError::Cancelled)));
            assert!(cancelled && asked.get() == last + 1, "{last} of {all}: {result:?}, {}", asked.get());
        }
    }
}

#[test]
fn nothing_to_convert_is_said() {
    let flat = TriangleMesh::new(vec![[1.0; 3]; 3], vec![[0, 1, 2]]);
    assert!(matches!(remesh(&flat, &RemeshOptions::default(), &|_, _| true), Err(RemeshError::Empty)));
}

/// So many faces are thinned first, and the marked edges with them: fewer, and still one ring.
#[test]
fn marks_outlive_thinning() {
    let mut mesh = shapes::subdivide(&shapes::octahedron(), 8);
    for p in &mut mesh.positions {
        *p = DVec3::from(*p).normalize().to_array();
    }
    let in_plane = |ends: &[u32; 2]| ends.iter().all(|&v| mesh.positions[v as usize][2] == 0.0);
    let ring: Vec<[u32; 2]> =
        mesh.faces.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).filter(in_plane).collect();
    let mesh = mesh.with_sharp_edges(ring);
    let connectivity = Connectivity::build(mesh.positions.len() as u32, mesh.faces.clone()).unwrap();
    let Prepared { target, ground, .. } = Prepared::new(mesh, connectivity, &|_| true).unwrap();
    assert!(ground.faces.len() < target.faces.len());
    assert!(
        (64..target.sharp_edges.len()).contains(&ground.sharp_edges.len()),
        "{}",
        ground.sharp_edges.len()
    );
    let of_ring = ground.sharp_edges.iter().flatten();
    let off = of_ring.clone().map(|&v| ground.positions[v as usize][2].abs()).fold(0.0, f64::max);
    assert!(off < 1e-5, "{off}");
    let mut ends: Vec<&u32> = of_ring.collect();
    ends.sort_unstable();
    assert!(ends.chunks(2).all(|pair| pair[0] == pair[1]) && ends.len() == 2 * ground.sharp_edges.len());
}
