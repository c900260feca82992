//! The window in tests: an editor on the software GPU, driven through its widgets.
//!
//! Every test file is a program of its own and uses its part of this.
#![allow(dead_code, unreachable_pub)]

use bozzetto::editor::{Editor, FileChooser, Purpose, Start};
use bozzetto::render::{Gpu, GpuError, Samples};
use bozzetto_core::edit::Edit;
use bozzetto_core::surface::SurfaceHash;
use eframe::egui;
use egui_kittest::Harness;
use std::path::PathBuf;

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
    let mut harness = Harness::builder()
        .with_size(egui::vec2(1280.0, 800.0))
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

/// The hash of the open surface.
pub fn hash(harness: &Harness<'_, Editor>) -> SurfaceHash {
    harness.state().document().expect("a surface is open").session.hash()
}

/// The log of what was done here plays the same bits on a fresh surface.
pub fn assert_replays(harness: &Harness<'_, Editor>) {
    let session = &harness.state().document().expect("open").session;
    let steps: Vec<Edit> = session.history().take(session.steps()).collect();
    let Start::Session(mut fresh) = Start::sample().expect("the sample opens") else { panic!("a session") };
    for edit in steps {
        let text = serde_json::to_string(&edit).expect("plain data");
        fresh.edit(serde_json::from_str(&text).expect("its own text")).expect("it was accepted before");
    }
    assert_eq!(fresh.hash(), session.hash(), "a script gives the same bits");
    assert_eq!(fresh.surface().mask().values(), session.surface().mask().values());
}
