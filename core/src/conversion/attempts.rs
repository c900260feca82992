//! Whether a conversion is made again another way: with more faces where a tolerance is not met; where nothing was asked
//! for and the surface is rough or lies in folds, over another base mesh.

use super::lay_out::Spacing;
use super::remesh::RemeshOptions;
use super::size::{MOST_TIMES, MOST_TRIED, Size, finer};
use super::unfold::MOST_LOOKS;
use crate::mesh::{Comparison, TriangleMesh};

/// Faces of attempts in a row that hardly come closer than the best before, after which no more are made: what is left
/// is a place that more faces do not mend.
const MOST_STALLED: f64 = 600_000.0;
/// An attempt comes closer if its greatest distance is below this part of the least before.
const CLOSER: f64 = 0.9;

/// A first attempt further off than this, over the diagonal, is made again another way.
const POOR: f64 = 8e-3;
/// A surface is rough from this root mean square on, over the diagonal.
const ROUGH: f64 = 2e-4;
/// Faces at most of a surface that is made again as the input is, because some are turned over.
const MOST_AS_IS: f64 = 60_000.0;
/// Boxes and triangles that fits may have looked at before one more attempt is made at a surface that is less rough: so many
/// for each face made, and so many more. They take some 350 a face, of small inputs 800, where those are sound; where one lies
/// through itself, or is crumpled, many times as many.
const LOOKS_PER_FACE: f64 = 600.0;
const LOOKS: f64 = 4e6;
/// Nor is one made where a larger part of the faces than this is turned over: so many folds are the input's.
const MOST_FOLDED: f64 = 0.02;
/// What a face that is turned over counts against the root mean square.
const TURNED: f64 = 1e-6;

/// What came of an attempt.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    pub(super) measured: Comparison,
    /// Faces that are turned over, or without area.
    pub(super) turned: usize,
    /// Boxes and triangles that the fits of this and all attempts before it looked at.
    pub(super) looks: u64,
}

impl Found {
    /// What results are compared by: the greatest distance where that was promised or is poor, else the root mean square
    /// and what is turned over.
    pub(super) fn badness(&self, options: &RemeshOptions) -> f64 {
        let Comparison { rms, max, .. } = self.measured;
        if options.tolerance.is_some() {
            return max;
        }
        rms + self.turned as f64 * TURNED + (max - POOR).max(0.0)
    }
}

/// The attempts so far.
#[derive(Debug)]
pub(super) struct Attempts {
    least: f64,
    /// Faces of the attempts since one came closer.
    stalled: f64,
    /// How many, and their faces.
    made: u64,
    faces: f64,
    /// Whether a gentle one was made.
    gentle: bool,
    /// The first of those at a surface that is less rough, and how many there were.
    rough: Option<(Size, usize)>,
}

impl Attempts {
    pub(super) fn new() -> Self {
        Self { least: f64::INFINITY, stalled: 0.0, made: 0, faces: 0.0, gentle: false, rough: None }
    }

    /// What is left for turning faces back in the next attempt: where nothing was promised, the less the more were made.
    pub(super) fn unfolding(&self, options: &RemeshOptions) -> u64 {
        if options.tolerance.is_some() { MOST_LOOKS } else { MOST_LOOKS / (1 + self.made) }
    }

    /// The next after one of this size; see [`Size::next`].
    pub(super) fn next(
        &mut self,
        size: Size,
        found: &Found,
        input: &TriangleMesh,
        options: &RemeshOptions,
    ) -> Option<Size> {
        self.made += 1;
        self.faces += size.finest();
        // A thin horn may have been left behind: once more another way before there are more faces.
        let poor = found.measured.max > POOR && !std::mem::replace(&mut self.gentle, true);
        let next = match options.tolerance {
            Some(tolerance) => {
                let greatest = found.measured.max;
                self.stalled =
                    if greatest < CLOSER * self.least { 0.0 } else { self.stalled + size.finest() };
                self.least = self.least.min(greatest);
                (self.stalled < MOST_STALLED).then(|| size.next(greatest / tolerance, input, options))?
            }
            None if poor => None,
            None => self.less_rough(size, found, input, options),
        };
        if poor { Some(Size { spacing: Spacing::Gentle, ..size }) } else { next }
    }

    /// The next where nothing was asked for, as long as the surface is rough or lies in folds. More base faces and fewer
    /// levels leave fewer folds; a surface that is rough, as small inputs are that bend at every edge, gets as many faces as
    /// are affordable, at last over a base mesh that is hardly coarser than the input.
    fn less_rough(
        &mut self,
        size: Size,
        found: &Found,
        input: &TriangleMesh,
        options: &RemeshOptions,
    ) -> Option<Size> {
        let rough = found.measured.rms > ROUGH;
        let asked = options.base_faces.is_some() || options.levels.is_some();
        let tangled = found.looks as f64 > LOOKS + LOOKS_PER_FACE * self.faces
            || found.turned as f64 > MOST_FOLDED * size.finest();
        if asked || tangled || !(rough || found.turned > 0) {
            return None;
        }
        let (first, made) = self.rough.get_or_insert((size, 0));
        let (first, levels) = (*first, first.levels);
        *made += 1;
        let over = |levels: u8, finest: f64| {
            let base_faces = (finest / finer(levels)) as usize;
            Size { base_faces, levels, spacing: size.spacing, closely: rough }
        };
        let most = MOST_TIMES * input.faces.len() as f64;
        let as_is = Size { spacing: Spacing::AsIs, ..over(1, most) };
        if !rough {
            let finer =
                (levels > 1 && first.finest() <= MOST_TRIED).then(|| over(levels - 1, first.finest()));
            let is_as_is = size.spacing == Spacing::AsIs;
            let as_is = (!is_as_is && as_is.finest() <= MOST_AS_IS).then_some(as_is);
            return [finer, as_is].into_iter().flatten().nth(*made - 1);
        }
        let sizes = [over(levels - 1, most), as_is];
        let allowed = |size: &&Size| size.levels > 0 && size.finest() <= MOST_TRIED;
        sizes.iter().filter(allowed).nth(*made - 1).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::OneWay;
    use crate::mesh::shapes::{octahedron, subdivide};

    fn found(rms: f64, max: f64, turned: usize) -> Found {
        let way = OneWay { mean: 0.5 * rms, rms, max };
        let measured = Comparison { a_to_b: way, b_to_a: way, rms, max, psnr: None, diagonal: 1.0 };
        Found { measured, turned, looks: 0 }
    }

    /// The sizes tried when all attempts come to the same.
    fn sizes(input: &TriangleMesh, options: &RemeshOptions, found: Found) -> Vec<Size> {
        let mut attempts = Attempts::new();
        let first = Size::first(input.faces.len(), 0, options);
        std::iter::successors(Some(first), |&size| attempts.next(size, &found, input, options)).collect()
    }

    #[test]
    fn attempts_end_when_more_faces_bring_nothing() {
        let input = subdivide(&octahedron(), 6);
        let options = RemeshOptions { tolerance: Some(1e-3), ..RemeshOptions::default() };
        let first = Size::first(input.faces.len(), 0, &options);
        let sizes = |greatest: &[f64]| {
            let mut attempts = Attempts::new();
            let mut size = Some(first);
            greatest
                .iter()
                .map(|&g| {
                    size = attempts.next(size?, &found(0.1 * g, g, 0), &input, &options);
                    size
                })
                .collect::<Vec<_>>()
        };
        let falling = sizes(&[1.5e-3, 1.3e-3, 1.15e-3, 0.9e-3]);
        assert!(falling[..3].iter().all(Option::is_some), "{falling:?}");
        assert_eq!(falling[3], None, "the tolerance is met");
        let stuck = sizes(&[1.3e-3, 1.25e-3, 1.2e-3, 1.18e-3]);
        assert!(stuck[2].is_some() && stuck[3].is_none(), "{stuck:?}");
        let late = sizes(&[1.3e-3, 1.25e-3, 1.2e-3, 1.05e-3, 1.04e-3]);
        assert!(late[4].is_some(), "an attempt that comes closer starts the count anew: {late:?}");
    }

    #[test]
    fn what_is_left_behind_is_laid_out_gently_once() {
        let input = subdivide(&octahedron(), 6);
        let strict = RemeshOptions { tolerance: Some(0.5 * POOR), ..RemeshOptions::default() };
        let poor = found(1e-4, 1.1 * POOR, 0);
        for options in [RemeshOptions::default(), strict] {
            let tried = sizes(&input, &options, poor);
            assert_eq!(tried[1], Size { spacing: Spacing::Gentle, ..tried[0] });
            assert_eq!(tried.len() > 2, options.tolerance.is_some(), "{tried:?}");
        }
    }

    #[test]
    fn rough_surfaces_are_made_again_over_other_base_meshes_within_the_budget() {
        let input = subdivide(&octahedron(), 4);
        let options = RemeshOptions::default();
        assert_eq!(sizes(&input, &options, found(0.99 * ROUGH, 1e-3, 0)).len(), 1, "near enough");
        let rough = sizes(&input, &options, found(1.01 * ROUGH, 1e-3, 0));
        assert_eq!(rough.iter().map(|size| size.levels).collect::<Vec<_>>(), [2, 1, 1], "{rough:?}");
        for size in &rough[1..] {
            let times = size.finest() / input.faces.len() as f64;
            assert!(size.closely && (3.5..4.0).contains(&times), "{size:?}: {times}");
        }
        for asked in
            [RemeshOptions { levels: Some(2), ..options }, RemeshOptions { base_faces: Some(90), ..options }]
        {
            assert_eq!(sizes(&input, &asked, found(1.0, 1e-3, 9)).len(), 1, "what was asked for is kept");
        }
        let large = subdivide(&octahedron(), 7);
        assert_eq!(sizes(&large, &options, found(1e-3, 1e-3, 0)).len(), 1, "too dear");
        let tangled = [Found { looks: 10_000_000, ..found(1.0, 1e-3, 9) }, found(1.0, 1e-3, 400)];
        assert!(tangled.iter().all(|&tangled| sizes(&input, &options, tangled).len() == 1), "too dear");
    }

    #[test]
    fn folds_are_tried_over_a_finer_base_mesh_with_as_many_faces_then_as_the_input_is() {
        let (input, options) = (subdivide(&octahedron(), 5), RemeshOptions::default());
        let folded = sizes(&input, &options, found(1e-4, 1e-3, 1));
        assert_eq!(folded.len(), 3, "{folded:?}");
        assert_eq!((folded[2].levels, folded[2].spacing), (1, Spacing::AsIs));
        assert!(folded[2].finest() < 4.0 * input.faces.len() as f64);
        assert_eq!(folded[1].levels + 1, folded[0].levels);
        let growth = folded[1].finest() / folded[0].finest();
        assert!((0.99..=1.0).contains(&growth), "{folded:?}");
        let large = subdivide(&octahedron(), 7);
        assert_eq!(sizes(&large, &options, found(1e-4, 1e-3, 1)).len(), 1, "too dear");
    }

    #[test]
    fn the_best_result_leaves_least_behind_then_has_the_least_mean_square_and_fewest_folds() {
        let usual = RemeshOptions::default();
        let strict = RemeshOptions { tolerance: Some(1e-3), ..usual };
        let better = |a: Found, b: Found, options| a.badness(options) < b.badness(options);
        assert!(better(found(1e-4, 3e-3, 0), found(2e-4, 2e-3, 0), &usual));
        assert!(better(found(1.2e-4, 3e-3, 0), found(1e-4, 2e-3, 40), &usual));
        assert!(better(found(2e-4, 2e-3, 0), found(1e-4, 3e-2, 0), &usual));
        assert!(better(found(2e-4, 2e-3, 9), found(1e-4, 3e-3, 0), &strict));
    }
}
