//! Sharp edges and corners through the conversion: marked where the input has them, and on it at every level.

mod mirrored;

use bozzetto_core::conversion::Axis;
use bozzetto_core::conversion::remesh::{RemeshOptions, Remeshed, remesh};
use bozzetto_core::hierarchy::{BaseMesh, Level, Site};
use bozzetto_core::mesh::{BoundingVolumes, TriangleMesh, shapes};
use bozzetto_core::surface::{FormOptions, Surface};
use bozzetto_core::wavelet::Wavelet;
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};

/// Edges of the input whose faces meet at more than 40°, and those of the boundary if asked for.
fn curves(mesh: &TriangleMesh, boundary: bool) -> Vec<[DVec3; 2]> {
    let at = |v: u32| DVec3::from(mesh.positions[v as usize]);
    let mut sides: BTreeMap<[u32; 2], Vec<DVec3>> = BTreeMap::new();
    for f in &mesh.faces {
        let [a, b, c] = f.map(at);
        for k in 0..3 {
            let (v, w) = (f[k], f[(k + 1) % 3]);
            sides.entry([v.min(w), v.max(w)]).or_default().push((b - a).cross(c - a));
        }
    }
    let wanted = |normals: &[DVec3]| match normals {
        [n, m] => !boundary && n.angle_between(*m) > 40f64.to_radians(),
        _ => boundary,
    };
    sides.iter().filter(|(_, n)| wanted(n)).map(|(ends, _)| ends.map(at)).collect()
}

fn distance(p: DVec3, curve: &[[DVec3; 2]]) -> f64 {
    let to = |&[a, b]: &[DVec3; 2]| {
        let t = ((p - a).dot(b - a) / a.distance_squared(b)).clamp(0.0, 1.0);
        p.distance(a + (b - a) * t)
    };
    curve.iter().map(to).fold(f64::INFINITY, f64::min)
}

/// A number between −1 and 1 that only depends on the place.
fn noise(p: [f64; 3], axis: usize) -> f64 {
    let mix = p.iter().fold(axis as u64 + 1, |sum, x| {
        (sum ^ x.to_bits().rotate_left(17)).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29)
    });
    (mix >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// A block of unit cubes with vertices spread irregularly over its faces and along its edges.
fn block(holes: u32) -> TriangleMesh {
    let mut mesh = shapes::subdivide(&shapes::pretzel(holes), 3);
    for p in &mut mesh.positions {
        let was = *p;
        for axis in (0..3).filter(|&axis| was[axis].fract() != 0.0) {
            p[axis] += 0.04 * noise(was, axis);
        }
    }
    mesh
}

/// An irregular square sheet that bulges.
fn sheet() -> TriangleMesh {
    let size = 25u32;
    let mut positions = Vec::new();
    for v in 0..size * size {
        let mut p = [f64::from(v % size), f64::from(v / size), 0.0];
        let was = p;
        for axis in (0..2).filter(|&axis| was[axis] != 0.0 && was[axis] != f64::from(size - 1)) {
            p[axis] += 0.3 * noise(was, axis);
        }
        p[2] = 0.02 * p[0] * (24.0 - p[0]) * (p[1] * 0.2).sin();
        positions.push(p);
    }
    let quads = (0..size - 1).flat_map(|y| (0..size - 1).map(move |x| y * size + x));
    let faces = quads.flat_map(|v| [[v, v + 1, v + size], [v + 1, v + size + 1, v + size]]).collect();
    TriangleMesh::new(positions, faces)
}

/// A cylinder with caps, its sides smooth but for its rims.
fn cylinder() -> TriangleMesh {
    let (around, rings) = (40u32, 14u32);
    let mut positions: Vec<[f64; 3]> = Vec::new();
    let mut ring = |radius: f64, height: f64, turn: f64| {
        for k in 0..around {
            let angle = (f64::from(k) + turn) / f64::from(around) * std::f64::consts::TAU;
            positions.push([radius * angle.cos(), radius * angle.sin(), height]);
        }
    };
    let steps = [0.25, 0.5, 0.75].map(|r| (r, -1.0));
    let side = (0..=rings).map(|k| (1.0, f64::from(k) / f64::from(rings) * 2.0 - 1.0));
    let rows: Vec<(f64, f64)> =
        steps.into_iter().chain(side).chain([0.75, 0.5, 0.25].map(|r| (r, 1.0))).collect();
    for (k, &(radius, height)) in rows.iter().enumerate() {
        ring(radius, height, 0.5 * f64::from(k as u32 % 2));
    }
    let count = rows.len() as u32;
    let at = |row: u32, k: u32| row * around + k % around;
    let mut faces = Vec::new();
    for row in 0..count - 1 {
        for k in 0..around {
            let (a, b, c, d) = (at(row, k), at(row, k + 1), at(row + 1, k), at(row + 1, k + 1));
            let halves = if row % 2 == 0 { [[a, b, c], [b, d, c]] } else { [[a, b, d], [a, d, c]] };
            faces.extend(halves);
        }
    }
    let (south, north) = (count * around, count * around + 1);
    positions.extend([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]]);
    for k in 0..around {
        faces.push([south, at(0, k + 1), at(0, k)]);
        faces.push([north, at(count - 1, k), at(count - 1, k + 1)]);
    }
    TriangleMesh::new(positions, faces)
}

fn converted(mesh: &TriangleMesh, base_faces: usize, sharp_angle: Option<f64>) -> Remeshed {
    let options =
        RemeshOptions { base_faces: Some(base_faces), levels: Some(3), sharp_angle, ..Default::default() };
    remesh(mesh, &options, &|_, _| true).expect("a conversion")
}

fn surface(made: &Remeshed, wavelet: Wavelet) -> Surface {
    let options = FormOptions { wavelet, ..FormOptions::default() };
    Surface::from_positions(made.hierarchy.clone(), &made.positions, &options).expect("a surface")
}

/// Where the descendants of marked edges are at a level.
fn descendants(surface: &Surface, level: Level) -> Vec<DVec3> {
    let layout = surface.hierarchy().layout(level);
    let base = surface.hierarchy().base();
    let marked = (0..base.edges().len() as u32).filter(|&e| base.is_sharp(e));
    marked
        .flat_map(|e| (0..=layout.segments()).map(move |t| (e, t)))
        .map(|(e, t)| DVec3::from(surface.position(level, layout.slot(layout.along_edge(e, t)))))
        .collect()
}

/// The greatest distance of points of a curve from a level of a surface, and of marked edges from the curve.
fn crease_error(surface: &Surface, level: Level, curve: &[[DVec3; 2]]) -> f64 {
    let tree = BoundingVolumes::build(&surface.to_mesh(level)).expect("faces");
    let from_curve = curve
        .iter()
        .flat_map(|&[a, b]| [a, (a + b) * 0.5, b])
        .map(|p| DVec3::from(tree.closest(p.to_array()).point).distance(p));
    let from_marks = descendants(surface, level).into_iter().map(|p| distance(p, curve));
    from_curve.chain(from_marks).fold(0.0, f64::max)
}

/// The vertices where other than two sharp edges meet.
fn corners(base: &BaseMesh) -> BTreeSet<u32> {
    (0..base.vertex_count()).filter(|&v| !matches!(base.sharp_valence(v), 0 | 2)).collect()
}

#[test]
fn straight_creases_are_straight_at_every_level() {
    for (holes, base_faces, expected) in [(0, 40, 8), (1, 90, 16), (2, 150, 24)] {
        let input = block(holes);
        let made = converted(&input, base_faces, None);
        // Without updates every level holds points of the finest: where the conversion put the descendants.
        let surface = surface(&made, Wavelet::Lazy);
        let base = surface.hierarchy().base();
        assert!(base.faces().len() <= base_faces, "{holes} holes");
        let corners = corners(base);
        assert_eq!(corners.len(), expected, "{holes} holes");
        let curve = curves(&input, false);
        let diagonal = input.diagonal();
        for level in (0..=3).map(Level) {
            let layout = surface.hierarchy().layout(level);
            for &v in &corners {
                let p = surface.position(level, layout.slot(Site::Base(v)));
                assert!(p.iter().all(|x| (x - x.round()).abs() < 1e-6 * diagonal), "{holes} holes: {p:?}");
            }
            let error = crease_error(&surface, level, &curve);
            assert!(error < 1e-6 * diagonal, "{holes} holes, level {level:?}: {error}");
        }
        // Planes stay plane, but for a face that may cut across a hole's corner.
        let (rms, max) = (made.measured.rms, made.measured.max);
        assert!(rms < 1e-5 && max < 5e-3, "{holes} holes: rms {rms}, max {max}");
    }
}

#[test]
fn round_creases_are_followed() {
    let input = cylinder();
    let made = converted(&input, 80, None);
    let surface = surface(&made, Wavelet::Lazy);
    let base = surface.hierarchy().base();
    assert!(base.sharp_edges().len() >= 6 && corners(base).is_empty());
    let curve = curves(&input, false);
    assert_eq!(curve.len(), 80);
    for level in (0..=3).map(Level) {
        for p in descendants(&surface, level) {
            assert!(distance(p, &curve) < 1e-6 * input.diagonal(), "{p}");
        }
    }
    // Two rims, each one round.
    let levels: BTreeSet<bool> =
        base.sharp_edges().iter().flatten().map(|&v| made.positions[v as usize][2] > 0.0).collect();
    assert_eq!(levels.len(), 2);
}

#[test]
fn marks_halve_the_crease_error_of_coarse_levels() {
    for (name, input, base_faces) in [("block", block(1), 90), ("cylinder", cylinder(), 80)] {
        let curve = curves(&input, false);
        let [with, without] =
            [None, Some(180.0)].map(|angle| surface(&converted(&input, base_faces, angle), Wavelet::Disc(2)));
        assert!(without.hierarchy().base().sharp_edges().is_empty());
        for level in [1, 2].map(Level) {
            let [with, without] = [&with, &without].map(|surface| crease_error(surface, level, &curve));
            assert!(2.0 * with <= without, "{name}, level {level:?}: {with} with marks, {without} without");
        }
    }
}

#[test]
fn a_sheet_keeps_its_corners() {
    for angle in [None, Some(180.0)] {
        let made = converted(&sheet(), 60, angle);
        assert!(made.hierarchy.base().sharp_edges().is_empty());
        let count = made.hierarchy.base().vertex_count() as usize;
        for corner in [[0.0, 0.0], [24.0, 0.0], [0.0, 24.0], [24.0, 24.0]] {
            let off = |p: &[f64; 3]| (p[0] - corner[0]).hypot(p[1] - corner[1]);
            let nearest = made.positions[..count].iter().map(off).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-9, "{corner:?}: {nearest}");
        }
    }
}

#[test]
fn bumps_and_short_ridges_are_no_sharp_edges() {
    let mut rough = shapes::subdivide(&shapes::torus(24, 30), 1);
    for p in &mut rough.positions {
        let was = *p;
        (0..3).for_each(|axis| p[axis] += 0.012 * noise(was, axis));
    }
    assert!(curves(&rough, false).len() > 20, "the bumps are sharp");
    assert!(converted(&rough, 200, None).hierarchy.base().sharp_edges().is_empty());
}

#[test]
fn the_angle_is_the_users() {
    let input = shapes::subdivide(&shapes::octahedron(), 4);
    let marks = |angle| converted(&input, 24, Some(angle)).hierarchy.base().sharp_edges().len();
    // Faces of an octahedron meet at 70.5°.
    assert!(marks(70.0) >= 12);
    assert_eq!(marks(71.0), 0);
}

/// A cube with a roof on it; the ridge lies in the plane x = 0.5.
fn house() -> TriangleMesh {
    let mut mesh = block(0);
    for p in &mut mesh.positions {
        if (p[0] - 0.5).abs() < 0.05 {
            p[0] = 0.5;
        }
        p[2] *= 1.5 - (p[0] - 0.5).abs();
    }
    mesh
}

/// Creases that cross the mirror plane, and one that lies in it.
#[test]
fn a_symmetric_base_keeps_its_creases() {
    for (name, input, plane, expected) in [("block", block(1), 1.5, 16), ("house", house(), 0.5, 10)] {
        let options = RemeshOptions {
            base_faces: Some(120),
            levels: Some(3),
            symmetric: Some(Axis::X),
            ..RemeshOptions::default()
        };
        let made = remesh(&input, &options, &|_, _| true).expect(name);
        mirrored::check(name, &made.hierarchy, &made.positions, plane, 0.0);
        assert_eq!(corners(made.hierarchy.base()).len(), expected, "{name}");
        let curve = curves(&input, false);
        for level in (0..=3).map(Level) {
            let off = crease_error(&surface(&made, Wavelet::Lazy), level, &curve);
            assert!(off < 1e-6 * input.diagonal(), "{name}, level {level:?}: {off}");
        }
    }
}
