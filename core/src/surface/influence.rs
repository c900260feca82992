//! Basis functions as seen on a level: where a scaling function or a wavelet is not zero, and its value there.

use super::Surface;
use crate::hierarchy::{Layout, Level, Odd, Site, Slot};
use crate::wavelet::weights::WEIGHT_BITS;
use rustc_hash::FxHashMap;

impl Surface {
    /// The scaling function `φ_i^j` at the vertices of `M^shown`, where it is not zero; `shown ≥ level`. Cost: its
    /// support.
    pub fn scaling_function(&self, level: Level, slot: Slot, shown: Level) -> Vec<(Slot, f64)> {
        let site = self.hierarchy().layout(level).site(slot);
        self.refined(level, FxHashMap::from_iter([(site, 1.0)]), shown)
    }

    /// The wavelet `ψ_i^j` at the vertices of `M^shown`, where it is not zero; `shown > level`. Cost: its support.
    pub fn wavelet_function(&self, level: Level, odd: Odd, shown: Level) -> Vec<(Slot, f64)> {
        let values = self.wavelet_one_level_finer(level, odd);
        self.refined(level.finer(), values, shown)
    }

    /// `ψ_i^j(i)`: how far the vertex moves for a unit of its wavelet coefficient (0.805 at regular vertices, k = 2).
    pub fn wavelet_peak(&self, level: Level, odd: Odd) -> f64 {
        let site = self.hierarchy().layout(level).odd_site(odd);
        self.wavelet_one_level_finer(level, odd)[&site]
    }

    /// `ψ_i^j` on `M^{j+1}`: `−s_iv` at even vertices, and their means, plus 1 at `i`, at odd ones.
    fn wavelet_one_level_finer(&self, level: Level, odd: Odd) -> FxHashMap<Site, f64> {
        let layout = self.hierarchy().layout(level);
        let own = layout.odd_site(odd);
        let mut evens: FxHashMap<Site, f64> = FxHashMap::default();
        if let Some(k) = self.form().wavelet.disc_radius() {
            for v in layout.disc(&layout.parents(own), k) {
                self.filters().for_each_tap(layout, v, |tap, weight| {
                    if tap == odd {
                        evens.insert(v, -f64::from(weight) / f64::from(1 << WEIGHT_BITS));
                    }
                });
            }
        }
        let mut finer = one_finer(self.hierarchy().layout(level.finer()), layout, &evens);
        *finer.entry(own).or_default() += 1.0;
        finer
    }

    fn refined(&self, level: Level, mut values: FxHashMap<Site, f64>, shown: Level) -> Vec<(Slot, f64)> {
        for j in level.0..shown.0 {
            values =
                one_finer(self.hierarchy().layout(Level(j + 1)), self.hierarchy().layout(Level(j)), &values);
        }
        let layout = self.hierarchy().layout(shown);
        let mut by_slot: Vec<(Slot, f64)> =
            values.into_iter().map(|(site, x)| (layout.slot(site), x)).collect();
        by_slot.sort_unstable_by_key(|&(slot, _)| slot);
        by_slot
    }
}

/// A function of `V^j`, given where it is not zero, at the vertices of `M^{j+1}`.
fn one_finer(fine: &Layout, coarse: &Layout, values: &FxHashMap<Site, f64>) -> FxHashMap<Site, f64> {
    let mut finer = FxHashMap::default();
    for (&site, &value) in values {
        let even = Layout::refine(site);
        finer.insert(even, value);
        fine.for_each_neighbour(even, |odd| {
            let at = |p: Site| values.get(&p).copied().unwrap_or(0.0);
            let [a, b] = coarse.parents(odd);
            finer.insert(odd, (at(a) + at(b)) * 0.5);
        });
    }
    finer
}
