//! The picture in the window is the picture without one: `Viewport` blits what `render_png` gives.

use bozzetto::render::{
    BoundingSphere, Camera, Gpu, GpuError, Handle, HandleState, Samples, Scene, Style, View, Viewport,
    render_png, vertex_normals,
};
use eframe::egui;
use egui_kittest::Harness;
use glam::DVec3;

const POSITIONS: [[f32; 3]; 4] = [[1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0]];
const TRIANGLES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
const EDGES: [[u32; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
/// The window, in points, and the part of it that the picture fills.
const WINDOW: egui::Vec2 = egui::vec2(200.0, 150.0);
const PLACE: egui::Rect = egui::Rect { min: egui::pos2(20.0, 10.0), max: egui::pos2(180.0, 130.0) };

/// A window with one picture in it.
struct Window {
    viewport: Viewport,
}

impl eframe::App for Window {
    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        ui.painter().add(self.viewport.shape(PLACE, &camera(), &Style::default()));
    }
}

fn camera() -> Camera {
    let sphere = BoundingSphere { center: DVec3::ZERO, radius: 3_f64.sqrt() };
    View { yaw: 30.0, pitch: 20.0, distance: 1.0 }.camera(sphere, 160.0 / 120.0)
}

#[test]
fn the_window_shows_the_headless_picture() {
    let gpu = match Gpu::headless() {
        Ok(gpu) => gpu,
        Err(GpuError::NoAdapter(why)) => {
            eprintln!(
                "\n*** NOT TESTED: no graphics adapter ({why}); apt-get install mesa-vulkan-drivers ***\n"
            );
            return;
        }
        Err(other) => panic!("{other}"),
    };
    let normals = vertex_normals(&POSITIONS, &TRIANGLES);
    let handles = POSITIONS.map(|position| Handle {
        position,
        radius: 5.0,
        fill: [255, 255, 255, 255],
        rim: [0, 0, 0, 255],
        state: HandleState::Idle,
    });
    for scale in [1.0, 1.5, 2.0] {
        let mut harness =
            Harness::builder().with_size(WINDOW).with_pixels_per_point(scale).wgpu().build_eframe(|cc| {
                let state = cc.wgpu_render_state.as_ref().expect("kittest was asked for wgpu");
                let viewport = Viewport::new(state, Samples::One).expect("the device pulls vertices");
                let mut renderer = viewport.renderer();
                renderer.set_vertices(&POSITIONS, &normals).unwrap();
                renderer.set_topology(&TRIANGLES, &EDGES).unwrap();
                renderer.set_handles(&handles).unwrap();
                drop(renderer);
                Window { viewport }
            });
        harness.run_steps(2);
        let window = harness.render().expect("kittest renders");
        assert!(harness.state().viewport.take_failure().is_none());

        let scene = Scene {
            positions: &POSITIONS,
            normals: &normals,
            triangles: &TRIANGLES,
            edges: &EDGES,
            handles: &handles,
            style: Style { scale, ..Style::default() },
            ..Scene::default()
        };
        let size = [160.0, 120.0].map(|side| (side * scale) as u32);
        let expected = render_png(&gpu, &scene, &camera(), size, Samples::One).unwrap();
        let [left, top] = [PLACE.min.x, PLACE.min.y].map(|edge| (edge * scale) as u32);
        for (x, y, pixel) in expected.enumerate_pixels() {
            let shown = window.get_pixel(left + x, top + y);
            let far = pixel.0.iter().zip(shown.0).any(|(a, b)| a.abs_diff(b) > 1);
            assert!(!far, "at scale {scale}, ({x}, {y}) is {shown:?}, not {pixel:?}");
        }
    }
}
