//! What is worked on and what is seen, with the rules that keep it meaningful.

use super::command::Overlay;
use crate::render::Shading;
use bozzetto_core::edit::{Falloff, Kind, Mirror, Over, Spread, Tool};
use bozzetto_core::hierarchy::{Level, PublicId};

/// What is in the hand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Hand {
    /// Drags the nearest coefficient.
    Handle,
    /// Drags the place under the cursor, as far round as the brush reaches.
    Grab,
    /// A brush.
    Brush(Tool),
}

impl Hand {
    /// Its name as people read it.
    pub fn name(self) -> &'static str {
        match self {
            Hand::Handle => "Handle",
            Hand::Grab => "Grab",
            Hand::Brush(tool) => tool.name(),
        }
    }
}

/// How the mouse moves the camera, after the habits of other programs. Dragging the background always orbits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Navigation {
    /// Middle: orbit, with Shift pan, with Ctrl zoom. Right: pan.
    #[default]
    Blender,
    /// Alt with left: orbit, middle: pan, right: zoom.
    Maya,
    /// Right: orbit, with Alt pan, with Ctrl zoom; Alt with the left on the background: pan.
    ZBrush,
}

impl Navigation {
    /// All of them with their names.
    pub const ALL: [(Navigation, &'static str); 3] =
        [(Navigation::Blender, "Blender"), (Navigation::Maya, "Maya"), (Navigation::ZBrush, "ZBrush")];
}

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
    /// What is in the hand.
    pub hand: Hand,
    /// The brush's radius as a fraction of the model's.
    pub brush_radius: f64,
    /// The brush's strength.
    pub strength: f64,
    /// Mirror planes across x, y and z through the model's middle.
    pub symmetry: [bool; 3],
    /// How handles bend finer levels.
    pub spread: Spread,
    /// Finer detail turns with what handles and grabs bend.
    pub follow: bool,
    /// The finest level of the detail that erasing takes; none: all finer than the edited level.
    pub erase_to: Option<u8>,
    /// The brush's radius chooses the level.
    pub auto_level: bool,
    /// Where the equaliser acts.
    pub over: Over,
    /// How far, in points, the brush trails behind the cursor; 0: not at all.
    pub steady: f64,
    /// A pen's pressure acts on the strength.
    pub pressure_strength: bool,
    /// A pen's pressure acts on the radius.
    pub pressure_radius: bool,
    /// How the mouse moves the camera.
    pub navigation: Navigation,
    /// The inspector is shown.
    pub inspector: bool,
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
            hand: Hand::Handle,
            brush_radius: 0.12,
            strength: 0.5,
            symmetry: [false; 3],
            spread: Spread::Smooth,
            follow: true,
            erase_to: None,
            auto_level: false,
            over: Over::All,
            steady: 0.0,
            pressure_strength: true,
            pressure_radius: false,
            navigation: Navigation::Blender,
            inspector: true,
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

    /// The choices after the surface got other levels: the finest is shown.
    pub fn for_levels(&mut self, finest: Level) -> Option<String> {
        self.shown = finest;
        self.level = self.level.min(finest);
        self.selected = None;
        self.settle(finest)
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
        self.erase_to = self.erase_to.map(|to| to.min(finest.0.saturating_sub(1)));
        if self.shown < visible_from {
            self.shown = visible_from;
            note.get_or_insert(format!(
                "Level {visible_from} is shown, so that its coefficients can be seen"
            ));
        }
        note
    }

    /// Whether a handle drags the paper's coefficient as it is: neither spread smoothly, nor with detail that follows, nor, for
    /// a scaling coefficient, in a mirror.
    pub fn drags_raw(&self) -> bool {
        let mirrored = self.kind == Kind::Scaling && self.symmetry.contains(&true);
        self.spread == Spread::Hat && !self.follow && !mirrored
    }

    /// The mirror planes in model units, through a point; none without symmetry.
    pub fn mirror(&self, middle: [f64; 3]) -> Option<Mirror> {
        let at = |axis: usize| self.symmetry[axis].then_some(middle[axis]);
        let mirror = Mirror { x: at(0), y: at(1), z: at(2) };
        (!mirror.is_none()).then_some(mirror)
    }

    /// The level whose triangles are about a quarter of the brush's radius, where there are `vertices` by level on a model
    /// of radius 1.
    pub fn level_for_radius(&self, vertices: impl Iterator<Item = u32>) -> Level {
        let spacing = |n: u32| (4.0 * std::f64::consts::PI / f64::from(n)).sqrt();
        let fine_enough = |n: &u32| spacing(*n) <= 0.25 * self.brush_radius;
        let counts: Vec<u32> = vertices.collect();
        let level = counts.iter().position(fine_enough).unwrap_or(counts.len() - 1);
        Level(level as u8)
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A level to erase to that the surface does not have would refuse every stroke.
    #[test]
    fn the_level_to_erase_to_is_one_that_there_is() {
        let mut settings = Settings { erase_to: Some(6), ..Settings::default() };
        settings.for_surface(Level(4));
        assert_eq!(settings.erase_to, Some(3));
        settings.for_surface(Level::BASE);
        assert_eq!(settings.erase_to, Some(0));
    }
}
