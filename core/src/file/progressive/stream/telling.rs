//! How a stream tells a surface, as the header says it.

use crate::file::progressive::Coding;
use crate::hierarchy::{Hierarchy, Level};

/// Levels of so many odd vertices are finished in lanes; those of fewer would lose more by starting them than they gain.
const FEWEST_IN_LANES: u32 = 4096;
/// What the header adds to the transform's number.
const IN_LANES: u8 = 8;

/// The transform of a stream, and whether large levels are finished in lanes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::file) struct Telling {
    pub(in crate::file) coding: Coding,
    pub(in crate::file) in_lanes: bool,
}

impl Telling {
    /// Without lanes where no level is large, so that older readers can read it.
    pub(super) fn of(coding: Coding, hierarchy: &Hierarchy) -> Self {
        let mut telling = Self { coding, in_lanes: true };
        telling.in_lanes = (0..hierarchy.finest().0).any(|j| telling.finishes_in_lanes(hierarchy, Level(j)));
        telling
    }

    /// Whether a level is finished in lanes.
    pub(super) fn finishes_in_lanes(self, hierarchy: &Hierarchy, level: Level) -> bool {
        self.in_lanes && hierarchy.layout(level).odd_len() >= FEWEST_IN_LANES
    }

    /// The number that stands for it in files.
    pub(in crate::file) fn code(self) -> u8 {
        self.coding.code() + if self.in_lanes { IN_LANES } else { 0 }
    }

    /// What a number stands for.
    pub(in crate::file) fn from_code(code: u8) -> Option<Self> {
        let in_lanes = code & IN_LANES != 0;
        Coding::from_code(code & !IN_LANES).map(|coding| Self { coding, in_lanes })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::progressive::{Granularity, Held, decode_stream, encode_stream};
    use crate::hierarchy::BaseMesh;
    use crate::mesh::shapes;
    use crate::surface::{FormOptions, Surface, Vector};
    use crate::wavelet::Wavelet;
    use std::sync::Arc;

    #[test]
    fn every_number_stands_for_itself() {
        let known: Vec<u8> = (0..=255).filter(|&code| Telling::from_code(code).is_some()).collect();
        assert_eq!(known, [0, 1, 2, 3, 4, 8, 9, 10, 11, 12]);
        assert!(known.iter().all(|&code| Telling::from_code(code).map(Telling::code) == Some(code)));
    }

    /// A wavy sheet, rougher in one corner than anything beside it foretells.
    fn rough(levels: u8) -> Surface {
        let base = BaseMesh::new(6, shapes::octahedron().faces, &[]).expect("a base mesh");
        let hierarchy = Hierarchy::new(Arc::new(base), Level(levels)).expect("small");
        let place = |slot: u32| {
            let x = f64::from(slot) * 0.001;
            let spike = if slot.is_multiple_of(4999) { 7.0 } else { 0.0 };
            [libm::sin(x) + spike, 0.01 * f64::from(slot * 7919 % 101), x * 0.01]
        };
        let count = hierarchy.layout(Level(levels)).len();
        let positions: Vec<[f64; 3]> = (0..count).map(place).collect();
        let form = FormOptions { wavelet: Wavelet::Lazy, ..FormOptions::default() };
        Surface::from_positions(hierarchy, &positions, &form).expect("small valences")
    }

    fn finest(surface: &Surface, telling: Telling, bytes: &[u8]) -> Option<(Vec<Vector>, bool)> {
        let (hierarchy, own) = (surface.hierarchy(), surface.form().wavelet);
        let others = telling.coding.filters(hierarchy, own).expect("small valences");
        let filters = others.as_ref().unwrap_or_else(|| surface.filters());
        let decoded = decode_stream(hierarchy, filters, telling, bytes)?;
        let Held::Finest(positions) = decoded.held else { panic!("a smooth transform") };
        Some((positions.to_vec(), decoded.exact))
    }

    /// Levels of several runs, told at once or after some planes, whole and cut in every run.
    #[test]
    fn large_levels_are_finished_in_lanes() {
        assert!(!encode_stream(&rough(4), Granularity::Coarse).telling.in_lanes, "none is large");
        let surface = rough(7);
        let wanted = surface.scaling(Level(7));
        for granularity in [Granularity::Coarse, Granularity::Fine] {
            let encoded = encode_stream(&surface, granularity);
            let (telling, bytes) = (encoded.telling, &encoded.bytes[..]);
            assert!(telling.in_lanes);
            let (found, exact) = finest(&surface, telling, bytes).expect("base positions");
            assert!(exact && found == wanted, "{granularity:?}");
            let mut before = f64::INFINITY;
            for part in 1..24 {
                let cut = bytes.len() * part / 24;
                let (found, exact) = finest(&surface, telling, &bytes[..cut]).expect("base positions");
                let off = |(a, b): (&Vector, &Vector)| {
                    (0..3).map(|c| (f64::from(a[c]) - f64::from(b[c])).powi(2)).sum::<f64>()
                };
                let error = found.iter().zip(wanted).map(off).sum::<f64>();
                assert!(!exact && error < 1.05 * before, "{granularity:?}, {cut}: {error} after {before}");
                before = error;
            }
        }
    }
}
