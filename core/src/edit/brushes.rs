//! What the brushes that move vertices do: for every touched vertex a displacement, in steps, at weight 1.
//!
//! A dab reads the surface as the dabs before have left it. Heights grow with the radius, so a brush feels alike at every
//! size.

use super::reach::{Steps, Touched, cross, dot, minus, normal_at, plus, steps, times, unit};
use super::stroke::Tool;
use crate::hierarchy::{Address, Level};
use crate::surface::Surface;

/// Height of a dab at full strength over its radius. Four dabs a radius then raise a stroke by about a third of it.
const HEIGHT: f64 = 0.1;
/// Share of the way to the middle that a dab of pinch goes at full strength.
const PINCH: f64 = 0.25;

/// The mean of the touched vertices and their unit normal, by weight.
pub(super) struct Plane {
    middle: Steps,
    normal: Steps,
}

impl Plane {
    pub(super) fn under(surface: &Surface, level: Level, region: &[Touched]) -> Self {
        let (layout, positions) = (surface.hierarchy().layout(level), surface.scaling(level));
        let (mut middle, mut normal, mut sum) = ([0.0; 3], [0.0; 3], 0.0);
        for touched in region {
            middle = plus(middle, times(steps(positions[touched.slot.index()]), touched.weight));
            normal = plus(normal, times(normal_at(layout, positions, touched.site), touched.weight));
            sum += touched.weight;
        }
        let middle = if sum > 0.0 { times(middle, 1.0 / sum) } else { middle };
        Self { middle, normal: unit(normal) }
    }
}

/// The displacement of a touched vertex at weight 1. `radius` in steps; `strength` with its sign.
pub(super) fn displacement(
    surface: &Surface,
    level: Level,
    tool: Tool,
    plane: &Plane,
    touched: &Touched,
    (radius, strength): (f64, f64),
) -> Steps {
    let (layout, positions) = (surface.hierarchy().layout(level), surface.scaling(level));
    let position = steps(positions[touched.slot.index()]);
    let height = HEIGHT * strength * radius;
    let from_middle = minus(position, plane.middle);
    let above = dot(from_middle, plane.normal);
    match tool {
        Tool::Draw => times(plane.normal, height),
        Tool::Inflate => times(unit(normal_at(layout, positions, touched.site)), height),
        Tool::Clay => {
            let missing = height - above;
            let filled = if height >= 0.0 {
                missing.clamp(0.0, 2.0 * height)
            } else {
                missing.clamp(2.0 * height, 0.0)
            };
            times(plane.normal, filled)
        }
        Tool::Flatten => times(plane.normal, -above * strength.clamp(-1.0, 1.0)),
        Tool::Pinch | Tool::Crease => {
            let along = minus(from_middle, times(plane.normal, above));
            let share = PINCH * strength.abs().min(1.0);
            let together = times(along, if tool == Tool::Pinch && strength < 0.0 { share } else { -share });
            match tool {
                Tool::Crease => minus(together, times(plane.normal, height)),
                _ => together,
            }
        }
        // The others do not move vertices by a displacement.
        Tool::Smooth | Tool::Sharpen | Tool::Erase | Tool::Copy | Tool::Mask => [0.0; 3],
    }
}

/// A vector turned by a rotation.
pub(super) fn turned(rotation: &[Steps; 3], v: Steps) -> Steps {
    (0..3).fold([0.0; 3], |sum, axis| plus(sum, times(rotation[axis], v[axis])))
}

/// The smallest rotation that takes the normal of `S^j` at one address to that at another.
pub(super) fn turn_normal(surface: &Surface, level: Level, [from, to]: [Address; 2]) -> [Steps; 3] {
    let layout = surface.hierarchy().layout(level);
    let normal = |address: Address| {
        let at = |site| steps(surface.scaling(level)[layout.slot(site).index()]);
        let [a, b, c] = address.corners(layout).map(|(site, _)| at(site));
        unit(cross(minus(b, a), minus(c, a)))
    };
    let (from, to) = (normal(from), normal(to));
    let (axis, cosine) = (cross(from, to), dot(from, to));
    let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    // Opposite normals have no smallest rotation.
    if cosine < -0.999 {
        return identity;
    }
    // Rodrigues' formula: v cos + (axis × v) + axis (axis · v) / (1 + cos).
    identity.map(|e| {
        let along = times(axis, dot(axis, e) / (1.0 + cosine));
        plus(plus(times(e, cosine), cross(axis, e)), along)
    })
}
