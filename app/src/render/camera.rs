//! The orbit camera: where the eye is, and what lies under a pixel.
//!
//! Right-handed, y up. With yaw 0 and pitch 0 the eye looks from +z towards −z; a positive yaw carries the eye
//! towards +x, a positive pitch towards +y. Pixels are continuous: (0, 0) is the top left corner of the picture,
//! y runs down, and the centre of the first pixel is (0.5, 0.5). All of it is `f64`; only the matrices sent to
//! the GPU are rounded.

use glam::{DMat4, DVec2, DVec3, DVec4};

/// The near plane, as a fraction of the distance to the target. There is no far plane.
const NEAR_FRACTION: f64 = 1e-3;
/// The eye never comes nearer to the target than this, nor goes farther, so every matrix stays finite.
const DISTANCE_RANGE: (f64, f64) = (1e-12, 1e15);
/// Half of a right angle each way: beyond it the picture would be upside down.
const PITCH_LIMIT: f64 = std::f64::consts::FRAC_PI_2;
/// How much room a fitted sphere leaves around it: 1 would touch the nearer pair of edges.
const FIT_MARGIN: f64 = 1.08;

/// A ball that holds a model: the centre of its bounding box, and the farthest vertex from there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundingSphere {
    /// Centre, model units.
    pub center: DVec3,
    /// Radius, model units; never zero.
    pub radius: f64,
}

impl BoundingSphere {
    /// The sphere about `positions`; a unit sphere about the origin when there are none. Points that are not
    /// finite are left out. Cost: two passes.
    pub fn of(positions: &[[f32; 3]]) -> Self {
        let points = || positions.iter().map(|p| DVec3::from(p.map(f64::from))).filter(|p| p.is_finite());
        let (low, high) =
            points().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        if low.x > high.x {
            return Self { center: DVec3::ZERO, radius: 1.0 };
        }
        let center = (low + high) * 0.5;
        let radius = points().map(|p| p.distance_squared(center)).fold(0.0, f64::max).sqrt();
        Self { center, radius: if radius > 0.0 { radius } else { 1.0 } }
    }
}

/// A half line: where it starts and its unit direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// The eye.
    pub origin: DVec3,
    /// Unit vector into the picture.
    pub direction: DVec3,
}

/// An orbit camera. Angles are radians, lengths model units, pictures and pixels as the module says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Rotation about the y axis.
    pub yaw: f64,
    /// Elevation, within ±π/2.
    pub pitch: f64,
    /// From the target to the eye, above zero.
    pub distance: f64,
    /// What the eye looks at and turns about.
    pub target: DVec3,
    /// Full vertical angle of view.
    pub vertical_fov: f64,
}

impl Default for Camera {
    /// Looks at the unit sphere about the origin, from a little above and to the right, through a 35° lens.
    fn default() -> Self {
        let mut camera = Self {
            yaw: 0.5,
            pitch: 0.3,
            distance: 1.0,
            target: DVec3::ZERO,
            vertical_fov: 35_f64.to_radians(),
        };
        camera.fit(BoundingSphere { center: DVec3::ZERO, radius: 1.0 }, 1.0);
        camera
    }
}

impl Camera {
    /// Unit vectors to the right, up, and from the target back to the eye.
    pub fn axes(&self) -> [DVec3; 3] {
        let (sin_yaw, cos_yaw) = self.yaw.sin_cos();
        let (sin_pitch, cos_pitch) = self.pitch.sin_cos();
        let right = DVec3::new(cos_yaw, 0.0, -sin_yaw);
        let back = DVec3::new(sin_yaw * cos_pitch, sin_pitch, cos_yaw * cos_pitch);
        [right, back.cross(right), back]
    }

    /// Where the eye is.
    pub fn eye(&self) -> DVec3 {
        self.target + self.axes()[2] * self.distance
    }

    /// Distance of the near plane from the eye.
    pub fn near(&self) -> f64 {
        self.distance * NEAR_FRACTION
    }

    /// World to eye space: x right, y up, z towards the eye.
    pub fn view(&self) -> DMat4 {
        let [right, up, back] = self.axes();
        let eye = self.eye();
        DMat4::from_cols(
            DVec4::new(right.x, up.x, back.x, 0.0),
            DVec4::new(right.y, up.y, back.y, 0.0),
            DVec4::new(right.z, up.z, back.z, 0.0),
            DVec4::new(-right.dot(eye), -up.dot(eye), -back.dot(eye), 1.0),
        )
    }

    /// Eye space to clip space, y up, depth reversed: 1 at the near plane, 0 at infinity.
    pub fn projection(&self, aspect: f64) -> DMat4 {
        let focal = 1.0 / (self.vertical_fov * 0.5).tan();
        DMat4::from_cols(
            DVec4::new(focal / aspect, 0.0, 0.0, 0.0),
            DVec4::new(0.0, focal, 0.0, 0.0),
            DVec4::new(0.0, 0.0, 0.0, -1.0),
            DVec4::new(0.0, 0.0, self.near(), 0.0),
        )
    }

    /// World to clip space for a picture `aspect` = width / height.
    pub fn view_projection(&self, aspect: f64) -> DMat4 {
        self.projection(aspect) * self.view()
    }

    /// Moves the target to the sphere's centre and the eye back until the sphere fills a picture of this
    /// `aspect`, with a small margin. Angles stay.
    pub fn fit(&mut self, sphere: BoundingSphere, aspect: f64) {
        self.target = sphere.center;
        self.set_distance(self.fit_distance(sphere, aspect));
    }

    /// The distance at which [`Self::fit`] puts the eye.
    pub fn fit_distance(&self, sphere: BoundingSphere, aspect: f64) -> f64 {
        let half = (self.vertical_fov * 0.5).tan() * aspect.min(1.0);
        sphere.radius * FIT_MARGIN / half.atan().sin()
    }

    /// Turns about the target by radians; the pitch stops at straight up and straight down.
    pub fn orbit(&mut self, yaw: f64, pitch: f64) {
        self.yaw = (self.yaw + yaw).rem_euclid(std::f64::consts::TAU);
        self.pitch = (self.pitch + pitch).clamp(-PITCH_LIMIT, PITCH_LIMIT);
    }

    /// Slides eye and target so that what lies in the plane of the target follows the cursor by `pixels`.
    pub fn pan(&mut self, pixels: DVec2, picture: DVec2) {
        let [right, up, _] = self.axes();
        let scale = self.world_per_pixel_at(self.target, picture);
        self.target += (up * pixels.y - right * pixels.x) * scale;
    }

    /// Multiplies the distance to the target: below 1 comes nearer.
    pub fn zoom(&mut self, factor: f64) {
        self.set_distance(self.distance * factor);
    }

    /// Zooms towards `pixel`: the point of the target's plane under it stays under it.
    pub fn zoom_at(&mut self, factor: f64, pixel: DVec2, picture: DVec2) {
        let before = self.unproject(pixel, self.target, picture);
        let old = self.distance;
        self.zoom(factor);
        self.target = before + (self.target - before) * (self.distance / old);
    }

    /// The pixel at which `point` appears, or `None` if it lies behind the near plane.
    pub fn project(&self, point: DVec3, picture: DVec2) -> Option<DVec2> {
        let [right, up, back] = self.axes();
        let offset = point - self.eye();
        let depth = -back.dot(offset);
        if depth.is_nan() || depth < self.near() {
            return None;
        }
        let scale = picture.y / (2.0 * (self.vertical_fov * 0.5).tan() * depth);
        Some(picture * 0.5 + DVec2::new(right.dot(offset), -up.dot(offset)) * scale)
    }

    /// The half line from the eye through `pixel`.
    pub fn ray(&self, pixel: DVec2, picture: DVec2) -> Ray {
        Ray { origin: self.eye(), direction: self.pixel_vector(pixel, picture).normalize() }
    }

    /// The point under `pixel` in the plane through `through` that is parallel to the picture: what a drag of a
    /// handle at `through` is measured in.
    pub fn unproject(&self, pixel: DVec2, through: DVec3, picture: DVec2) -> DVec3 {
        self.eye() + self.pixel_vector(pixel, picture) * self.depth_of(through)
    }

    /// How many model units one pixel spans at the depth of `point`.
    pub fn world_per_pixel_at(&self, point: DVec3, picture: DVec2) -> f64 {
        2.0 * (self.vertical_fov * 0.5).tan() * self.depth_of(point) / picture.y
    }

    /// Distance of `point` from the eye's plane, along the line of sight; negative behind the eye.
    pub fn depth_of(&self, point: DVec3) -> f64 {
        self.axes()[2].dot(self.eye() - point)
    }

    /// The vector from the eye to `pixel` on the plane one unit in front of it.
    fn pixel_vector(&self, pixel: DVec2, picture: DVec2) -> DVec3 {
        let [right, up, back] = self.axes();
        let offset = (pixel - picture * 0.5) * (2.0 * (self.vertical_fov * 0.5).tan() / picture.y);
        right * offset.x - up * offset.y - back
    }

    fn set_distance(&mut self, distance: f64) {
        if distance.is_finite() {
            self.distance = distance.clamp(DISTANCE_RANGE.0, DISTANCE_RANGE.1);
        }
    }
}
