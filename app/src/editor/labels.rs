//! A list of everything in the window that has a name, for scripts that drive it as a hand would.
//!
//! The names are those that screen readers get. A script looks one up, moves the mouse there and clicks.

use bozzetto_core::disk::{Disk, Vfs};
use std::fmt::Write;
use std::path::PathBuf;

/// The environment variable that asks for the list and says where it goes.
pub(super) const LABELS: &str = "BOZZETTO_LABELS";

/// Writes the list anew whenever the window's content has changed: a line for each name, `left top right bottom`
/// in points, `on` or `off`, then the name.
pub(super) struct Labels {
    path: PathBuf,
    written: String,
}

impl Labels {
    /// A list at a path.
    pub(super) fn new(ctx: &egui::Context, path: PathBuf) -> Self {
        ctx.enable_accesskit();
        Self { path, written: String::new() }
    }
}

impl egui::Plugin for Labels {
    fn debug_name(&self) -> &'static str {
        "labels"
    }

    fn output_hook(&mut self, _: &egui::Context, output: &mut egui::FullOutput) {
        let Some(update) = &output.platform_output.accesskit_update else { return };
        let mut text = String::new();
        for (_, node) in &update.nodes {
            let (Some(name), Some(bounds)) = (node.label().or_else(|| node.value()), node.bounds()) else {
                continue;
            };
            let state = if node.is_disabled() { "off" } else { "on" };
            let name = name.replace('\n', " ");
            let (x, y) = (bounds.x0.round(), bounds.y0.round());
            let (right, bottom) = (bounds.x1.round(), bounds.y1.round());
            writeln!(text, "{x} {y} {right} {bottom} {state} {name}").expect("strings grow");
        }
        if text != self.written && Disk.replace(&self.path, text.as_bytes()).is_ok() {
            self.written = text;
        }
    }
}
