//! Sculpts the sample head and writes it as OBJ: `sculpted_head OUT.obj [LEVELS]`.
//!
//! A subdivided icosahedron is wrapped onto the smooth form level by level and relaxed along it; the finest level goes
//! out to the carving. Deterministic, whatever the number of threads.

use anyhow::{Context, Result};
use bozzetto_assets::faun::{CENTRE, carved, form};
use bozzetto_assets::vector::{Vec3, vec3};
use bozzetto_assets::wrap::{icosahedron, relax, wrap};
use bozzetto_core::io::{MeshFormat, write_mesh};
use bozzetto_core::mesh::{TriangleMesh, shapes};

/// 20 base faces × 4^6 = 81,920 faces.
const LEVELS: u32 = 6;
/// Rounds of relaxation at each level: coarse levels settle the flow, fine ones smooth what subdivision left.
const ROUNDS: [u32; 7] = [10, 20, 30, 30, 24, 16, 8];

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().context("name the OBJ file to write")?;
    let levels = arguments.next().map_or(Ok(LEVELS), |text| text.parse()).context("LEVELS is a number")?;

    let (corners, faces) = icosahedron();
    let mut mesh = TriangleMesh { positions: corners.iter().map(|&c| array(c)).collect(), faces };
    let mut wrapped = wrap(&form, CENTRE, corners);
    relax(&form, CENTRE, &mut wrapped, &mesh.faces, ROUNDS[0]);
    for level in 1..=levels as usize {
        mesh.positions = wrapped.directions.iter().map(|&d| array(d)).collect();
        mesh = shapes::subdivide(&mesh, 1);
        let directions = mesh.positions.iter().map(|&[x, y, z]| vec3(x, y, z).normalised()).collect();
        wrapped = wrap(&form, CENTRE, directions);
        relax(&form, CENTRE, &mut wrapped, &mesh.faces, ROUNDS[level.min(ROUNDS.len() - 1)]);
        eprintln!("level {level}: {} faces", mesh.faces.len());
    }
    let carved = wrap(&carved, CENTRE, wrapped.directions);
    mesh.positions = carved.positions.into_iter().map(array).collect();
    let file = std::fs::File::create(&path).with_context(|| path.clone())?;
    write_mesh(&mesh, MeshFormat::Obj, &mut std::io::BufWriter::new(file)).with_context(|| path.clone())
}

fn array(v: Vec3) -> [f64; 3] {
    [v.x, v.y, v.z]
}
