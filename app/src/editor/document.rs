//! An open surface with what is shown of it.

use crate::display::{HiddenFaces, Hit, PickTree, ShownVertices};
use crate::render::{BoundingSphere, Ray};
use bozzetto_core::edit::{Kind, true_reach};
use bozzetto_core::hierarchy::{Address, Level, Odd, PublicId, Slot};
use bozzetto_core::session::{Session, SessionError};
use bozzetto_core::surface::{Changes, Surface};
use glam::DVec3;
use std::cell::OnceCell;
use std::ops::Range;

/// A session, the shown level's vertices and the tree for picking, kept in step.
#[derive(Debug)]
pub struct Document {
    /// The session.
    pub session: Session,
    vertices: ShownVertices,
    tree: PickTree,
    sphere: BoundingSphere,
    /// A coarser level shown in place of the chosen one while a long stroke lasts, or until a large
    /// step of the history is on all levels.
    preview: Option<ShownVertices>,
    spectrum: OnceCell<Vec<f64>>,
}

/// A step through the history.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HistoryStep {
    /// Back.
    Undo,
    /// Forth again.
    Redo,
}

/// A coefficient under the cursor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// Scaling or wavelet.
    pub kind: Kind,
    /// Its level.
    pub level: Level,
    /// Its id.
    pub vertex: PublicId,
    /// Its vertex at the shown level.
    pub slot: Slot,
    /// Where that is drawn.
    pub position: DVec3,
    /// The surface's normal there.
    pub normal: DVec3,
    /// How far the vertex moves for a unit of the coefficient.
    pub peak: f64,
}

impl Document {
    /// A document that shows a level.
    pub fn new(session: Session, shown: Level) -> Self {
        let vertices = ShownVertices::new(session.surface(), shown);
        let tree = PickTree::new(session.surface().hierarchy(), &vertices);
        let sphere = BoundingSphere::of(vertices.positions());
        Self { session, vertices, tree, sphere, preview: None, spectrum: OnceCell::new() }
    }

    /// The surface.
    pub fn surface(&self) -> &Surface {
        self.session.surface()
    }

    /// The shown vertices: those of the chosen level, or of a coarser one while a long stroke lasts.
    pub fn vertices(&self) -> &ShownVertices {
        self.preview.as_ref().unwrap_or(&self.vertices)
    }

    /// The level shown in place of the chosen one while a long stroke lasts.
    pub fn preview(&self) -> Option<Level> {
        self.preview.as_ref().map(ShownVertices::level)
    }

    /// Lets the stroke go on with a coarser level's vertices, samples of the surface, so that what is held stays under
    /// the cursor. The chosen level stands still at the stroke's beginning until its end.
    pub fn begin_preview(&mut self, level: Level) {
        let delta = self.session.stroke_delta().unwrap_or_default();
        if let (Ok(changes), None) = (self.session.drag_to([0.0; 3]), &self.preview) {
            self.follow(&changes);
        }
        self.preview = Some(ShownVertices::sampled(self.session.surface(), level, &self.vertices));
        self.session.preview_stroke(level);
        // A delta that was accepted before is accepted again.
        if let Ok(changes) = self.session.drag_to(delta) {
            self.follow(&changes);
        }
    }

    /// Shows what the next undo, or redo, will bring, on a coarser level, if the one chosen cannot follow at once: a sample of the
    /// surface there. Whether there is such a preview; the step itself, or [`Document::end_preview`], ends it.
    pub fn preview_step(&mut self, step: HistoryStep) -> bool {
        let shown_at_once = match step {
            HistoryStep::Undo => self.session.undo_shown_at_once(),
            HistoryStep::Redo => self.session.redo_shown_at_once(),
        };
        let Some(level) = shown_at_once.filter(|&level| level < self.vertices.level()) else { return false };
        self.preview = Some(ShownVertices::sampled(self.session.surface(), level, &self.vertices));
        let changes = match step {
            HistoryStep::Undo => self.session.preview_undo(level),
            HistoryStep::Redo => self.session.preview_redo(level),
        };
        self.follow(&changes);
        true
    }

    /// Lets the drag that has begun go on with what can follow the hand: where that is coarser than what is shown, as a
    /// preview. Whether there is one.
    pub fn preview_if_large(&mut self) -> bool {
        let Some(reach) = self.session.affordable_reach() else { return false };
        if reach < self.vertices.level() {
            self.begin_preview(reach);
            return true;
        }
        if reach < self.surface().finest() {
            // Nothing has moved yet, and what waits is not shown.
            self.session.preview_stroke(reach);
        }
        false
    }

    /// Moves the stroke under way, with the shown level where it is coarser than what is dragged.
    ///
    /// # Errors
    /// As [`Session::drag_to`].
    pub fn drag_to(&mut self, delta: [f64; 3]) -> Result<Changes, SessionError> {
        let mut changes = self.session.drag_to(delta)?;
        if self.session.stroke_home() > Some(self.vertices().level()) {
            changes.join(self.session.settle_stroke());
        }
        Ok(changes)
    }

    /// Shows another level as it is until the end: a coarser one, while finer ones wait, or the finer one that a brush moves.
    pub fn preview_level(&mut self, level: Level) {
        self.preview = Some(ShownVertices::new(self.session.surface(), level));
    }

    /// The energy of every level's detail. Linear in the surface, once after every change; while a brush is at work, that
    /// of the stroke's beginning.
    pub fn spectrum(&self) -> &[f64] {
        self.spectrum.get_or_init(|| self.session.surface().spectrum())
    }

    /// Shows the chosen level again; whether another was shown.
    pub fn end_preview(&mut self) -> bool {
        self.preview.take().is_some()
    }

    /// A ball around the model as it was when it was opened or last fitted.
    pub fn sphere(&self) -> BoundingSphere {
        self.sphere
    }

    /// Measures the ball anew. Linear in the shown vertices.
    pub fn measure(&mut self) {
        self.sphere = BoundingSphere::of(self.vertices.positions());
    }

    /// Shows another level. Linear in its vertices.
    pub fn show(&mut self, level: Level) {
        self.vertices = ShownVertices::new(self.session.surface(), level);
        self.tree = PickTree::new(self.session.surface().hierarchy(), &self.vertices);
    }

    /// Follows an edit; the runs of slots to upload. Cost: what it moved.
    pub fn follow(&mut self, changes: &Changes) -> Vec<Range<u32>> {
        if self.session.brush_words().is_none() {
            self.spectrum.take();
        }
        let Some(moved) = changes.moved.get(self.vertices().level().index()) else { return Vec::new() };
        let surface = self.session.surface();
        if let Some(preview) = &mut self.preview {
            return preview.follow(surface, moved);
        }
        let runs = self.vertices.follow(surface, moved);
        self.tree.follow(surface, &self.vertices, moved);
        runs
    }

    /// The shown surface under a ray.
    pub fn pick(&self, ray: &Ray) -> Option<Hit> {
        let surface = self.surface();
        let hidden = HiddenFaces::of(surface, self.vertices.level());
        self.tree.pick(surface.hierarchy(), &self.vertices, ray, &hidden)
    }

    /// The coefficient of a kind and level nearest to a hit.
    pub fn target_at(&self, hit: &Hit, kind: Kind, level: Level) -> Target {
        let hierarchy = self.surface().hierarchy();
        let vertex = match kind {
            Kind::Scaling => {
                let layout = hierarchy.layout(level);
                layout.public_id(layout.site(hit.nearest_vertex(hierarchy, level)))
            }
            Kind::Wavelet => self.surface().wavelet_id(level, hit.nearest_odd(hierarchy, level)),
        };
        self.target(kind, level, vertex).expect("picked coefficients exist")
    }

    /// The place under a hit as something to drag.
    pub fn place_at(&self, hit: &Hit) -> Target {
        let target = self.target_at(hit, Kind::Scaling, self.vertices().level());
        Target { position: hit.point, normal: self.normal_at(hit), peak: 1.0, ..target }
    }

    /// The surface's normal at a hit.
    pub fn normal_at(&self, hit: &Hit) -> DVec3 {
        let layout = self.surface().hierarchy().layout(self.vertices().level());
        let address = Address { face: hit.face, at: [hit.barycentric.y, hit.barycentric.z] };
        let normals = self.vertices().normals();
        let corners = address.corners(layout).into_iter();
        let sum: DVec3 = corners
            .map(|(site, w)| DVec3::from_array(normals[layout.slot(site).index()].map(f64::from)) * w)
            .sum();
        sum.normalize_or(DVec3::Z)
    }

    /// How far, in drawing space, a brush of a radius truly reaches round a hit on a level: further where the level's
    /// triangles are larger than the brush.
    pub fn true_reach(&self, hit: &Hit, level: Level, radius: f64) -> f64 {
        let address = Address { face: hit.face, at: [hit.barycentric.y, hit.barycentric.z] };
        let step = self.surface().form().placement.step;
        true_reach(self.surface(), level, address, radius / step) * step
    }

    /// A drawn place in model units.
    pub fn model_place(&self, drawn: DVec3) -> [f64; 3] {
        let origin = DVec3::from_array(self.surface().form().placement.origin);
        (origin + self.vertices().frame().turn_back(drawn)).to_array()
    }

    /// A coefficient by its id, if it exists and the shown level has its vertex.
    pub fn target(&self, kind: Kind, level: Level, vertex: PublicId) -> Option<Target> {
        let hierarchy = self.surface().hierarchy();
        let shown = self.vertices().level();
        let layout = hierarchy.layout(level);
        let (home, range) = match kind {
            Kind::Scaling => (level, 0..layout.len()),
            Kind::Wavelet if level < hierarchy.finest() => {
                (level.finer(), layout.len()..layout.len() + layout.odd_len())
            }
            Kind::Wavelet => return None,
        };
        if !range.contains(&vertex.0) || shown < home {
            return None;
        }
        let home_layout = hierarchy.layout(home);
        let slot = hierarchy.refine_slot(home, shown, home_layout.slot(home_layout.site_of(vertex)));
        let peak = match kind {
            Kind::Scaling => 1.0,
            Kind::Wavelet => self.surface().wavelet_peak(level, Odd(vertex.0 - layout.len())),
        };
        let at = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        Some(Target {
            kind,
            level,
            vertex,
            slot,
            position: at(self.vertices().positions()[slot.index()]),
            normal: at(self.vertices().normals()[slot.index()]),
            peak,
        })
    }

    /// The document's name for the title: the file's, or what it was made from.
    pub fn name(&self) -> String {
        let from_path =
            self.session.path().and_then(|p| p.file_name()).map(|n| n.to_string_lossy().into_owned());
        from_path.or_else(|| self.session.metadata().source.clone()).unwrap_or_else(|| "Untitled".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bozzetto_core::conversion::{ConversionOptions, convert};
    use bozzetto_core::disk::Disk;
    use bozzetto_core::edit::Move;
    use bozzetto_core::file::{Metadata, Model};
    use bozzetto_core::mesh::shapes;
    use bozzetto_core::surface::FormOptions;
    use std::sync::Arc;

    fn bumpy() -> Document {
        let mut mesh = shapes::subdivide(&shapes::octahedron(), 4);
        for (at, position) in mesh.positions.iter_mut().enumerate() {
            position[at % 3] += 0.02 * ((at * 37 % 19) as f64 - 9.0);
        }
        let converted = convert(&mesh, &ConversionOptions::default()).expect("subdivided");
        let surface =
            Surface::from_positions(converted.hierarchy, &converted.positions, &FormOptions::default());
        let model = Model::new(surface.expect("small"), None, Metadata::default());
        Document::new(Session::new(Arc::new(Disk), model), Level(4))
    }

    /// While a stroke is previewed, the coarse vertices lie where the whole surface will have them.
    #[test]
    fn a_preview_shows_samples_of_the_result() {
        for kind in [Kind::Scaling, Kind::Wavelet] {
            let mut document = bumpy();
            let vertex = if kind == Kind::Scaling { 5 } else { 25 };
            let edit = Move {
                kind,
                level: 1,
                vertex,
                delta: [0.0; 3],
                radius: None,
                falloff: None,
                mirror: None,
                v: 1,
            };
            document.session.begin_stroke(edit).expect("it exists");
            for (delta, preview) in [
                ([0.1, 0.0, 0.0], Some(Level(3))),
                ([0.1, 0.2, 0.0], Some(Level(2))),
                ([0.1, 0.2, -0.3], None),
            ] {
                let changes = document.session.drag_to(delta).expect("in range");
                document.follow(&changes);
                if let Some(level) = preview {
                    document.begin_preview(level);
                    assert_eq!(document.preview(), Some(level));
                }
            }
            let previewed = document.vertices().positions().to_vec();
            assert!(document.end_preview());
            let changes = document.session.end_stroke();
            document.follow(&changes);
            let hierarchy = document.surface().hierarchy().clone();
            for (slot, previewed) in previewed.iter().enumerate() {
                let fine = hierarchy.refine_slot(Level(2), Level(4), Slot(slot as u32));
                let now = document.vertices().positions()[fine.index()];
                let apart = (0..3).map(|c| (now[c] - previewed[c]).abs()).fold(0.0, f32::max);
                assert!(apart < 1e-5, "{kind}, slot {slot}: {now:?}, previewed {previewed:?}");
            }
            let fresh = ShownVertices::new(document.surface(), Level(4));
            assert!(
                document.vertices().positions() == fresh.positions(),
                "{kind}: the shown level is up to date"
            );
        }
    }
}
