//! The space things are drawn in: y up, the model's middle at zero, model units.

use bozzetto_core::surface::{Placement, UpAxis, Vector};
use glam::DVec3;

/// Translates between steps, model space and drawing space. Relative to the placement's origin, so that `f32` is
/// fine enough for drawing wherever the model lies.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    step: f64,
    up: UpAxis,
}

impl Frame {
    /// The frame of a placement.
    pub fn of(placement: &Placement) -> Self {
        Self { step: placement.step, up: placement.up }
    }

    /// A position or vector in steps, as it is drawn.
    pub fn place(&self, steps: Vector) -> DVec3 {
        self.turn(DVec3::from_array(steps.map(f64::from)) * self.step)
    }

    /// The same in the renderer's precision.
    pub fn place_f32(&self, steps: Vector) -> [f32; 3] {
        self.place(steps).as_vec3().to_array()
    }

    /// A model vector as it is drawn.
    pub fn turn(&self, model: DVec3) -> DVec3 {
        match self.up {
            UpAxis::Y => model,
            UpAxis::Z => DVec3::new(model.x, model.z, -model.y),
        }
    }

    /// A drawn vector in model units.
    pub fn turn_back(&self, drawn: DVec3) -> DVec3 {
        match self.up {
            UpAxis::Y => drawn,
            UpAxis::Z => DVec3::new(drawn.x, -drawn.z, drawn.y),
        }
    }
}
