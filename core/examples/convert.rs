//! Converts a mesh and says how well it went: `convert MODEL BASE_FACES LEVELS OUT.obj SHARP_ANGLE TOLERANCE AXIS` (0 = by
//! default, the last three optional; an angle or a tolerance of - is the default one). AXIS is x, y or z.

use bozzetto_core::conversion::Axis;
use bozzetto_core::conversion::remesh::{Phase, RemeshOptions, remesh};
use bozzetto_core::hierarchy::Level;
use bozzetto_core::io;
use bozzetto_core::mesh::{BoundingVolumes, CompareOptions, FaceIndex, TriangleMesh, compare};
use bozzetto_core::surface::{FormOptions, Surface};
use glam::DVec3;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |k: usize| arguments.get(k).and_then(|a| a.parse::<usize>().ok()).filter(|&n| n > 0);
    let mesh = io::read_mesh(Path::new(&arguments[0])).expect("a readable mesh");
    let options = RemeshOptions {
        base_faces: number(1),
        levels: number(2).map(|n| n as u8),
        sharp_angle: arguments.get(4).and_then(|a| a.parse().ok()),
        tolerance: arguments.get(5).and_then(|a| a.parse().ok()),
        symmetric: arguments.get(6).and_then(|a| Axis::ALL.into_iter().find(|axis| axis.to_string() == *a)),
        ..RemeshOptions::default()
    };
    let phases: RefCell<Vec<(Phase, Instant)>> = RefCell::new(Vec::new());
    // The longest time between two questions whether to go on, and the phase that had begun.
    let waits = RefCell::new((Instant::now(), Phase::Clean, Vec::<(f64, Phase)>::new()));
    let start = Instant::now();
    let result = remesh(&mesh, &options, &|phase, _| {
        let (last, before, longest) = &mut *waits.borrow_mut();
        longest.push((last.elapsed().as_secs_f64(), *before));
        (*last, *before) = (Instant::now(), phase);
        let mut phases = phases.borrow_mut();
        if phases.last().is_none_or(|last| last.0 != phase) {
            phases.push((phase, Instant::now()));
        }
        true
    })
    .unwrap_or_else(|e| panic!("{}: {e}", arguments[0]));
    let end = Instant::now();
    let mut phases = phases.into_inner();
    phases.push((Phase::Measure, end));
    let timings: Vec<String> =
        phases.windows(2).map(|w| format!("{:?} {:.2}", w[0].0, (w[1].1 - w[0].1).as_secs_f64())).collect();
    let level = result.hierarchy.finest();
    let surface =
        Surface::from_positions(result.hierarchy.clone(), &result.positions, &FormOptions::default())
            .expect("a surface");
    let out = TriangleMesh::new(result.positions, result.hierarchy.triangles(level));
    let options = CompareOptions { samples: 1_000_000, seed: 5 };
    let measured = compare(&mesh, &out, &options, &|_| true).expect("a comparison");
    let base = result.hierarchy.base();
    let valences: Vec<usize> = (0..base.vertex_count()).map(|v| base.fan(v).corners.len()).collect();
    let (low, high) = (valences.iter().min().unwrap_or(&0), valences.iter().max().unwrap_or(&0));
    println!(
        "{}: {} faces -> {} x 4^{} ({} vertices; V_in {}) genus {} loops {} components {} valence {low}-{high}, {} sharp",
        arguments[0],
        mesh.faces.len(),
        base.faces().len(),
        level.0,
        out.positions.len(),
        mesh.positions.len(),
        base.genus(),
        base.boundary_loops(),
        base.components(),
        base.sharp_edges().len()
    );
    println!("  {:.2} s: {}; cleaned {:?}", (end - start).as_secs_f64(), timings.join(", "), result.cleaned);
    let (last, before, mut longest) = waits.into_inner();
    longest.push((end.duration_since(last).as_secs_f64(), before));
    longest.sort_by(|a, b| b.0.total_cmp(&a.0));
    let longest: Vec<String> =
        longest.iter().take(8).map(|(seconds, phase)| format!("{phase:?} {:.0} ms", seconds * 1e3)).collect();
    println!("  longest waits for an answer to whether to go on: {}", longest.join(", "));
    println!(
        "  rms {:.3e} max {:.3e} | ab {:.2e} {:.2e} ba {:.2e} {:.2e}",
        measured.rms,
        measured.max,
        measured.a_to_b.rms,
        measured.a_to_b.max,
        measured.b_to_a.rms,
        measured.b_to_a.max
    );
    shape(&mesh, &out);
    creases(&mesh, &surface);
    if level > Level(0)
        && let Some(path) = arguments.get(3)
    {
        let text: String = out
            .positions
            .iter()
            .map(|p| format!("v {} {} {}\n", p[0], p[1], p[2]))
            .chain(out.faces.iter().map(|f| format!("f {} {} {}\n", f[0] + 1, f[1] + 1, f[2] + 1)))
            .collect();
        std::fs::write(path, text).expect("a writable path");
    }
}

/// Angles, and faces whose normal is more than 90° from that of the nearest point of the input.
fn shape(mesh: &TriangleMesh, out: &TriangleMesh) {
    let tree = BoundingVolumes::build(mesh).expect("faces");
    let mut cursor = tree.cursor();
    let mut angles = Vec::new();
    let mut flips = 0;
    for f in 0..out.faces.len() as u32 {
        let [a, b, c] = out.corners(FaceIndex(f)).map(DVec3::from);
        for (p, q, r) in [(a, b, c), (b, c, a), (c, a, b)] {
            angles.push((q - p).angle_between(r - p).to_degrees());
        }
        let closest = cursor.closest(((a + b + c) / 3.0).to_array());
        let [d, e, g] = mesh.corners(closest.face).map(DVec3::from);
        flips += usize::from((b - a).cross(c - a).dot((e - d).cross(g - d)) <= 0.0);
    }
    angles.sort_by(f64::total_cmp);
    let above = angles.iter().filter(|a| **a > 15.0).count() as f64 / angles.len() as f64;
    println!(
        "  angles: least {:.2}°, 0.1% {:.1}°, 1% {:.1}°, 5% {:.1}°; above 15°: {:.2}%; flips {flips} ({:.3}%)",
        angles[0],
        angles[angles.len() / 1000],
        angles[angles.len() / 100],
        angles[angles.len() / 20],
        100.0 * above,
        100.0 * flips as f64 / out.faces.len() as f64
    );
}

/// How far the input's edges of more than 20° are from each level: the greatest distance and the root mean square.
fn creases(mesh: &TriangleMesh, surface: &Surface) {
    let corner = |v: u32| DVec3::from(mesh.positions[v as usize]);
    let mut sides: BTreeMap<[u32; 2], Vec<DVec3>> = BTreeMap::new();
    for face in &mesh.faces {
        let [a, b, c] = face.map(corner);
        for k in 0..3 {
            let (v, w) = (face[k], face[(k + 1) % 3]);
            sides.entry([v.min(w), v.max(w)]).or_default().push((b - a).cross(c - a));
        }
    }
    let sharp = |normals: &[DVec3]| matches!(normals, [n, m] if n.angle_between(*m) > 20f64.to_radians());
    let points: Vec<DVec3> = sides
        .iter()
        .filter(|(_, normals)| sharp(normals))
        .flat_map(|(ends, _)| {
            let [p, q] = ends.map(corner);
            [p, (p + q) * 0.5]
        })
        .collect();
    if points.is_empty() {
        return;
    }
    let diagonal = mesh.diagonal();
    let figures: Vec<String> = (0..=surface.finest().0)
        .map(|level| {
            let tree = BoundingVolumes::build(&surface.to_mesh(Level(level))).expect("faces");
            let mut cursor = tree.cursor();
            let off = |p: &DVec3| DVec3::from(cursor.closest(p.to_array()).point).distance(*p) / diagonal;
            let (max, squares) =
                points.iter().map(off).fold((0.0f64, 0.0), |(max, sum), d| (max.max(d), sum + d * d));
            format!("{level}: {max:.2e} {:.2e}", (squares / points.len() as f64).sqrt())
        })
        .collect();
    println!("  creases, max and rms by level: {}", figures.join("; "));
}
