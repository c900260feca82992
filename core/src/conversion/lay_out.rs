//! From the domain to a lattice that lies evenly on the input: the order in which levels are evened, base edges
//! flipped and what is missed given more faces. Coarse lattices first, where a round costs little.

use super::base_flips::flipped;
use super::density::Density;
use super::domain::Domain;
use super::even::Evening;
use super::lattice::{Lattice, Places};
use super::parameterise::OnFace;
use super::simplify::Cancelled;
use super::walk::Ground;
use crate::hierarchy::Level;
use crate::mesh::TriangleMesh;

/// One lattice is evened: its finest level, the levels that slide and their rounds, and whether base edges are flipped
/// afterwards.
struct Stage {
    finest: u8,
    rounds: &'static [(Level, usize)],
    flips: bool,
}

/// Without the first stages handles of the input stay twisted, and horns and ears are spread over too few faces; there
/// a round costs little. On four scans twice the rounds of the last stages change the error by nothing.
const STAGES: [Stage; 9] = [
    Stage { finest: 2, rounds: &[(Level(0), 6), (Level(1), 6), (Level(2), 6)], flips: true },
    Stage { finest: 2, rounds: &[(Level(0), 6), (Level(1), 6), (Level(2), 6)], flips: true },
    Stage { finest: 2, rounds: &[(Level(0), 6), (Level(1), 6), (Level(2), 6)], flips: true },
    Stage { finest: 2, rounds: &[(Level(0), 6), (Level(1), 6), (Level(2), 6)], flips: true },
    Stage { finest: 2, rounds: &[(Level(0), 6), (Level(1), 6), (Level(2), 6)], flips: true },
    Stage { finest: 3, rounds: &[(Level(1), 4), (Level(2), 4), (Level(3), 4)], flips: true },
    Stage { finest: 3, rounds: &[(Level(0), 4), (Level(1), 4), (Level(2), 4), (Level(3), 4)], flips: true },
    Stage { finest: 4, rounds: &[(Level(2), 3), (Level(3), 4), (Level(4), 3)], flips: false },
    Stage { finest: 15, rounds: &[(Level(3), 3), (Level(4), 6)], flips: false },
];

/// Faces of the coarse lattice at most in which a first stage more is gone through, all those stages together: a fine base mesh
/// is less twisted, and its first stages cost as much as the last ones.
const MOST_COARSE: usize = 100_000;

/// How a lattice is spaced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Spacing {
    /// Evenly, by the density.
    Even,
    /// Evenly, but without the first stages: thin horns stay where simplification put them.
    Gentle,
    /// As the domain has it: where its faces are hardly fewer than the input's, its edges lie on the input's.
    AsIs,
}

impl Spacing {
    fn stages(self, base_faces: usize) -> &'static [Stage] {
        let first = (MOST_COARSE / (16 * base_faces)).clamp(1, GENTLE + 1);
        match self {
            Self::Even => &STAGES[GENTLE + 1 - first..],
            Self::Gentle => &STAGES[GENTLE..],
            Self::AsIs => &[],
        }
    }
}

/// Stages left out for a gentle layout.
const GENTLE: usize = 4;
/// A vertex of the input is missed if the surface is this part of an edge of the finest level away.
const FAR: f64 = 0.3;

/// What a lattice is laid over.
pub(super) struct Input<'a> {
    pub(super) mesh: &'a TriangleMesh,
    pub(super) ground: &'a Ground<'a>,
    pub(super) domain: &'a Domain<'a>,
}

/// Why there is no lattice.
pub(super) enum NoLattice {
    /// It would have too many vertices.
    TooFine,
    /// The progress function asked to stop.
    Cancelled,
}

impl From<Cancelled> for NoLattice {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

/// Lays `levels` levels over the domain; returns the lattice and the places of its vertices on the input.
pub(super) fn lay_out(
    input: &Input,
    density: &mut Density,
    levels: Level,
    spacing: Spacing,
    progress: &dyn Fn(f32) -> bool,
) -> Result<(Lattice, Places), NoLattice> {
    let stages = spacing.stages(input.domain.base.faces().len());
    let Input { ground, domain, .. } = *input;
    let first = stages.first().map_or(levels, |stage| levels.min(Level(stage.finest)));
    let mut lattice = Lattice::over(domain, first).ok_or(NoLattice::TooFine)?;
    // Whether the finest level fits, before any work.
    Lattice::fits(domain, levels).ok_or(NoLattice::TooFine)?;
    // Where its vertices are, while that is known.
    let mut points = None;
    for (at, stage) in stages.iter().enumerate() {
        let finest = Level(stage.finest.min(levels.0));
        let asked = || progress(at as f32 / stages.len() as f32);
        while lattice.hierarchy.finest() < finest {
            lattice = lattice.refined(domain).ok_or(NoLattice::TooFine)?;
            points = None;
        }
        let start = match points.take() {
            Some(points) => points,
            None => lattice.points(domain, &asked)?,
        };
        if at > 0 {
            reveal(input, density, &lattice, &start);
        }
        let evening = Evening { domain, ground, density: &density.at };
        let places = evening.run(&mut lattice, start, stage.rounds, &asked)?;
        if stage.flips
            && let Some(better) = flipped(&lattice, domain, &places)
        {
            lattice = better;
        } else {
            points = Some(places.points);
        }
    }
    let points = match points {
        Some(points) => points,
        None => lattice.points(domain, &|| progress(1.0))?,
    };
    let places = Places::of(ground, &density.at, points);
    Ok((lattice, places))
}

/// Raises the density where the lattice misses something.
fn reveal(input: &Input, density: &mut Density, lattice: &Lattice, points: &[OnFace]) {
    let surface = TriangleMesh::new(
        points.iter().map(|point| input.ground.place(point).to_array()).collect(),
        lattice.fitted.pattern.faces().to_vec(),
    );
    let edge = (4.0 / 3f64.sqrt() * density.area() / surface.faces.len() as f64).sqrt();
    density.reveal(input.mesh, &surface, points, FAR * edge);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fine_base_meshes_go_through_fewer_first_stages() {
        let stages = |base_faces| Spacing::Even.stages(base_faces).len();
        assert_eq!([400, 1_250, 3_125, 12_500].map(stages), [9, 9, 6, 5]);
        assert_eq!(Spacing::Gentle.stages(400).len(), 5);
    }
}
