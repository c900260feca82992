//! The editor's window.
//!
//! A frame: take back finished work, turn keys into commands, let the panels and the picture show themselves and
//! return commands, carry the commands out in one place, bring the renderer's buffers up to date. The window repaints
//! only when something happens. The UI thread owns the session, except while a worker has it.

mod choices;
mod chooser;
pub mod command;
mod cursor;
mod dialog;
mod document;
mod equalising;
mod execute;
mod importing;
mod labels;
mod panels;
mod pens;
mod preview;
mod scenery;
mod settings;
mod shortcuts;
mod start;
mod stroking;
mod theme;
mod tools;
mod viewport;
mod worker;

pub use choices::{ImportChoices, ImportFrom};
pub use chooser::{FileChooser, Purpose, SystemChooser};
pub use document::{Document, HistoryStep, Target};
pub use preview::{Facts, Preview, PreviewView};
pub use settings::{Hand, Navigation, Settings};
pub use start::{Start, run};
pub use tools::{PenEvent, PenInput, RecordedPen, TouchPen};

use crate::render::{Camera, GpuError, Samples, Style, Viewport};
use bozzetto_core::hierarchy::Level;
use command::Command;
use dialog::Dialog;
use egui::Rect;
use importing::ReadMesh;
use panels::{Banner, Seen};
use scenery::{Scenery, Shown};
use std::collections::VecDeque;
use std::path::Path;
use stroking::Trace;
use tools::{BrushTool, HandleTool};
use viewport::{Picture, Turning};
use worker::Work;

/// Room for tools on the left, in points.
const STRIP_WIDTH: f32 = 44.0;
/// Room for the inspector on the right, in points.
const INSPECTOR_WIDTH: f32 = 268.0;
/// Height of the status bar, in points.
const STATUS_HEIGHT: f32 = 28.0;
/// Handles closer than this on the picture, in points, show only near the cursor.
const CROWDED: f64 = 12.0;
/// Edges of a level whose vertices are so far apart, in points, are not drawn at all, and drawn in full.
const FADING_EDGES: [f64; 2] = [5.0, 16.0];

/// So many undos and redos wait while a worker has the session: a key held down must not go on for long after.
const MOST_WAITING: usize = 8;

/// The program behind the window.
pub struct Editor {
    document: Option<Document>,
    settings: Settings,
    camera: Camera,
    tool: HandleTool,
    brush: BrushTool,
    /// Where the brush is that trails behind the cursor.
    trailing: Option<glam::DVec2>,
    /// Where copied detail comes from, in model units.
    copy_from: Option<[f64; 3]>,
    last_stroke: Option<Trace>,
    pen: Box<dyn PenInput>,
    turning: Option<Turning>,
    viewport: Viewport,
    scenery: Scenery,
    dialog: Option<Dialog>,
    banner: Option<Banner>,
    work: Option<Work>,
    /// Undos and redos asked for while a worker has the session.
    waiting: VecDeque<Command>,
    /// The choices of the conversion under way.
    choosing: Option<ImportChoices>,
    /// A mesh that was read, while its import is being chosen.
    read: Option<ReadMesh>,
    /// What was converted and not opened yet.
    preview: Option<Preview>,
    chooser: Box<dyn FileChooser>,
    picture: Rect,
    /// The camera is to be fitted once the picture's size is known.
    refit: bool,
    leaving: bool,
    /// The window was to close while a worker had the session.
    closing: bool,
    title: String,
}

impl Editor {
    /// An editor in a window, with the way to choose files and what to begin with.
    ///
    /// # Errors
    /// The adapter cannot draw surfaces.
    ///
    /// # Panics
    /// If eframe was not set up with wgpu.
    pub fn new(
        cc: &eframe::CreationContext<'_>,
        samples: Samples,
        chooser: Box<dyn FileChooser>,
        start: Start,
    ) -> Result<Self, GpuError> {
        let state = cc.wgpu_render_state.as_ref().expect("the window draws with wgpu");
        let mut editor = Self::over(&cc.egui_ctx, state, samples, chooser, start)?;
        editor.find_tablet(cc);
        Ok(editor)
    }

    /// An editor in whatever draws egui.
    ///
    /// # Errors
    /// The adapter cannot draw surfaces.
    pub(crate) fn over(
        context: &egui::Context,
        state: &egui_wgpu::RenderState,
        samples: Samples,
        chooser: Box<dyn FileChooser>,
        start: Start,
    ) -> Result<Self, GpuError> {
        theme::apply(context);
        let mut editor = Self {
            document: None,
            settings: Settings::default(),
            camera: Camera::default(),
            tool: HandleTool::default(),
            brush: BrushTool::default(),
            trailing: None,
            copy_from: None,
            last_stroke: None,
            pen: Box::new(TouchPen::default()),
            turning: None,
            viewport: Viewport::new(state, samples)?,
            scenery: Scenery::default(),
            dialog: None,
            banner: None,
            work: None,
            waiting: VecDeque::new(),
            choosing: None,
            read: None,
            preview: None,
            chooser,
            picture: Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(924.0, 772.0)),
            refit: false,
            leaving: false,
            closing: false,
            title: String::new(),
        };
        match start {
            Start::Empty => {}
            Start::Session(session) => editor.show(*session, Vec::new()),
            Start::File(path) => editor.open(context, path),
        }
        Ok(editor)
    }

    /// The open surface; `None` while there is none or a worker has it.
    pub fn document(&self) -> Option<&Document> {
        self.document.as_ref()
    }

    /// What was converted and not opened yet.
    pub fn preview(&self) -> Option<&Preview> {
        self.preview.as_ref()
    }

    /// Takes pressure from another pen.
    pub fn set_pen(&mut self, pen: Box<dyn PenInput>) {
        self.pen = pen;
    }

    /// The choices.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Where the surface is looked at from.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Where the picture lies in the window, in points.
    pub fn picture(&self) -> Rect {
        self.picture
    }

    /// The message shown, and whether it is about a failure.
    pub fn message(&self) -> Option<(&str, bool)> {
        self.banner.as_ref().map(|b| (b.text.as_str(), b.failed))
    }

    /// Takes the message away.
    pub(crate) fn dismiss_message(&mut self) {
        self.banner = None;
    }

    /// Whether work is under way.
    pub fn is_working(&self) -> bool {
        self.work.is_some()
    }

    /// Whether a tool's drag or stroke is under way.
    fn is_dragging(&self) -> bool {
        self.tool.drag().is_some() || self.brush.is_stroking()
    }

    fn hint(&self) -> String {
        match self.settings.hand {
            Hand::Handle | Hand::Grab if !self.brush.is_choosing() => self.tool.hint(),
            _ => self.brush.hint(&self.settings),
        }
    }

    fn panels(&mut self, ui: &mut egui::Ui) -> Vec<Command> {
        let mut commands = Vec::new();
        let seen = Seen {
            document: self.document.as_ref(),
            settings: &self.settings,
            hint: match &self.preview {
                Some(preview) => preview.hint(),
                None => self.hint(),
            },
            work: self.work.as_ref(),
            dialog: self.dialog.as_ref(),
            preview: self.preview.as_ref(),
        };
        let frame = egui::Frame::NONE.fill(ui.visuals().panel_fill);
        egui::Panel::bottom("status")
            .exact_size(STATUS_HEIGHT)
            .frame(frame.inner_margin(egui::Margin::symmetric(12, 0)))
            .show(ui, |ui| commands.extend(panels::status(ui, &seen)));
        egui::Panel::left("strip")
            .resizable(false)
            .exact_size(STRIP_WIDTH)
            .frame(frame.inner_margin(egui::Margin::symmetric(2, 0)))
            .show(ui, |ui| commands.extend(panels::strip(ui, &seen)));
        egui::Panel::left("tools")
            .resizable(false)
            .exact_size(STRIP_WIDTH)
            .frame(frame.inner_margin(egui::Margin::symmetric(2, 0)))
            .show(ui, |ui| commands.extend(panels::toolbar(ui, &seen)));
        let inspector = seen.settings.inspector || seen.preview.is_some();
        if inspector {
            egui::Panel::right("inspector")
                .resizable(false)
                .exact_size(INSPECTOR_WIDTH)
                .frame(frame.inner_margin(egui::Margin::symmetric(12, 4)))
                .show(ui, |ui| {
                    egui::ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
                        commands.extend(match seen.preview {
                            Some(preview) => panels::preview(ui, preview),
                            None => panels::inspector(ui, &seen),
                        });
                    });
                });
        }
        commands.extend(panels::dialogs(ui.ctx(), &seen));
        commands.extend(panels::banner(ui.ctx(), self.picture, self.banner.as_ref()));
        commands
    }

    fn show_picture(&mut self, ui: &mut egui::Ui) -> Vec<Command> {
        let (document, settings) = match &self.preview {
            Some(preview) => (Some(preview.document()), preview.settings()),
            None => (self.document.as_ref(), &self.settings),
        };
        let closed = document.is_some_and(|d| d.surface().hierarchy().base().boundary_loops() == 0);
        let painted = self.preview.as_ref().is_some_and(|p| p.painted().is_some());
        let cavity = if painted { 0.0 } else { Style::default().cavity };
        let mut style = Style { shading: settings.shading, two_sided: !closed, cavity, ..Style::default() };
        let clear = document.map_or(1.0, |d| self.edges_clarity(d, settings));
        let [r, g, b, opacity] = style.edges.color;
        style.edges.color = [r, g, b, (f64::from(opacity) * clear).round() as u8];
        // A surface with hidden parts is open.
        style.two_sided |= document.is_some_and(|d| !d.surface().mask().hidden().is_empty());
        let picture = Picture {
            // A preview is only looked at: without a document there is nothing to take hold of.
            document: self.document.as_ref().filter(|_| self.preview.is_none()),
            settings: &self.settings,
            camera: &self.camera,
            tool: &mut self.tool,
            brush: &mut self.brush,
            trailing: &mut self.trailing,
            copy_from: &mut self.copy_from,
            pen: &mut *self.pen,
            turning: &mut self.turning,
            viewport: &self.viewport,
            style,
            listening: self.dialog.is_none() && self.work.is_none(),
        };
        let (rect, commands) = viewport::picture(ui, picture);
        self.picture = rect;
        commands
    }

    /// How far apart, in points, a level's vertices are in the picture: a ball's area shared out among them.
    fn spacing(&self, document: &Document, level: Level) -> f64 {
        let vertices = f64::from(document.surface().hierarchy().layout(level).len());
        let size = self.picture_size();
        let per_point = self.camera.world_per_pixel_at(document.sphere().center, size).max(1e-12);
        document.sphere().radius * (4.0 * std::f64::consts::PI / vertices).sqrt() / per_point
    }

    /// How clearly the edited level's edges are drawn, 0 to 1: where they are dense they would hide the form.
    fn edges_clarity(&self, document: &Document, settings: &Settings) -> f64 {
        let [from, to] = FADING_EDGES;
        ((self.spacing(document, settings.level) - from) / (to - from)).clamp(0.0, 1.0)
    }

    /// Brings the renderer's buffers up to date.
    fn update_scenery(&mut self) {
        let shown = match (&self.preview, &self.document) {
            (Some(preview), _) => Shown {
                document: preview.document(),
                settings: preview.settings(),
                painted: preview.painted(),
            },
            (None, Some(document)) => Shown { document, settings: &self.settings, painted: None },
            (None, None) => return,
        };
        let document = shown.document;
        let held = self.tool.target();
        let level = shown.settings.level;
        let spacing = self.spacing(document, level);
        let edges = self.edges_clarity(document, shown.settings) > 0.0;
        let mut renderer = self.viewport.renderer();
        let updated = self.scenery.update(&mut renderer, &shown, held, spacing < CROWDED, edges);
        drop(renderer);
        if let Err(error) = updated {
            self.fail(error.to_string());
        }
    }

    fn take_chosen_file(&mut self) {
        if let Some(Some(chosen)) = self.chooser.answer()
            && let Some((path, _)) = self.dialog.as_mut().and_then(Dialog::path_field)
        {
            *path = chosen.to_string_lossy().into_owned();
        }
    }

    /// Whether nothing stands in the way of opening something.
    fn is_free(&self) -> bool {
        self.dialog.is_none() && self.work.is_none() && self.preview.is_none()
    }

    /// A file let go over the window is opened.
    fn dropped_file(&self, ctx: &egui::Context) -> Option<Command> {
        let dropped = ctx.input(|i| i.raw.dropped_files.first().map(|file| file.path().to_owned()));
        dropped.filter(|_| self.is_free()).map(Command::Open)
    }

    fn update_title(&mut self, ctx: &egui::Context) {
        let title = match (&self.preview, &self.document) {
            (Some(preview), _) => format!("Preview of {} – Bozzetto", preview.name()),
            (None, Some(document)) => format!("{} – Bozzetto", document.name()),
            (None, None) if self.work.is_some() => return,
            (None, None) => "Bozzetto".to_owned(),
        };
        if title != self.title {
            ctx.send_viewport_cmd(egui::ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }
}

impl Editor {
    /// One frame.
    pub(crate) fn frame(&mut self, ui: &mut egui::Ui) {
        let ctx = ui.ctx().clone();
        self.take_outcome();
        self.take_chosen_file();
        let mut commands = Vec::new();
        if self.dialog.is_none() {
            let keys = shortcuts::shortcuts(&ctx, &self.settings, self.is_dragging()).into_iter();
            match &self.work {
                None => {
                    commands.extend(self.waiting.pop_front());
                    commands.extend(keys.filter(|key| self.preview.is_none() || key.only_looks()));
                }
                Some(work) if work.holds_session => {
                    let room = MOST_WAITING - self.waiting.len();
                    self.waiting.extend(keys.filter(Command::goes_through_history).take(room));
                }
                Some(_) => {}
            }
        }
        commands.extend(self.dropped_file(&ctx));
        commands.extend(self.panels(ui));
        commands.extend(egui::CentralPanel::no_frame().show(ui, |ui| self.show_picture(ui)).inner);
        if std::mem::take(&mut self.refit) {
            commands.push(Command::Fit);
        }
        if ctx.input(|i| i.viewport().close_requested()) && !self.leaving {
            ctx.send_viewport_cmd(egui::ViewportCommand::CancelClose);
            commands.push(Command::Quit);
        }
        if self.work.is_none() && std::mem::take(&mut self.closing) {
            commands.push(Command::Quit);
        }
        if !commands.is_empty() {
            // Panels drawn above show the state before; show the one after.
            ctx.request_repaint();
        }
        for command in commands {
            self.execute(&ctx, command);
        }
        if self.work.is_some() {
            ctx.request_repaint_after(std::time::Duration::from_millis(100));
        }
        self.update_scenery();
        self.update_title(&ctx);
        if let Some(failure) = self.viewport.take_failure() {
            self.fail(failure.to_string());
        }
    }
}

impl eframe::App for Editor {
    fn raw_input_hook(&mut self, ctx: &egui::Context, raw_input: &mut egui::RawInput) {
        self.pen_strokes(ctx, raw_input);
    }

    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        self.frame(ui);
    }
}

/// A file's name without its folder, for people.
fn shown_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}
