//! Triangle meshes as files hold them: connectivity, shapes, distance.

pub mod connectivity;
pub mod shapes;
mod triangle_mesh;

pub use connectivity::{Connectivity, NotManifold};
pub use triangle_mesh::TriangleMesh;
