//! The brush's ring on the surface.

use super::document::Document;
use super::settings::{Hand, Settings};
use super::tools::Touch;
use crate::render::Camera;
use egui::{Color32, Painter, Pos2, Rect, Shape, Stroke};
use glam::{DVec2, DVec3};

/// Segments of a ring.
const SEGMENTS: usize = 64;
const PLAIN: Color32 = Color32::from_rgb(250, 246, 238);
const INVERTED: Color32 = Color32::from_rgb(96, 170, 250);
const SMOOTHING: Color32 = Color32::from_rgb(130, 220, 150);

/// How the ring looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Look {
    /// As the tool is.
    Plain,
    /// The other way round.
    Inverted,
    /// Smoothing, whatever is in the hand.
    Smoothing,
}

/// Draws the ring of the brush's radius in the surface's plane, a dot in the middle, its mirror images, and dashed how far
/// the level truly reaches where that is further.
pub(super) fn ring(
    painter: &Painter,
    rect: Rect,
    camera: &Camera,
    (document, settings): (&Document, &Settings),
    touch: Touch,
    look: Look,
) {
    let radius = settings.brush_radius * document.sphere().radius;
    let size = DVec2::new(f64::from(rect.width()), f64::from(rect.height()));
    let at = |p: DVec3| {
        let p = camera.project(p, size)?;
        Some(Pos2::new(rect.min.x + p.x as f32, rect.min.y + p.y as f32))
    };
    let circle = |center: DVec3, normal: DVec3, radius: f64| -> Vec<Pos2> {
        let (u, v) = normal.any_orthonormal_pair();
        (0..=SEGMENTS)
            .filter_map(|k| {
                let turn = std::f64::consts::TAU * k as f64 / SEGMENTS as f64;
                at(center + (u * turn.cos() + v * turn.sin()) * radius)
            })
            .collect()
    };
    let colour = match look {
        Look::Plain => PLAIN,
        Look::Inverted => INVERTED,
        Look::Smoothing => SMOOTHING,
    };
    let stroke = Stroke::new(1.6, colour);
    painter.add(Shape::line(
        circle(touch.point, touch.normal, radius),
        Stroke::new(3.0, Color32::from_black_alpha(90)),
    ));
    painter.add(Shape::line(circle(touch.point, touch.normal, radius), stroke));
    if matches!(settings.hand, Hand::Brush(_)) {
        // A mark along the normal: up, or down when inverted.
        let way = if look == Look::Inverted { -1.0 } else { 1.0 };
        let tip = touch.point + touch.normal * (way * radius * 0.5 * settings.strength);
        if let (Some(from), Some(to)) = (at(touch.point), at(tip)) {
            painter.line_segment([from, to], stroke);
        }
    }
    if let Some(at) = at(touch.point) {
        painter.circle_filled(at, 2.0, colour);
    }
    let level = settings.level;
    let toward_eye = crate::render::Ray {
        origin: camera.eye(),
        direction: (touch.point - camera.eye()).normalize_or(DVec3::NEG_Z),
    };
    if let Some(hit) = document.pick(&toward_eye) {
        let reach = document.true_reach(&hit, level, radius);
        if reach > radius * 1.001 {
            let dashed = circle(touch.point, touch.normal, reach);
            painter.extend(Shape::dashed_line(
                &dashed,
                Stroke::new(1.2, colour.gamma_multiply(0.8)),
                5.0,
                5.0,
            ));
        }
    }
    for signs in mirrored(settings, document) {
        let image = circle(touch.point * signs, touch.normal * signs, radius);
        painter.add(Shape::line(image, Stroke::new(1.0, colour.gamma_multiply(0.5))));
    }
}

/// Draws the mark of the place that copied detail comes from.
pub(super) fn cross(painter: &Painter, at: Pos2) {
    for (width, colour) in [(4.0, Color32::from_black_alpha(110)), (1.8, SMOOTHING)] {
        let stroke = Stroke::new(width, colour);
        for arm in [egui::vec2(9.0, 0.0), egui::vec2(0.0, 9.0)] {
            painter.line_segment([at - arm, at - arm * 0.3], stroke);
            painter.line_segment([at + arm * 0.3, at + arm], stroke);
        }
        painter.circle_stroke(at, 6.0, stroke);
    }
}

/// The signs that drawn axes take in the mirror images, the first left out.
fn mirrored(settings: &Settings, document: &Document) -> Vec<DVec3> {
    let frame = document.vertices().frame();
    let mut all = vec![DVec3::ONE];
    for (axis, unit) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().enumerate() {
        if settings.symmetry[axis] {
            let flip = DVec3::ONE - 2.0 * frame.turn(unit).abs();
            all.extend(all.clone().into_iter().map(|signs| signs * flip));
        }
    }
    all.split_off(1)
}
