//! How many base faces and levels: by the size of the input, and more where a tolerance is not met.

use super::remesh::RemeshOptions;
use crate::mesh::TriangleMesh;

/// Faces of the finest level by default, for each face of the input.
const FINENESS: f64 = 2.5;
/// Faces of the finest level by default at most: a conversion takes time in proportion to them.
const MOST_FINEST: f64 = 200_000.0;
/// Levels by default.
const LEVELS: u8 = 4;
/// The fewest base faces aimed at by default.
const FEWEST_BASE_FACES: usize = 200;
/// How many times the faces aimed at are accepted before levels are left out.
const MOST_EXCESS: f64 = 4.0;

/// An attempt has this times the faces that a greatest distance over its tolerance asks for: distances of smooth places
/// fall with the faces, those of spikes later.
const MARGIN: f64 = 1.3;
/// Base faces are added rather than a level while so many times as many are enough.
const MOST_BASE_GROWTH: f64 = 2.0;
/// Faces of the finest level at most, for each face of the input, when a tolerance is kept; small inputs are allowed
/// [`ALWAYS_ALLOWED`].
const MOST_FOR_TOLERANCE: f64 = 48.0;
const ALWAYS_ALLOWED: f64 = 400_000.0;
/// And in any case.
const NEVER_MORE: f64 = 4_000_000.0;

/// The size of one attempt.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Size {
    /// Base faces aimed at.
    pub(super) base_faces: usize,
    /// Levels J.
    pub(super) levels: u8,
}

impl Size {
    /// From the options and the faces of the input.
    pub(super) fn first(input_faces: usize, options: &RemeshOptions) -> Self {
        let finest = (input_faces as f64 * FINENESS).min(MOST_FINEST);
        let levels = options.levels.unwrap_or_else(|| {
            let per_face = finest / options.base_faces.unwrap_or(FEWEST_BASE_FACES) as f64;
            (0..=LEVELS).rev().find(|&j| finer(j) <= per_face).unwrap_or(0).max(1)
        });
        let faces = options.base_faces.unwrap_or((finest / finer(levels.min(12))) as usize);
        Self { base_faces: faces.max(4), levels }
    }

    /// The next attempt after one whose greatest distance was `excess` times the tolerance; `None` if it was met, if
    /// the options leave nothing to change, or if it would be too large.
    pub(super) fn next(self, excess: f64, input: &TriangleMesh, options: &RemeshOptions) -> Option<Self> {
        if excess <= 1.0 {
            return None;
        }
        let growth = excess * MARGIN;
        let more_faces = Self { base_faces: (self.base_faces as f64 * growth) as usize + 1, ..self };
        let more_levels = Self { levels: self.levels + 1, ..self };
        let next = match (options.base_faces, options.levels) {
            (Some(_), Some(_)) => return None,
            (None, None) if growth > MOST_BASE_GROWTH => more_levels,
            (None, _) => more_faces,
            (Some(_), None) => more_levels,
        };
        let allowed = (MOST_FOR_TOLERANCE * input.faces.len() as f64).clamp(ALWAYS_ALLOWED, NEVER_MORE);
        // A base mesh needs far fewer faces than its input.
        let simple = next.base_faces * 4 <= input.faces.len().max(4 * self.base_faces);
        (next.finest() <= allowed && simple).then_some(next)
    }

    fn finest(self) -> f64 {
        self.base_faces as f64 * finer(self.levels)
    }
}

/// So many levels, or fewer if the base mesh has far more faces than were aimed at, as where components are many.
pub(super) fn affordable(levels: u8, base_faces: usize, input_faces: usize) -> u8 {
    let most = FINENESS * MOST_EXCESS * input_faces as f64 / base_faces as f64;
    (1..=levels).rev().find(|&j| finer(j) <= most).unwrap_or(levels.min(1))
}

/// Faces of a level for each base face.
fn finer(level: u8) -> f64 {
    f64::from(4u32.pow(level.min(15).into()))
}
