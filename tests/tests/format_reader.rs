//! A reader in another language, written from docs/FORMAT.md, decodes wavelet files to the same hash.

use bozzetto_core::conversion::{ConversionOptions, convert};
use bozzetto_core::file::{Metadata, Model, decode, encode};
use bozzetto_core::mesh::{TriangleMesh, shapes};
use bozzetto_core::surface::{FormOptions, Surface};
use bozzetto_core::wavelet::Wavelet;
use std::path::Path;
use std::process::Command;

#[test]
fn the_python_reader_agrees() {
    let reader = Path::new(env!("CARGO_MANIFEST_DIR")).join("format_reader.py");
    if !Command::new("python3").arg("--version").output().is_ok_and(|o| o.status.success()) {
        eprintln!("\n*** NOT TESTED: there is no python3 to run {} ***\n", reader.display());
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let agrees = |name: &str, base: &TriangleMesh, times: u32, wavelet: Wavelet| {
        let mut mesh = shapes::subdivide(base, times);
        for (at, position) in mesh.positions.iter_mut().enumerate() {
            position[at % 3] += 0.07 * ((at * 37 % 19) as f64 - 9.0);
        }
        let converted = convert(&mesh, &ConversionOptions::default()).expect("subdivided");
        let form = FormOptions { wavelet, ..FormOptions::default() };
        let surface =
            Surface::from_positions(converted.hierarchy, &converted.positions, &form).expect("small");
        let hash = surface.hash().to_string();
        let path = folder.path().join("surface.boz");
        let whole = encode(&Model::new(surface, None, Metadata::default()));
        // A part ends in the middle of what is known of some level.
        let part = &whole[..whole.len() * 2 / 3];
        let of_part = decode(part, &path).expect("a partial model").surface.hash().to_string();
        for (bytes, hash, kind) in [(whole.as_slice(), hash, "complete"), (part, of_part, "partial")] {
            std::fs::write(&path, bytes).expect("written");
            let output = Command::new("python3").arg(&reader).arg(&path).output().expect("python3 runs");
            let said = String::from_utf8_lossy(&output.stdout).into_owned();
            let errors = String::from_utf8_lossy(&output.stderr);
            assert!(
                output.status.success() && said.contains(&format!("hash {hash}")) && said.contains(kind),
                "{name}, {wavelet}, {kind}: {hash}\n{said}{errors}"
            );
        }
    };
    for (name, base) in [("octahedron", shapes::octahedron()), ("open disc", shapes::disc(5))] {
        Wavelet::ALL.into_iter().for_each(|wavelet| agrees(name, &base, 2, wavelet));
    }
    // Large levels are finished in lanes, this one in two runs.
    agrees("large disc", &shapes::disc(5), 7, Wavelet::Lazy);
}
