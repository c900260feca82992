//! The largest wavelet coefficients, and what dropping the others costs.
//!
//! Based on: DeRose, Lounsbery, Stollnitz, Eck, Hoppe et al., "Multiresolution Surfaces for Compression, Display, and
//! Editing"; Lounsbery, DeRose, Warren, ACM TOG 16(1), 1997. Coefficients are compared as `2^−j d^j`, since a wavelet of
//! level j spreads over an area of `4^−j`. Were the wavelets orthogonal, the squared error would be the sum of what is dropped;
//! those of k-discs nearly are, so that sum foretells it.

use crate::hierarchy::Level;
use crate::surface::{Surface, Vector};
use crate::wavelet::Wavelet;
use rayon::prelude::*;

/// A surface of the largest wavelet coefficients.
#[derive(Debug, Clone)]
pub struct Kept {
    /// The surface: all of `c^0`, and zeros for what was dropped.
    pub surface: Surface,
    /// How many coefficients it keeps that are not zero.
    pub kept: usize,
    /// How many there were, zeros included.
    pub all: usize,
    /// What [`domain_distance`] between the two should be, by the dropped coefficients alone.
    pub predicted: f64,
}

/// The squared norm of a wavelet of level 0 in a regular neighbourhood, in areas of a base face; one of level j has `4^−j`
/// of it.
pub fn regular_norm(wavelet: Wavelet) -> f64 {
    match wavelet {
        Wavelet::Lazy => 0.25,
        Wavelet::Disc(0) => 0.175595238,
        Wavelet::Disc(1) => 0.170597484,
        Wavelet::Disc(_) => 0.170107466,
    }
}

/// Keeps a fraction of the wavelet coefficients, the largest after L2 normalisation, and all that are as large as the
/// smallest of these. `O(n_J)`.
///
/// # Panics
/// If the fraction is not from 0 to 1.
pub fn keep_largest(surface: &Surface, fraction: f64) -> Kept {
    assert!((0.0..=1.0).contains(&fraction), "a fraction is from 0 to 1");
    let finest = surface.finest().0;
    // Squared magnitudes on the scale of the finest level are exact integers.
    let size = |level: u8, d: &Vector| -> u128 { squared(*d) << (2 * (finest - level)) };
    let mut sizes: Vec<u128> =
        (0..finest).flat_map(|j| surface.wavelets(Level(j)).iter().map(move |d| size(j, d))).collect();
    let all = sizes.len();
    let count = (all as f64 * fraction).round() as usize;
    let threshold = match count {
        0 => u128::MAX,
        count => *sizes.select_nth_unstable_by(count - 1, |a, b| b.cmp(a)).1,
    };
    let dropped: u128 = sizes.iter().filter(|&&size| size < threshold).sum();
    let kept = sizes.iter().filter(|&&size| size >= threshold.max(1)).count();
    let wavelets: Vec<Vec<Vector>> = (0..finest)
        .map(|j| {
            let keep = |d: &Vector| if size(j, d) >= threshold { *d } else { [0; 3] };
            surface.wavelets(Level(j)).iter().map(keep).collect()
        })
        .collect();
    let smaller = Surface::from_coefficients(
        surface.hierarchy().as_ref().clone(),
        surface.form().clone(),
        surface.scaling(Level::BASE).to_vec(),
        wavelets,
    )
    .expect("its weights were solved before");
    let faces = surface.hierarchy().base().faces().len() as f64;
    let on_level_0 = dropped as f64 / 4f64.powi(i32::from(finest));
    let form = surface.form();
    let predicted = (on_level_0 * regular_norm(form.wavelet) / faces).sqrt() * form.placement.step;
    Kept { surface: smaller, kept, all, predicted }
}

/// The root mean square distance, in model units, between points of two surfaces with the same place on the base mesh, where
/// every base face counts alike: the norm of the wavelets. It sees a shift along the surface too, so it is at least the distance
/// between the shapes. `O(n_J)`, the same bits for any number of threads.
///
/// # Panics
/// If the surfaces do not have the same hierarchy or placement.
pub fn domain_distance(a: &Surface, b: &Surface) -> f64 {
    let finest = a.finest();
    assert_eq!(a.hierarchy().base(), b.hierarchy().base(), "surfaces over one base mesh");
    assert!(finest == b.finest() && a.form().placement == b.form().placement);
    let triangles = a.hierarchy().triangles(finest);
    let (from, to) = (a.scaling(finest), b.scaling(finest));
    let apart = |slot: u32| -> [i64; 3] {
        let (p, q) = (from[slot as usize], to[slot as usize]);
        std::array::from_fn(|c| i64::from(q[c]) - i64::from(p[c]))
    };
    // Over a triangle the square of a linear function with values u, v, w at the corners has the mean
    // (u² + v² + w² + (u + v + w)²) / 12.
    let sum: u128 = triangles
        .par_iter()
        .with_min_len(4096)
        .map(|&corners| {
            let [u, v, w] = corners.map(apart);
            (0..3)
                .flat_map(|c| [u[c], v[c], w[c], u[c] + v[c] + w[c]])
                .map(|x| u128::from(x.unsigned_abs()).pow(2))
                .sum::<u128>()
        })
        .sum();
    (sum as f64 / (12.0 * triangles.len() as f64)).sqrt() * a.form().placement.step
}

fn squared(d: Vector) -> u128 {
    d.iter().map(|&x| u128::from(x.unsigned_abs()).pow(2)).sum()
}
