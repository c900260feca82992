//! What is worked on and what is seen, with the rules that keep it meaningful.

use super::command::Overlay;
use crate::render::Shading;
use bozzetto_core::edit::{Falloff, Kind};
use bozzetto_core::hierarchy::{Level, PublicId};

/// The editor's choices.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Scaling or wavelet coefficients.
    pub kind: Kind,
    /// The edited level.
    pub level: Level,
    /// The shown level.
    pub shown: Level,
    /// The selected coefficient of kind and level.
    pub selected: Option<PublicId>,
    /// Reach of a move as a fraction of the model's radius; 0: one coefficient.
    pub radius: f64,
    /// How a move fades.
    pub falloff: Falloff,
    /// The shading.
    pub shading: Shading,
    /// The level's edges are drawn.
    pub edges: bool,
    /// Handles are drawn.
    pub handles: bool,
    /// The control polyhedron is drawn.
    pub control: bool,
    /// The selected coefficient's support is drawn.
    pub support: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            kind: Kind::Scaling,
            level: Level::BASE,
            shown: Level::BASE,
            selected: None,
            radius: 0.0,
            falloff: Falloff::Smooth,
            shading: Shading::Clay,
            edges: true,
            handles: true,
            control: false,
            support: true,
        }
    }
}

impl Settings {
    /// The choices for a surface just opened: its finest level shown, a coarse level edited.
    pub fn for_surface(&mut self, finest: Level) {
        self.shown = finest;
        self.level = Level(finest.0.min(1));
        self.selected = None;
        self.settle(finest);
    }

    /// The last level that coefficients of a kind have.
    pub fn last_level(kind: Kind, finest: Level) -> Level {
        match kind {
            Kind::Scaling => finest,
            Kind::Wavelet => Level(finest.0.saturating_sub(1)),
        }
    }

    /// Makes the choices fit each other and the surface; says what had to give way. A coefficient can be seen only
    /// on a level that has it: the edited level for scaling coefficients, the next finer one for wavelets.
    pub fn settle(&mut self, finest: Level) -> Option<String> {
        let mut note = None;
        if self.kind == Kind::Wavelet && finest == Level::BASE {
            self.kind = Kind::Scaling;
            note = Some("This surface has one level only, so it has no wavelets".to_owned());
        }
        let last = Self::last_level(self.kind, finest);
        if self.level > last {
            self.level = last;
            note = Some(format!("{} coefficients end at level {last}", capitalised(self.kind)));
        }
        let visible_from = match self.kind {
            Kind::Scaling => self.level,
            Kind::Wavelet => self.level.finer(),
        };
        self.shown = self.shown.min(finest);
        if self.shown < visible_from {
            self.shown = visible_from;
            note.get_or_insert(format!(
                "Level {visible_from} is shown, so that its coefficients can be seen"
            ));
        }
        note
    }

    /// Switches an overlay.
    pub fn toggle(&mut self, overlay: Overlay) {
        let flag = match overlay {
            Overlay::Edges => &mut self.edges,
            Overlay::Handles => &mut self.handles,
            Overlay::Control => &mut self.control,
            Overlay::Support => &mut self.support,
        };
        *flag = !*flag;
    }
}

fn capitalised(kind: Kind) -> &'static str {
    match kind {
        Kind::Scaling => "Scaling",
        Kind::Wavelet => "Wavelet",
    }
}
