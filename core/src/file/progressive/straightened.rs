//! A surface without the tangential parts of its details.

use super::frames::frames;
use super::transform::{Coding, Transform};
use crate::hierarchy::{Hierarchy, Level};
use crate::memory::Buffer;
use crate::wavelet::{Filters, ValenceTooHigh, Wavelet};

/// Positions are taken to so many bits of their greatest coordinate.
const BITS: i32 = 26;
/// A level of fewer faces keeps its tangential parts, and one of fewer than twice as many half of them. On three scans over
/// 30 to 200 base faces files are then smallest between 60 and 80 dB; without the parts of 60 base faces they get larger,
/// for vertices leave what they are there for.
const KEPT_FACES: usize = 200;

/// Takes the tangential parts of details away.
pub(in crate::file) struct Straightened<'a> {
    hierarchy: &'a Hierarchy,
    filters: Filters,
    coding: Coding,
}

impl<'a> Straightened<'a> {
    /// For the details that a stream has of a surface with these wavelets. Cost: that of their weights.
    ///
    /// # Errors
    /// A base vertex has too high a valence.
    pub(in crate::file) fn new(hierarchy: &'a Hierarchy, wavelet: Wavelet) -> Result<Self, ValenceTooHigh> {
        let wavelet = Coding::smooth_update(wavelet);
        let coding = Coding::Butterfly(wavelet);
        Ok(Self { hierarchy, filters: Filters::new(hierarchy, wavelet)?, coding })
    }

    /// Positions by slot of the finest level, less the tangential parts of their details but for those of the coarsest
    /// levels: an analysis and two syntheses.
    pub(in crate::file) fn of(&self, positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let greatest = positions.iter().flatten().fold(0.0f64, |most, x| most.max(x.abs()));
        if greatest == 0.0 {
            return positions.to_vec();
        }
        let scale = f64::from(1 << BITS) / greatest;
        let finest = Buffer::of(positions.len(), |at| positions[at].map(|x| (x * scale).round() as i32));
        let Self { hierarchy, filters, coding } = self;
        let transform = Transform { coding: *coding, hierarchy, filters };
        let (base, details) = transform.analyse(&finest);
        let (mut exact, mut straight) = (base.clone(), base);
        for (j, details) in (0..).zip(details) {
            let level = Level(j);
            let shift = self.kept(level);
            let frames = frames(hierarchy, level, &exact);
            let normal = Buffer::of(details.len(), |odd| {
                let [normal, b, c] = frames[odd].turn(details[odd]);
                frames[odd].turn_back([normal, shift(b), shift(c)])
            });
            straight = transform.synthesise_level(level, &straight, normal);
            exact = transform.synthesise_level(level, &exact, details);
        }
        straight.iter().map(|p| p.map(|x| f64::from(x) / scale)).collect()
    }

    /// What is left of a tangential part.
    fn kept(&self, level: Level) -> fn(i32) -> i32 {
        let faces = self.hierarchy.base().faces().len() << (2 * level.0);
        match faces {
            few if few < KEPT_FACES => |x| x,
            some if some < 2 * KEPT_FACES => |x| x / 2,
            _ => |_| 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hierarchy::{BaseMesh, Slot};
    use crate::mesh::shapes;
    use std::sync::Arc;

    /// A ball whose vertices are pushed about within its surface.
    fn uneven_ball(hierarchy: &Hierarchy, corners: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let layout = hierarchy.layout(hierarchy.finest());
        let place = |slot: u32| {
            let (face, b) = layout.chart(layout.site(Slot(slot)));
            let corners = hierarchy.base().faces()[face as usize].map(|v| corners[v as usize]);
            let p = [0, 1, 2].map(|c| (0..3).map(|k| f64::from(b[k]) * corners[k][c]).sum::<f64>());
            let p = p.map(|x| x / f64::from(layout.segments()));
            let p = [p[0] + 0.06 * (9.0 * p[1]).sin(), p[1] + 0.06 * (11.0 * p[2]).sin(), p[2]];
            let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
            p.map(|x| x / length)
        };
        (0..layout.len()).map(place).collect()
    }

    fn octahedron(levels: u8) -> (Hierarchy, Vec<[f64; 3]>) {
        let mesh = shapes::octahedron();
        let base = BaseMesh::new(6, mesh.faces, &[]).expect("a base mesh");
        (Hierarchy::new(Arc::new(base), Level(levels)).expect("small"), mesh.positions)
    }

    fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
        (0..3).map(|c| (a[c] - b[c]) * (a[c] - b[c])).sum::<f64>().sqrt()
    }

    /// What is straight stays where it is, at the precision of the transform.
    #[test]
    fn straightening_is_done_once() {
        let (hierarchy, corners) = octahedron(5);
        let straightened = Straightened::new(&hierarchy, Wavelet::Disc(1)).expect("small valences");
        let ball = uneven_ball(&hierarchy, &corners);
        let once = straightened.of(&ball);
        let twice = straightened.of(&once);
        let most = |a: &[[f64; 3]], b: &[[f64; 3]]| {
            a.iter().zip(b).map(|(&a, &b)| distance(a, b)).fold(0.0, f64::max)
        };
        let (first, second) = (most(&ball, &once), most(&once, &twice));
        assert!(first > 0.01 && second < 0.5 * first, "{first}, then {second}");
    }

    /// Levels of few faces keep what they say of places, so a coarse surface stays as it is.
    #[test]
    fn coarse_levels_stay() {
        let (hierarchy, corners) = octahedron(3);
        let straightened = Straightened::new(&hierarchy, Wavelet::Disc(2)).expect("small valences");
        let ball = uneven_ball(&hierarchy, &corners);
        for (a, b) in ball.iter().zip(straightened.of(&ball)) {
            assert!(distance(*a, b) < 1e-6, "{a:?} became {b:?}");
        }
    }
}
