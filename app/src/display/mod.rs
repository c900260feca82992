//! What of a surface is shown: vertices and normals of a level as plain arrays, followed locally through edits, and
//! the overlays that explain it. Knows the core and the renderer's plain types; neither egui nor wgpu.

mod frame;
mod heat;
mod hidden;
mod normals;
mod overlay;
mod pick_tree;
mod vertices;

pub use frame::Frame;
pub use heat::HeatScale;
pub use hidden::HiddenFaces;
pub use overlay::{Influence, support_border, tints};
pub use pick_tree::{Hit, PickTree};
pub use vertices::ShownVertices;
