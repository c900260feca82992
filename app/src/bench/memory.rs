//! The most memory that commands take: each runs as a process of its own, and the system's high-water mark of it is read.

use super::machine::Machine;
use super::shape::Base;
use anyhow::{Context, Result, bail, ensure};
use bozzetto_core::hierarchy::Level;
use bozzetto_core::io::{MeshFormat, write_mesh};
use serde::Serialize;
use std::fs::{File, metadata};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// How often the mark is read. It only ever rises, so what is missed is what the last moments add.
const LOOK_EVERY: Duration = Duration::from_millis(2);

/// An edit of one coefficient.
const EDIT: &str = r#"{"edit":"move","kind":"scaling","level":2,"vertex":5,"delta":[0,0.02,0]}"#;

/// What some commands take.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct MemoryFigures {
    /// What they ran on.
    pub(crate) machine: Machine,
    /// By command.
    pub(crate) peaks: Vec<Peak>,
}

/// What one command takes.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Peak {
    /// What it does.
    pub(crate) what: &'static str,
    /// Vertices of the finest level.
    pub(crate) vertices: u64,
    /// The file it reads.
    pub(crate) read_bytes: u64,
    /// The wavelet file it writes.
    pub(crate) file_bytes: u64,
    /// Its high-water mark of resident memory, the program included.
    pub(crate) peak_bytes: u64,
    /// What of that is beyond the wavelet file, over the vertices.
    pub(crate) bytes_per_vertex: f64,
}

/// Imports the octahedron split so often as a binary PLY, moves a coefficient, saves; and one level less as an OBJ.
///
/// # Errors
/// The system does not tell, there is no room for the files, or a command fails.
pub(crate) fn peaks(levels: u8, progress: &dyn Fn(f32)) -> Result<MemoryFigures> {
    ensure!(
        Path::new("/proc/self/status").exists(),
        "the memory of a process is read from /proc, which this system lacks; measure on Linux"
    );
    let folder = tempfile::tempdir()?;
    let [ply, obj, boz, moved, script] =
        ["ball.ply", "ball.obj", "ball.boz", "moved.boz", "move.edits"].map(|name| folder.path().join(name));
    std::fs::write(&script, EDIT)?;
    let vertices = |level: u8| -> Result<u64> {
        Ok(u64::from(Base::EightFaces.hierarchy(levels)?.layout(Level(level)).len()))
    };
    {
        let surface = Base::EightFaces.surface(levels)?;
        write_mesh(&surface.to_mesh(Level(levels)), MeshFormat::Ply, &mut File::create(&ply)?)?;
        progress(0.1);
        write_mesh(&surface.to_mesh(Level(levels - 1)), MeshFormat::Obj, &mut File::create(&obj)?)?;
    }
    progress(0.2);
    let word = |word: &'static str| Path::new(word);
    let import = [word("import"), word("-o"), boz.as_path()];
    let replay = [word("replay"), boz.as_path(), script.as_path(), word("-o"), moved.as_path()];
    let steps = [
        ("import a binary PLY", [&import[..], &[ply.as_path()]].concat(), &ply, &boz, levels),
        ("open, move a coefficient, save", replay.to_vec(), &boz, &moved, levels),
        ("the same, saved as one file", [&replay[..], &[word("--bake")]].concat(), &boz, &moved, levels),
        ("import an OBJ", [&import[..], &[obj.as_path()]].concat(), &obj, &boz, levels - 1),
    ];
    let mut peaks = Vec::new();
    for (done, (what, arguments, input, output, level)) in steps.into_iter().enumerate() {
        let peak_bytes = peak(&arguments)?;
        let (read_bytes, file_bytes) = (metadata(input)?.len(), metadata(output)?.len());
        let vertices = vertices(level)?;
        let bytes_per_vertex = peak_bytes.saturating_sub(file_bytes) as f64 / vertices as f64;
        peaks.push(Peak { what, vertices, read_bytes, file_bytes, peak_bytes, bytes_per_vertex });
        progress(0.4 + 0.2 * done as f32);
        let _ = std::fs::remove_file(&moved);
        let _ = std::fs::remove_file(moved.with_extension("edits"));
    }
    Ok(MemoryFigures { machine: Machine::here(), peaks })
}

/// Runs this program with the given arguments; its high-water mark in bytes.
fn peak(arguments: &[&Path]) -> Result<u64> {
    let program = std::env::current_exe()?;
    let mut child =
        Command::new(program).args(arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn()?;
    let mut most = 0;
    let status = loop {
        most = most.max(high_water(&child).unwrap_or(0));
        match child.try_wait()? {
            Some(status) => break status,
            None => std::thread::sleep(LOOK_EVERY),
        }
    };
    if !status.success() {
        let said = child.wait_with_output()?.stderr;
        bail!("{}", String::from_utf8_lossy(&said).trim());
    }
    Ok(most)
}

/// The most memory that a process has had so far, in bytes.
fn high_water(child: &Child) -> Result<u64> {
    let status = std::fs::read_to_string(format!("/proc/{}/status", child.id()))?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).context("no mark")?;
    let kib: u64 = line.trim().trim_end_matches("kB").trim().parse()?;
    Ok(kib << 10)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(target_os = "linux")]
    fn the_mark_of_a_process_is_at_least_what_it_holds() {
        let mut child = Command::new("sleep").arg("5").spawn().expect("every Linux has it");
        std::thread::sleep(Duration::from_millis(100));
        let mark = high_water(&child).expect("it runs");
        child.kill().expect("it runs");
        child.wait().expect("it was started here");
        assert!((100_000..100_000_000).contains(&mark), "{mark}");
    }
}
