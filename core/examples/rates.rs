//! How many bytes of a wavelet file bring its surface how near to a mesh, and how fast files are written and read.
//!
//! * `rates convert MESH OUT.boz BASE_FACES LEVELS PRECISION WAVELET`: remeshes, draws detail along normals and writes; 0 levels
//!   takes the mesh's own connectivity.
//! * `rates measure FILE.boz MESH [FOLDER]`: the smallest files at 55 to 80 dB, the surface of each written to the folder as a mesh.
//! * `rates speed FILE.boz PRECISION`: bytes without loss at that precision, and vertices a second.
//! * `rates ball OUT.boz LEVELS PRECISION`: writes a wavy ball over an octahedron, 1,048,578 vertices at 9 levels.
//! * `rates opening FILE.boz`: the machine; how long the whole takes to open, and prefixes of it up to the normals of a first picture.

use bozzetto_core::conversion::{ConversionOptions, Remesh, convert};
use bozzetto_core::file::{Metadata, Model, Size, decode, encode, encode_smaller, normal_mesh};
use bozzetto_core::hierarchy::{BaseMesh, Hierarchy, Level, Slot};
use bozzetto_core::io::{self, MeshFormat};
use bozzetto_core::mesh::shapes;
use bozzetto_core::surface::{FormOptions, Surface};
use bozzetto_core::wavelet::Wavelet;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words[..] {
        ["convert", mesh, out, faces, levels, precision, wavelet] => {
            let number = |text: &str| text.parse::<usize>().expect("a number");
            let wavelet = Wavelet::from_code(number(wavelet) as u8).expect("0 = lazy, 1 to 3 = 0- to 2-disc");
            convert_to(mesh, out, number(faces), number(levels) as u8, number(precision) as u8, wavelet);
        }
        ["measure", file, mesh] => measure(file, mesh, None),
        ["measure", file, mesh, folder] => measure(file, mesh, Some(folder)),
        ["speed", file, precision] => speed(file, precision.parse().expect("bits")),
        ["ball", out, levels, precision] => {
            let number = |text: &str| text.parse::<u8>().expect("a number");
            ball(out, number(levels), number(precision));
        }
        ["opening", file] => opening(file),
        _ => eprintln!("rates convert|measure|speed|ball|opening …; see the top of core/examples/rates.rs"),
    }
}

fn convert_to(mesh: &str, out: &str, faces: usize, levels: u8, precision: u8, wavelet: Wavelet) {
    let mesh = io::read_mesh(Path::new(mesh)).expect("a readable mesh");
    let start = Instant::now();
    let options = match levels {
        0 => ConversionOptions::default(),
        _ => ConversionOptions {
            remesh: Remesh::Always,
            base_faces: Some(faces),
            levels: Some(levels),
            ..ConversionOptions::default()
        },
    };
    let mut made = convert(&mesh, &options).expect("a conversion");
    if levels > 0 {
        made.positions =
            normal_mesh(&mesh, &made.hierarchy, &made.positions, wavelet, &|_| true).expect("a mesh");
    }
    let form = FormOptions { precision, wavelet, ..FormOptions::default() };
    let surface = Surface::from_positions(made.hierarchy, &made.positions, &form).expect("a surface");
    let bytes = encode(&Model::new(surface, None, Metadata::default()));
    std::fs::write(out, &bytes).expect("a writable path");
    println!("{out}: {} bytes, {:.1} s", bytes.len(), start.elapsed().as_secs_f64());
}

fn measure(file: &str, mesh: &str, folder: Option<&str>) {
    let bytes = std::fs::read(file).expect("a readable file");
    let mesh = io::read_mesh(Path::new(mesh)).expect("a readable mesh");
    let model = decode(&bytes, Path::new(file)).expect("a wavelet file");
    println!("{file}: {} bytes", bytes.len());
    for wanted in [55, 60, 65, 70, 75, 80] {
        let (bytes, smaller) = match encode_smaller(&model, Size::Psnr(f64::from(wanted), &mesh)) {
            Ok(found) => found,
            Err(error) => {
                println!("  {wanted} dB: {error}");
                break;
            }
        };
        println!("  {wanted} dB: {} bytes", bytes.len());
        if let Some(folder) = folder {
            let mut text = Vec::new();
            let surface = smaller.surface;
            io::write_mesh(&surface.to_mesh(surface.finest()), MeshFormat::Obj, &mut text).expect("memory");
            std::fs::write(Path::new(folder).join(format!("{wanted}.obj")), text).expect("a writable folder");
        }
    }
}

fn ball(out: &str, levels: u8, precision: u8) {
    let mesh = shapes::octahedron();
    let base = BaseMesh::new(6, mesh.faces, &[]).expect("a base mesh");
    let hierarchy = Hierarchy::new(Arc::new(base), Level(levels)).expect("levels that can be counted");
    let layout = hierarchy.layout(Level(levels));
    let place = |slot: u32| {
        let (face, b) = layout.chart(layout.site(Slot(slot)));
        let corners = layout.base().faces()[face as usize].map(|v| mesh.positions[v as usize]);
        let flat = [0, 1, 2].map(|c| (0..3).map(|k| f64::from(b[k]) * corners[k][c]).sum::<f64>());
        let length = flat.iter().map(|x| x * x).sum::<f64>().sqrt();
        let phase = (flat[0] + 2.0 * flat[1]) / length;
        let waves = [(3.0, 0.1), (17.0, 0.02), (90.0, 0.003)].map(|(k, height)| height * (k * phase).sin());
        flat.map(|x| x / length * (1.0 + waves.iter().sum::<f64>()))
    };
    let positions: Vec<[f64; 3]> = (0..layout.len()).map(place).collect();
    let form = FormOptions { precision, ..FormOptions::default() };
    let surface = Surface::from_positions(hierarchy, &positions, &form).expect("a surface");
    std::fs::write(out, encode(&Model::new(surface, None, Metadata::default()))).expect("a writable path");
}

fn speed(file: &str, precision: u8) {
    let bytes = std::fs::read(file).expect("a readable file");
    let surface = decode(&bytes, Path::new(file)).expect("a wavelet file").surface;
    let finest: Vec<[f64; 3]> = (0..surface.scaling(surface.finest()).len() as u32)
        .map(|v| surface.position(surface.finest(), Slot(v)))
        .collect();
    let form = FormOptions { precision, wavelet: surface.form().wavelet, ..FormOptions::default() };
    let surface =
        Surface::from_positions(surface.hierarchy().as_ref().clone(), &finest, &form).expect("a surface");
    let model = Model::new(surface, None, Metadata::default());
    let vertices = finest.len() as f64;
    let (mut written, mut write, mut read) = (Vec::new(), f64::INFINITY, f64::INFINITY);
    for _ in 0..3 {
        let start = Instant::now();
        written = encode(&model);
        write = write.min(start.elapsed().as_secs_f64());
        let start = Instant::now();
        let held = decode(&written, Path::new(file)).expect("what was written");
        read = read.min(start.elapsed().as_secs_f64());
        assert_eq!(held.surface.scaling(Level::BASE), model.surface.scaling(Level::BASE));
        assert_eq!(held.surface.hash(), model.surface.hash());
    }
    println!(
        "{file} at {precision} bits: {vertices} vertices, {} bytes, {:.2} bits a vertex; written {:.2} M/s, read {:.2} M/s",
        written.len(),
        8.0 * written.len() as f64 / vertices,
        vertices / write / 1e6,
        vertices / read / 1e6
    );
}

/// A line of the machine's description by its key.
fn described(path: &str, key: &str) -> String {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let line = text.lines().find(|line| line.starts_with(key)).and_then(|line| line.split_once(':'));
    line.map_or_else(|| "unknown".to_owned(), |(_, value)| value.trim().to_owned())
}

fn opening(file: &str) {
    let bytes = std::fs::read(file).expect("a readable file");
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = std::env::var("RAYON_NUM_THREADS").unwrap_or_else(|_| threads.to_string());
    println!("{}, {threads} threads", described("/proc/cpuinfo", "model name"));
    for part in [bytes.len(), bytes.len() / 4, bytes.len() / 16, bytes.len() / 64] {
        let mut seconds: Vec<f64> = (0..5)
            .map(|_| {
                let start = Instant::now();
                let held = decode(&bytes[..part], Path::new(file)).expect("what was written").surface;
                assert!(!held.to_mesh(held.finest()).faces.is_empty());
                start.elapsed().as_secs_f64()
            })
            .collect();
        seconds.sort_by(f64::total_cmp);
        println!("{file}: {part} of {} bytes as triangles after {:.0} ms", bytes.len(), 1e3 * seconds[2]);
    }
}
