//! A converted mesh that a user looks at before it becomes the open surface.

use super::choices::ImportChoices;
use super::document::Document;
use super::settings::Settings;
use super::worker::Converted;
use crate::display::HeatScale;
use crate::figures::{counted, grouped, length, percent, tolerance};
use crate::render::{Camera, Shading};
use bozzetto_core::hierarchy::Level;
use bozzetto_core::session::Session;

/// What of the preview is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PreviewView {
    /// The finest level.
    Surface,
    /// Level 0 with its edges.
    Base,
    /// The finest level, painted with its distance to the mesh.
    Error,
}

/// A surface that is not open yet, with what is known of it.
#[derive(Debug)]
pub struct Preview {
    document: Document,
    settings: Settings,
    view: PreviewView,
    tints: Vec<[u8; 4]>,
    scale: HeatScale,
    facts: Facts,
    choices: ImportChoices,
    /// Where the open surface was looked at from.
    camera_before: Camera,
}

/// What the preview says in words.
#[derive(Debug, Clone, PartialEq)]
pub struct Facts {
    /// Names and figures.
    pub rows: Vec<(&'static str, String)>,
    /// Whether the tolerance is met, if one was demanded, and by how much.
    pub tolerance: Option<(bool, String)>,
    /// What was repaired, one sentence each.
    pub cleaned: Vec<String>,
    /// The mesh's diagonal in model units, with its unit.
    pub diagonal: (f64, String),
}

impl Preview {
    /// A preview of what work came back with.
    pub(super) fn new(converted: Converted, choices: ImportChoices, camera_before: Camera) -> Self {
        let facts = Facts::of(&converted, &choices);
        let Converted { session, map, .. } = converted;
        let mut settings = Settings::default();
        settings.for_surface(session.surface().finest());
        let document = Document::new(session, settings.shown);
        let scale = HeatScale::of(&map, choices.tolerance);
        let mut preview = Self {
            document,
            settings,
            view: PreviewView::Surface,
            tints: scale.tints(&map),
            scale,
            facts,
            choices,
            camera_before,
        };
        preview.look_at(PreviewView::Surface);
        preview
    }

    /// The surface, as it would be opened.
    pub fn document(&self) -> &Document {
        &self.document
    }

    /// What is drawn of it: no handles, and edges of the base mesh only.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// What is looked at.
    pub fn view(&self) -> PreviewView {
        self.view
    }

    /// What it says in words.
    pub fn facts(&self) -> &Facts {
        &self.facts
    }

    /// The colours of the error.
    pub fn scale(&self) -> HeatScale {
        self.scale
    }

    /// What it is made from.
    pub fn name(&self) -> String {
        self.choices.name()
    }

    /// What the mouse does now.
    pub(super) fn hint(&self) -> String {
        format!("{}: not opened yet · drag: orbit · right drag: pan · wheel: zoom", self.choices.name())
    }

    /// The colours of the shown vertices, if they are painted.
    pub(super) fn painted(&self) -> Option<&[[u8; 4]]> {
        (self.view == PreviewView::Error).then_some(&self.tints)
    }

    /// Looks at something else of it.
    pub(super) fn look_at(&mut self, view: PreviewView) {
        self.view = view;
        let finest = self.document.surface().finest();
        self.settings = Settings {
            level: Level::BASE,
            shown: if view == PreviewView::Base { Level::BASE } else { finest },
            shading: if view == PreviewView::Base { Shading::Flat } else { Shading::Clay },
            edges: view == PreviewView::Base,
            handles: false,
            support: false,
            ..Settings::default()
        };
        if self.document.vertices().level() != self.settings.shown {
            self.document.show(self.settings.shown);
        }
    }

    pub(super) fn document_mut(&mut self) -> &mut Document {
        &mut self.document
    }

    /// The surface, to open it.
    pub(super) fn into_session(self) -> Session {
        self.document.session
    }

    /// The choices it was made with, and where the open surface was looked at from.
    pub(super) fn into_choices(self) -> (ImportChoices, Camera) {
        (self.choices, self.camera_before)
    }
}

impl Facts {
    fn of(converted: &Converted, choices: &ImportChoices) -> Self {
        let hierarchy = converted.session.surface().hierarchy();
        let base = hierarchy.base();
        let finest = hierarchy.finest();
        let [rms, max] = converted.distance;
        let of_diagonal =
            |d: f64| format!("{} ({})", percent(d), length(d * converted.diagonal, &choices.unit));
        let [vertices, faces] = converted.mesh_counts.map(grouped);
        let made = grouped(u64::from(hierarchy.layout(finest).len()));
        let rows = vec![
            ("mesh", format!("{vertices} vertices, {faces} faces")),
            ("surface", format!("{made} vertices, {} faces", grouped(hierarchy.face_count(finest)))),
            ("levels", counted(finest.0.into(), "level over the base mesh", "levels over the base mesh")),
            (
                "base mesh",
                format!(
                    "{} vertices, {} faces",
                    grouped(base.vertex_count().into()),
                    grouped(base.faces().len() as u64)
                ),
            ),
            (
                "topology",
                format!(
                    "{}, genus {}, {}",
                    counted(base.components(), "component", "components"),
                    base.genus(),
                    counted(base.boundary_loops(), "boundary loop", "boundary loops")
                ),
            ),
            ("rms error", of_diagonal(rms)),
            ("greatest error", of_diagonal(max)),
        ];
        Self {
            rows,
            tolerance: choices.tolerance.map(|demanded| (max <= demanded, tolerance(max, demanded))),
            cleaned: converted.cleaned.clone(),
            diagonal: (converted.diagonal, choices.unit.clone()),
        }
    }
}
