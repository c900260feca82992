//! Named and numbered views: `front`, `right`, `top`, or `yaw,pitch,distance`.

use std::str::FromStr;

use super::camera::{BoundingSphere, Camera};

/// From where to look at a model, whatever its size and place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Degrees about the y axis: 0 looks from +z, 90 from +x.
    pub yaw: f64,
    /// Degrees of elevation, −90 to 90.
    pub pitch: f64,
    /// Multiple of the distance at which the bounding sphere fits the picture with a margin; above zero.
    pub distance: f64,
}

/// Why a `--view` was not understood.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the view {0:?} is not understood: give front, right, top or yaw,pitch,distance such as 30,20,1")]
pub struct ViewParseError(String);

impl View {
    /// From +z.
    pub const FRONT: Self = Self { yaw: 0.0, pitch: 0.0, distance: 1.0 };
    /// From +x.
    pub const RIGHT: Self = Self { yaw: 90.0, pitch: 0.0, distance: 1.0 };
    /// From +y, with −z at the top of the picture.
    pub const TOP: Self = Self { yaw: 0.0, pitch: 90.0, distance: 1.0 };

    /// The camera that looks so at `sphere`, for a picture of this `aspect` (width / height).
    pub fn camera(self, sphere: BoundingSphere, aspect: f64) -> Camera {
        let mut camera = Camera { yaw: 0.0, pitch: 0.0, ..Camera::default() };
        camera.orbit(self.yaw.to_radians(), self.pitch.to_radians());
        camera.fit(sphere, aspect);
        camera.zoom(self.distance);
        camera
    }
}

impl Default for View {
    /// A little from the right and from above.
    fn default() -> Self {
        Self { yaw: 30.0, pitch: 18.0, distance: 1.0 }
    }
}

impl FromStr for View {
    type Err = ViewParseError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text.trim() {
            "front" => return Ok(Self::FRONT),
            "right" => return Ok(Self::RIGHT),
            "top" => return Ok(Self::TOP),
            _ => {}
        }
        let refused = || ViewParseError(text.to_owned());
        let numbers: Vec<f64> = text
            .split(',')
            .map(|part| part.trim().parse().map_err(|_| refused()))
            .collect::<Result<_, _>>()?;
        let &[yaw, pitch, distance] = numbers.as_slice() else { return Err(refused()) };
        let sound = yaw.is_finite() && pitch.abs() <= 90.0 && distance > 0.0 && distance.is_finite();
        if sound { Ok(Self { yaw, pitch, distance }) } else { Err(refused()) }
    }
}
