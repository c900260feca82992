//! A delta times the weights of a region, in steps.

use crate::surface::Vector;
use pulp::{Arch, Simd, WithSimd};

/// Values that are taken together.
const BLOCK: usize = 48;

/// Added to an integer below 2^51 in magnitude, this leaves it in the low bits of the sum.
const LOW_BITS: f64 = 6_755_399_441_055_744.0;

/// Far beyond what a surface can hold, so that an edit which asks for more is refused all the same.
const MOST: f64 = (1 << 30) as f64;

/// For the weights of each vertex what they add at the second delta less what they add at the first: each component times its
/// weight, rounded once, halves away from zero. Cost: linear.
pub(crate) fn weighted_steps(weights: &[[f64; 3]], deltas: [Vector; 2], steps: &mut Vec<Vector>) {
    steps.resize(weights.len(), [0; 3]);
    Arch::new().dispatch(Weighted {
        weights: weights.as_flattened(),
        deltas,
        steps: steps.as_flattened_mut(),
    });
}

struct Weighted<'a> {
    weights: &'a [f64],
    deltas: [Vector; 2],
    steps: &'a mut [i32],
}

impl WithSimd for Weighted<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let repeated = |delta: Vector| -> [f64; BLOCK] { std::array::from_fn(|l| f64::from(delta[l % 3])) };
        let [old, new] = self.deltas.map(repeated);
        let step =
            |weight: f64, l: usize| integer((new[l] * weight).round()) - integer((old[l] * weight).round());
        let (blocks, rest) = self.weights.as_chunks::<BLOCK>();
        let (steps, rest_steps) = self.steps.as_chunks_mut::<BLOCK>();
        for (weights, steps) in blocks.iter().zip(steps) {
            for l in 0..BLOCK {
                steps[l] = step(weights[l], l);
            }
        }
        for (l, (&weight, value)) in rest.iter().zip(rest_steps).enumerate() {
            *value = step(weight, l);
        }
    }
}

/// An integer as one, in a way that vectorises.
#[inline(always)]
fn integer(x: f64) -> i32 {
    (x.clamp(-MOST, MOST) + LOW_BITS).to_bits() as i32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::LIMIT;

    #[test]
    fn products_are_rounded_once_halves_away_from_zero() {
        let weights: Vec<[f64; 3]> = (0..=200)
            .map(|k| [f64::from(k) / 200.0, f64::from(k) / -64.0, 1.0 - f64::from(k) / 128.0])
            .collect();
        for deltas in [[[0; 3], [1, -1, 5]], [[3, -7, 100], [-99, 8, 0]], [[LIMIT; 3], [-LIMIT, 12_345, -1]]]
        {
            for count in [0, 1, 15, 16, 17, 201] {
                let mut steps = vec![[9; 3]; 5];
                weighted_steps(&weights[..count], deltas, &mut steps);
                let expected: Vec<Vector> = weights[..count]
                    .iter()
                    .map(|w| {
                        let [old, new] = deltas
                            .map(|delta| [0, 1, 2].map(|c| (f64::from(delta[c]) * w[c]).round() as i32));
                        std::array::from_fn(|c| new[c] - old[c])
                    })
                    .collect();
                assert_eq!(steps, expected, "{deltas:?}, {count}");
            }
        }
    }

    /// What wraps round must not come back into range.
    #[test]
    fn what_is_far_too_much_stays_too_much() {
        let mut steps = Vec::new();
        for weight in [9.0, 16.0, 32.0, 1e9, 1e300] {
            weighted_steps(&[[weight; 3]], [[0; 3], [LIMIT, -LIMIT, 0]], &mut steps);
            assert_eq!(steps, [[1 << 30, -(1 << 30), 0]], "{weight}");
        }
    }
}
