//! How much memory writing a large surface takes beside the surface.

use bozzetto_core::file::{Metadata, Model, encode};
use bozzetto_core::surface::Surface;
use peak_alloc::PeakAlloc;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// What is to be written, what was made of it, and one level as a reader has it: never all of them twice.
#[test]
fn writing_takes_little_beside_the_surface() {
    let model = Model::new(Surface::ball(8, |_| 1.0), None, Metadata::default());
    let vertices = model.surface.scaling(model.surface.finest()).len();
    let before = MEMORY.current_usage();
    MEMORY.reset_peak_usage();
    let file = encode(&model);
    let taken = MEMORY.peak_usage() - before;
    let each = (taken - file.len()) as f64 / vertices as f64;
    println!("{each:.1} bytes a vertex of {vertices}");
    assert!(each < 33.0, "{each:.1} bytes a vertex");
}
