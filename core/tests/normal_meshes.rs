//! Surfaces drawn along themselves: their detail along normals takes fewer bytes, what is sharp stays, and nothing depends
//! on threads.

use bozzetto_core::conversion::remesh::RemeshError;
use bozzetto_core::conversion::{ConversionOptions, Converted, Remesh, convert, move_along};
use bozzetto_core::file::{Metadata, Model, NotNormal, Size, encode_smaller, normal_mesh};
use bozzetto_core::hierarchy::{BaseMesh, Hierarchy, Level, Slot};
use bozzetto_core::mesh::{CompareOptions, TriangleMesh, compare, shapes};
use bozzetto_core::surface::{FormOptions, Surface};
use bozzetto_core::wavelet::Wavelet;
use std::sync::Arc;

/// A ball with hills of two sizes.
fn hilly_ball() -> TriangleMesh {
    let mut mesh = shapes::subdivide(&shapes::octahedron(), 5);
    for p in &mut mesh.positions {
        let length = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
        let u = p.map(|x| x / length);
        let hills =
            1.0 + 0.2 * (3.0 * u[0]).sin() * (4.0 * u[1]).cos() + 0.03 * (9.0 * u[2] + 5.0 * u[0]).sin();
        *p = u.map(|x| x * hills);
    }
    mesh
}

fn converted(mesh: &TriangleMesh) -> Converted {
    let given = ConversionOptions {
        levels: Some(3),
        base_faces: Some(100),
        remesh: Remesh::Always,
        ..ConversionOptions::default()
    };
    convert(mesh, &given).expect("a ball")
}

fn straightened(mesh: &TriangleMesh, from: &Converted) -> Vec<[f64; 3]> {
    normal_mesh(mesh, &from.hierarchy, &from.positions, Wavelet::Disc(2), &|_| true).expect("a ball")
}

fn surface(hierarchy: &Hierarchy, positions: &[[f64; 3]]) -> Surface {
    Surface::from_positions(hierarchy.clone(), positions, &FormOptions::default()).expect("small")
}

#[test]
fn detail_along_normals_takes_fewer_bytes() {
    let mesh = hilly_ball();
    let made = converted(&mesh);
    let bytes = |positions: &[[f64; 3]]| {
        let model = Model::new(surface(&made.hierarchy, positions), None, Metadata::default());
        encode_smaller(&model, Size::Psnr(74.0, &mesh)).expect("fine enough").0.len()
    };
    let normal = straightened(&mesh, &made);
    let (before, after) = (bytes(&made.positions), bytes(&normal));
    assert!(20 * after < 17 * before, "{after} after {before} bytes");
    // The surface is about as near as it was.
    let rms = |positions: &[[f64; 3]]| {
        let surface = surface(&made.hierarchy, positions);
        let held = surface.to_mesh(surface.finest());
        compare(&mesh, &held, &CompareOptions { samples: 50_000, seed: 3 }, &|_| true).expect("surfaces").rms
    };
    let (before, after) = (rms(&made.positions), rms(&normal));
    assert!(after < 1.5 * before, "{after} after {before}");
}

#[test]
fn threads_do_not_matter_and_a_refusal_ends_it() {
    let mesh = hilly_ball();
    let made = converted(&mesh);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| straightened(&mesh, &made))
    };
    assert!(with(1) == with(3));
    let refused = normal_mesh(&mesh, &made.hierarchy, &made.positions, Wavelet::Disc(0), &|done| done < 0.5);
    assert_eq!(refused, Err(NotNormal::Fit(RemeshError::Cancelled)));
}

/// Vertices on sharp edges slide along them and base vertices there stay, whatever the goal.
#[test]
fn what_is_sharp_stays_on_its_curve() {
    let mesh = shapes::octahedron();
    let marks = [mesh.faces[0][0], mesh.faces[0][1]];
    let base = BaseMesh::new(6, mesh.faces.clone(), &[marks]).expect("a base mesh");
    let hierarchy = Hierarchy::new(Arc::new(base), Level(4)).expect("small");
    let input = shapes::subdivide(&mesh, 4);
    let layout = hierarchy.layout(Level(4));
    let place = |slot: u32| {
        let (face, b) = layout.chart(layout.site(Slot(slot)));
        let corners = hierarchy.base().faces()[face as usize].map(|v| mesh.positions[v as usize]);
        [0, 1, 2].map(|c| (0..3).map(|k| f64::from(b[k]) * corners[k][c]).sum::<f64>() / 16.0)
    };
    let positions: Vec<[f64; 3]> = (0..layout.len()).map(place).collect();
    let goal = |at: &[[f64; 3]]| -> Vec<[f64; 3]> {
        at.iter().map(|p| [p[0] + 0.02, p[1] - 0.01, p[2] + 0.01]).collect()
    };
    let moved = move_along(&input, &hierarchy, &positions, &goal, &|_| true).expect("a surface");
    let edge = hierarchy.base().sharp_edges()[0];
    let [a, b] = edge.map(|v| mesh.positions[v as usize]);
    let id = hierarchy.base().edges().iter().position(|&ends| ends == edge).expect("an edge") as u32;
    let mut slid = 0;
    for t in 0..=16 {
        let slot = layout.slot(layout.along_edge(id, t)).index();
        let (p, q) = (positions[slot], moved[slot]);
        let along: f64 = (0..3).map(|c| (q[c] - a[c]) * (b[c] - a[c])).sum::<f64>() / 2.0;
        let off = (0..3).map(|c| (q[c] - a[c] - along * (b[c] - a[c])).abs()).fold(0.0, f64::max);
        assert!(off < 1e-9, "vertex {t} is {off} off its edge");
        let way = (0..3).map(|c| (q[c] - p[c]).abs()).fold(0.0, f64::max);
        if t == 0 || t == 16 {
            assert!(way < 1e-12, "an end moved by {way}");
        }
        slid += usize::from(way > 1e-4);
    }
    assert!(slid > 5, "{slid} vertices slid");
}
