//! Writes a flat hexagonal disc, subdivided, on which single basis functions can be seen:
//! `cargo run -p bozzetto-core --example flat_disc -- OUT.obj`.

use bozzetto_core::io::{MeshFormat, write_mesh};
use bozzetto_core::mesh::shapes::{disc, subdivide};
use std::error::Error;
use std::fs::File;
use std::io::BufWriter;

/// Levels: fine enough that a level-2 function looks smooth-edged.
const LEVELS: u32 = 5;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("name the file to write")?;
    let mut mesh = disc(6);
    for position in &mut mesh.positions {
        // Flat in the plane y = 0, facing up.
        *position = [position[0], 0.0, -position[1]];
    }
    let mesh = subdivide(&mesh, LEVELS);
    write_mesh(&mesh, MeshFormat::Obj, &mut BufWriter::new(File::create(path)?))?;
    Ok(())
}
