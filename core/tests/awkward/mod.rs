//! Converting meshes that nobody would make on purpose, and judging what comes out: a sound surface or one sentence.
#![allow(dead_code, reason = "every test program uses its own part of this")]

use bozzetto_core::conversion::clean::clean;
use bozzetto_core::conversion::remesh::Phase;
use bozzetto_core::conversion::{ConversionOptions, convert_with_progress};
use bozzetto_core::file::{Metadata, Model, decode, encode};
use bozzetto_core::mesh::{Connectivity, TriangleMesh};
use bozzetto_core::surface::{FormOptions, Surface};
use std::path::Path;

pub(crate) mod damage;
pub(crate) mod shapes;

/// What an import came to.
#[derive(Debug, Clone)]
pub(crate) enum Outcome {
    /// A surface, sound in every way that is checked.
    Converted(Figures),
    /// One sentence.
    Refused(String),
}

/// What is known of a converted mesh.
#[derive(Debug, Clone)]
pub(crate) struct Figures {
    /// Components, genus and boundary loops.
    pub(crate) topology: [u32; 3],
    /// Faces of the base mesh.
    pub(crate) base_faces: usize,
    /// J.
    pub(crate) levels: u8,
    /// Whether subdivision connectivity was found.
    pub(crate) detected: bool,
    /// What was repaired.
    pub(crate) cleaned: Vec<String>,
    /// Root mean square distance over the diagonal, where the mesh was remeshed.
    pub(crate) rms: f64,
}

/// Imports a mesh as the program does, up to the bytes of the wavelet file and back. `go_on` may stop the conversion,
/// which is then refused as cancelled.
///
/// Panics if a promise is broken.
pub(crate) fn import(
    mesh: &TriangleMesh,
    options: &ConversionOptions,
    go_on: &dyn Fn(Phase, f32) -> bool,
) -> Outcome {
    let converted = match convert_with_progress(mesh, options, go_on) {
        Ok(converted) => converted,
        Err(error) => return Outcome::Refused(sentence(error.to_string())),
    };
    let hierarchy = converted.hierarchy.clone();
    let finest = hierarchy.finest();
    let figures = Figures {
        topology: topology(converted.positions.len(), &hierarchy.triangles(finest)),
        base_faces: hierarchy.base().faces().len(),
        levels: finest.0,
        detected: converted.source.is_some(),
        cleaned: converted.cleaned.iter().cloned().map(sentence).collect(),
        rms: converted.measured.map_or(0.0, |measured| measured.rms),
    };
    assert_eq!(converted.positions.len(), hierarchy.layout(finest).len() as usize);
    assert!(converted.positions.iter().flatten().all(|x| x.is_finite()), "positions are finite");
    if converted.measured.is_some() {
        nothing_is_lost(mesh, &figures);
        if options.levels.is_none() && options.base_faces.is_none() {
            let finest = figures.base_faces << (2 * figures.levels);
            assert!(finest <= 10 * mesh.faces.len(), "{finest} faces are out of proportion");
        }
    }
    let surface = match Surface::from_positions(hierarchy, &converted.positions, &FormOptions::default()) {
        Ok(surface) => surface,
        Err(error) => return Outcome::Refused(sentence(error.to_string())),
    };
    let hash = surface.hash();
    let bytes = encode(&Model::new(surface, None, Metadata::default()));
    let read = decode(&bytes, Path::new("awkward.boz")).expect("what was encoded decodes");
    assert!(read.complete && read.surface.hash() == hash, "the file holds the surface");
    Outcome::Converted(figures)
}

/// The result has the topology that cleaning leaves, and cleaning says how many faces it took out.
fn nothing_is_lost(mesh: &TriangleMesh, figures: &Figures) {
    let cleaned = clean(mesh, 0.0).expect("what was converted has a surface");
    let after = topology(cleaned.positions.len(), cleaned.connectivity.faces());
    assert_eq!(figures.topology, after, "components, genus and loops are those after cleaning");
    assert_eq!(figures.cleaned, cleaned.report.sentences());
    let report = &cleaned.report;
    let told = report.degenerate + report.doubled + report.dropped;
    let lost = mesh.faces.len() - cleaned.connectivity.faces().len();
    assert!(told == lost || (told < lost && report.islands > 0), "{lost} faces are gone, {told} are told");
    assert!(figures.rms.is_finite() && figures.rms < 0.1, "rms {}", figures.rms);
}

/// Components, genus and boundary loops of a manifold.
pub(crate) fn topology(vertices: usize, faces: &[[u32; 3]]) -> [u32; 3] {
    let surface = Connectivity::build(vertices as u32, faces.to_vec()).expect("an oriented manifold");
    [surface.components(), surface.genus(), surface.boundary_loops()]
}

fn sentence(text: String) -> String {
    assert!(
        !text.is_empty() && !text.contains('\n') && !text.ends_with('.') && !text.contains(". "),
        "{text}"
    );
    text
}
