//! The samples that are kept in the repository.

use bozzetto_core::file::decode;
use bozzetto_core::hierarchy::detection::detect;
use bozzetto_core::io::read_mesh;
use bozzetto_core::mesh::{Connectivity, compare};
use std::path::PathBuf;

fn sample(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(name)
}

#[test]
fn the_scan_is_closed_and_without_order_and_its_conversion_is_near() {
    let scan = read_mesh(&sample("faun.ply")).expect("the scan");
    let count = scan.positions.len() as u32;
    let surface = Connectivity::build(count, scan.faces.clone()).expect("a manifold");
    assert_eq!((surface.components(), surface.genus(), surface.boundary_loops()), (1, 0, 0));
    assert_eq!(scan.faces.len(), 70_000);
    assert!(detect(count, &scan.faces, 1).expect("a manifold").is_none(), "no subdivision connectivity");

    let path = sample("faun.boz");
    let model = decode(&std::fs::read(&path).expect("the conversion"), &path).expect("a wavelet file");
    let converted = model.surface.to_mesh(model.surface.finest());
    let distance = compare(&scan, &converted, &Default::default(), &|_| true).expect("surfaces");
    assert!(distance.rms < 2e-4, "rms {}", distance.rms);
}
