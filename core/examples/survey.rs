//! Converts meshes at default settings, each a file or all of a folder, and says in a line of each what came of it and what
//! it missed: `survey PATH…`. With an `OUT=` folder before them, the surfaces are written there as OBJ. With `FINER=1000000`
//! each mesh is refined to so many faces first, without subdivision connectivity; at the end stands what memory all took.
//!
//! Wanted are genus and boundary loops of the repaired input, no face whose normal is over 90° from that of the input nearest to
//! its middle, none without area, a root mean square of 2e-4 of the diagonal, four times the input's vertices and 20 s
//! at most.

use bozzetto_core::conversion::clean::clean;
use bozzetto_core::conversion::remesh::{RemeshOptions, remesh};
use bozzetto_core::io;
use bozzetto_core::mesh::{BoundingVolumes, CompareOptions, FaceIndex, TriangleMesh, compare, shapes};
use bozzetto_core::surface::{FormOptions, Surface};
use glam::DVec3;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Twice the area of a face without area is less than this part of its longest side's square.
const NO_AREA: f64 = 1e-6;

fn main() {
    println!(
        "{:<28}{:>9} {:>12} {:>5} {:>12} {:>6} {:>5} {:>9} {:>9} {:>7}  missed",
        "model", "faces", "base", "times", "genus, loops", "flips", "flat", "rms", "max", "s"
    );
    let (words, paths): (Vec<String>, Vec<String>) = std::env::args().skip(1).partition(|a| a.contains('='));
    let word = |name: &str| words.iter().find_map(|word| word.strip_prefix(name));
    let out = word("OUT=").map(PathBuf::from);
    let finer = word("FINER=").map(|count| count.parse().expect("a number of faces"));
    for path in paths.iter().flat_map(|path| files(Path::new(path))) {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        match survey(&path, finer, out.as_ref().map(|out| out.join(format!("{name}.obj")))) {
            Ok(line) => println!("{name:<28}{line}"),
            Err(why) => println!("{name:<28} refused: {why}"),
        }
    }
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    if let Some(mark) = status.lines().find_map(|line| line.strip_prefix("VmHWM:")) {
        println!("memory at most: {}", mark.trim());
    }
}

/// Up to so many faces, or two more: all halved along every side as often as that is not too much, then as many as are missing, each
/// once at most, cut into three about their middle.
fn refined(mut mesh: TriangleMesh, count: usize) -> TriangleMesh {
    while 4 * mesh.faces.len() <= count {
        mesh = shapes::subdivide(&mesh, 1);
    }
    let halved = mesh.faces.len();
    // Golden steps: every face comes up once at most, in no order.
    let cut = (0..halved).map(|k| (k * 0x9e37_79b1) % halved);
    let mut seen = vec![false; halved];
    for face in cut {
        if mesh.faces.len() >= count {
            break;
        }
        if std::mem::replace(&mut seen[face], true) {
            continue;
        }
        let [a, b, c] = mesh.faces[face];
        let corners = mesh.corners(FaceIndex(face as u32)).map(DVec3::from);
        let middle = mesh.positions.len() as u32;
        mesh.positions.push(((corners[0] + corners[1] + corners[2]) / 3.0).to_array());
        mesh.faces[face] = [a, b, middle];
        mesh.faces.extend([[b, c, middle], [c, a, middle]]);
    }
    TriangleMesh::new(mesh.positions, mesh.faces)
}

/// A file, or the meshes of a folder by their names.
fn files(path: &Path) -> Vec<PathBuf> {
    let Ok(folder) = std::fs::read_dir(path) else { return vec![path.to_path_buf()] };
    let is_mesh = |path: &PathBuf| {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        ["obj", "ply", "stl", "off", "glb"].contains(&extension.as_str())
    };
    let mut files: Vec<PathBuf> = folder.flatten().map(|entry| entry.path()).filter(is_mesh).collect();
    files.sort();
    files
}

/// One line of the table, or why there is none.
fn survey(path: &Path, finer: Option<usize>, out: Option<PathBuf>) -> Result<String, String> {
    let mut mesh = io::read_mesh(path).map_err(|e| e.to_string())?;
    if let Some(count) = finer {
        mesh = refined(mesh, count);
    }
    let cleaned = clean(&mesh, 0.0).ok_or("no face with area")?;
    let input = cleaned.to_mesh();
    let start = Instant::now();
    let made = remesh(&mesh, &RemeshOptions::default(), &|_, _| true).map_err(|e| e.to_string())?;
    let seconds = start.elapsed().as_secs_f64();
    let level = made.hierarchy.finest();
    let base = made.hierarchy.base();
    let topology = [base.genus(), base.boundary_loops(), base.components()];
    let wanted = [
        cleaned.connectivity.genus(),
        cleaned.connectivity.boundary_loops(),
        cleaned.connectivity.components(),
    ];
    let faces = base.faces().len();
    // As a file has it, in whole steps.
    let surface = Surface::from_positions(made.hierarchy, &made.positions, &FormOptions::default())
        .map_err(|e| e.to_string())?
        .to_mesh(level);
    if let Some(path) = out {
        let mut file = std::fs::File::create(path).map_err(|e| e.to_string())?;
        io::write_mesh(&surface, io::MeshFormat::Obj, &mut file).map_err(|e| e.to_string())?;
    }
    let options = CompareOptions { samples: 400_000, seed: 5 };
    let measured = compare(&input, &surface, &options, &|_| true).map_err(|e| e.to_string())?;
    let (flips, flat) = faults(&input, &surface);
    let times = surface.positions.len() as f64 / input.positions.len() as f64;
    let missed: Vec<&str> = [
        ("topology", topology != wanted),
        ("flips", flips > 0),
        ("flat", flat > 0),
        ("rms", measured.rms > 2e-4),
        ("times", times > 4.0),
        ("time", seconds > 20.0),
    ]
    .into_iter()
    .filter_map(|(name, missed)| missed.then_some(name))
    .collect();
    let [genus, loops, _] = topology;
    Ok(format!(
        "{:>9} {:>12} {times:>5.2} {:>12} {flips:>6} {flat:>5} {:>9.2e} {:>9.2e} {seconds:>7.2}  {}",
        input.faces.len(),
        format!("{faces} x 4^{}", level.0),
        format!("{genus}, {loops}"),
        measured.rms,
        measured.max,
        missed.join(" ")
    ))
}

/// How many faces are turned over, and how many have no area.
fn faults(input: &TriangleMesh, surface: &TriangleMesh) -> (usize, usize) {
    let tree = BoundingVolumes::build(input).expect("faces");
    let mut cursor = tree.cursor();
    let (mut flips, mut flat) = (0, 0);
    for f in 0..surface.faces.len() as u32 {
        let [a, b, c] = surface.corners(FaceIndex(f)).map(DVec3::from);
        let normal = (b - a).cross(c - a);
        let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
        let closest = cursor.closest(((a + b + c) / 3.0).to_array());
        let [d, e, g] = input.corners(closest.face).map(DVec3::from);
        flips += usize::from(normal.dot((e - d).cross(g - d)) <= 0.0);
        flat += usize::from(normal.length() <= NO_AREA * longest);
    }
    (flips, flat)
}
