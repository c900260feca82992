//! Keeps the renderer's buffers in step with document and choices, uploading only what changed.

use super::document::{Document, Target};
use super::settings::{Hand, Settings};
use crate::display::{HiddenFaces, Influence, support_border, tints};
use crate::render::{GhostMesh, GpuError, Handle, HandleState, Line, SurfaceRenderer};
use bozzetto_core::edit::Kind;
use bozzetto_core::hierarchy::{Layout, Level, PublicId, Slot};
use std::ops::Range;

/// Levels with more vertices show handles near the cursor only.
const MOST_HANDLES: u32 = 3000;
/// A finer control polyhedron would hide the surface.
const MOST_CONTROL_VERTICES: u32 = 20_000;

const HANDLE_FILL: [u8; 4] = [240, 234, 224, 255];
const WAVELET_FILL: [u8; 4] = [150, 196, 240, 255];
const RIM: [u8; 4] = [34, 30, 30, 255];
const HELD_FILL: [u8; 4] = [246, 150, 70, 255];
const MASKED: [u8; 3] = [22, 20, 34];
const OUTLINE: [u8; 4] = [252, 246, 236, 220];

/// What is drawn.
pub(super) struct Shown<'a> {
    /// The surface.
    pub document: &'a Document,
    /// The choices.
    pub settings: &'a Settings,
    /// The colour of every shown vertex, in place of the support's.
    pub painted: Option<&'a [[u8; 4]]>,
}

/// What of the scene has to be made anew.
#[derive(Debug, Clone, Default)]
pub(super) struct Scenery {
    surface: bool,
    overlays: bool,
    runs: Vec<Range<u32>>,
    handles_for: Option<(Settings, Option<Target>, bool)>,
    edges_for: Option<(Level, Level, bool)>,
    tinted_for: Option<(Kind, Level, Level, Option<PublicId>, bool, bool)>,
    border: Vec<[u32; 2]>,
}

impl Scenery {
    /// Another surface or level is shown.
    pub(super) fn replace_surface(&mut self) {
        *self = Self { surface: true, overlays: true, ..Self::default() };
    }

    /// An edit moved these runs.
    pub(super) fn moved(&mut self, runs: Vec<Range<u32>>) {
        self.overlays |= !runs.is_empty();
        self.runs.extend(runs);
    }

    /// The mask changed.
    pub(super) fn masked(&mut self) {
        self.tinted_for = None;
    }

    /// Writes what changed. Cost: what changed; overlays are bounded in size.
    ///
    /// # Errors
    /// The adapter cannot hold the surface.
    pub(super) fn update(
        &mut self,
        renderer: &mut SurfaceRenderer,
        shown: &Shown<'_>,
        held: Option<Target>,
        dense: bool,
        edges: bool,
    ) -> Result<(), GpuError> {
        let Shown { document, settings, .. } = *shown;
        // While a stroke is previewed on a coarser level, the held vertex has another slot.
        let held = held.and_then(|t| document.target(t.kind, t.level, t.vertex));
        self.update_surface(renderer, document)?;
        self.update_edges(renderer, document, settings.level, settings.edges && edges)?;
        self.update_tints(renderer, shown)?;
        let key = (settings.clone(), held, dense);
        if self.overlays || self.handles_for.as_ref() != Some(&key) {
            renderer.set_handles(&handles(document, settings, held, dense))?;
            renderer.set_lines(&self.lines(document, settings, held))?;
            self.update_control(renderer, document, settings)?;
            self.handles_for = Some(key);
        }
        self.overlays = false;
        Ok(())
    }

    fn update_surface(
        &mut self,
        renderer: &mut SurfaceRenderer,
        document: &Document,
    ) -> Result<(), GpuError> {
        let vertices = document.vertices();
        if std::mem::take(&mut self.surface) {
            self.runs.clear();
            renderer.set_vertices(vertices.positions(), vertices.normals())?;
            let surface = document.surface();
            let mut triangles = surface.hierarchy().triangles(vertices.level());
            let hidden = HiddenFaces::of(surface, vertices.level());
            triangles.retain(|&triangle| !hidden.hides(triangle));
            renderer.set_triangles(&triangles)?;
        }
        for run in self.runs.drain(..) {
            let range = run.start as usize..run.end as usize;
            renderer.write_vertices(
                run.start,
                &vertices.positions()[range.clone()],
                &vertices.normals()[range],
            )?;
        }
        Ok(())
    }

    fn update_edges(
        &mut self,
        renderer: &mut SurfaceRenderer,
        document: &Document,
        level: Level,
        drawn: bool,
    ) -> Result<(), GpuError> {
        let shown = document.vertices().level();
        let key = (level.min(shown), shown, drawn);
        if self.edges_for != Some(key) {
            let hierarchy = document.surface().hierarchy();
            let mut edges = if drawn { hierarchy.edges_shown_on(key.0, shown) } else { Vec::new() };
            let hidden = HiddenFaces::of(document.surface(), shown);
            edges.retain(|&[a, b]| !hidden.hides([a, b]));
            renderer.set_edges(&edges)?;
            self.edges_for = Some(key);
        }
        Ok(())
    }

    fn update_tints(&mut self, renderer: &mut SurfaceRenderer, scene: &Shown<'_>) -> Result<(), GpuError> {
        let Shown { document, settings, painted } = *scene;
        let shown = document.vertices().level();
        let key = (
            settings.kind,
            settings.level,
            shown,
            settings.selected.filter(|_| settings.hand == Hand::Handle),
            settings.support,
            painted.is_some(),
        );
        if self.tinted_for == Some(key) {
            return Ok(());
        }
        renderer.clear_tints();
        self.border.clear();
        if let Some(tints) = painted {
            renderer.write_tints(0, tints)?;
        }
        if painted.is_none() {
            for (start, run) in consecutive(mask_tints(document)) {
                renderer.write_tints(start, &run)?;
            }
        }
        let handle = settings.hand == Hand::Handle;
        if let Some(id) = settings.selected.filter(|_| settings.support && handle)
            && let Some(influence) =
                Influence::of(document.surface(), settings.kind, settings.level, id, shown)
        {
            for (start, run) in consecutive(tints(&influence)) {
                renderer.write_tints(start, &run)?;
            }
            self.border = support_border(document.surface().hierarchy().layout(shown), &influence);
        }
        self.tinted_for = Some(key);
        self.overlays = true;
        Ok(())
    }

    /// The support's outline and the line from the held handle to its control point.
    fn lines(&self, document: &Document, settings: &Settings, held: Option<Target>) -> Vec<Line> {
        let positions = document.vertices().positions();
        let at = |slot: u32| positions[slot as usize];
        let outline =
            self.border.iter().map(|&[a, b]| Line { from: at(a), to: at(b), color: OUTLINE, width: 1.6 });
        let to_control = held.filter(|t| settings.control && t.kind == Kind::Scaling).map(|target| {
            let layout = document.surface().hierarchy().layout(target.level);
            let steps =
                document.surface().scaling(target.level)[layout.slot(layout.site_of(target.vertex)).index()];
            let to = document.vertices().frame().place_f32(steps);
            Line { from: at(target.slot.0), to, color: HELD_FILL, width: 1.6 }
        });
        outline.chain(to_control).collect()
    }

    fn update_control(
        &self,
        renderer: &mut SurfaceRenderer,
        document: &Document,
        settings: &Settings,
    ) -> Result<(), GpuError> {
        let hierarchy = document.surface().hierarchy();
        let level = settings.level;
        if !settings.control || hierarchy.layout(level).len() > MOST_CONTROL_VERTICES {
            return renderer.set_ghost(GhostMesh::default());
        }
        let frame = document.vertices().frame();
        let positions: Vec<[f32; 3]> =
            document.surface().scaling(level).iter().map(|&p| frame.place_f32(p)).collect();
        renderer.set_ghost(GhostMesh {
            positions: &positions,
            triangles: &hierarchy.triangles(level),
            edges: &hierarchy.edges(level),
        })
    }
}

/// Handles of all coefficients of the level, or where they would crowd, of those near the held one.
fn handles(document: &Document, settings: &Settings, held: Option<Target>, dense: bool) -> Vec<Handle> {
    let hierarchy = document.surface().hierarchy();
    let shown = document.vertices().level();
    let home = match settings.kind {
        Kind::Scaling => settings.level,
        Kind::Wavelet => settings.level.finer(),
    };
    if home > shown {
        return Vec::new();
    }
    let layout = hierarchy.layout(home);
    let belongs = |site| settings.kind == Kind::Scaling || Layout::coarsen(site).is_none();
    let slot_of = |site| hierarchy.refine_slot(home, shown, layout.slot(site));
    let mut slots: Vec<Slot> = Vec::new();
    if settings.handles && settings.hand == Hand::Handle {
        if !dense && layout.len() <= MOST_HANDLES {
            slots
                .extend((0..layout.len()).map(|s| layout.site(Slot(s))).filter(|&s| belongs(s)).map(slot_of));
        } else if let Some(target) = held {
            let near = layout.disc(&[layout.site_of(target.vertex)], 2);
            slots.extend(near.into_iter().filter(|&s| belongs(s)).map(slot_of));
        }
    }
    let selected = settings.selected.filter(|_| settings.hand == Hand::Handle);
    let selected = selected.and_then(|id| document.target(settings.kind, settings.level, id));
    let held = held.filter(|_| settings.hand == Hand::Handle);
    slots.extend(selected.iter().chain(&held).map(|t| t.slot));
    let hidden = HiddenFaces::of(document.surface(), shown);
    slots.retain(|slot| !hidden.hides([slot.0]));
    slots.sort_unstable();
    slots.dedup();
    let fill = if settings.kind == Kind::Scaling { HANDLE_FILL } else { WAVELET_FILL };
    slots
        .into_iter()
        .map(|slot| {
            let is = |target: Option<Target>| target.is_some_and(|t| t.slot == slot);
            let state = match (is(selected), is(held)) {
                (true, _) => HandleState::Selected,
                (_, true) => HandleState::Hovered,
                _ => HandleState::Idle,
            };
            Handle {
                position: document.vertices().positions()[slot.index()],
                radius: 4.0,
                fill: if state == HandleState::Idle { fill } else { HELD_FILL },
                rim: RIM,
                state,
            }
        })
        .collect()
}

/// Dark where the mask keeps the brushes off.
fn mask_tints(document: &Document) -> Vec<(Slot, [u8; 4])> {
    let surface = document.surface();
    if surface.mask().values().is_empty() {
        return Vec::new();
    }
    let (shown, hierarchy) = (document.vertices().level(), surface.hierarchy());
    let [r, g, b] = MASKED;
    (0..hierarchy.layout(shown).len())
        .map(Slot)
        .filter_map(|slot| {
            let value = surface.mask().value(hierarchy.refine_slot(shown, surface.finest(), slot));
            (value > 0).then(|| (slot, [r, g, b, (u16::from(value) * 3 / 4) as u8]))
        })
        .collect()
}

/// Joins sorted tints to runs.
fn consecutive(tints: Vec<(Slot, [u8; 4])>) -> Vec<(u32, Vec<[u8; 4]>)> {
    let mut runs: Vec<(u32, Vec<[u8; 4]>)> = Vec::new();
    for (slot, tint) in tints {
        match runs.last_mut() {
            Some((start, run)) if *start + run.len() as u32 == slot.0 => run.push(tint),
            _ => runs.push((slot.0, vec![tint])),
        }
    }
    runs
}
