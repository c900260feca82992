//! Pens in the window: which there is, and what it does where the window hears nothing of it.

#[cfg(any(windows, all(unix, not(target_os = "macos"))))]
mod tablet;

use super::Editor;
use super::tools::PenEvent;

impl Editor {
    /// Takes the pen of a graphics tablet where the window system gives it; elsewhere, and where that fails, the pen is what
    /// touches say.
    #[cfg(any(windows, all(unix, not(target_os = "macos"))))]
    pub(super) fn find_tablet(&mut self, cc: &eframe::CreationContext<'_>) {
        match cc.winit_window().map(tablet::TabletPen::of) {
            Some(Ok(Some(pen))) => self.pen = Box::new(pen),
            Some(Err(why)) => tracing::warn!("no tablet: {why}"),
            _ => {}
        }
    }

    #[cfg(not(any(windows, all(unix, not(target_os = "macos")))))]
    pub(super) fn find_tablet(&mut self, _: &eframe::CreationContext<'_>) {}

    /// What a pen did since the last frame that the window heard nothing of, as if the mouse had done it.
    pub(super) fn pen_strokes(&mut self, ctx: &egui::Context, raw_input: &mut egui::RawInput) {
        let modifiers = ctx.input(|input| input.modifiers);
        for mut event in
            self.pen.strokes().into_iter().flat_map(|e| as_pointer(e, ctx.zoom_factor())).flatten()
        {
            if let egui::Event::PointerButton { modifiers: held, .. } = &mut event {
                *held = modifiers;
            }
            raw_input.events.push(event);
        }
        if let Some(soon) = self.pen.asks_again_in() {
            ctx.request_repaint_after(soon);
        }
    }
}

/// What a pen does that the window hears nothing of, as the mouse would do it.
fn as_pointer(event: PenEvent, zoom: f32) -> [Option<egui::Event>; 2] {
    let at = |[x, y]: [f32; 2]| egui::pos2(x / zoom, y / zoom);
    let button = |pos, pressed| egui::Event::PointerButton {
        pos,
        button: egui::PointerButton::Primary,
        pressed,
        modifiers: egui::Modifiers::NONE,
    };
    match event {
        PenEvent::Moved(to) => [Some(egui::Event::PointerMoved(at(to))), None],
        PenEvent::Down(to) => [Some(egui::Event::PointerMoved(at(to))), Some(button(at(to), true))],
        PenEvent::Up(to) => [Some(button(at(to), false)), None],
        PenEvent::Gone => [Some(egui::Event::PointerGone), None],
    }
}
