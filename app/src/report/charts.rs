//! Charts of a report, as pictures in lines of the page itself.

use super::quality::{Angles, BIN, WELL_SHAPED};
use crate::display::HeatScale;
use crate::figures::{grouped, length, percent};
use std::fmt::Write;

/// Width and height of the histogram's area, in its own units.
const AREA: [f64; 2] = [560.0, 150.0];

/// How many triangles have which smallest angle. Those that are not well shaped are told apart by colour and by a
/// line.
pub(super) fn histogram(angles: &Angles) -> String {
    let [width, height] = AREA;
    let most = angles.counts.iter().copied().max().unwrap_or(0).max(1) as f64;
    let step = width / angles.counts.len() as f64;
    let mut bars = String::new();
    for (at, &count) in angles.counts.iter().enumerate() {
        let tall = (count as f64 / most * height).max(if count > 0 { 1.0 } else { 0.0 });
        let (from, to) = (at as f64 * BIN, (at + 1) as f64 * BIN);
        let class = if from < WELL_SHAPED { "thin" } else { "well" };
        let (x, y) = (at as f64 * step + 2.0, height - tall);
        let _ = writeln!(
            bars,
            "<rect class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{:.1}\" height=\"{tall:.1}\">\
             <title>{from}° to {to}°: {} triangles</title></rect>",
            step - 4.0,
            grouped(count as u64),
        );
    }
    let ticks: String = (0..=angles.counts.len())
        .step_by(3)
        .map(|at| {
            let (x, degrees) = (at as f64 * step, at as f64 * BIN);
            let anchor = match at {
                0 => "start",
                at if at == angles.counts.len() => "end",
                _ => "middle",
            };
            format!(
                "<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\">{degrees}°</text>\n",
                height + 18.0
            )
        })
        .collect();
    format!(
        "<svg class=\"chart\" viewBox=\"0 -4 {width} {:.0}\" role=\"img\" \
         aria-label=\"Histogram of the smallest angle of each triangle\">\n{bars}\
         <line x1=\"0\" y1=\"{height}\" x2=\"{width}\" y2=\"{height}\"/>\n{ticks}</svg>\n",
        height + 28.0,
    )
}

/// The colours of the map of the error with what they stand for.
pub(super) fn colour_bar(scale: &HeatScale, diagonal: f64, unit: &str) -> String {
    let stops: Vec<String> = (0..=10)
        .map(|tenth| {
            let [r, g, b] = HeatScale::colour(f64::from(tenth) / 10.0);
            format!("rgb({r} {g} {b})")
        })
        .collect();
    let label = |share: f64, more: &str| {
        let fraction = scale.end() * share;
        format!("<span>{more}{}<br>{}</span>", percent(fraction), length(fraction * diagonal, unit))
    };
    format!(
        "<div class=\"bar\" role=\"img\" aria-label=\"Colours from no distance to {end} of the diagonal and more\" \
         style=\"background: linear-gradient(to right, {colours})\"></div>\n\
         <div class=\"ticks\"><span>0</span>{}{}</div>\n",
        label(0.5, ""),
        label(1.0, "≥ "),
        end = percent(scale.end()),
        colours = stops.join(", "),
    )
}
