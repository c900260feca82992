//! Placeholder until the reader's type lands.
/// A triangle mesh as files hold it.
#[derive(Debug, Clone, PartialEq)]
pub struct TriangleMesh {
    /// Vertex positions, in model units.
    pub positions: Vec<[f64; 3]>,
    /// Corners, counter-clockwise from outside.
    pub faces: Vec<[u32; 3]>,
}
