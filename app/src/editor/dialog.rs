//! Dialogs: what they ask, and their state while they are open.

use super::choices::{ImportChoices, ImportFrom};
use super::chooser::Purpose;
use super::command::Command;
use bozzetto_core::file::is_wavelet_file;
use bozzetto_core::io::MeshFormat;
use std::path::PathBuf;
use std::sync::LazyLock;

/// Endings of wavelet files.
const WAVELET_FILES: &[&str] = &["boz"];
/// Endings of meshes that can be read.
static MESHES_IN: LazyLock<Vec<&str>> =
    LazyLock::new(|| MeshFormat::READABLE.iter().map(|format| format.extension()).collect());
/// Endings of meshes that can be written.
static MESHES_OUT: LazyLock<Vec<&str>> =
    LazyLock::new(|| MeshFormat::WRITABLE.iter().map(|format| format.extension()).collect());
/// Endings of what can be opened.
static OPENABLE: LazyLock<Vec<&str>> =
    LazyLock::new(|| WAVELET_FILES.iter().chain(MESHES_IN.iter()).copied().collect());

/// An open dialog.
#[derive(Debug, Clone)]
pub enum Dialog {
    /// Asks for a path.
    Path {
        /// What for.
        task: PathTask,
        /// The path field.
        path: String,
    },
    /// Asks how to import a mesh.
    Import(Box<ImportChoices>),
    /// Asks what to do with unsaved edits before closing.
    Closing,
    /// Asks what to do with edits that have no file, before a command that loses them.
    Losing(Box<Command>),
    /// Shows the keys.
    Keys,
}

/// What a path is wanted for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PathTask {
    /// Open a wavelet file or mesh.
    Open,
    /// Save under another name.
    SaveAs,
    /// Write a baked copy.
    SaveCopy,
    /// Write a mesh.
    Export {
        /// The level to write.
        level: u8,
    },
}

impl Dialog {
    /// The path field and what a file is wanted for, if the dialog has one.
    pub fn path_field(&mut self) -> Option<(&mut String, Purpose)> {
        match self {
            Dialog::Path { task, path } => Some((path, task.purpose())),
            Dialog::Import(choices) => match &mut choices.from {
                ImportFrom::File(path) => Some((path, Purpose::Read(&MESHES_IN))),
                ImportFrom::Surface(_) => None,
            },
            Dialog::Closing | Dialog::Losing(_) | Dialog::Keys => None,
        }
    }
}

impl PathTask {
    /// The dialog's title and the word on its button.
    pub fn words(&self) -> (&'static str, &'static str) {
        match self {
            PathTask::Open => ("Open a wavelet file or mesh", "Open file"),
            PathTask::SaveAs => ("Save as", "Save file"),
            PathTask::SaveCopy => ("Save a baked copy", "Save copy"),
            PathTask::Export { .. } => ("Export a mesh", "Export mesh"),
        }
    }

    /// What is written for a path as it was typed; `None` if nothing is written.
    pub fn target(&self, typed: &str) -> Option<PathBuf> {
        let path = PathBuf::from(typed.trim());
        match self {
            PathTask::Open => None,
            PathTask::SaveAs | PathTask::SaveCopy if !is_wavelet_file(&path) => {
                Some(path.with_added_extension("boz"))
            }
            _ => Some(path),
        }
    }

    /// What the file is for.
    pub fn purpose(&self) -> Purpose {
        match self {
            PathTask::Open => Purpose::Read(&OPENABLE),
            PathTask::SaveAs | PathTask::SaveCopy => Purpose::Write(WAVELET_FILES),
            PathTask::Export { .. } => Purpose::Write(&MESHES_OUT),
        }
    }

    /// The dialog, its path field empty.
    pub fn dialog(self) -> Dialog {
        Dialog::Path { task: self, path: String::new() }
    }
}
