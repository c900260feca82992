//! What the file and session tests work on: small models over awkward base meshes, numbers without pattern that are the
//! same every time, and edits drawn from them.

#![allow(dead_code, reason = "every test program uses its own part of this")]

use bozzetto_core::edit::{Edit, Falloff, Gain, Kind, Move, Stroke, Tool};
use bozzetto_core::file::{Metadata, Model, SourceIndices};
use bozzetto_core::hierarchy::{BaseMesh, Hierarchy, Level};
use bozzetto_core::mesh::TriangleMesh;
use bozzetto_core::surface::{Form, Placement, Surface, UpAxis, Vector};
use bozzetto_core::wavelet::{Scheme, Wavelet};
use std::sync::Arc;

/// Numbers without pattern (SplitMix64).
#[derive(Debug, Clone)]
pub(crate) struct Numbers(pub(crate) u64);

impl Numbers {
    /// Any 64 bits.
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A whole number below `end`.
    pub(crate) fn below(&mut self, end: u32) -> u32 {
        (self.bits() % u64::from(end)) as u32
    }

    /// A number from −1 to 1.
    pub(crate) fn signed(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// A permutation of `0..count`.
    pub(crate) fn permutation(&mut self, count: u32) -> Vec<u32> {
        let mut order: Vec<u32> = (0..count).collect();
        for at in (1..order.len()).rev() {
            order.swap(at, self.below(at as u32 + 1) as usize);
        }
        order
    }
}

/// A surface with random vertices within ±2^24 steps; the first `sharp` edges met in the face list are sharp. The
/// placement has no round numbers in it.
pub(crate) fn surface(mesh: &TriangleMesh, wavelet: Wavelet, sharp: usize, finest: u8, seed: u64) -> Surface {
    let marks: Vec<[u32; 2]> = mesh.faces.iter().take(sharp).map(|f| [f[0], f[1]]).collect();
    let base = BaseMesh::new(mesh.positions.len() as u32, mesh.faces.clone(), &marks).expect("a base mesh");
    let hierarchy = Hierarchy::new(Arc::new(base), Level(finest)).expect("small");
    let mut numbers = Numbers(seed);
    let count = hierarchy.layout(Level(finest)).len();
    let mut coordinate = || (numbers.bits() >> 39) as i32 - (1 << 24);
    let positions: Vec<Vector> = (0..count).map(|_| std::array::from_fn(|_| coordinate())).collect();
    let placement = Placement {
        origin: [0.1, -7.3, 1e3],
        step: 1.1 / f64::from(1 << 24),
        up: UpAxis::Z,
        unit: "mm".into(),
    };
    let form = Form { scheme: Scheme::Linear, wavelet, precision: 24, placement };
    Surface::from_finest(hierarchy, form, positions).expect("small valences")
}

/// A ball with bumps, its poles on the y axis, mirrored to itself by every axis plane.
pub(crate) fn ball(levels: u8) -> Surface {
    Surface::ball(levels, |[x, _, z]| 1.0 + 0.02 * (40.0 * x.abs()).sin() * (40.0 * z.abs()).sin())
}

/// A [`surface`] as the content of a file, with metadata and a source map.
pub(crate) fn model(mesh: &TriangleMesh, wavelet: Wavelet, sharp: usize, finest: u8, seed: u64) -> Model {
    let surface = surface(mesh, wavelet, sharp, finest, seed);
    let source = Numbers(!seed).permutation(surface.scaling(surface.finest()).len() as u32);
    let metadata = Metadata { source: Some("Büste.obj".into()), source_sha256: Some("00ff".into()) };
    Model::new(surface, Some(SourceIndices::new(&source)), metadata)
}

/// Every integer a surface holds: `c^0 … c^J`, then `d^0 … d^{J−1}`.
pub(crate) fn contents(surface: &Surface) -> Vec<Vec<Vector>> {
    let scaling = (0..=surface.finest().0).map(|j| surface.scaling(Level(j)).to_vec());
    let wavelets = (0..surface.finest().0).map(|j| surface.wavelets(Level(j)).to_vec());
    scaling.chain(wavelets).collect()
}

/// The whole transform of the finest positions gives what the surface holds.
pub(crate) fn assert_consistent(surface: &Surface) {
    let finest = surface.scaling(surface.finest()).to_vec();
    let hierarchy = surface.hierarchy().as_ref().clone();
    let anew = Surface::from_finest(hierarchy, surface.form().clone(), finest).expect("as before");
    assert!(contents(&anew) == contents(surface) && anew.hash() == surface.hash());
}

/// An edit that the surface takes, moves of up to half a unit: one coefficient, a neighbourhood or now and then a gain.
pub(crate) fn draw_edit(numbers: &mut Numbers, surface: &Surface) -> Edit {
    let finest = surface.finest().0;
    if finest > 0 && numbers.below(12) == 0 {
        let level = numbers.below(u32::from(finest)) as u8;
        return Edit::Gain(Gain { level, factor: numbers.signed(), v: 1 });
    }
    Edit::Move(draw_move(numbers, surface))
}

/// A move as [`draw_edit`] draws it.
pub(crate) fn draw_move(numbers: &mut Numbers, surface: &Surface) -> Move {
    let finest = u32::from(surface.finest().0);
    let kind = if finest > 0 && numbers.below(2) == 0 { Kind::Wavelet } else { Kind::Scaling };
    let (levels, wavelet) = if kind == Kind::Wavelet { (finest, true) } else { (finest + 1, false) };
    let level = numbers.below(levels) as u8;
    let layout = surface.hierarchy().layout(Level(level));
    let vertex =
        if wavelet { layout.len() + numbers.below(layout.odd_len()) } else { numbers.below(layout.len()) };
    let radius = (numbers.below(3) == 0).then(|| 0.1 + 0.6 * (numbers.signed() + 1.0));
    let falloffs = [Falloff::Smooth, Falloff::Linear, Falloff::Sharp, Falloff::Constant];
    let falloff = radius.and_then(|_| falloffs.get(numbers.below(5) as usize).copied());
    let delta = std::array::from_fn(|_| 0.5 * numbers.signed());
    Move { kind, level, vertex, delta, radius, falloff, mirror: None, v: 1 }
}

/// Runs the same work on so many threads.
pub(crate) fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a thread pool").install(work)
}

/// A stroke without dabs.
pub(crate) fn stroke(tool: Tool, level: u8, radius: f64) -> Stroke {
    Stroke {
        tool,
        level,
        radius,
        strength: 0.5,
        falloff: None,
        mirror: None,
        to: None,
        from: Some([0.3, 0.1, -0.2]),
        dabs: Vec::new(),
        v: 1,
    }
}
