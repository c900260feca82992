//! Sculpts the sample head, a faun's bust, and writes it as OBJ: `sculpted_head OUT.obj [LEVELS]`.
//!
//! Deterministic, whatever the number of threads. Prints what each level came to on stderr.

use anyhow::{Context, Result};
use bozzetto_assets::sculpt::sculpt_head;
use bozzetto_core::io::{MeshFormat, write_mesh};

/// 168 base faces × 4^5 = 172,032 faces.
const LEVELS: u32 = 5;

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().context("name the OBJ file to write")?;
    let levels = arguments.next().map_or(Ok(LEVELS), |text| text.parse()).context("LEVELS is a number")?;
    let skin = sculpt_head(levels, |report| eprintln!("{report:?}"));
    let file = std::fs::File::create(&path).with_context(|| path.clone())?;
    write_mesh(&skin.to_triangle_mesh(), MeshFormat::Obj, &mut std::io::BufWriter::new(file))
        .with_context(|| path.clone())
}
