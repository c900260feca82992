//! Colours for distances: the map of the error after an import.

use rayon::prelude::*;

/// Colours from no distance to the scale's end, evenly spaced; what lies beyond has the last.
const COLOURS: [[u8; 3]; 6] =
    [[44, 82, 152], [54, 150, 172], [146, 200, 128], [246, 220, 104], [236, 134, 60], [176, 28, 48]];

/// The share of vertices that the scale shall reach where nothing else says how far.
const REACHED: f64 = 0.99;

/// A scale of colours from 0 to an end, for distances as fractions of the bounding-box diagonal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeatScale {
    end: f64,
}

impl HeatScale {
    /// The scale that ends at the tolerance, or without one, at a round number that nearly all distances are below.
    pub fn of(distances: &[f64], tolerance: Option<f64>) -> Self {
        let end = tolerance.filter(|t| *t > 0.0).unwrap_or_else(|| {
            let mut sorted = distances.to_vec();
            let at = ((sorted.len() as f64 * REACHED) as usize).min(sorted.len().saturating_sub(1));
            if sorted.is_empty() {
                return 0.0;
            }
            round_up(*sorted.select_nth_unstable_by(at, f64::total_cmp).1)
        });
        // Surfaces that agree to rounding are calm all over.
        Self { end: end.max(1e-9) }
    }

    /// Where the scale ends.
    pub fn end(&self) -> f64 {
        self.end
    }

    /// The colour of a share of the scale, 0 to 1 and beyond.
    pub fn colour(share: f64) -> [u8; 3] {
        let place = share.clamp(0.0, 1.0) * (COLOURS.len() - 1) as f64;
        let first = (place as usize).min(COLOURS.len() - 2);
        let along = place - first as f64;
        let mix = |c: usize| {
            let (a, b) = (f64::from(COLOURS[first][c]), f64::from(COLOURS[first + 1][c]));
            (a + (b - a) * along).round() as u8
        };
        [mix(0), mix(1), mix(2)]
    }

    /// A full tint for each distance.
    pub fn tints(&self, distances: &[f64]) -> Vec<[u8; 4]> {
        let tint = |&d: &f64| {
            let [r, g, b] = Self::colour(d / self.end);
            [r, g, b, 255]
        };
        distances.par_iter().map(tint).collect()
    }
}

/// The least of 1, 2 and 5 times a power of ten that is not less.
fn round_up(x: f64) -> f64 {
    if !(x > 0.0 && x.is_finite()) {
        return 0.0;
    }
    let power = x.log10().floor() as i32;
    [1, 2, 5, 10]
        .into_iter()
        // Parsed, not multiplied: the shortest decimals are what a legend shows.
        .filter_map(|digit| format!("{digit}e{power}").parse::<f64>().ok())
        .find(|&round| round >= x * (1.0 - 1e-12))
        .unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_end_at_the_tolerance_or_a_round_number() {
        let distances: Vec<f64> = (0..1000).map(|k| f64::from(k) * 1.3e-6).collect();
        assert_eq!(HeatScale::of(&distances, Some(3e-4)).end(), 3e-4);
        assert_eq!(HeatScale::of(&distances, None).end(), 2e-3);
        // One outlier does not spoil the scale.
        let with = |outlier: f64| [&distances[..], &[outlier]].concat();
        assert_eq!(HeatScale::of(&with(0.5), None).end(), 2e-3);
        for degenerate in [&[][..], &[0.0], &[0.0; 5]] {
            assert!(HeatScale::of(degenerate, None).end() > 0.0);
        }
        for (x, round) in [(1e-4, 1e-4), (1.01e-4, 2e-4), (4.9e-4, 5e-4), (7e-4, 1e-3), (0.0, 0.0)] {
            assert_eq!(round_up(x), round, "{x}");
        }
    }

    #[test]
    fn colours_run_from_the_first_to_the_last() {
        assert_eq!(HeatScale::colour(0.0), COLOURS[0]);
        assert_eq!(HeatScale::colour(0.2), COLOURS[1]);
        assert_eq!(HeatScale::colour(1.0), COLOURS[5]);
        assert_eq!(HeatScale::colour(7.0), COLOURS[5]);
        let tints = HeatScale::of(&[], Some(0.5)).tints(&[0.0, 0.5, f64::INFINITY]);
        assert_eq!(tints[0], [44, 82, 152, 255]);
        assert_eq!((tints[1], tints[2]), ([176, 28, 48, 255], [176, 28, 48, 255]));
    }
}
