//! The renderer on whatever adapter there is, a software one included, and the camera without one.

mod camera;
mod pictures;
mod shapes;
