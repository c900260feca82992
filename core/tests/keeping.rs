//! Keeping the largest coefficients: the error foretold by what is dropped, and the error that it makes.

mod samples;

use bozzetto_core::hierarchy::{Level, Odd, Slot};
use bozzetto_core::lod::{domain_distance, keep_largest, regular_norm};
use bozzetto_core::mesh::shapes;
use bozzetto_core::surface::{Form, Surface};
use bozzetto_core::wavelet::Wavelet;
use samples::{contents, surface};

/// A ball with bumps of several sizes, nowhere smooth.
fn bumpy(wavelet: Wavelet, levels: u8) -> Surface {
    let wave = |p: [f64; 3], f: f64| (f * p[0]).sin() * (f * p[1] + 1.0).sin() * (f * p[2] + 2.0).sin();
    let ball = Surface::ball(levels, |p| {
        1.0 + 0.2 * wave(p, 3.0) + 0.06 * wave(p, 9.0) + 0.02 * wave(p, 27.0) + 0.01 * (p[0] + p[1]).abs()
    });
    let form = Form { wavelet, ..ball.form().clone() };
    let finest = ball.scaling(ball.finest()).to_vec();
    Surface::from_finest(ball.hierarchy().as_ref().clone(), form, finest).expect("as before")
}

/// The inner product of two functions given at the vertices of a level, in areas of a base face.
fn squared_norm(surface: &Surface, shown: Level, function: &[(Slot, f64)]) -> f64 {
    let mut values = vec![0.0; surface.scaling(shown).len()];
    function.iter().for_each(|&(slot, x)| values[slot.index()] = x);
    let area = 0.25f64.powi(i32::from(shown.0));
    let of = |corners: [u32; 3]| {
        let [u, v, w] = corners.map(|slot| values[slot as usize]);
        u * u + v * v + w * w + (u + v + w) * (u + v + w)
    };
    surface.hierarchy().triangles(shown).into_iter().map(of).sum::<f64>() * area / 12.0
}

#[test]
fn the_norms_are_those_of_wavelets_in_regular_places() {
    for wavelet in Wavelet::ALL {
        let torus = surface(&shapes::torus(4, 3), wavelet, 0, 4, 1);
        for level in [2, 3] {
            let odd = Odd(torus.hierarchy().layout(Level(level)).odd_len() - 5);
            let function = torus.wavelet_function(Level(level), odd, Level(level + 1));
            let norm = squared_norm(&torus, Level(level + 1), &function) * 4f64.powi(i32::from(level));
            assert!((norm / regular_norm(wavelet) - 1.0).abs() < 1e-5, "{wavelet}: {norm}");
        }
    }
}

/// The least and the greatest of (error / prediction)² that coefficients of one level can have where all is regular: the
/// extreme eigenvalues of the wavelets' inner products over their squared norms, by the power method.
fn riesz_bounds(wavelet: Wavelet) -> [f64; 2] {
    let torus = surface(&shapes::torus(4, 3), wavelet, 0, 3, 1);
    let level = Level(2);
    let count = torus.hierarchy().layout(level).odd_len();
    let functions: Vec<_> = (0..count).map(|odd| torus.wavelet_function(level, Odd(odd), Level(3))).collect();
    let triangles = torus.hierarchy().triangles(Level(3));
    let area = 0.25f64.powi(3);
    let gram = |x: &[f64]| -> Vec<f64> {
        let mut values = vec![0.0; torus.scaling(Level(3)).len()];
        for (function, x) in functions.iter().zip(x) {
            function.iter().for_each(|&(slot, y)| values[slot.index()] += x * y);
        }
        let mut weighed = vec![0.0; values.len()];
        for corners in &triangles {
            let sum: f64 = corners.iter().map(|&c| values[c as usize]).sum();
            corners.iter().for_each(|&c| weighed[c as usize] += (values[c as usize] + sum) * area / 12.0);
        }
        let norm = regular_norm(wavelet) / 16.0;
        let with = |f: &Vec<(Slot, f64)>| f.iter().map(|&(slot, y)| weighed[slot.index()] * y).sum::<f64>();
        functions.iter().map(|f| with(f) / norm).collect()
    };
    let greatest = |map: &dyn Fn(&[f64]) -> Vec<f64>| {
        let mut numbers = samples::Numbers(5);
        let mut x: Vec<f64> = (0..count).map(|_| numbers.signed()).collect();
        let mut value = 0.0;
        for _ in 0..300 {
            let y = map(&x);
            value = y.iter().map(|y| y * y).sum::<f64>().sqrt();
            x = y.iter().map(|y| y / value).collect();
        }
        value
    };
    let high = greatest(&gram);
    let low = high - greatest(&|x| gram(x).iter().zip(x).map(|(y, x)| high * x - y).collect());
    [low, high]
}

/// The paper's second property. 2-disc wavelets of different levels are nearly orthogonal (their update takes out all but 3
/// thousandths of what a coarser level sees), so what all levels together do is bounded by what one level can do, and at
/// irregular vertices, where norms are not the regular ones, by a tenth more.
#[test]
fn the_error_is_what_the_dropped_coefficients_foretell() {
    let [low, high] = riesz_bounds(Wavelet::Disc(2)).map(f64::sqrt);
    assert!(low > 0.5 && high < 1.41, "from {low} to {high}");
    let whole = bumpy(Wavelet::Disc(2), 6);
    let mut before = f64::INFINITY;
    for share in [0.0, 0.003, 0.01, 0.03, 0.12, 0.3, 0.7] {
        let kept = keep_largest(&whole, share);
        let measured = domain_distance(&whole, &kept.surface);
        assert!(measured > 0.9 * low * kept.predicted, "{share}: {measured}, {} foretold", kept.predicted);
        assert!(measured < 1.1 * high * kept.predicted, "{share}: {measured}, {} foretold", kept.predicted);
        // Where many coefficients of all kinds are dropped, which is no worst case, it is much nearer.
        let near = (measured / kept.predicted - 1.0).abs() < 0.1;
        assert!(near || share == 0.0, "{share}: {measured}, {} foretold", kept.predicted);
        assert!(measured < before, "{share}");
        before = measured;
    }
}

/// The other wavelets: the more orthogonal, the nearer is what is foretold to what is measured, and at every share any disc
/// wavelet is nearer to the whole than the lazy one.
#[test]
fn the_wider_the_disc_the_truer_the_prediction() {
    const SHARES: [f64; 5] = [0.01, 0.03, 0.12, 0.3, 0.7];
    let curve = |wavelet: Wavelet| {
        let whole = bumpy(wavelet, 6);
        SHARES.map(|share| {
            let kept = keep_largest(&whole, share);
            let measured = domain_distance(&whole, &kept.surface);
            (measured, (measured / kept.predicted - 1.0).abs())
        })
    };
    let curves = Wavelet::ALL.map(curve);
    let off = |curve: &[(f64, f64); 5]| curve.iter().map(|&(_, off)| off).fold(0.0, f64::max);
    let [lazy, none, one, two] = [0, 1, 2, 3].map(|at| off(&curves[at]));
    assert!(lazy > 2.0 * none && none > one && one > two, "{lazy}, {none}, {one}, {two}");
    for disc in &curves[1..] {
        for ((lazy, disc), share) in curves[0].iter().zip(disc).zip(SHARES) {
            assert!(disc.0 < 0.95 * lazy.0, "{share}: {} against {} of lazy", disc.0, lazy.0);
        }
    }
}

#[test]
fn what_is_kept_is_the_largest() {
    for wavelet in Wavelet::ALL {
        let whole = bumpy(wavelet, 4);
        let kept = keep_largest(&whole, 0.2);
        assert_eq!(kept.all, 1020);
        assert!((204..=206).contains(&kept.kept), "{}", kept.kept);
        let size = |level: u8, d: &[i32; 3]| {
            d.iter().map(|&x| f64::from(x).powi(2)).sum::<f64>() / 4f64.powi(i32::from(level))
        };
        let (mut least, mut most) = (f64::INFINITY, 0f64);
        for level in 0..4 {
            let pair = whole.wavelets(Level(level)).iter().zip(kept.surface.wavelets(Level(level)));
            for (d, held) in pair {
                if held == d {
                    least = least.min(size(level, d));
                } else {
                    assert_eq!(*held, [0; 3]);
                    most = most.max(size(level, d));
                }
            }
        }
        assert!(most < least && most > 0.0, "{wavelet}: {most} dropped, {least} kept");
        let all = keep_largest(&whole, 1.0);
        assert!(contents(&all.surface) == contents(&whole) && all.predicted == 0.0);
        assert_eq!(domain_distance(&whole, &all.surface), 0.0);
    }
}
