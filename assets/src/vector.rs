//! Vectors in three dimensions: just the arithmetic the sculptor needs, in `f64`.

use std::ops::{Add, AddAssign, Mul, Neg, Sub};

/// A point or direction in model units: x to the model's left, y up, z towards the viewer.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Vec3 {
    /// Along the model's left, which is the viewer's right.
    pub x: f64,
    /// Upwards.
    pub y: f64,
    /// Out of the face.
    pub z: f64,
}

/// Shorthand for a [`Vec3`].
pub const fn vec3(x: f64, y: f64, z: f64) -> Vec3 {
    Vec3 { x, y, z }
}

impl Vec3 {
    /// The inner product.
    pub fn dot(self, other: Self) -> f64 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// The cross product.
    pub fn cross(self, other: Self) -> Self {
        vec3(
            self.y * other.z - self.z * other.y,
            self.z * other.x - self.x * other.z,
            self.x * other.y - self.y * other.x,
        )
    }

    /// The Euclidean length.
    pub fn length(self) -> f64 {
        self.dot(self).sqrt()
    }

    /// The vector scaled to length one; zero stays zero.
    pub fn normalised(self) -> Self {
        let length = self.length();
        if length > 0.0 { self * (1.0 / length) } else { self }
    }

    /// The part at right angles to the unit vector `axis`.
    pub fn without(self, axis: Self) -> Self {
        self - axis * self.dot(axis)
    }

    /// The components divided by those of `radii`.
    pub fn divided(self, radii: Self) -> Self {
        vec3(self.x / radii.x, self.y / radii.y, self.z / radii.z)
    }

    /// The image in the plane x = 0.
    pub fn mirrored(self) -> Self {
        vec3(-self.x, self.y, self.z)
    }
}

impl Add for Vec3 {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        vec3(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl AddAssign for Vec3 {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for Vec3 {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        vec3(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl Mul<f64> for Vec3 {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        vec3(self.x * factor, self.y * factor, self.z * factor)
    }
}

impl Neg for Vec3 {
    type Output = Self;
    fn neg(self) -> Self {
        self * -1.0
    }
}
