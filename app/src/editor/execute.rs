//! The one place where commands are carried out.

use super::Editor;
use super::command::Command;
use super::dialog::{Dialog, PathTask};
use super::document::{Document, HistoryStep};
use super::panels::Banner;
use super::preview::Preview;
use super::shown_name;
use super::viewport::orbit_angles;
use super::worker::{Done, Outcome, Returned, Work};
use crate::render::BoundingSphere;
use bozzetto_core::disk::{Disk, Vfs};
use bozzetto_core::edit::{Edit, EditError, Kind};
use bozzetto_core::file::{is_wavelet_file, mend_of};
use bozzetto_core::hierarchy::Level;
use bozzetto_core::io::{MeshFormat, write_mesh};
use bozzetto_core::session::{OpenOptions, Opened, Session};
use bozzetto_core::surface::{Changes, Moved};
use glam::DVec2;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

/// Surfaces with more vertices do whole-level work away from the window.
const LONG_WORK: usize = 100_000;
/// Steps of the history that move no more vertices of such a surface are done in the window: some 10 ms.
const QUICK_STEP: u64 = 1 << 17;

impl Editor {
    /// Carries out a command.
    pub(super) fn execute(&mut self, ctx: &egui::Context, command: Command) {
        if !command.leaves_equaliser() {
            self.end_equaliser();
        }
        match command {
            Command::Ask(dialog) => self.dialog = Some(dialog),
            Command::CloseDialog => self.dialog = None,
            Command::Browse => {
                if let Some((_, purpose)) = self.dialog.as_mut().and_then(Dialog::path_field) {
                    self.chooser.ask(purpose, ctx);
                }
            }
            Command::Open(_) | Command::CommitImport if self.would_lose_edits() => {
                self.dialog = Some(Dialog::Losing(Box::new(command)));
            }
            Command::Open(path) => self.open(ctx, path),
            Command::CommitImport => self.commit_import(),
            Command::Anyway(command) => {
                self.dialog = None;
                match *command {
                    Command::Open(path) => self.open(ctx, path),
                    Command::CommitImport => self.commit_import(),
                    other => self.execute(ctx, other),
                }
            }
            Command::AskRemesh => self.ask_how_to_remesh(),
            Command::Convert(choices) => self.convert(ctx, *choices),
            Command::LookAt(view) => self.look_at(view),
            Command::ChangeImport => self.change_import(),
            Command::CancelImport => self.cancel_import(),
            Command::Save => self.save(),
            Command::SaveAs(path) => self.save_as(ctx, path),
            Command::SaveCopy(path) => self.save_copy(ctx, path),
            Command::Export(path, level) => self.export(ctx, path, level),
            Command::Quit => self.quit(ctx),
            Command::QuitKeeping => self.leave(ctx, Leaving::Keeping),
            Command::QuitDiscarding => self.leave(ctx, Leaving::Discarding),
            Command::CancelWork => self.cancel_work(),
            Command::DismissBanner => self.banner = None,
            Command::Edit(edit) => self.edit(ctx, edit),
            Command::Undo => self.step(ctx, HistoryStep::Undo),
            Command::Redo => self.step(ctx, HistoryStep::Redo),
            Command::GoTo(steps) => {
                let title = "Going through the history".to_owned();
                self.on_session(ctx, title, self.is_large(), move |session| Ok(session.go_to(steps)));
            }
            Command::BeginStroke { .. }
            | Command::BeginGrab(_)
            | Command::BeginBrush(..)
            | Command::Dab(..)
            | Command::DragTo(_)
            | Command::EndStroke
            | Command::CancelStroke => self.stroke(ctx, command),
            Command::SetGain(..) | Command::SetOver(_) | Command::EndEqualiser | Command::CancelEqualiser => {
                self.equalise(&command)
            }
            Command::Take(_)
            | Command::SetBrushRadius(_)
            | Command::SetStrength(_)
            | Command::ToggleSymmetry(_)
            | Command::SetSpread(_)
            | Command::ToggleFollow
            | Command::SetEraseTo(_)
            | Command::ToggleAutoLevel
            | Command::SetSteady(_)
            | Command::TogglePressure(_)
            | Command::SetNavigation(_)
            | Command::ToggleInspector => self.equip(&command),
            Command::ClearMask => self.clear_mask(ctx),
            Command::FrameStroke => self.frame_stroke(),
            Command::SetKind(_) | Command::SetLevel(_) | Command::SetShown(_) => self.choose_level(&command),
            Command::SetRadius(radius) => self.settings.radius = radius,
            Command::SetFalloff(falloff) => self.settings.falloff = falloff,
            Command::Select(vertex) => self.settings.selected = vertex,
            Command::SetShading(shading) => self.settings.shading = shading,
            Command::Toggle(overlay) => self.settings.toggle(overlay),
            Command::Look(_) | Command::Fit | Command::Orbit(_) | Command::Pan(_) | Command::Zoom(..) => {
                self.look(&command);
            }
        }
    }

    fn look(&mut self, command: &Command) {
        let size = self.picture_size();
        let aspect = size.x / size.y.max(1.0);
        match *command {
            Command::Look(view) => {
                let sphere = BoundingSphere { center: self.camera.target, radius: 1.0 };
                let turned = view.camera(sphere, aspect);
                (self.camera.yaw, self.camera.pitch) = (turned.yaw, turned.pitch);
            }
            Command::Fit => {
                let previewed = self.preview.as_mut().map(Preview::document_mut);
                if let Some(document) = previewed.or(self.document.as_mut()) {
                    document.measure();
                    self.camera.fit(document.sphere(), aspect);
                }
            }
            Command::Orbit(points) => {
                let angles = orbit_angles(points);
                self.camera.orbit(angles.x, angles.y);
            }
            Command::Pan(points) => self.camera.pan(points, size),
            Command::Zoom(factor, at) => self.camera.zoom_at(factor, at, size),
            _ => {}
        }
    }

    pub(super) fn choose_level(&mut self, command: &Command) {
        let Some(document) = &mut self.document else { return };
        let finest = document.surface().finest();
        let before = (self.settings.kind, self.settings.level);
        match *command {
            Command::SetKind(kind) => self.settings.kind = kind,
            Command::SetLevel(level) => self.settings.level = Level(level),
            Command::SetShown(level) => {
                self.settings.shown = Level(level);
                // A coarser picture than the edited level makes the edited level give way, not the picture.
                let edited =
                    if self.settings.kind == Kind::Wavelet { level.saturating_sub(1) } else { level };
                self.settings.level = self.settings.level.min(Level(edited));
            }
            _ => {}
        }
        let note = self.settings.settle(finest);
        if let Some(text) = note {
            self.banner = Some(Banner { text, failed: false });
        }
        if before != (self.settings.kind, self.settings.level) {
            self.settings.selected = None;
        }
        if document.vertices().level() != self.settings.shown {
            document.show(self.settings.shown);
            self.scenery.replace_surface();
        }
    }

    // ---- edits ------------------------------------------------------------------------------------------

    pub(super) fn edit(&mut self, ctx: &egui::Context, edit: Edit) {
        self.on_session(ctx, edit.to_string(), self.is_large(), move |session| {
            session.edit(edit).map(Some).map_err(|e| e.to_string())
        });
    }

    /// Undoes or redoes a step: here if it is small, else first on a level that can show it at once, and on all levels away from
    /// the window.
    fn step(&mut self, ctx: &egui::Context, step: HistoryStep) {
        self.let_go();
        let Some(document) = &mut self.document else { return };
        let (moves, title) = match step {
            HistoryStep::Undo => (document.session.undo_moves(), "Undoing"),
            HistoryStep::Redo => (document.session.redo_moves(), "Redoing"),
        };
        let Some(moves) = moves else { return };
        let away = moves > QUICK_STEP;
        let mut title = title.to_owned();
        if away && document.preview_step(step) {
            if let Some(level) = document.preview() {
                title += &format!("; level {level} is shown until all levels have followed");
            }
            self.scenery.replace_surface();
            self.update_scenery();
        }
        self.on_session(ctx, title, away, move |session| {
            Ok(match step {
                HistoryStep::Undo => session.undo(),
                HistoryStep::Redo => session.redo(),
            })
        });
    }

    fn is_large(&self) -> bool {
        let vertices = |d: &Document| d.surface().scaling(d.surface().finest()).len();
        self.document.as_ref().is_some_and(|document| vertices(document) > LONG_WORK)
    }

    /// Does work on the session here, or away from the window.
    fn on_session(
        &mut self,
        ctx: &egui::Context,
        title: String,
        away: bool,
        work: impl FnOnce(&mut Session) -> Result<Option<Changes>, String> + Send + 'static,
    ) {
        self.let_go();
        let Some(document) = &mut self.document else { return };
        if away {
            self.send_session(ctx, title, move |session| work(session).map(Done::Changed));
            return;
        }
        match work(&mut document.session) {
            Ok(Some(changes)) => self.follow(&changes),
            Ok(None) => {}
            Err(sentence) => self.fail(sentence),
        }
    }

    /// Moves the session to a worker; it comes back with the outcome. The picture stays.
    pub(super) fn send_session(
        &mut self,
        ctx: &egui::Context,
        title: String,
        work: impl FnOnce(&mut Session) -> Result<Done, String> + Send + 'static,
    ) {
        if let Some(document) = self.document.take() {
            self.work = Some(Work::on_session(ctx.clone(), title, document, work));
        }
    }

    pub(super) fn follow(&mut self, changes: &Changes) {
        if changes.reshaped {
            self.follow_levels();
        } else if changes.hidden {
            self.scenery.replace_surface();
        }
        let runs = self.document.as_mut().map(|document| document.follow(changes));
        self.followed(changes, runs.unwrap_or_default());
    }

    /// What is shown has followed an edit.
    fn followed(&mut self, changes: &Changes, runs: Vec<Range<u32>>) {
        if let Some(document) = &self.document {
            self.scenery.moved(runs);
            if changes.masked != Moved::Nothing {
                self.scenery.masked();
            }
            if let Some(failure) = document.session.journal_failure() {
                self.fail(format!("Edits no longer reach the log ({failure}); save under another name"));
            }
        }
    }

    /// Begins anew with what is shown: the surface has other levels.
    fn follow_levels(&mut self) {
        let Some(Document { session, .. }) = self.document.take() else { return };
        let note = self.settings.for_levels(session.surface().finest());
        if let Some(text) = note {
            self.banner = Some(Banner { text, failed: false });
        }
        self.document = Some(Document::new(session, self.settings.shown));
        self.scenery.replace_surface();
        self.tool = Default::default();
        self.brush = Default::default();
    }

    // ---- documents ----------------------------------------------------------------------------------------

    pub(super) fn open(&mut self, ctx: &egui::Context, path: PathBuf) {
        if !is_wavelet_file(&path) {
            self.open_mesh(ctx, path);
            return;
        }
        if self.document.as_ref().is_some_and(|d| d.session.path() == Some(&path)) {
            return;
        }
        self.work =
            Some(Work::opening(ctx.clone(), format!("Opening {}", shown_name(&path)), move |share| {
                let report = |done| share.report(done);
                let opened = Session::open(Arc::new(Disk), &path, OpenOptions::default(), &report);
                opened
                    .map(|Opened { session, notes }| Outcome::Opened(Box::new(session), notes))
                    .map_err(|e| e.to_string())
            }));
    }

    fn save(&mut self) {
        let Some(document) = &mut self.document else { return };
        if document.session.path().is_none() {
            self.dialog = Some(PathTask::SaveAs.dialog());
            return;
        }
        if let Err(error) = document.session.save() {
            self.fail(error.to_string());
        }
    }

    fn save_as(&mut self, ctx: &egui::Context, path: PathBuf) {
        self.let_go();
        let title = format!("Saving {}", shown_name(&path));
        self.send_session(ctx, title, move |session| {
            session.save_as(&path).map_err(|e| e.to_string())?;
            Ok(Done::Wrote(format!("Saved as {}", session.path().unwrap_or(&path).display())))
        });
    }

    fn save_copy(&mut self, ctx: &egui::Context, path: PathBuf) {
        self.let_go();
        let title = format!("Writing {}", shown_name(&path));
        self.send_session(ctx, title, move |session| {
            let path = if is_wavelet_file(&path) { path } else { path.with_added_extension("boz") };
            session.save_copy(&path).map_err(|e| e.to_string())?;
            Ok(Done::Wrote(format!("A copy is in {}", path.display())))
        });
    }

    fn export(&mut self, ctx: &egui::Context, path: PathBuf, level: u8) {
        self.let_go();
        let title = format!("Writing {}", shown_name(&path));
        self.send_session(ctx, title, move |session| {
            let format = MeshFormat::from_path(&path).ok_or_else(|| {
                format!("{}: the format is not known; use .obj, .ply, .stl, .glb or .off", path.display())
            })?;
            let mut bytes = Vec::new();
            let surface = session.surface();
            let mesh = surface.to_mesh(Level(level).min(surface.finest()));
            write_mesh(&mesh, format, &mut bytes).map_err(|e| format!("{}: {e}", path.display()))?;
            Disk.replace(&path, &bytes).map_err(|e| format!("{}: {e}; {}", path.display(), mend_of(&e)))?;
            Ok(Done::Wrote(format!("Level {level} is in {}", path.display())))
        });
    }

    /// Whether the open surface has edits and no file that keeps them.
    fn would_lose_edits(&self) -> bool {
        let session = self.document.as_ref().map(|d| &d.session);
        session.is_some_and(|s| s.journal_failure().is_some() || s.path().is_none() && s.history_len() > 0)
    }

    /// Shows a surface just opened, in place of the one that was.
    pub(super) fn show(&mut self, session: Session, mut notes: Vec<String>) {
        if let Some(before) = self.document.take()
            && let Err(failure) = before.session.close()
        {
            notes.push(format!("The log of the surface closed is not on disk: {failure}"));
        }
        self.settings.for_surface(session.surface().finest());
        let document = Document::new(session, self.settings.shown);
        let size = self.picture_size();
        let view = crate::render::View::default();
        self.camera = view.camera(document.sphere(), size.x / size.y.max(1.0));
        self.refit = true;
        self.document = Some(document);
        self.scenery.replace_surface();
        self.tool = Default::default();
        self.brush = Default::default();
        self.last_stroke = None;
        // A place on the surface that was.
        self.copy_from = None;
        self.banner = (!notes.is_empty()).then(|| Banner { text: notes.join("\n"), failed: false });
    }

    /// Takes back what work came back with.
    pub(super) fn take_outcome(&mut self) {
        let Some(outcome) = self.work.as_ref().and_then(Work::poll) else { return };
        self.work = None;
        match outcome {
            Outcome::Opened(session, notes) => self.show(*session, notes),
            Outcome::Read { path, source } => self.ask_how_to_import(path, source),
            Outcome::Converted(converted) => self.show_preview(*converted),
            Outcome::Failed(sentence) => {
                self.back_to_choices();
                self.fail(sentence);
            }
            Outcome::Returned(returned) => self.take_document(*returned),
        }
    }

    /// Takes back a document, and goes on with what was done.
    fn take_document(&mut self, returned: Returned) {
        let Returned { mut document, done, previewed, runs } = returned;
        if done.is_err() {
            // Whatever went wrong may have changed something.
            document.show(self.settings.shown);
            self.waiting.clear();
        }
        if previewed || done.is_err() {
            self.scenery.replace_surface();
        }
        self.document = Some(document);
        match done {
            Ok(Done::Changed(Some(changes))) => {
                if changes.reshaped {
                    self.follow(&changes);
                } else {
                    if changes.hidden {
                        self.scenery.replace_surface();
                    }
                    self.followed(&changes, runs);
                }
                if changes.beyond_limit {
                    self.fail(EditError::BeyondLimit.to_string());
                }
            }
            Ok(Done::Changed(None)) => {}
            Ok(Done::Wrote(text)) => self.banner = Some(Banner { text, failed: false }),
            Err(sentence) => self.fail(sentence),
        }
    }

    fn cancel_work(&mut self) {
        if let Some(work) = &self.work {
            work.cancel();
            if !work.holds_session {
                self.work = None;
                self.back_to_choices();
            }
        }
    }

    // ---- closing ------------------------------------------------------------------------------------------

    fn quit(&mut self, ctx: &egui::Context) {
        if self.work.as_ref().is_some_and(|work| work.holds_session) {
            // The edits are with the worker, and perhaps half a file.
            self.closing = true;
            return;
        }
        let unsaved = |d: &Document| d.session.path().is_some() && d.session.is_unsaved();
        if self.would_lose_edits() || self.document.as_ref().is_some_and(unsaved) {
            self.dialog = Some(Dialog::Closing);
        } else {
            self.leave(ctx, Leaving::Keeping);
        }
    }

    fn leave(&mut self, ctx: &egui::Context, leaving: Leaving) {
        self.dialog = None;
        self.leaving = true;
        if let Some(document) = self.document.take() {
            let closed = match leaving {
                Leaving::Discarding => document.session.discard(),
                Leaving::Keeping => document.session.close(),
            };
            if let Err(failure) = closed {
                tracing::error!("the log is not on disk: {failure}");
            }
        }
        ctx.send_viewport_cmd(egui::ViewportCommand::Close);
    }

    pub(super) fn fail(&mut self, text: String) {
        self.banner = Some(Banner { text, failed: true });
    }

    pub(super) fn picture_size(&self) -> DVec2 {
        let size = self.picture.size();
        DVec2::new(f64::from(size.x.max(1.0)), f64::from(size.y.max(1.0)))
    }
}

#[derive(Clone, Copy)]
enum Leaving {
    Keeping,
    Discarding,
}
