//! Edges that a file marks as sharp: they become sharp edges of the base mesh whatever their angle, and leave with an
//! export.

mod samples;

use bozzetto_core::conversion::{ConversionOptions, Converted, Remesh, convert};
use bozzetto_core::hierarchy::Level;
use bozzetto_core::io::{MeshFormat, read_mesh_bytes, write_mesh};
use bozzetto_core::mesh::{TriangleMesh, shapes};
use bozzetto_core::wavelet::Wavelet;

/// A lumpy ball whose edges in the plane z = 0 are marked: its normals turn by two degrees there.
fn ringed_ball(levels: u32) -> TriangleMesh {
    let mut mesh = shapes::subdivide(&shapes::octahedron(), levels);
    for p in &mut mesh.positions {
        let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
        let radius = 1.0 + 0.1 * (3.0 * p[0]).sin() + 0.05 * (4.0 * p[1] + p[2]).cos();
        *p = p.map(|x| x / length * radius);
    }
    let in_plane = |v: &u32| mesh.positions[*v as usize][2] == 0.0;
    let sides = mesh.faces.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let ring = sides.filter(|ends| ends.iter().all(in_plane)).collect();
    mesh.with_sharp_edges(ring)
}

fn remeshed(mesh: &TriangleMesh, base_faces: usize, sharp_angle: Option<f64>) -> Converted {
    let options = ConversionOptions {
        remesh: Remesh::Always,
        base_faces: Some(base_faces),
        levels: Some(3),
        sharp_angle,
        ..ConversionOptions::default()
    };
    convert(mesh, &options).expect("a conversion")
}

/// How far the sharp edges of the finest level are from the plane z = 0, and their length.
fn ring_of(converted: &Converted) -> (f64, f64) {
    let layout = converted.hierarchy.layout(converted.hierarchy.finest());
    let mut figures = (0.0f64, 0.0);
    for [p, q] in layout.sharp_edges().map(|ends| ends.map(|slot| converted.positions[slot.index()])) {
        figures.0 = figures.0.max(p[2].abs());
        figures.1 += (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt();
    }
    figures
}

#[test]
fn marked_edges_become_sharp_edges_of_the_base_mesh() {
    let mesh = ringed_ball(5);
    let around: f64 = mesh.sharp_edges.iter().map(|&[a, b]| length(&mesh, [a, b])).sum();
    for sharp_angle in [None, Some(180.0), Some(80.0)] {
        let (off, length) = ring_of(&remeshed(&mesh, 120, sharp_angle));
        assert!(off < 1e-9, "{sharp_angle:?}: {off} off the plane");
        assert!((length / around - 1.0).abs() < 0.01, "{sharp_angle:?}: {length} of {around}");
    }
    let unmarked = TriangleMesh { sharp_edges: Vec::new(), ..mesh };
    assert_eq!(ring_of(&remeshed(&unmarked, 120, None)), (0.0, 0.0));
}

fn length(mesh: &TriangleMesh, ends: [u32; 2]) -> f64 {
    let [p, q] = ends.map(|v| mesh.positions[v as usize]);
    (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt()
}

/// Every face with corners of its own, as STL-like exporters write them, and one that stands twice: repair numbers the
/// vertices anew, and the marks are found by their places.
#[test]
fn marks_outlive_a_repair() {
    let whole = ringed_ball(4);
    let positions = whole.faces.iter().flatten().map(|&v| whole.positions[v as usize]).collect();
    let count = 3 * whole.faces.len() as u32;
    let mut soup =
        TriangleMesh::new(positions, (0..count / 3).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect());
    let marked = |ends: [u32; 2]| {
        let [a, b] = ends.map(|corner| whole.faces[corner as usize / 3][corner as usize % 3]);
        whole.sharp_edges.contains(&[a.min(b), a.max(b)])
    };
    let sides = soup.faces.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let ring = sides.filter(|&ends| marked(ends)).collect();
    soup.faces.push([2, 1, 0]);
    let (off, length) = ring_of(&remeshed(&soup.with_sharp_edges(ring), 120, None));
    assert!(off < 1e-9 && length > 5.0, "{length} around, {off} off the plane");
}

/// A wireframe marks every edge: no base mesh has so many corners, and the surface is made without them.
#[test]
fn marks_on_every_edge_are_passed_over_and_that_is_said() {
    let mesh = ringed_ball(4);
    let every = mesh.faces.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    let converted = remeshed(&mesh.with_sharp_edges(every), 120, None);
    assert!(converted.hierarchy.base().sharp_edges().is_empty());
    assert!(converted.hierarchy.base().faces().len() <= 130);
    let said: Vec<&String> =
        converted.cleaned.iter().filter(|said| said.contains("marked as sharp")).collect();
    assert_eq!(said.len(), 1, "{:?}", converted.cleaned);
}

#[test]
fn sharp_edges_leave_with_an_export_and_come_back() {
    for (name, base) in shapes::awkward() {
        let surface = samples::surface(&base, Wavelet::Disc(1), 2, 3, 7);
        let count = surface.hierarchy().base().sharp_edges().len();
        let mesh = surface.to_mesh(surface.finest());
        assert_eq!(mesh.sharp_edges.len(), 8 * count, "{name}");
        for format in [MeshFormat::Obj, MeshFormat::Ply] {
            let mut bytes = Vec::new();
            write_mesh(&mesh, format, &mut bytes).expect("written");
            let read = read_mesh_bytes(format, &bytes, "model").expect("read");
            assert_eq!(read, mesh, "{name}");
            let options = ConversionOptions { levels: Some(3), ..ConversionOptions::default() };
            let again = convert(&read, &options).expect("it has subdivision connectivity");
            assert_eq!(again.hierarchy.finest(), Level(3), "{name}");
            assert_eq!(again.hierarchy.base().sharp_edges().len(), count, "{name}: {:?}", again.cleaned);
        }
    }
}

/// One edge of a finer level alone cannot be sharp.
#[test]
fn marks_along_a_part_of_a_base_edge_are_counted() {
    let mut mesh = samples::ball(3).to_mesh(Level(3));
    mesh = mesh.clone().with_sharp_edges(vec![[mesh.faces[0][0], mesh.faces[0][1]]]);
    let converted = convert(&mesh, &ConversionOptions::default()).expect("it has subdivision connectivity");
    assert!(converted.hierarchy.base().sharp_edges().is_empty());
    assert!(
        converted.cleaned.iter().any(|said| said.starts_with("1 of 1 edges marked")),
        "{:?}",
        converted.cleaned
    );
}
