//! The JSON of a glTF file, as far as it places triangles (glTF 2.0 specification, section 5).
//!
//! What is rarely there is boxed, so that a hostile text of many empty objects takes some twenty times its length.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::io::error::excerpt_of;
use crate::io::{Defect, Parsed, Place};

/// The longest JSON that is read. Real ones are under 1 MB, of large scenes some 20.
const LONGEST_JSON: usize = 64 << 20;

/// The top level.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Scenes {
    /// The number of the default scene.
    pub(super) scene: Option<usize>,
    #[serde(default)]
    pub(super) scenes: Vec<Scene>,
    #[serde(default)]
    pub(super) nodes: Vec<Node>,
    #[serde(default)]
    pub(super) meshes: Vec<Mesh>,
    #[serde(default)]
    pub(super) accessors: Vec<Accessor>,
    #[serde(default)]
    pub(super) buffer_views: Vec<BufferView>,
    #[serde(default)]
    pub(super) buffers: Vec<Buffer>,
    #[serde(default)]
    extensions_required: Vec<String>,
}

/// A scene: its root nodes.
#[derive(Debug, Deserialize)]
pub(super) struct Scene {
    #[serde(default)]
    pub(super) nodes: Vec<usize>,
}

/// A place in the scene, relative to its parent.
#[derive(Debug, Deserialize)]
pub(super) struct Node {
    #[serde(default)]
    pub(super) children: Vec<usize>,
    pub(super) mesh: Option<u32>,
    pub(super) skin: Option<IgnoredAny>,
    matrix: Option<Box<[f64; 16]>>,
    translation: Option<Box<[f64; 3]>>,
    rotation: Option<Box<[f64; 4]>>,
    scale: Option<Box<[f64; 3]>>,
}

/// Primitives drawn together.
#[derive(Debug, Deserialize)]
pub(super) struct Mesh {
    #[serde(default)]
    pub(super) primitives: Vec<Primitive>,
}

/// Triangles, lines or points.
#[derive(Debug, Deserialize)]
pub(super) struct Primitive {
    pub(super) attributes: Attributes,
    pub(super) indices: Option<usize>,
    #[serde(default = "triangles")]
    pub(super) mode: u32,
    extensions: Option<Box<PrimitiveExtensions>>,
}

/// The accessors of a primitive's vertices.
#[derive(Debug, Deserialize)]
pub(super) struct Attributes {
    #[serde(rename = "POSITION")]
    pub(super) position: Option<usize>,
}

#[derive(Debug, Deserialize)]
struct PrimitiveExtensions {
    #[serde(rename = "KHR_draco_mesh_compression")]
    draco: Option<IgnoredAny>,
}

/// Numbers of one kind in a part of the buffer.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub(super) buffer_view: Option<usize>,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) component_type: u32,
    pub(super) count: u64,
    #[serde(rename = "type")]
    pub(super) shape: Shape,
    #[serde(default)]
    pub(super) normalized: bool,
    pub(super) sparse: Option<IgnoredAny>,
}

/// How many numbers an element has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
pub(super) enum Shape {
    #[serde(rename = "SCALAR")]
    Scalar,
    #[serde(rename = "VEC3")]
    Vec3,
    #[serde(other)]
    Other,
}

/// A part of a buffer.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub(super) buffer: usize,
    #[serde(default)]
    pub(super) byte_offset: u64,
    pub(super) byte_length: u64,
    pub(super) byte_stride: Option<u64>,
    extensions: Option<Box<ViewExtensions>>,
}

#[derive(Debug, Deserialize)]
struct ViewExtensions {
    #[serde(rename = "EXT_meshopt_compression", alias = "KHR_meshopt_compression")]
    meshopt: Option<IgnoredAny>,
}

/// The file's binary chunk, or another file.
#[derive(Debug, Deserialize)]
pub(super) struct Buffer {
    pub(super) uri: Option<IgnoredAny>,
}

fn triangles() -> u32 {
    4
}

impl Scenes {
    /// Parses the JSON and refuses what needs extensions that change the triangles.
    pub(super) fn parse(json: &[u8]) -> Parsed<Self> {
        if json.len() > LONGEST_JSON {
            let problem = format!("its JSON is longer than {} MiB", LONGEST_JSON >> 20);
            return Err((Place::Whole, Defect::Scene { problem }));
        }
        let scenes: Self = serde_json::from_slice(json).map_err(|error| {
            let reason = excerpt_of(error.to_string().as_bytes(), 100);
            (
                Place::Whole,
                Defect::Scene { problem: format!("its JSON is not that of glTF 2.0 ('{reason}')") },
            )
        })?;
        match scenes.extensions_required.iter().find(|name| !leaves_triangles_alone(name)) {
            None => Ok(scenes),
            Some(name) if name == "KHR_draco_mesh_compression" => Err((Place::Whole, draco())),
            Some(name) => {
                let feature = format!("the extension '{}'", excerpt_of(name.as_bytes(), 60));
                Err((Place::Whole, Defect::Feature { feature }))
            }
        }
    }
}

/// Whether the triangles are the same for a reader that knows nothing of the extension. Quantised positions are read.
fn leaves_triangles_alone(extension: &str) -> bool {
    let families = ["KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_", "MSFT_texture_"];
    extension == "KHR_mesh_quantization" || families.iter().any(|family| extension.starts_with(family))
}

fn draco() -> Defect {
    Defect::Feature { feature: "a Draco-compressed mesh".to_owned() }
}

impl Primitive {
    /// Refuses positions that are nowhere but in compressed form.
    pub(super) fn check_compression(&self, positions: &Accessor) -> Result<(), Defect> {
        let compressed = self.extensions.as_ref().is_some_and(|extensions| extensions.draco.is_some());
        if compressed && positions.buffer_view.is_none() { Err(draco()) } else { Ok(()) }
    }
}

impl BufferView {
    /// Refuses data in compressed form.
    pub(super) fn check_compression(&self) -> Result<(), Defect> {
        match self.extensions.as_ref().is_some_and(|extensions| extensions.meshopt.is_some()) {
            true => Err(Defect::Feature { feature: "a mesh with meshopt compression".to_owned() }),
            false => Ok(()),
        }
    }
}

impl Node {
    /// The node's place relative to its parent; `None` if it is the parent's own. A rotation's length does not matter.
    pub(super) fn placement(&self) -> Option<DAffine3> {
        if let Some(matrix) = &self.matrix {
            let column = |k: usize| DVec3::from_slice(&matrix[4 * k..4 * k + 3]);
            let linear = DMat3::from_cols(column(0), column(1), column(2));
            return Some(DAffine3 { matrix3: linear, translation: column(3) });
        }
        if self.translation.is_none() && self.rotation.is_none() && self.scale.is_none() {
            return None;
        }
        let given = |vector: &Option<Box<[f64; 3]>>, otherwise| {
            vector.as_ref().map_or(otherwise, |v| DVec3::from(**v))
        };
        let rotation = self.rotation.as_ref().map_or(DQuat::IDENTITY, |q| DQuat::from_array(**q));
        let turn = if rotation.length_squared() > 0.0 {
            DMat3::from_quat(rotation.normalize())
        } else {
            DMat3::IDENTITY
        };
        let linear = turn * DMat3::from_diagonal(given(&self.scale, DVec3::ONE));
        Some(DAffine3 { matrix3: linear, translation: given(&self.translation, DVec3::ZERO) })
    }
}
