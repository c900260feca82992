use super::super::tests::irregular;
use super::*;
use bozzetto_core::file::decode;
use bozzetto_core::hierarchy::Level;
use std::cell::RefCell;
use std::path::Path;

const WAVELETS: [Wavelet; 2] = [Wavelet::Disc(0), Wavelet::Disc(2)];

fn source() -> (tempfile::TempDir, MeshSource) {
    let folder = tempfile::tempdir().expect("a folder");
    let source = MeshSource::read(&irregular(folder.path()), &|_, _| true).expect("a mesh");
    (folder, source)
}

fn options(conversion: ConversionOptions) -> ImportOptions {
    ImportOptions { conversion, form: FormOptions::default() }
}

#[test]
fn the_choice_is_no_worse_than_any_place_tried_by_hand() {
    let (_folder, source) = source();
    let size = Size::Psnr(45.0, &source.mesh);
    let free = options(ConversionOptions::default());
    let found = import_compact(&source, &free, &WAVELETS, Some(size), &|_| true).expect("a file");
    assert!(found.tried > 3, "{} tried", found.tried);
    let measured = found.imported.measured.expect("measured");
    let decibels = -20.0 * measured.rms.log10();
    assert!(decibels >= 45.0, "{decibels} dB");
    for base_faces in [60, 96] {
        let conversion = ConversionOptions {
            base_faces: Some(base_faces),
            levels: Some(1),
            remesh: Remesh::Always,
            ..ConversionOptions::default()
        };
        let imported = import(&source, &options(conversion), &|_, _| true).expect("an import");
        if let Ok((bytes, _)) = encode_smaller(&imported.model, size) {
            assert!(found.bytes.len() <= bytes.len(), "{} after {}", found.bytes.len(), bytes.len());
        }
    }
    let again = import_compact(&source, &free, &WAVELETS, Some(size), &|_| true).expect("a file");
    assert_eq!(again.bytes, found.bytes);
}

#[test]
fn what_is_given_is_kept() {
    let (_folder, source) = source();
    let given = ConversionOptions { base_faces: Some(40), levels: Some(2), ..ConversionOptions::default() };
    let size = Size::Bytes(500);
    let found = import_compact(&source, &options(given), &[], Some(size), &|_| true).expect("a file");
    let surface = &found.imported.model.surface;
    assert!(surface.hierarchy().base().faces().len() <= 40);
    assert_eq!((surface.finest(), surface.form().wavelet), (Level(2), Wavelet::Disc(2)));
    assert!(found.bytes.len() <= 500, "{} bytes", found.bytes.len());
    let freely = options(ConversionOptions::default());
    let free = import_compact(&source, &freely, &WAVELETS, Some(size), &|_| true).expect("a file");
    assert!(free.imported.distance[0] < found.imported.distance[0], "{:?}", free.imported.distance);
}

#[test]
fn connectivity_that_is_there_is_tried_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("ball.off");
    let ball = bozzetto_core::mesh::shapes::subdivide(&bozzetto_core::mesh::shapes::octahedron(), 3);
    let mut bytes = Vec::new();
    bozzetto_core::io::write_mesh(&ball, bozzetto_core::io::MeshFormat::Off, &mut bytes).expect("written");
    std::fs::write(&path, bytes).expect("written");
    let source = MeshSource::read(&path, &|_, _| true).expect("a mesh");
    let size = Size::Psnr(65.0, &source.mesh);
    // Flat faces, each split into 64: nothing is as small as what is there.
    let free = options(ConversionOptions::default());
    let found = import_compact(&source, &free, &WAVELETS, Some(size), &|_| true).expect("a file");
    assert!(found.imported.kept && found.bytes.len() < 300, "{} bytes", found.bytes.len());
    let never = options(ConversionOptions { remesh: Remesh::Never, ..ConversionOptions::default() });
    let kept = import_compact(&source, &never, &WAVELETS, Some(size), &|_| true).expect("a file");
    assert_eq!((kept.tried, &kept.bytes), (1, &found.bytes));
}

#[test]
fn a_refusal_is_the_last_question_of_a_search() {
    let (_folder, source) = source();
    let given = options(ConversionOptions { levels: Some(1), ..ConversionOptions::default() });
    let size = Size::Bytes(400);
    let asked = |last: usize| {
        let shares = RefCell::new(Vec::new());
        let done = import_compact(&source, &given, &[], Some(size), &|share| {
            shares.borrow_mut().push(share);
            shares.borrow().len() < last
        });
        (done.is_ok(), shares.into_inner())
    };
    let (done, all) = asked(usize::MAX);
    assert!(done && all.iter().all(|share| (0.0..=1.0).contains(share)));
    assert!(all.windows(2).all(|pair| pair[0] <= pair[1]), "the share never falls");
    for last in (1..=all.len()).step_by(1 + all.len() / 8) {
        let (done, seen) = asked(last);
        assert!(!done && seen == all[..last], "refused at question {last} of {}", all.len());
    }
}

#[test]
fn a_size_that_no_file_has_is_refused() {
    let (_folder, source) = source();
    let given = options(ConversionOptions { levels: Some(1), ..ConversionOptions::default() });
    for size in [Size::Bytes(20), Size::Psnr(250.0, &source.mesh)] {
        let refused = import_compact(&source, &given, &[], Some(size), &|_| true).expect_err("no such file");
        assert!(refused.to_string().contains("irregular.off"), "{refused}");
    }
}

/// Without a size every bit of a surface is kept, and the first part of it is near for its bytes.
#[test]
fn without_a_size_the_whole_is_written() {
    let (_folder, source) = source();
    let given = options(ConversionOptions { levels: Some(2), ..ConversionOptions::default() });
    let found = import_compact(&source, &given, &WAVELETS, None, &|_| true).expect("a file");
    let read = decode(&found.bytes, Path::new("whole.boz")).expect("a sound file");
    assert!(read.complete && read.metadata.source.is_some());
    assert_eq!(read.surface.hash(), found.imported.model.surface.hash());
    let editing = import(&source, &found.options, &|_, _| true).expect("an import");
    let plain = encode(&editing.model).len();
    assert!(found.bytes.len() < plain, "{} of {plain} bytes", found.bytes.len());
}
