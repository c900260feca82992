//! The space things are drawn in: y up, the model's middle at zero, model units.

use bozzetto_core::surface::{Placement, UpAxis, Vector};
use glam::DVec3;

/// Translates between steps, model space and drawing space. Relative to the placement's origin, so that `f32` is
/// fine enough for drawing wherever the model lies.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    origin: DVec3,
    step: f64,
    up: UpAxis,
}

impl Frame {
    /// The frame of a placement.
    pub fn of(placement: &Placement) -> Self {
        Self { origin: DVec3::from_array(placement.origin), step: placement.step, up: placement.up }
    }

    /// A position or vector in steps, as it is drawn.
    pub fn place(&self, steps: Vector) -> DVec3 {
        self.turn(DVec3::from_array(steps.map(f64::from)) * self.step)
    }

    /// A model position as it is drawn.
    pub fn place_model(&self, position: [f64; 3]) -> DVec3 {
        self.turn(DVec3::from_array(position) - self.origin)
    }

    /// [`Self::place`] in the renderer's precision.
    pub fn place_f32(&self, steps: Vector) -> [f32; 3] {
        self.place(steps).as_vec3().to_array()
    }

    /// [`Self::place_f32`] of many at once.
    ///
    /// # Panics
    /// If there are not as many places as positions.
    pub fn place_all(&self, steps: &[Vector], places: &mut [[f32; 3]]) {
        assert_eq!(steps.len(), places.len());
        let step = self.step;
        let scaled = |x: i32| (f64::from(x) * step) as f32;
        match self.up {
            UpAxis::Y => {
                let all = steps.as_flattened().iter().zip(places.as_flattened_mut());
                all.for_each(|(&x, place)| *place = scaled(x));
            }
            UpAxis::Z => {
                let all = steps.iter().zip(places);
                all.for_each(|(&[x, y, z], place)| *place = [scaled(x), scaled(z), -scaled(y)]);
            }
            UpAxis::X => {
                let all = steps.iter().zip(places);
                all.for_each(|(&[x, y, z], place)| *place = [-scaled(y), scaled(x), scaled(z)]);
            }
        }
    }

    /// A model vector as it is drawn.
    pub fn turn(&self, model: DVec3) -> DVec3 {
        match self.up {
            UpAxis::Y => model,
            UpAxis::Z => DVec3::new(model.x, model.z, -model.y),
            UpAxis::X => DVec3::new(-model.y, model.x, model.z),
        }
    }

    /// A drawn vector in model units.
    pub fn turn_back(&self, drawn: DVec3) -> DVec3 {
        match self.up {
            UpAxis::Y => drawn,
            UpAxis::Z => DVec3::new(drawn.x, -drawn.z, drawn.y),
            UpAxis::X => DVec3::new(drawn.y, -drawn.x, drawn.z),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_up_axis_points_up_and_nothing_is_mirrored() {
        for (up, axis) in [(UpAxis::X, DVec3::X), (UpAxis::Y, DVec3::Y), (UpAxis::Z, DVec3::Z)] {
            let placement = Placement { origin: [1.0, -2.0, 3.0], step: 0.5, up, unit: String::new() };
            let frame = Frame::of(&placement);
            assert_eq!(frame.turn(axis), DVec3::Y, "{up}");
            let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|v| frame.turn(v));
            assert_eq!(x.cross(y), z, "{up}: right hands stay right hands");
            let v = DVec3::new(0.25, -7.0, 3.5);
            assert_eq!(frame.turn_back(frame.turn(v)), v, "{up}");
            let places = [[3, -5, 7], [0, 1 << 24, 9], [-1, 0, 1 - (1 << 24)]];
            let mut placed = [[0.0; 3]; 3];
            frame.place_all(&places, &mut placed);
            assert_eq!(placed, places.map(|p| frame.place_f32(p)), "{up}");
            assert_eq!(frame.place_model(placement.to_model([4, -6, 8])), frame.place([4, -6, 8]), "{up}");
        }
    }
}
