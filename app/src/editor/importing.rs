//! Importing: reading a mesh, asking, converting away from the window, looking before it is opened.

use super::Editor;
use super::choices::{ImportChoices, ImportFrom};
use super::dialog::Dialog;
use super::preview::{Preview, PreviewView};
use super::shown_name;
use super::worker::{Converted, Outcome, Share, Work};
use crate::opening::{self, ImportOptions, Imported, MeshSource, Stage};
use bozzetto_core::conversion::Remesh;
use bozzetto_core::disk::Disk;
use bozzetto_core::file::Metadata;
use bozzetto_core::session::Session;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A mesh file that was read, kept while its import is being chosen.
#[derive(Debug, Clone)]
pub(super) struct ReadMesh {
    path: PathBuf,
    source: Arc<MeshSource>,
}

impl Editor {
    /// Reads a mesh: with subdivision connectivity it opens, without it the dialog asks how to convert it.
    pub(super) fn open_mesh(&mut self, ctx: &egui::Context, path: PathBuf) {
        self.read = None;
        let title = format!("Reading {}", shown_name(&path));
        self.work = Some(Work::opening(ctx.clone(), title, move |share| read_and_look(&path, share)));
    }

    /// Asks how to convert a mesh that was read.
    pub(super) fn ask_how_to_import(&mut self, path: PathBuf, source: Arc<MeshSource>) {
        let path_text = path.to_string_lossy().into_owned();
        self.read = Some(ReadMesh { path, source });
        let found = "It has no subdivision connectivity, so it will be converted.".to_owned();
        let choices = ImportChoices { found, ..ImportChoices::file(path_text) };
        self.dialog = Some(Dialog::Import(Box::new(choices)));
    }

    /// Asks how to convert the open surface again.
    pub(super) fn ask_how_to_remesh(&mut self) {
        if let Some(document) = &self.document {
            let choices = ImportChoices::surface(document.name(), &document.surface().form().placement);
            self.dialog = Some(Dialog::Import(Box::new(choices)));
        }
    }

    /// Converts away from the window; the open surface stays as it is.
    pub(super) fn convert(&mut self, ctx: &egui::Context, choices: ImportChoices) {
        let options = choices.options();
        let title = format!("Converting {}", choices.name());
        let from = match (&choices.from, &self.document) {
            (ImportFrom::Surface(name), Some(document)) => Origin::Mesh(Arc::new(mesh_of(document, name))),
            (ImportFrom::Surface(_), None) => return,
            (ImportFrom::File(path), _) => {
                let path = PathBuf::from(path.trim());
                match &self.read {
                    Some(read) if read.path == path => Origin::Mesh(read.source.clone()),
                    _ => Origin::File(path),
                }
            }
        };
        let stages = match from {
            Origin::File(_) => &Stage::ALL[..],
            Origin::Mesh(_) if options.conversion.remesh == Remesh::Always => Stage::CONVERTING,
            Origin::Mesh(_) => Stage::OF_A_MESH,
        };
        self.choosing = Some(choices);
        self.work =
            Some(Work::converting(ctx.clone(), title, stages, move |share| converted(from, &options, share)));
    }

    /// Shows what the conversion came to, before it is opened.
    pub(super) fn show_preview(&mut self, converted: Converted) {
        let Some(choices) = self.choosing.take() else { return };
        if let ImportFrom::File(path) = &choices.from {
            self.read = Some(ReadMesh { path: path.trim().into(), source: converted.source.clone() });
        }
        self.tool = Default::default();
        self.banner = None;
        let preview = Preview::new(converted, choices, self.camera);
        let size = self.picture_size();
        self.camera =
            crate::render::View::default().camera(preview.document().sphere(), size.x / size.y.max(1.0));
        self.preview = Some(preview);
        self.scenery.replace_surface();
    }

    /// Opens what is previewed.
    pub(super) fn commit_import(&mut self) {
        let Some(preview) = self.preview.take() else { return };
        self.read = None;
        let notes = preview.facts().cleaned.clone();
        self.show(preview.into_session(), notes);
    }

    /// Goes from the preview back to the choices, the open surface as it was.
    pub(super) fn change_import(&mut self) {
        if let Some(choices) = self.leave_preview() {
            self.dialog = Some(Dialog::Import(Box::new(choices)));
        }
    }

    /// Gives the import up, the open surface as it was.
    pub(super) fn cancel_import(&mut self) {
        self.leave_preview();
        self.read = None;
    }

    /// Looks at something else of the preview.
    pub(super) fn look_at(&mut self, view: PreviewView) {
        if let Some(preview) = &mut self.preview {
            preview.look_at(view);
            self.scenery.replace_surface();
        }
    }

    /// After a conversion that was cancelled or failed, the choices are there again.
    pub(super) fn back_to_choices(&mut self) {
        if let Some(choices) = self.choosing.take() {
            self.dialog = Some(Dialog::Import(Box::new(choices)));
        }
    }

    fn leave_preview(&mut self) -> Option<ImportChoices> {
        let (choices, camera) = self.preview.take()?.into_choices();
        self.camera = camera;
        self.scenery.replace_surface();
        Some(choices)
    }
}

/// What is converted: a file yet to be read, or a mesh at hand.
enum Origin {
    File(PathBuf),
    Mesh(Arc<MeshSource>),
}

/// The finest level of the open surface, to convert it again.
fn mesh_of(document: &super::Document, name: &str) -> MeshSource {
    let surface = document.surface();
    let metadata = Metadata { source: Some(format!("{name}, remeshed")), source_sha256: None };
    MeshSource { name: name.to_owned(), metadata, mesh: surface.to_mesh(surface.finest()) }
}

/// Reads a mesh and opens it if it has subdivision connectivity.
fn read_and_look(path: &Path, share: &Share) -> Result<Outcome, String> {
    let progress = |stage: Stage, done: f32| share.report_stage(stage, done);
    let source = MeshSource::read(path, &progress).map_err(|e| format!("{e:#}"))?;
    let kept = opening::import_if_kept(&source, &ImportOptions::default(), &progress);
    let Some(imported) = kept.map_err(|e| format!("{e:#}"))? else {
        return Ok(Outcome::Read { path: path.to_owned(), source: Arc::new(source) });
    };
    let surface = &imported.model.surface;
    let mut notes = vec![format!(
        "This mesh has subdivision connectivity: {} levels over {} base faces. Its vertices were kept, nothing was \
         converted.",
        surface.finest(),
        surface.hierarchy().base().faces().len()
    )];
    notes.extend(imported.cleaned);
    Ok(Outcome::Opened(Box::new(Session::new(Arc::new(Disk), imported.model)), notes))
}

fn converted(from: Origin, options: &ImportOptions, share: &Share) -> Result<Converted, String> {
    let progress = |stage: Stage, done: f32| share.report_stage(stage, done);
    let sentence = |e: anyhow::Error| format!("{e:#}");
    let source = match from {
        Origin::File(path) => Arc::new(MeshSource::read(&path, &progress).map_err(sentence)?),
        Origin::Mesh(source) => source,
    };
    let Imported { model, cleaned, distance, .. } =
        opening::import(&source, options, &progress).map_err(sentence)?;
    let map = opening::error_map(&model.surface, &source.mesh, &progress).map_err(sentence)?;
    Ok(Converted {
        session: Session::new(Arc::new(Disk), model),
        map,
        cleaned,
        distance,
        diagonal: source.mesh.diagonal(),
        mesh_counts: [source.mesh.positions.len() as u64, source.mesh.faces.len() as u64],
        source,
    })
}
