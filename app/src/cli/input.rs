//! Inputs of commands: a wavelet file with its log, or a mesh.

use super::progress::Busy;
use crate::opening::{ImportOptions, MeshSource, import};
use anyhow::{Result, bail};
use bozzetto_core::conversion::{ConversionOptions, Remesh};
use bozzetto_core::disk::Disk;
use bozzetto_core::file::{Metadata, Model, is_wavelet_file};
use bozzetto_core::io::{MeshFormat, read_mesh};
use bozzetto_core::mesh::TriangleMesh;
use bozzetto_core::session::{LogUse, OpenOptions, open_model};
use bozzetto_core::surface::FormOptions;
use std::path::Path;

/// How much of a log to take, shared by commands that open wavelet files.
#[derive(Debug, Clone, Copy, clap::Args)]
pub(super) struct LogArgs {
    /// Take the wavelet file without its log.
    #[arg(long, conflicts_with = "saved")]
    base: bool,
    /// Take the log up to the last save mark only.
    #[arg(long)]
    saved: bool,
}

impl LogArgs {
    /// As options of the session.
    pub(super) fn options(self) -> OpenOptions {
        let log = match (self.base, self.saved) {
            (true, _) => LogUse::Ignored,
            (_, true) => LogUse::Saved,
            _ => LogUse::Whole,
        };
        OpenOptions { log, rebind: false }
    }
}

/// What an input file holds.
#[derive(Debug)]
pub enum Loaded {
    /// A wavelet file, log replayed.
    Surface(Box<Model>),
    /// A mesh file.
    Mesh(TriangleMesh),
}

/// Loads a wavelet file or a mesh; notes go to stderr.
///
/// # Errors
/// The file cannot be read.
pub fn load(path: &Path, options: OpenOptions) -> Result<Loaded> {
    if is_wavelet_file(path) {
        return Ok(Loaded::Surface(Box::new(load_model(path, options)?)));
    }
    if MeshFormat::from_path(path).is_none() {
        bail!(
            "{}: the format is not known; give a .boz, .obj, .ply, .stl, .glb or .off file",
            path.display()
        );
    }
    let _busy = Busy::new(OPENING);
    Ok(Loaded::Mesh(read_mesh(path)?))
}

/// Says on stderr what a user should know about the files.
pub(super) fn tell(notes: Vec<String>) {
    for note in notes {
        eprintln!("note: {note}");
    }
}

/// What is said of an input that takes long.
const OPENING: &str = "Opening";

fn opened(path: &Path, options: OpenOptions) -> Result<(Model, Vec<String>)> {
    let _busy = Busy::new(OPENING);
    Ok(open_model(&Disk, path, options)?)
}

/// Loads a wavelet file with its log; notes go to stderr.
///
/// # Errors
/// The files cannot be read or do not fit together.
pub(super) fn load_model(path: &Path, options: OpenOptions) -> Result<Model> {
    let (model, notes) = opened(path, options)?;
    tell(notes);
    Ok(model)
}

/// Loads a wavelet file with its log and the notes on them, and refuses a partial one.
///
/// # Errors
/// The files cannot be read, do not fit together or end early.
pub(super) fn load_complete(path: &Path, options: OpenOptions) -> Result<(Model, Vec<String>)> {
    let (model, notes) = opened(path, options)?;
    if !model.complete {
        bail!("{} is incomplete: it ends before its end marker; get the rest of the file", path.display());
    }
    Ok((model, notes))
}

/// A mesh to look at: that of a mesh file, or the finest level of a wavelet file.
///
/// # Errors
/// The file cannot be read.
pub(super) fn load_mesh(path: &Path, options: OpenOptions) -> Result<TriangleMesh> {
    Ok(match load(path, options)? {
        Loaded::Mesh(mesh) => mesh,
        Loaded::Surface(model) => model.surface.to_mesh(model.surface.finest()),
    })
}

/// A surface to look at: of a wavelet file, or of a mesh by its subdivision connectivity or as its own base mesh.
///
/// # Errors
/// The file cannot be read, or the mesh is no surface.
pub(super) fn load_surface(path: &Path, options: OpenOptions) -> Result<Model> {
    match load(path, options)? {
        Loaded::Surface(model) => Ok(*model),
        Loaded::Mesh(mesh) => {
            let conversion = ConversionOptions { remesh: Remesh::Never, ..ConversionOptions::default() };
            let never = ImportOptions { conversion, form: FormOptions::default() };
            let name = path.display().to_string();
            let source = MeshSource { name, metadata: Metadata::default(), mesh };
            let _busy = Busy::new(OPENING);
            Ok(import(&source, &never, &|_, _| true)?.model)
        }
    }
}
