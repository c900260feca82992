//! Small files: no larger than asked for, complete, and the better the larger; or as near to a mesh as asked for.

use bozzetto_core::conversion::{ConversionOptions, Remesh, convert};
use bozzetto_core::file::{Metadata, Model, NoSuchFile, Size, SourceIndices, decode, encode, encode_smaller};
use bozzetto_core::mesh::{CompareOptions, TriangleMesh, compare, shapes};
use bozzetto_core::surface::{FormOptions, Surface};
use std::path::Path;

/// A bumpy ball of 1026 vertices.
fn ball() -> TriangleMesh {
    let mut mesh = shapes::subdivide(&shapes::octahedron(), 4);
    for p in &mut mesh.positions {
        let length = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
        let unit = p.map(|x| x / length);
        let bump = 1.0 + 0.3 * unit[0] * unit[1] + 0.2 * unit[2] * unit[2] * unit[0];
        *p = unit.map(|x| x * bump);
    }
    mesh
}

fn model(mesh: &TriangleMesh) -> Model {
    let converted = convert(mesh, &ConversionOptions::default()).expect("subdivided");
    let form = FormOptions { precision: 18, ..FormOptions::default() };
    let surface = Surface::from_positions(converted.hierarchy, &converted.positions, &form).expect("small");
    let source = converted.source.map(|source| SourceIndices::new(&source));
    Model::new(surface, source, Metadata::default())
}

fn distance(mesh: &TriangleMesh, model: &Model) -> f64 {
    let found = model.surface.to_mesh(model.surface.finest());
    compare(mesh, &found, &CompareOptions { samples: 20_000, seed: 3 }, &|_| true).expect("surfaces").rms
}

#[test]
fn a_file_of_so_many_bytes() {
    let mesh = ball();
    let model = model(&mesh);
    let whole = encode(&Model { source: None, ..model.clone() });
    let mut before = f64::INFINITY;
    for bytes in [300, 301, 450, 700, 1000, 2000] {
        let (file, smaller) = encode_smaller(&model, Size::Bytes(bytes)).expect("enough for the base mesh");
        assert!(file.len() <= bytes && file.len() + 24 > bytes, "{} of {bytes} bytes", file.len());
        assert!(smaller.source.is_none());
        let read = decode(&file, Path::new("small.boz")).expect("a sound file");
        assert!(read.complete && !read.tail_cut, "{bytes} bytes");
        assert_eq!(read.surface.hash(), smaller.surface.hash(), "{bytes} bytes");
        assert_eq!(read.stated_hash, read.surface.hash(), "{bytes} bytes");
        let distance = distance(&mesh, &read);
        assert!(distance < 1.02 * before, "{bytes} bytes: {distance} after {before}");
        before = distance;
    }
    assert!(before < 1e-3, "{before}");
    // With room for everything nothing is lost.
    let (file, smaller) = encode_smaller(&model, Size::Bytes(1 << 20)).expect("enough");
    assert!(file == whole && smaller.surface.hash() == model.surface.hash());
}

#[test]
fn prefixes_of_a_surface_of_few_levels_are_near() {
    // The finer of two levels holds much of the shape: told to the last bit at once, a half would be at 3e-4.
    let given = ConversionOptions {
        levels: Some(2),
        base_faces: Some(60),
        remesh: Remesh::Always,
        ..ConversionOptions::default()
    };
    let converted = convert(&ball(), &given).expect("a ball");
    let form = FormOptions::default();
    let surface = Surface::from_positions(converted.hierarchy, &converted.positions, &form).expect("small");
    let mesh = surface.to_mesh(surface.finest());
    let whole = encode(&Model::new(surface, None, Metadata::default()));
    for (hundredths, most) in [(25, 2e-4), (35, 4e-5), (50, 2e-5)] {
        let prefix = &whole[..whole.len() * hundredths / 100];
        let held = distance(&mesh, &decode(prefix, Path::new("prefix.boz")).expect("a prefix"));
        assert!(held < most, "{hundredths} %: {held}");
    }
}

#[test]
fn a_file_too_small_for_its_base_mesh() {
    let model = model(&ball());
    let Err(NoSuchFile::TooSmall { least }) = encode_smaller(&model, Size::Bytes(60)) else {
        panic!("sixty bytes");
    };
    assert!(encode_smaller(&model, Size::Bytes(least)).is_ok());
    assert!(encode_smaller(&model, Size::Bytes(least - 1)).is_err());
}

#[test]
fn a_file_as_near_as_asked_for() {
    let mesh = ball();
    let model = model(&mesh);
    let mut before = 0;
    for decibels in [45.0, 75.0] {
        let (file, smaller) = encode_smaller(&model, Size::Psnr(decibels, &mesh)).expect("that near");
        let found = -20.0 * distance(&mesh, &smaller).log10();
        assert!(found >= decibels && found < decibels + 8.0, "{found} dB, {decibels} asked for");
        assert!(file.len() > before, "{decibels} dB");
        before = file.len();
    }
    let too_near = encode_smaller(&model, Size::Psnr(200.0, &mesh));
    assert!(matches!(too_near, Err(NoSuchFile::NotThatNear { best }) if best > 80.0), "{too_near:?}");
}
