//! Makes the sample scan, `faun.ply`: the faun's bust as a scanner would give it, 70,000 faces without any order.
//!
//! ```text
//! cargo run --release -p bozzetto-assets --bin scanned_head -- assets/faun.ply [FACES]
//! ```
//!
//! Deterministic, whatever the number of threads.

use anyhow::{Context, Result};
use bozzetto_assets::decimate::decimate;
use bozzetto_assets::faun::spacing;
use bozzetto_assets::sculpt::sculpt_head;
use bozzetto_core::io::{MeshFormat, write_mesh};
use bozzetto_core::mesh::TriangleMesh;

/// 168 base faces × 4^6 = 688,128 faces, ten times as many as are left.
const LEVELS: u32 = 6;
/// Faces that are left.
const FACES: usize = 70_000;

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().context("name the PLY file to write")?;
    let faces = arguments.next().map_or(Ok(FACES), |text| text.parse()).context("FACES is a number")?;
    let dense = sculpt_head(LEVELS, |report| eprintln!("{report:?}"));
    // Eyes and mouth are scanned from nearer by.
    let scan = decimate(&dense, faces, &|p| 1.0 / spacing(p)).to_triangle_mesh();
    let single = |p: &[f64; 3]| p.map(|x| f64::from(x as f32));
    let scan = TriangleMesh::new(scan.positions.iter().map(single).collect(), scan.faces);
    let file = std::fs::File::create(&path).with_context(|| path.clone())?;
    write_mesh(&scan, MeshFormat::Ply, &mut std::io::BufWriter::new(file)).with_context(|| path.clone())?;
    println!("{path}: {} vertices, {} faces", scan.positions.len(), scan.faces.len());
    Ok(())
}
