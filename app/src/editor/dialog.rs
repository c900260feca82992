//! Dialogs: what they ask, and their state while they are open.

use super::chooser::Purpose;
use bozzetto_core::wavelet::Wavelet;

/// Endings of wavelet files.
const WAVELET_FILES: &[&str] = &["boz"];
/// Endings of what can be opened.
const OPENABLE: &[&str] = &["boz", "obj", "ply", "off"];
/// Endings of meshes that can be read.
const MESHES_IN: &[&str] = &["obj", "ply", "off"];
/// Endings of meshes that can be written.
const MESHES_OUT: &[&str] = &["obj", "ply", "stl", "glb", "off"];

/// An open dialog.
#[derive(Debug, Clone, PartialEq)]
pub enum Dialog {
    /// Asks for a path.
    Path {
        /// What for.
        task: PathTask,
        /// The path field.
        path: String,
    },
    /// Asks what to do with unsaved edits before closing.
    Closing,
    /// Shows the keys.
    Keys,
}

/// What a path is wanted for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PathTask {
    /// Open a wavelet file or mesh.
    Open,
    /// Import a mesh with choices.
    Import {
        /// Which wavelets.
        wavelet: Wavelet,
        /// Take a mesh without subdivision connectivity as its own base mesh.
        own_base: bool,
    },
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

impl PathTask {
    /// The dialog's title and the word on its button.
    pub fn words(&self) -> (&'static str, &'static str) {
        match self {
            PathTask::Open => ("Open a wavelet file or mesh", "Open file"),
            PathTask::Import { .. } => ("Import a mesh", "Import mesh"),
            PathTask::SaveAs => ("Save as", "Save file"),
            PathTask::SaveCopy => ("Save a baked copy", "Save copy"),
            PathTask::Export { .. } => ("Export a mesh", "Export mesh"),
        }
    }

    /// What the file is for.
    pub fn purpose(&self) -> Purpose {
        match self {
            PathTask::Open => Purpose::Read(OPENABLE),
            PathTask::Import { .. } => Purpose::Read(MESHES_IN),
            PathTask::SaveAs | PathTask::SaveCopy => Purpose::Write(WAVELET_FILES),
            PathTask::Export { .. } => Purpose::Write(MESHES_OUT),
        }
    }

    /// The dialog, its path field empty.
    pub fn dialog(self) -> Dialog {
        Dialog::Path { task: self, path: String::new() }
    }
}
