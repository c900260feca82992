//! Opening the window.

use super::Editor;
use super::chooser::SystemChooser;
use super::labels::{LABELS, Labels};
use crate::render::{Gpu, Samples, device_descriptor};
use anyhow::{Result, anyhow};
use bozzetto_core::disk::Disk;
use bozzetto_core::file::decode;
use bozzetto_core::session::Session;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tracing_subscriber::Layer;
use tracing_subscriber::filter::Targets;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;

/// The sample that opens when no file is named: the scan `faun.ply`, converted beforehand, for that takes seconds.
const SCAN: &[u8] = include_bytes!("../../../assets/faun.boz");

/// A smaller sample, over a base mesh placed by hand.
const HEAD: &[u8] = include_bytes!("../../../assets/head.boz");

/// What the editor begins with.
pub enum Start {
    /// No surface.
    Empty,
    /// A surface already open.
    Session(Box<Session>),
    /// A wavelet file or mesh to open.
    File(PathBuf),
}

impl Start {
    /// The sample scan, converted, as a surface without a file.
    ///
    /// # Errors
    /// The sample is damaged.
    pub fn scan() -> Result<Self> {
        Self::without_file(SCAN, "faun.boz")
    }

    /// The sample head, as a surface without a file.
    ///
    /// # Errors
    /// The sample is damaged.
    pub fn sample() -> Result<Self> {
        Self::without_file(HEAD, "head.boz")
    }

    fn without_file(bytes: &[u8], name: &str) -> Result<Self> {
        let model = decode(bytes, Path::new(name))?;
        Ok(Self::Session(Box::new(Session::new(Arc::new(Disk), model))))
    }
}

/// Lets what goes wrong beside the window be read in the terminal that it was started from.
fn speak_on_stderr() {
    let own = Targets::new().with_target("bozzetto", tracing::Level::WARN);
    let lines = tracing_subscriber::fmt::layer().with_writer(std::io::stderr).without_time();
    // Already done where the program opens a second window.
    let _ = tracing_subscriber::registry().with(lines.with_filter(own)).try_init();
}

/// Opens the window on a file, or on the sample scan, and returns when it is closed.
///
/// # Errors
/// The file does not exist, or there is no display or no way to draw; one sentence says what to install.
pub fn run(file: Option<PathBuf>) -> Result<()> {
    let start = match file {
        Some(path) => {
            // A name mistyped on the command line is told there, not in a window.
            std::fs::metadata(&path).map_err(|cause| {
                anyhow!("{}: {cause}; give a wavelet file or a mesh, or see bozzetto --help", path.display())
            })?;
            Start::File(path)
        }
        None => Start::scan()?,
    };
    speak_on_stderr();
    // The window's own messages about missing drivers say less than these.
    Gpu::headless()?;
    let mut options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_title("Bozzetto")
            .with_app_id("bozzetto")
            .with_inner_size([1280.0, 800.0])
            .with_min_inner_size([820.0, 520.0]),
        ..Default::default()
    };
    if let egui_wgpu::WgpuSetup::CreateNew(setup) = &mut options.wgpu_options.wgpu_setup {
        setup.device_descriptor = Arc::new(device_descriptor);
    }
    let editor = |cc: &eframe::CreationContext<'_>| -> Result<Box<dyn eframe::App>, Box<dyn std::error::Error + Send + Sync>> {
        if let Some(path) = std::env::var_os(LABELS) {
            cc.egui_ctx.add_plugin(Labels::new(&cc.egui_ctx, path.into()));
        }
        Ok(Box::new(Editor::new(cc, Samples::Four, Box::new(SystemChooser::default()), start)?))
    };
    eframe::run_native("Bozzetto", options, Box::new(editor)).map_err(|error| {
        anyhow!(
            "there is no window to show ({error}); start it in a desktop session, or use `bozzetto render`"
        )
    })
}
