//! What the program itself does for a frame while the camera goes round a surface: whole frames of the editor, headless.
//!
//! Timed is the processor time of the window's thread: input, panels, picture, overlays, egui's triangles, uniforms and the
//! recording and handing over of the commands. What then draws is the graphics adapter, waited for between frames and not
//! counted; a software one draws on threads of its own.

use super::timings::Timings;
use crate::editor::{Editor, Start, SystemChooser};
use crate::render::{Gpu, GpuError, Samples, device_descriptor};
use anyhow::{Result, bail};
use bozzetto_core::disk::Disk;
use bozzetto_core::file::{Metadata, Model};
use bozzetto_core::session::Session;
use bozzetto_core::surface::Surface;
use egui::{Event, Modifiers, PointerButton, Pos2, RawInput, Rect, TexturesDelta};
use egui_wgpu::{RenderState, RendererOptions, ScreenDescriptor, WgpuConfiguration, WgpuSetup};
use std::sync::Arc;

/// The window, in points and pixels.
const WINDOW: egui::Vec2 = egui::vec2(1280.0, 800.0);
/// Frames before the camera moves: fonts and buffers are uploaded, panels find their size.
const SETTLING: u32 = 6;
/// Frames of the drag that are not counted.
const UNCOUNTED: u32 = 2;

/// What frames take.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frames<const K: usize> {
    /// The median processor seconds of a frame, by surface.
    pub(super) seconds: [f64; K],
    /// Whether the adapter held all of them. Of one that it cannot hold nothing is drawn, which is some ten commands fewer.
    pub(super) drawn: bool,
}

/// Frames of several surfaces by turns; `None` without a graphics adapter.
///
/// # Errors
/// The adapter fails.
pub(super) fn frames<const K: usize>(
    surfaces: [Surface; K],
    frames: u32,
    done: &dyn Fn(f32),
) -> Result<Option<Frames<K>>> {
    match Gpu::headless() {
        Err(GpuError::NoAdapter(_)) => return Ok(None),
        other => drop(other?),
    }
    let mut windows = Vec::with_capacity(K);
    for surface in surfaces {
        windows.push(Window::new(surface)?);
    }
    let mut timings: [Timings; K] = std::array::from_fn(|_| Timings::default());
    for frame in 0..UNCOUNTED + frames {
        done(frame as f32 / (UNCOUNTED + frames) as f32);
        for (window, timings) in windows.iter_mut().zip(&mut timings) {
            let seconds = window.orbit()?;
            if frame >= UNCOUNTED {
                timings.push(seconds);
            }
        }
    }
    let drawn = windows.iter().all(|window| window.drawn);
    Ok(Some(Frames { seconds: timings.each_ref().map(Timings::median), drawn }))
}

/// An editor in a window that nobody sees.
struct Window {
    editor: Editor,
    context: egui::Context,
    state: RenderState,
    pointer: Pos2,
    frames: u32,
    drawn: bool,
}

impl Window {
    /// Opens the surface and presses the button that turns the camera.
    fn new(surface: Surface) -> Result<Self> {
        let state = render_state()?;
        let context = egui::Context::default();
        let model = Model::new(surface, None, Metadata::default());
        let start = Start::Session(Box::new(Session::new(Arc::new(Disk), model)));
        let chooser = Box::new(SystemChooser::default());
        let editor = Editor::over(&context, &state, Samples::One, chooser, start)?;
        let pointer = Pos2::ZERO + WINDOW * 0.5;
        let mut window = Self { editor, context, state, pointer, frames: 0, drawn: true };
        for _ in 0..SETTLING {
            window.frame(Vec::new())?;
        }
        window.drawn = window.editor.message().is_none();
        window.editor.dismiss_message();
        let button = PointerButton::Middle;
        let press = Event::PointerButton { pos: pointer, button, pressed: true, modifiers: Modifiers::NONE };
        window.frame(vec![Event::PointerMoved(pointer), press])?;
        Ok(window)
    }

    /// A frame in which the mouse turns the camera some more; its processor seconds.
    fn orbit(&mut self) -> Result<f64> {
        let before = self.editor.camera().eye();
        // To and fro, so that it stays in the picture.
        self.pointer.x += if (self.frames / 32).is_multiple_of(2) { 5.0 } else { -5.0 };
        let seconds = self.frame(vec![Event::PointerMoved(self.pointer)])?;
        if self.editor.camera().eye() == before {
            bail!("the camera did not turn; report this as a defect");
        }
        Ok(seconds)
    }

    fn frame(&mut self, events: Vec<Event>) -> Result<f64> {
        self.frames += 1;
        let input = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, WINDOW)),
            time: Some(f64::from(self.frames) / 60.0),
            events,
            ..RawInput::default()
        };
        let begun = processor_seconds();
        let mut output = self.context.run_ui(input, |ui| self.editor.frame(ui));
        let scale = output.pixels_per_point;
        let triangles = self.context.tessellate(std::mem::take(&mut output.shapes), scale);
        let (device, queue) = (&self.state.device, &self.state.queue);
        let mut renderer = self.state.renderer.write();
        upload(&mut renderer, &self.state, &mut output.textures_delta);
        let screen = ScreenDescriptor {
            pixels_per_point: scale,
            size_in_pixels: [WINDOW.x, WINDOW.y].map(|points| (points * scale).round() as u32),
        };
        let mut encoder = device.create_command_encoder(&Default::default());
        let others = renderer.update_buffers(device, queue, &mut encoder, &triangles, &screen);
        queue.submit(others.into_iter().chain([encoder.finish()]));
        let seconds = processor_seconds() - begun;
        drop(renderer);
        device.poll(wgpu::PollType::wait_indefinitely())?;
        Ok(seconds)
    }
}

/// Gives egui's textures to its renderer.
fn upload(renderer: &mut egui_wgpu::Renderer, state: &RenderState, delta: &mut TexturesDelta) {
    for (id, images) in delta.set.drain() {
        for image in images {
            renderer.update_texture(&state.device, &state.queue, id, &image);
        }
    }
    delta.free.drain().for_each(|id| renderer.free_texture(&id));
}

/// What eframe makes of a window, without one.
fn render_state() -> Result<RenderState> {
    let mut setup = egui_wgpu::WgpuSetupCreateNew::without_display_handle();
    setup.device_descriptor = Arc::new(device_descriptor);
    let wgpu_setup = WgpuSetup::CreateNew(setup);
    let instance = pollster::block_on(wgpu_setup.new_instance());
    let config = WgpuConfiguration { wgpu_setup, ..WgpuConfiguration::default() };
    let state = RenderState::create(&config, &instance, None, RendererOptions::default());
    Ok(pollster::block_on(state)?)
}

/// The processor time of this thread.
#[cfg(unix)]
fn processor_seconds() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// The time, where the system does not tell a thread's own.
#[cfg(not(unix))]
fn processor_seconds() -> f64 {
    std::time::SystemTime::UNIX_EPOCH.elapsed().map_or(0.0, |time| time.as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::super::shape::Base;
    use super::*;

    #[test]
    fn frames_are_made_and_timed() {
        let surfaces = [2, 4].map(|levels| Base::EightFaces.surface(levels).expect("small"));
        match frames(surfaces, 3, &|_| {}).expect("the adapter suffices") {
            None => eprintln!("\n*** NOT TESTED: no graphics adapter ***\n"),
            Some(frames) => {
                assert!(frames.drawn && frames.seconds.iter().all(|s| (1e-5..1.0).contains(s)), "{frames:?}");
            }
        }
    }
}
