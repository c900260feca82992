//! How many base faces and levels: by the size of the input, and more where a tolerance is not met.

use super::lay_out::Spacing;
use super::remesh::RemeshOptions;
use crate::mesh::TriangleMesh;

/// Faces of the finest level by default, for each face of the input.
const FINENESS: f64 = 2.5;
/// The same for small inputs, that have few faces where they bend, up to so many faces of the finest level.
const FINENESS_OF_SMALL: f64 = 3.6;
const SMALL: f64 = 72_000.0;
/// Faces of the finest level by default at most: a conversion takes time in proportion to them.
const MOST_FINEST: f64 = 200_000.0;
/// Levels by default.
const LEVELS: u8 = 4;
/// The fewest base faces aimed at by default.
const FEWEST_BASE_FACES: usize = 200;
/// And for each handle and each boundary loop: where they are many, most of the base faces lie round them, and those that are
/// left are stretched over the rest.
const FACES_PER_HANDLE: usize = 25;
const FACES_PER_LOOP: usize = 6;
/// Faces of the finest level by default at most, for each face of the input, where the base mesh has more than were aimed
/// at: vertices stay below four times the input's.
pub(super) const MOST_TIMES: f64 = 3.9;

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
    /// How they are spaced.
    pub(super) spacing: Spacing,
    /// Whether they are fitted with little regard to even spacing.
    pub(super) closely: bool,
}

impl Size {
    /// From the options, the faces of the input, and the fewest base faces its topology can do with.
    pub(super) fn first(input_faces: usize, fewest: usize, options: &RemeshOptions) -> Self {
        let faces = input_faces as f64;
        let small = (faces * FINENESS_OF_SMALL).min(SMALL);
        let finest = (faces * FINENESS).max(small).min(MOST_FINEST);
        let levels = options.levels.unwrap_or_else(|| {
            let fewest = options.base_faces.unwrap_or(fewest.max(FEWEST_BASE_FACES));
            let per_face = finest / fewest as f64;
            (0..=LEVELS).rev().find(|&j| finer(j) <= per_face).unwrap_or(0).max(1)
        });
        let faces = options.base_faces.unwrap_or((finest / finer(levels.min(12))) as usize);
        Self { base_faces: faces.max(4), levels, spacing: Spacing::Even, closely: false }
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

    /// Faces of the finest level.
    pub(super) fn finest(self) -> f64 {
        self.base_faces as f64 * finer(self.levels)
    }
}

/// The fewest base faces aimed at by default for a surface of so many handles and boundary loops.
pub(super) fn fewest_base_faces(genus: u32, loops: u32) -> usize {
    FACES_PER_HANDLE * genus as usize + FACES_PER_LOOP * loops as usize
}

/// What to aim at instead where the base mesh has far more faces than were aimed at, as where handles or components are
/// many: fewer levels over a finer base mesh. `None` if the levels are affordable.
pub(super) fn affordable(size: Size, base_faces: usize, input_faces: usize) -> Option<Size> {
    let most = MOST_TIMES * input_faces as f64;
    let fits = |j: u8| finer(j) * base_faces as f64 <= most;
    if size.levels <= 1 || fits(size.levels) {
        return None;
    }
    let levels = (1..size.levels).rev().find(|&j| fits(j)).unwrap_or(1);
    // The base mesh may turn out larger than this again, by some.
    let aim = (size.finest().min(most) / finer(levels) / MOST_OVER) as usize;
    Some(Size { base_faces: aim.max(size.base_faces), levels, ..size })
}

/// As many faces, over a base mesh of a quarter of them, where there is time for one attempt only; `None` where there is more,
/// or the surface to be simplified has hardly more faces than that.
pub(super) fn as_is(size: Size, ground_faces: usize) -> Option<Size> {
    let base_faces = (size.finest() / finer(1)) as usize;
    let large = size.finest() > MOST_TRIED && 2 * base_faces <= ground_faces;
    large.then_some(Size { base_faces, levels: 1, spacing: Spacing::AsIs, ..size })
}

/// Faces at most of a surface that is made again another way.
pub(super) const MOST_TRIED: f64 = 100_000.0;

/// How many times as many faces as are aimed at a base mesh may have after all.
const MOST_OVER: f64 = 1.15;

/// Faces of a level for each base face.
pub(super) fn finer(level: u8) -> f64 {
    f64::from(4u32.pow(level.min(15).into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_base_faces_leave_fewer_levels_but_no_coarser_surface() {
        let size = Size { base_faces: 240, levels: 4, spacing: Spacing::Even, closely: false };
        assert_eq!(affordable(size, 255, 17_000), None);
        let other = affordable(size, 1_800, 17_000).expect("460,800 faces are too many");
        assert_eq!(other.levels, 2);
        let finest = other.finest();
        assert!(finest > 0.7 * size.finest() && finest * MOST_OVER <= 3.9 * 17_000.0, "{other:?}");
        // Nothing is left to leave out.
        assert_eq!(affordable(Size { levels: 1, ..size }, 16_000, 17_000), None);
        assert_eq!(affordable(size, 16_000, 17_000).expect("fewer").levels, 1);
    }

    #[test]
    fn handles_and_loops_ask_for_more_base_faces_and_fewer_levels() {
        let options = RemeshOptions::default();
        let of = |genus, loops| Size::first(800_000, fewest_base_faces(genus, loops), &options);
        assert_eq!((of(0, 0).levels, of(2, 5).levels), (4, 4));
        let (many, holes) = (of(55, 0), of(0, 1_300));
        assert_eq!((many.levels, holes.levels), (3, 2));
        assert!(many.base_faces >= 55 * 25 && holes.base_faces >= 1_300 * 6);
        assert!(many.finest() > 0.9 * of(0, 0).finest());
        let asked = RemeshOptions { base_faces: Some(700), ..options };
        assert_eq!(Size::first(800_000, 10_000, &asked).base_faces, 700, "what was asked for is kept");
    }

    #[test]
    fn only_what_is_too_large_to_be_made_again_is_laid_out_as_it_is_at_once() {
        let size = Size { base_faces: 3_125, levels: 3, spacing: Spacing::Even, closely: false };
        let stays = as_is(size, 150_000).expect("large");
        assert_eq!((stays.base_faces, stays.levels, stays.spacing), (50_000, 1, Spacing::AsIs));
        assert_eq!(as_is(size, 90_000), None);
        assert_eq!(as_is(Size { levels: 2, ..size }, 150_000), None);
    }

    #[test]
    fn small_inputs_are_made_finer_but_below_four_times_their_size() {
        let options = RemeshOptions::default();
        for faces in [300usize, 2_000, 9_000, 20_000, 40_000, 120_000] {
            let size = Size::first(faces, 0, &options);
            let times = size.finest() / faces as f64;
            assert!(times <= 3.7, "{faces} faces: {times}");
            assert!(times >= if faces <= 20_000 { 3.3 } else { 1.6 }, "{faces} faces: {times}");
        }
    }
}
