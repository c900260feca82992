//! What a cut file gives: a model or the word that more is needed, at every length; and the more bytes, the nearer.

mod samples;

use bozzetto_core::file::{CurvePoint, Metadata, Model, decode, encode};
use bozzetto_core::hierarchy::{BaseMesh, Hierarchy, Level, Slot};
use bozzetto_core::mesh::{CompareOptions, TriangleMesh, compare, shapes};
use bozzetto_core::surface::{FormOptions, Surface};
use bozzetto_core::wavelet::Wavelet;
use rayon::prelude::*;
use samples::{Numbers, model};
use std::path::Path;
use std::sync::Arc;

/// Reads the first bytes of a file and says whether that was a model. Anything but a model and the call for more fails.
fn is_model(bytes: &[u8], length: usize, whole: &Model, what: &str) -> bool {
    match decode(&bytes[..length], Path::new("cut.boz")) {
        Ok(part) => {
            assert_eq!(part.stated_hash, whole.stated_hash, "{what}, {length} bytes");
            assert_eq!(
                part.surface.hierarchy().base(),
                whole.surface.hierarchy().base(),
                "{what}, {length} bytes"
            );
            let is_whole = part.surface.hash() == whole.surface.hash();
            assert!(is_whole || !part.complete, "{what}, {length} bytes");
            true
        }
        Err(error) => {
            let text = error.to_string();
            let more = text.contains("ends before its base mesh") || length < 16;
            assert!(more, "{what}, {length} bytes: {text}");
            false
        }
    }
}

/// Twenty small files: every awkward shape, every wavelet, with and without sharp edges.
#[test]
fn every_length_of_small_files() {
    let shapes = shapes::awkward();
    (0..20).into_par_iter().for_each(|at: usize| {
        let (name, mesh) = &shapes[at % shapes.len()];
        let wavelet = Wavelet::ALL[(at + at / shapes.len()) % 4];
        let levels = if mesh.faces.len() > 12 { 1 } else { 2 };
        let mut whole = model(mesh, wavelet, at % 3, levels, at as u64);
        whole.source = None;
        let bytes = encode(&whole);
        let what = format!("{name}, {wavelet}");
        // Once a prefix is a model, so is every longer one.
        let mut before = false;
        for length in 0..=bytes.len() {
            let now = is_model(&bytes, length, &whole, &what);
            assert!(now || !before, "{what}: {length} bytes are less than one fewer");
            before = now;
        }
        assert!(before, "{what}: the whole");
    });
}

/// A surface over some mesh whose finest vertices lie at the base mesh's points moved by a wave.
fn wavy(mesh: &TriangleMesh, sharp: usize, levels: u8, wavelet: Wavelet, height: f64) -> Surface {
    let marks: Vec<[u32; 2]> = mesh.faces.iter().take(sharp).map(|f| [f[0], f[1]]).collect();
    let base = BaseMesh::new(mesh.positions.len() as u32, mesh.faces.clone(), &marks).expect("a base mesh");
    let hierarchy = Hierarchy::new(Arc::new(base), Level(levels)).expect("small");
    let layout = hierarchy.layout(Level(levels));
    let positions: Vec<[f64; 3]> = (0..layout.len())
        .map(|slot| {
            let (face, b) = layout.chart(layout.site(Slot(slot)));
            let corners = hierarchy.base().faces()[face as usize].map(|v| mesh.positions[v as usize]);
            let share = |k: usize| f64::from(b[k]) / f64::from(layout.segments());
            let p: [f64; 3] = std::array::from_fn(|c| (0..3).map(|k| share(k) * corners[k][c]).sum());
            let wave = |x: f64, y: f64| height * (7.0 * x + 1.0).sin() * (5.0 * y - 2.0).cos();
            [p[0] + wave(p[1], p[2]), p[1] + wave(p[2], p[0]), p[2] + wave(p[0], p[1])]
        })
        .collect();
    let form = FormOptions { precision: 18, wavelet, ..FormOptions::default() };
    Surface::from_positions(hierarchy, &positions, &form).expect("small valences")
}

/// Surfaces of some thousand vertices with a boundary, handles, sharp edges or none of these.
fn larger() -> Vec<(&'static str, Surface)> {
    let bump = |[x, y, z]: [f64; 3]| 1.0 + 0.1 * (9.0 * x).sin() * (7.0 * y + z).cos();
    vec![
        ("ball", Surface::ball(5, bump)),
        ("torus", wavy(&shapes::torus(5, 4), 0, 4, Wavelet::Disc(1), 0.05)),
        ("disc", wavy(&shapes::disc(7), 0, 5, Wavelet::Disc(2), 0.1)),
        ("edges", wavy(&shapes::octahedron(), 3, 5, Wavelet::Disc(0), 0.1)),
        ("lazy", wavy(&shapes::octahedron(), 0, 5, Wavelet::Lazy, 0.15)),
    ]
}

fn random_cuts(cuts: usize) {
    // Its finest level is finished in lanes.
    let in_lanes =
        ("large ball", Surface::ball(6, |[x, y, _]| 1.0 + 0.1 * (9.0 * x).sin() * (7.0 * y).cos()));
    for (seed, (name, surface)) in larger().into_iter().chain([in_lanes]).enumerate() {
        let whole = Model::new(surface, None, Metadata::default());
        let bytes = encode(&whole);
        let mut numbers = Numbers(seed as u64);
        for _ in 0..cuts {
            is_model(&bytes, numbers.below(bytes.len() as u32 + 1) as usize, &whole, name);
        }
    }
}

#[test]
fn random_lengths_of_larger_files() {
    random_cuts(40);
}

/// The same, ten thousand times.
#[test]
#[ignore = "takes minutes; scripts/cuts runs it"]
fn many_random_lengths_of_larger_files() {
    random_cuts(2000);
}

/// At the borders of the curve no part is more than 0.1 dB worse than the best before it, and each is about as near as
/// the file says.
#[test]
fn more_bytes_are_nearer() {
    for (name, surface) in larger() {
        let finest = surface.to_mesh(surface.finest());
        let whole = Model::new(surface, None, Metadata::default());
        let bytes = encode(&whole);
        let borders = decode(&bytes, Path::new("whole.boz")).expect("sound").curve;
        assert!(borders.len() >= 8, "{name}: {} borders", borders.len());
        let mut off = Vec::new();
        let (mut best, mut first) = (f64::NEG_INFINITY, f64::INFINITY);
        for CurvePoint { bytes: border, error } in borders {
            let part = decode(&bytes[..border], Path::new("part.boz")).expect("a model").surface;
            let options = CompareOptions { samples: 20_000, seed: 1 };
            let found =
                compare(&finest, &part.to_mesh(part.finest()), &options, &|_| true).expect("surfaces");
            let decibels = found.psnr.unwrap_or(f64::INFINITY);
            let stated = -20.0 * (error / found.diagonal).log10();
            match error > 0.0 {
                true => off.push(stated - decibels),
                false => assert!(found.rms < 1e-9, "{name}, {border} bytes: {decibels:.2} dB, 0 stated"),
            }
            assert!(decibels > best - 0.1, "{name}, {border} bytes: {decibels:.2} dB after {best:.2}");
            best = best.max(decibels);
            first = first.min(decibels);
        }
        // At most borders it is measured; at the others it is taken from those.
        assert!(off.iter().all(|off| (-3.5..2.0).contains(off)), "{name}: {off:.2?} dB");
        off.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
        assert!(off[off.len() / 2].abs() < 0.7, "{name}: {off:.2?} dB");
        assert!(best > first + 40.0, "{name}: from {first:.1} to {best:.1} dB");
    }
}
