//! Long work away from the window: with progress, Cancel, and panics contained.

use super::document::Document;
use crate::opening::{MeshSource, Stage};
use bozzetto_core::session::Session;
use bozzetto_core::surface::Changes;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// How far the work is, and whether it should stop.
#[derive(Debug, Default)]
pub(super) struct Share {
    thousandths: AtomicU32,
    /// The place of the stage in [`Stage::ALL`].
    stage: AtomicUsize,
    cancelled: AtomicBool,
}

impl Share {
    /// Says how far the work is, from 0 to 1; returns whether to go on.
    pub(super) fn report(&self, share: f32) -> bool {
        self.thousandths.store((share * 1000.0) as u32, Ordering::Relaxed);
        !self.cancelled.load(Ordering::Relaxed)
    }

    /// Says how far a stage of an import is, from 0 to 1; returns whether to go on.
    pub(super) fn report_stage(&self, stage: Stage, done: f32) -> bool {
        let place = Stage::ALL.iter().position(|&s| s == stage).unwrap_or(0);
        self.stage.store(place, Ordering::Relaxed);
        self.report(stage.share(done))
    }

    /// How far the work is, from 0 to 1.
    pub(super) fn done(&self) -> f32 {
        self.thousandths.load(Ordering::Relaxed) as f32 / 1000.0
    }
}

/// What a conversion came to.
#[derive(Debug)]
pub(super) struct Converted {
    /// The surface, without a file.
    pub session: Session,
    /// The distance of every vertex of the finest level to the mesh, over the diagonal.
    pub map: Vec<f64>,
    /// What was repaired, one sentence each.
    pub cleaned: Vec<String>,
    /// Root mean square and maximum of the distance, over the diagonal.
    pub distance: [f64; 2],
    /// The mesh's diagonal in model units.
    pub diagonal: f64,
    /// Vertices and faces of the mesh.
    pub mesh_counts: [u64; 2],
    /// The mesh, for another try.
    pub source: Arc<MeshSource>,
}

/// What work comes back with.
#[derive(Debug)]
pub(super) enum Outcome {
    /// A surface was opened, with what its user should know.
    Opened(Box<Session>, Vec<String>),
    /// A mesh was read that has to be converted.
    Read {
        /// The file.
        path: PathBuf,
        /// The mesh.
        source: Arc<MeshSource>,
    },
    /// A mesh was converted.
    Converted(Box<Converted>),
    /// A document comes back from work on its session.
    Returned(Box<Returned>),
    /// Something went wrong; nothing has changed.
    Failed(String),
}

/// A document after work on its session: what is shown has followed already, unless the surface has other levels.
#[derive(Debug)]
pub(super) struct Returned {
    /// The document.
    pub document: Document,
    /// What was done, or what went wrong.
    pub done: Result<Done, String>,
    /// Whether another level was shown meanwhile.
    pub previewed: bool,
    /// The runs of slots to upload.
    pub runs: Vec<Range<u32>>,
}

/// What work on a session did.
#[derive(Debug)]
pub(super) enum Done {
    /// It changed the surface.
    Changed(Option<Changes>),
    /// It wrote a file; a sentence about it.
    Wrote(String),
}

/// Work under way.
#[derive(Debug)]
pub(super) struct Work {
    /// What it is, for people.
    pub title: String,
    share: Arc<Share>,
    outcome: Receiver<Outcome>,
    /// Whether it holds the session; then Cancel has to wait for it.
    pub holds_session: bool,
    /// The stages that it shows, if it is a conversion; otherwise none.
    pub stages: &'static [Stage],
}

impl Work {
    /// Starts work that opens a file.
    pub(super) fn opening(
        wake: egui::Context,
        title: String,
        work: impl FnOnce(&Share) -> Result<Outcome, String> + Send + 'static,
    ) -> Self {
        Self::start(wake, title, false, move |share| {
            contained(|| work(share)).unwrap_or_else(Outcome::Failed)
        })
    }

    /// Starts a conversion that goes through these stages.
    pub(super) fn converting(
        wake: egui::Context,
        title: String,
        stages: &'static [Stage],
        work: impl FnOnce(&Share) -> Result<Converted, String> + Send + 'static,
    ) -> Self {
        let outcome = |share: &Share| work(share).map(|converted| Outcome::Converted(Box::new(converted)));
        Self { stages, ..Self::opening(wake, title, outcome) }
    }

    /// Starts work on a document's session, which comes back whatever happens. What is shown follows there too.
    pub(super) fn on_session(
        wake: egui::Context,
        title: String,
        mut document: Document,
        work: impl FnOnce(&mut Session) -> Result<Done, String> + Send + 'static,
    ) -> Self {
        Self::start(wake, title, true, move |_| {
            let mut done = contained(|| work(&mut document.session));
            let previewed = document.end_preview();
            let mut runs = Vec::new();
            if let Ok(Done::Changed(Some(changes))) = &done
                && !changes.reshaped
            {
                match contained(|| Ok(document.follow(changes))) {
                    Ok(moved) => runs = moved,
                    Err(sentence) => done = Err(sentence),
                }
            }
            Outcome::Returned(Box::new(Returned { document, done, previewed, runs }))
        })
    }

    fn start(
        wake: egui::Context,
        title: String,
        holds_session: bool,
        work: impl FnOnce(&Share) -> Outcome + Send + 'static,
    ) -> Self {
        let share = Arc::new(Share::default());
        let (sender, outcome) = channel();
        let shared = share.clone();
        std::thread::spawn(move || {
            let outcome = work(&shared);
            // Nobody listens any more if the work was given up.
            let _ = sender.send(outcome);
            wake.request_repaint();
        });
        Self { title, share, outcome, holds_session, stages: &[] }
    }

    /// How far it is, from 0 to 1.
    pub(super) fn done(&self) -> f32 {
        self.share.done()
    }

    /// Whether it is a conversion.
    pub(super) fn converts(&self) -> bool {
        !self.stages.is_empty()
    }

    /// The stage of a conversion.
    pub(super) fn stage(&self) -> Stage {
        Stage::ALL[self.share.stage.load(Ordering::Relaxed).min(Stage::ALL.len() - 1)]
    }

    /// Asks it to stop.
    pub(super) fn cancel(&self) {
        self.share.cancelled.store(true, Ordering::Relaxed);
    }

    /// What it came back with, if it has.
    pub(super) fn poll(&self) -> Option<Outcome> {
        match self.outcome.try_recv() {
            Ok(outcome) => Some(outcome),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => {
                Some(Outcome::Failed("The work ended without a result".into()))
            }
        }
    }
}

/// Work whose panics are sentences.
fn contained<T>(work: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| Err(went_wrong(&panic)))
}

fn went_wrong(panic: &Box<dyn std::any::Any + Send>) -> String {
    let why = panic
        .downcast_ref::<String>()
        .map(String::as_str)
        .or_else(|| panic.downcast_ref::<&str>().copied())
        .unwrap_or("no reason given");
    format!("An error inside Bozzetto stopped this ({why}); please report it")
}
