//! Triangle meshes as files hold them: connectivity, shapes, distance.

mod bounding_volumes;
pub mod connectivity;
mod deviation;
mod distance;
pub(crate) mod sampling;
pub mod shapes;
mod triangle_distance;
mod triangle_mesh;

pub use bounding_volumes::{Abandoned, BoundingVolumes, ClosestPoint, ClosestPointCursor};
pub use connectivity::{Connectivity, NotManifold};
pub use deviation::distances_to;
pub(crate) use distance::compare_with;
pub use distance::{CompareError, CompareOptions, Comparison, OneWay, compare};
pub(crate) use sampling::AreaSampler;
pub(crate) use triangle_distance::closest_on_triangle;
pub use triangle_mesh::{Bounds, FaceIndex, TriangleMesh};
