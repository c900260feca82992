//! The words of brush strokes: a tool, where it goes and how far it reaches.
//!
//! Like every edit a stroke carries its operation's version. What each tool does is written in docs/FORMAT.md.

use super::vocabulary::{Falloff, first, is_first};
use serde::{Deserialize, Serialize};
use std::fmt;

/// A stroke of more dabs is refused; the editor goes on with a new one.
pub const MOST_DABS: usize = 4096;

/// What a brush does where it touches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Tool {
    /// Raises the surface along the brush's mean normal.
    Draw,
    /// Fills up to a plane above the surface.
    Clay,
    /// Moves every vertex along its own normal.
    Inflate,
    /// Moves vertices to the brush's mean plane.
    Flatten,
    /// Draws vertices together along the surface.
    Pinch,
    /// Digs a groove and draws its sides together.
    Crease,
    /// Attenuates detail finer than the level.
    Smooth,
    /// Amplifies detail finer than the level.
    Sharpen,
    /// Takes away the detail of chosen levels.
    Erase,
    /// Takes detail finer than the level from another place.
    Copy,
    /// Paints the mask.
    Mask,
}

impl Tool {
    /// All of them, in the order of a toolbar.
    pub const ALL: [Tool; 11] = [
        Tool::Draw,
        Tool::Clay,
        Tool::Inflate,
        Tool::Smooth,
        Tool::Sharpen,
        Tool::Flatten,
        Tool::Pinch,
        Tool::Crease,
        Tool::Erase,
        Tool::Copy,
        Tool::Mask,
    ];

    /// Whether it changes wavelet coefficients and leaves `c^j` as it is.
    pub fn acts_on_detail(self) -> bool {
        matches!(self, Tool::Smooth | Tool::Sharpen | Tool::Erase)
    }

    /// The newest version of what it does; older ones replay as they did.
    pub fn latest_version(self) -> u32 {
        if self == Tool::Copy { 2 } else { 1 }
    }

    /// Its name as people read it.
    pub fn name(self) -> &'static str {
        match self {
            Tool::Draw => "Draw",
            Tool::Clay => "Clay",
            Tool::Inflate => "Inflate",
            Tool::Flatten => "Flatten",
            Tool::Pinch => "Pinch",
            Tool::Crease => "Crease",
            Tool::Smooth => "Smooth",
            Tool::Sharpen => "Sharpen",
            Tool::Erase => "Erase detail",
            Tool::Copy => "Copy detail",
            Tool::Mask => "Mask",
        }
    }
}

/// Planes that mirror a stroke in space, each across an axis at a coordinate in model units.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mirror {
    /// The plane across the x axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x: Option<f64>,
    /// The plane across the y axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y: Option<f64>,
    /// The plane across the z axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub z: Option<f64>,
}

impl Mirror {
    /// The planes by axis.
    pub fn planes(&self) -> [Option<f64>; 3] {
        [self.x, self.y, self.z]
    }

    /// Whether there is none.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// Whether every plane stands at a finite place.
    pub fn is_finite(&self) -> bool {
        self.planes().into_iter().flatten().all(f64::is_finite)
    }

    /// The images of a point, itself first, with the sign that each axis of a vector takes in them.
    pub fn images(&self, p: [f64; 3]) -> Vec<([f64; 3], [f64; 3])> {
        let mut images = vec![(p, [1.0; 3])];
        for (axis, plane) in self.planes().into_iter().enumerate() {
            let Some(plane) = plane else { continue };
            for at in 0..images.len() {
                let (mut point, mut signs) = images[at];
                point[axis] = 2.0 * plane - point[axis];
                signs[axis] = -signs[axis];
                images.push((point, signs));
            }
        }
        images
    }
}

/// One touch of the brush: `[x, y, z]`, `[x, y, z, strength]` or `[x, y, z, strength, size]`, the last two multiplying the
/// stroke's own, as a pen's pressure does.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(into = "Vec<f64>", try_from = "Vec<f64>")]
pub struct Dab {
    /// A point in model units; the brush touches the surface where it is closest.
    pub at: [f64; 3],
    /// Times the stroke's strength.
    pub strength: f64,
    /// Times the stroke's radius.
    pub size: f64,
}

impl Dab {
    /// A touch with the stroke's own strength and radius.
    pub fn new(at: [f64; 3]) -> Self {
        Self { at, strength: 1.0, size: 1.0 }
    }

    /// The same with short decimals: to a thousandth of `radius`, and a hundredth for strength and size.
    pub fn shortened(&self, radius: f64) -> Self {
        let short = |x: f64, unit: f64| {
            let exponent = (0..300).find(|&e| unit > power_of_ten(-e)).unwrap_or(300);
            format!("{x:.0$}", exponent as usize).parse().unwrap_or(x)
        };
        Self {
            at: self.at.map(|x| short(x, radius * 1e-3)),
            strength: short(self.strength, 0.011),
            size: short(self.size, 0.011),
        }
    }

    fn is_sensible(&self) -> bool {
        let fine = |x: f64| x.is_finite() && x >= 0.0;
        self.at.iter().all(|x| x.is_finite()) && fine(self.strength) && fine(self.size) && self.size > 0.0
    }
}

fn power_of_ten(exponent: i32) -> f64 {
    (0..exponent.abs()).fold(1.0, |x, _| if exponent < 0 { x / 10.0 } else { x * 10.0 })
}

impl From<Dab> for Vec<f64> {
    fn from(dab: Dab) -> Self {
        let all = [dab.at[0], dab.at[1], dab.at[2], dab.strength, dab.size];
        let kept = match (dab.strength, dab.size) {
            (1.0, 1.0) => 3,
            (_, 1.0) => 4,
            _ => 5,
        };
        all[..kept].to_vec()
    }
}

impl TryFrom<Vec<f64>> for Dab {
    type Error = String;

    fn try_from(numbers: Vec<f64>) -> Result<Self, String> {
        let (at, rest) = numbers.split_at_checked(3).ok_or("a dab needs three coordinates")?;
        if rest.len() > 2 {
            return Err("a dab has three coordinates and at most a strength and a size".into());
        }
        Ok(Self {
            at: [at[0], at[1], at[2]],
            strength: rest.first().copied().unwrap_or(1.0),
            size: rest.get(1).copied().unwrap_or(1.0),
        })
    }
}

/// A stroke of a brush: its dabs one after another.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stroke {
    /// What it does.
    pub tool: Tool,
    /// The level it acts at: of scaling coefficients, or the coarsest of the wavelets.
    pub level: u8,
    /// How far it reaches, in model units.
    pub radius: f64,
    /// How strongly it acts: usually from 0 to 1; below 0 the other way round.
    pub strength: f64,
    /// How it fades towards the radius.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub falloff: Option<Falloff>,
    /// Planes that mirror it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mirror: Option<Mirror>,
    /// For erasing: the finest level of the wavelets; none: all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to: Option<u8>,
    /// For copying: what the first dab takes its detail from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<[f64; 3]>,
    /// Where it touches, in order.
    pub dabs: Vec<Dab>,
    /// Version of the operation.
    #[serde(default = "first", skip_serializing_if = "is_first")]
    pub v: u32,
}

impl Stroke {
    /// Whether every number in it means something.
    pub fn is_sensible(&self) -> bool {
        self.radius.is_finite()
            && self.radius > 0.0
            && self.strength.is_finite()
            && self.mirror.is_none_or(|m| m.is_finite())
            && self.from.is_none_or(|p| p.iter().all(|x| x.is_finite()))
            && self.dabs.iter().all(Dab::is_sensible)
            && self.dabs.len() <= MOST_DABS
    }
}

impl fmt::Display for Stroke {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} at level {}", self.tool.name(), self.level)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dabs_are_as_long_as_they_need_to_be() {
        let dabs = [
            Dab::new([0.5, -1.0, 2.0]),
            Dab { strength: 0.25, ..Dab::new([1.0; 3]) },
            Dab { size: 2.0, ..Dab::new([0.0; 3]) },
        ];
        let text = serde_json::to_string(&dabs).expect("plain data");
        assert_eq!(text, "[[0.5,-1.0,2.0],[1.0,1.0,1.0,0.25],[0.0,0.0,0.0,1.0,2.0]]");
        let back: Vec<Dab> = serde_json::from_str(&text).expect("its own text");
        assert_eq!(back, dabs);
        assert!(serde_json::from_str::<Dab>("[1,2]").is_err());
        assert!(serde_json::from_str::<Dab>("[1,2,3,4,5,6]").is_err());
    }

    #[test]
    fn short_decimals_stay_within_a_thousandth_of_the_radius() {
        for radius in [1e-6, 0.03, 1.0, 250.0] {
            let dab = Dab { at: [radius * 1.234_567_89, -3.3 * radius, 0.0], strength: 0.123_456, size: 1.0 };
            let short = dab.shortened(radius);
            for c in 0..3 {
                assert!((short.at[c] - dab.at[c]).abs() <= 1e-3 * radius, "{radius}: {short:?}");
            }
            assert!(serde_json::to_string(&short).expect("plain data").len() < 45, "{short:?}");
        }
    }

    #[test]
    fn two_planes_make_four_images() {
        let mirror = Mirror { x: Some(1.0), z: Some(0.0), y: None };
        let images = mirror.images([3.0, 5.0, 7.0]);
        let points: Vec<[f64; 3]> = images.iter().map(|&(p, _)| p).collect();
        assert_eq!(points, [[3.0, 5.0, 7.0], [-1.0, 5.0, 7.0], [3.0, 5.0, -7.0], [-1.0, 5.0, -7.0]]);
        assert_eq!(images[3].1, [-1.0, 1.0, -1.0]);
    }
}
