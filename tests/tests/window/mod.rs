//! The window in tests: an editor on the software GPU, driven through its widgets.
//!
//! Every test file is a program of its own and uses its part of this.
#![allow(dead_code, unreachable_pub)]

use bozzetto::editor::{Editor, FileChooser, Purpose, Start};
use bozzetto::render::{Gpu, GpuError, Samples};
use bozzetto_core::conversion::{ConversionOptions, convert};
use bozzetto_core::disk::Disk;
use bozzetto_core::edit::Edit;
use bozzetto_core::file::{Metadata, Model};
use bozzetto_core::mesh::shapes;
use bozzetto_core::session::Session;
use bozzetto_core::surface::{FormOptions, Surface, SurfaceHash};
use eframe::egui::{self, Event, Key, Modifiers, PointerButton, Pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use image::RgbaImage;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A machine without the system's file dialog.
struct NoChooser;

impl FileChooser for NoChooser {
    fn ask(&mut self, _: Purpose, _: &egui::Context) {}

    fn answer(&mut self) -> Option<Option<PathBuf>> {
        None
    }
}

/// Whether there is an adapter to draw with; says loudly if not.
pub fn can_draw() -> bool {
    match Gpu::headless() {
        Ok(_) => true,
        Err(GpuError::NoAdapter(why)) => {
            eprintln!(
                "\n*** NOT TESTED: no graphics adapter ({why}); apt-get install mesa-vulkan-drivers ***\n"
            );
            false
        }
        Err(other) => panic!("{other}"),
    }
}

/// An editor in a window of 1280 by 800 points, at rest.
pub fn editor(start: Start) -> Harness<'static, Editor> {
    editor_of_size(start, egui::vec2(1280.0, 800.0))
}

/// An editor in a window of a size in points, at rest.
pub fn editor_of_size(start: Start, size: egui::Vec2) -> Harness<'static, Editor> {
    let mut harness = Harness::builder()
        .with_size(size)
        .with_max_steps(40)
        .with_render_every_step(false)
        .wgpu()
        .build_eframe(|cc| {
            Editor::new(cc, Samples::One, Box::new(NoChooser), start).expect("the adapter suffices")
        });
    settle(&mut harness);
    harness
}

/// Runs until nothing is left to do, work away from the window included.
pub fn settle(harness: &mut Harness<'_, Editor>) {
    for _ in 0..600 {
        harness.run_steps(2);
        if !harness.state().is_working() {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    harness.run();
    assert!(!harness.state().is_working(), "work did not end");
}

/// The middle of the picture, where the sample's face is.
pub fn middle(harness: &Harness<'_, Editor>) -> Pos2 {
    harness.state().picture().center()
}

/// A button of the mouse, down or up.
pub fn button(pressed: bool, pos: Pos2, button: PointerButton, modifiers: Modifiers) -> Event {
    Event::PointerButton { pos, button, pressed, modifiers }
}

/// Drags with the left button from one place to another in steps, and does not let go.
pub fn drag(harness: &mut Harness<'_, Editor>, from: Pos2, to: Pos2, modifiers: Modifiers) {
    harness.event(Event::ModifiersChanged(modifiers));
    harness.event(Event::PointerMoved(from));
    harness.run_steps(2);
    harness.event(Event::ModifiersChanged(modifiers));
    harness.event(button(true, from, PointerButton::Primary, modifiers));
    harness.run_steps(1);
    for step in 1..=4 {
        harness.event(Event::PointerMoved(from + (to - from) * (step as f32 / 4.0)));
        harness.run_steps(1);
    }
}

/// Lets go of it.
pub fn release(harness: &mut Harness<'_, Editor>, at: Pos2) {
    harness.event(button(false, at, PointerButton::Primary, Modifiers::NONE));
    harness.event(Event::ModifiersChanged(Modifiers::NONE));
    harness.run_steps(1);
    harness.run();
}

/// A stroke across the face.
pub fn stroke(harness: &mut Harness<'_, Editor>, modifiers: Modifiers) {
    let from = middle(harness) + egui::vec2(-30.0, -20.0);
    let to = from + egui::vec2(60.0, 30.0);
    drag(harness, from, to, modifiers);
    release(harness, to);
}

/// Takes a tool into the hand, by its name.
pub fn take(harness: &mut Harness<'_, Editor>, name: &str) {
    harness.get_by_label(&format!("{name} tool")).click();
    harness.run();
}

/// A bumpy ball of 258 vertices, without a file.
pub fn ball() -> Session {
    let mut mesh = shapes::subdivide(&shapes::octahedron(), 3);
    for (at, p) in mesh.positions.iter_mut().enumerate() {
        let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
        *p = p.map(|x| x / length * (1.0 + 0.002 * (at * 37 % 19) as f64));
    }
    let converted = convert(&mesh, &ConversionOptions::default()).expect("subdivided");
    let surface = Surface::from_positions(converted.hierarchy, &converted.positions, &FormOptions::default());
    Session::new(Arc::new(Disk), Model::new(surface.expect("small"), None, Metadata::default()))
}

/// The open session.
pub fn session<'a>(harness: &'a Harness<'_, Editor>) -> &'a Session {
    &harness.state().document().expect("a surface is open").session
}

/// The last edit.
pub fn last(harness: &Harness<'_, Editor>) -> Edit {
    session(harness).history().last().expect("a step")
}

/// Undoes by the keys, and waits for it.
pub fn undo(harness: &mut Harness<'_, Editor>) {
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    settle(harness);
}

/// Redoes by the keys, and waits for it.
pub fn redo(harness: &mut Harness<'_, Editor>) {
    harness.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    settle(harness);
}

/// The window without the cursor over it.
pub fn picture(harness: &mut Harness<'_, Editor>) -> RgbaImage {
    harness.remove_cursor();
    harness.run();
    harness.render().expect("a picture")
}

/// Pixels of the picture of the surface that differ.
pub fn differing(harness: &Harness<'_, Editor>, a: &RgbaImage, b: &RgbaImage) -> usize {
    let picture = harness.state().picture();
    differing_where(a, b, |at| picture.contains(at))
}

/// Pixels that differ at some places of the window.
pub fn differing_where(a: &RgbaImage, b: &RgbaImage, there: impl Fn(Pos2) -> bool) -> usize {
    let differ = |x: u32, y: u32| a.get_pixel(x, y) != b.get_pixel(x, y);
    a.enumerate_pixels().filter(|&(x, y, _)| there(egui::pos2(x as f32, y as f32)) && differ(x, y)).count()
}

/// Chooses where a dialog reads or writes.
pub fn type_path(harness: &mut Harness<'_, Editor>, path: &Path) {
    harness.get_by_label("Path").focus();
    harness.run();
    harness.get_by_label("Path").type_text(path.to_str().expect("a plain path"));
    harness.run();
}

/// Saves under a name.
pub fn save_as(harness: &mut Harness<'_, Editor>, path: &Path) {
    harness.get_by_label("Save as").click();
    harness.run();
    type_path(harness, path);
    harness.get_by_label("Save file").click();
    settle(harness);
    assert!(path.exists(), "{:?}", harness.state().message());
}

/// The hash of the open surface.
pub fn hash(harness: &Harness<'_, Editor>) -> SurfaceHash {
    session(harness).hash()
}

/// The log of what was done here plays the same bits on a fresh surface.
pub fn assert_replays(harness: &Harness<'_, Editor>) {
    let Start::Session(fresh) = Start::sample().expect("the sample opens") else { panic!("a session") };
    assert_replays_on(harness, *fresh);
}

/// The log of what was done here plays the same bits on a surface as it was.
pub fn assert_replays_on(harness: &Harness<'_, Editor>, mut fresh: Session) {
    let session = session(harness);
    let steps: Vec<Edit> = session.history().take(session.steps()).collect();
    for edit in steps {
        let text = serde_json::to_string(&edit).expect("plain data");
        fresh.edit(serde_json::from_str(&text).expect("its own text")).expect("it was accepted before");
    }
    assert_eq!(fresh.hash(), session.hash(), "a script gives the same bits");
    let mask = |session: &Session| session.surface().mask().values().to_vec();
    let (again, here) = (mask(&fresh), mask(session));
    assert!(again == here || again.iter().chain(&here).all(|&m| m == 0), "and the same mask");
}
