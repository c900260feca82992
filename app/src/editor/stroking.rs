//! Strokes and drags carried out: from commands of the tools to the session, and back to what is shown.

use super::Editor;
use super::command::Command;
use super::panels::Banner;
use super::settings::Hand;
use super::worker::Done;
use crate::render::BoundingSphere;
use bozzetto_core::edit::{Dab, Edit, EditError, Falloff, Kind, Move, Pull, Stroke, Tool};
use bozzetto_core::hierarchy::Level;
use bozzetto_core::session::SessionError;
use bozzetto_core::surface::Changes;
use glam::DVec3;

/// Radii of brushes as a fraction of the model's.
const RADII: std::ops::RangeInclusive<f64> = 0.002..=2.0;

/// Where the last stroke was, in drawing space.
#[derive(Debug, Clone, Copy)]
pub(super) struct Trace {
    low: DVec3,
    high: DVec3,
}

impl Trace {
    fn at(p: DVec3) -> Self {
        Self { low: p, high: p }
    }

    fn with(self, p: DVec3) -> Self {
        Self { low: self.low.min(p), high: self.high.max(p) }
    }
}

impl Editor {
    /// Carries out a command of a tool's stroke.
    pub(super) fn stroke(&mut self, ctx: &egui::Context, command: Command) {
        let Some(document) = &mut self.document else { return };
        let middle = document.surface().form().placement.origin;
        let mirror = self.settings.mirror(middle);
        let begins = matches!(command, Command::BeginStroke { .. } | Command::BeginGrab(_));
        let result = match command {
            Command::BeginStroke { kind, level, vertex } => {
                if let Some(target) = document.target(kind, Level(level), vertex) {
                    self.last_stroke = Some(Trace::at(target.position));
                }
                let reach = self.settings.radius * document.sphere().radius;
                let (radius, falloff) =
                    if reach > 0.0 { (Some(reach), Some(self.settings.falloff)) } else { (None, None) };
                if self.settings.drags_raw() {
                    let v = if mirror.is_some() { Move::LATEST_VERSION } else { 1 };
                    let (vertex, delta) = (vertex.0, [0.0; 3]);
                    let edit = Move { kind, level, vertex, delta, radius, falloff, mirror, v };
                    let alone = document.session.begin_stroke(edit);
                    self.say_without_partner(alone)
                } else {
                    let edit = Pull { vertex: Some(vertex.0), ..self.pull(kind, level, radius, falloff) };
                    self.begin_pull(edit)
                }
            }
            Command::BeginGrab(place) => {
                self.last_stroke = Some(Trace::at(place));
                let radius = self.settings.brush_radius * document.sphere().radius;
                let at = Some(document.model_place(place));
                let level = self.settings.level.0;
                let edit = Pull { at, ..self.pull(Kind::Scaling, level, Some(radius), None) };
                self.begin_pull(edit)
            }
            Command::BeginBrush(Tool::Copy, _) if self.copy_from.is_none() => {
                let text = "Choose first where the detail comes from: Alt + click on the surface".to_owned();
                self.banner = Some(Banner { text, failed: false });
                return;
            }
            Command::BeginBrush(tool, inverted) => {
                self.last_stroke = None;
                let radius = self.settings.brush_radius * document.sphere().radius;
                let sign = if inverted { -1.0 } else { 1.0 };
                let words = Stroke {
                    tool,
                    level: self.settings.level.0,
                    radius,
                    strength: sign * self.settings.strength,
                    falloff: None,
                    mirror,
                    to: self.settings.erase_to.filter(|_| tool == Tool::Erase),
                    from: self.copy_from.filter(|_| tool == Tool::Copy),
                    dabs: Vec::new(),
                    v: tool.latest_version(),
                };
                let begun = document.session.begin_brush(words).map(|()| Changes::default());
                // Levels coarser than what moves wait for the stroke's end: what moves is shown meanwhile.
                if let Some(level) =
                    document.session.brush_level().filter(|&level| level > self.settings.shown)
                {
                    document.preview_level(level);
                    self.scenery.replace_surface();
                }
                begun
            }
            Command::Dab(place, pressure) => {
                self.last_stroke = Some(self.last_stroke.map_or(Trace::at(place), |t| t.with(place)));
                let acts = |on: bool| pressure.filter(|_| on).unwrap_or(1.0);
                let dab = Dab {
                    at: document.model_place(place),
                    strength: acts(self.settings.pressure_strength),
                    size: acts(self.settings.pressure_radius).max(0.05),
                };
                document.session.dab(dab)
            }
            Command::DragTo(drawn) => {
                let model = document.vertices().frame().turn_back(drawn).to_array();
                document.drag_to(model)
            }
            Command::EndStroke if document.session.ends_slowly() => {
                // The preview stays until the session is back.
                self.send_session(ctx, "Finishing the drag on all levels".to_owned(), |session| {
                    Ok(Done::Changed(Some(session.end_stroke())))
                });
                return;
            }
            Command::EndStroke => return self.let_go(),
            _ => {
                if document.end_preview() {
                    self.scenery.replace_surface();
                }
                Ok(document.session.cancel_stroke())
            }
        };
        match result {
            Ok(changes) => self.follow(&changes),
            Err(error) => self.fail(error.to_string()),
        }
        if begins {
            self.preview_if_large();
        }
    }

    /// Ends the stroke under way, if there is one.
    pub(super) fn let_go(&mut self) {
        let Some(document) = self.document.as_mut().filter(|document| document.session.in_stroke()) else {
            return;
        };
        if document.end_preview() {
            self.scenery.replace_surface();
        }
        let changes = document.session.end_stroke();
        let refused = changes.beyond_limit;
        self.follow(&changes);
        if refused {
            self.fail(EditError::BeyondLimit.to_string());
        }
    }

    fn pull(&self, kind: Kind, level: u8, radius: Option<f64>, falloff: Option<Falloff>) -> Pull {
        let document = self.document.as_ref();
        let finest = document.map_or(Level::BASE, |d| d.surface().finest());
        let mirror = document.and_then(|d| self.settings.mirror(d.surface().form().placement.origin));
        let turning = Level(if kind == Kind::Wavelet { level + 1 } else { level });
        Pull {
            kind,
            level,
            vertex: None,
            at: None,
            delta: [0.0; 3],
            radius,
            falloff,
            spread: self.settings.spread,
            follow: self.settings.follow && turning < finest,
            mirror,
            v: Pull::version_for(kind),
        }
    }

    fn begin_pull(&mut self, edit: Pull) -> Result<Changes, SessionError> {
        let Some(document) = &mut self.document else { return Ok(Changes::default()) };
        let alone = document.session.begin_pull(edit);
        self.say_without_partner(alone)
    }

    /// Nothing has moved yet; but if a coefficient has no mirror image, that is said.
    fn say_without_partner(&mut self, alone: Result<usize, SessionError>) -> Result<Changes, SessionError> {
        if alone? > 0 {
            let text =
                "No vertex of this level lies at the mirror image, so the coefficient moves alone".to_owned();
            self.banner = Some(Banner { text, failed: false });
        }
        Ok(Changes::default())
    }

    /// A drag of more than can follow the hand goes on at a coarser level. Brushes have none: they read the finest.
    fn preview_if_large(&mut self) {
        if self.document.as_mut().is_some_and(|document| document.preview_if_large()) {
            self.scenery.replace_surface();
        }
    }

    /// Carries out a choice about the tool in the hand.
    pub(super) fn equip(&mut self, command: &Command) {
        let settings = &mut self.settings;
        match *command {
            Command::Take(hand) => {
                settings.hand = hand;
                self.tool = Default::default();
                self.brush = Default::default();
            }
            Command::SetBrushRadius(radius) => {
                settings.brush_radius = radius.clamp(*RADII.start(), *RADII.end());
            }
            Command::SetStrength(strength) => settings.strength = strength.clamp(0.0, 1.0),
            Command::ToggleSymmetry(axis) => settings.symmetry[axis] = !settings.symmetry[axis],
            Command::SetSpread(spread) => settings.spread = spread,
            Command::ToggleFollow => settings.follow = !settings.follow,
            Command::SetEraseTo(level) => settings.erase_to = level,
            Command::ToggleAutoLevel => settings.auto_level = !settings.auto_level,
            Command::SetSteady(points) => settings.steady = points,
            Command::TogglePressure(true) => settings.pressure_strength = !settings.pressure_strength,
            Command::TogglePressure(false) => settings.pressure_radius = !settings.pressure_radius,
            Command::SetNavigation(navigation) => settings.navigation = navigation,
            Command::ToggleInspector => settings.inspector = !settings.inspector,
            _ => {}
        }
        if settings.auto_level && settings.hand != Hand::Handle {
            self.choose_level_for_radius();
        }
    }

    fn choose_level_for_radius(&mut self) {
        let Some(document) = &self.document else { return };
        let hierarchy = document.surface().hierarchy();
        let counts = (0..=hierarchy.finest().0).map(|j| hierarchy.layout(Level(j)).len());
        let level = self.settings.level_for_radius(counts);
        if level != self.settings.level {
            self.choose_level(&Command::SetLevel(level.0));
        }
    }

    /// Frees everything, as a stroke of the mask brush over the whole model.
    pub(super) fn clear_mask(&mut self, ctx: &egui::Context) {
        let Some(document) = &self.document else { return };
        let sphere = document.sphere();
        let words = Stroke {
            tool: Tool::Mask,
            level: 0,
            radius: 4.0 * sphere.radius,
            strength: -1.0,
            falloff: Some(Falloff::Constant),
            mirror: None,
            to: None,
            from: None,
            dabs: vec![Dab::new(document.model_place(sphere.center)).shortened(sphere.radius)],
            v: 1,
        };
        self.edit(ctx, Edit::Stroke(words));
    }

    /// Looks at where the last stroke was.
    pub(super) fn frame_stroke(&mut self) {
        let (Some(document), Some(trace)) = (&self.document, self.last_stroke) else { return };
        let around = self.settings.brush_radius * document.sphere().radius;
        let sphere = BoundingSphere {
            center: (trace.low + trace.high) * 0.5,
            radius: ((trace.high - trace.low).length() * 0.5 + around).max(1e-3 * document.sphere().radius),
        };
        let size = self.picture_size();
        self.camera.fit(sphere, size.x / size.y.max(1.0));
    }
}
