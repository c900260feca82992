//! A globe: an equirectangular grid of numbers displaces a subdivided octahedron.

use super::Converted;
use crate::hierarchy::{BaseMesh, Hierarchy, Layout, Level, Slot};
use crate::mesh::shapes;
use rayon::prelude::*;
use std::sync::Arc;
use thiserror::Error;

/// Values on an equirectangular grid: row 0 in the north, column 0 at longitude −180°, each value at the centre of
/// its cell.
#[derive(Debug, Clone, PartialEq)]
pub struct EquirectangularGrid {
    width: usize,
    height: usize,
    values: Vec<f32>,
}

/// What the grid's values mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GridMeaning {
    /// Elevations: the radius is `1 + relief · (value − zero)`.
    Elevation {
        /// Radius gained per unit of value.
        relief: f64,
        /// The value at sea level.
        zero: f64,
    },
    /// Radii.
    Radius,
}

/// Why a grid makes no globe.
#[derive(Debug, Error, Clone, PartialEq)]
pub enum GlobeError {
    /// The values do not fill the grid.
    #[error("an equirectangular grid needs at least 2 × 1 finite values; give a whole picture")]
    Grid,
    /// Some radius is not positive.
    #[error(
        "the grid gives a radius of {radius} somewhere, which is not positive; choose a smaller --relief, or a \
         picture of radii without black"
    )]
    Radius {
        /// The radius.
        radius: f64,
    },
    /// Too many levels.
    #[error("a globe has 1 to 11 levels, not {levels}; choose --levels in that range")]
    Levels {
        /// The levels asked for.
        levels: u8,
    },
}

impl EquirectangularGrid {
    /// A grid from its rows.
    ///
    /// # Errors
    /// The values do not fill the grid or are not finite.
    pub fn new(width: usize, height: usize, values: Vec<f32>) -> Result<Self, GlobeError> {
        let filled = width >= 2 && height >= 1 && width.checked_mul(height) == Some(values.len());
        if !filled || values.iter().any(|v| !v.is_finite()) {
            return Err(GlobeError::Grid);
        }
        Ok(Self { width, height, values })
    }

    /// The value in a direction, linear between centres; longitudes wrap, poles hold their row.
    pub fn sample(&self, [x, y, z]: [f64; 3]) -> f64 {
        // libm's functions are plain arithmetic, the same bits on every platform.
        let longitude = libm::atan2(x, z) / std::f64::consts::TAU + 0.5;
        let latitude = 0.5 - libm::asin(y.clamp(-1.0, 1.0)) / std::f64::consts::PI;
        let column = longitude * self.width as f64 - 0.5;
        let row = (latitude * self.height as f64 - 0.5).clamp(0.0, (self.height - 1) as f64);
        let (left, top) = (column.floor(), row.floor());
        let (across, down) = (column - left, row - top);
        let at = |c: f64, r: f64| {
            let c = (c as i64).rem_euclid(self.width as i64) as usize;
            let r = (r as usize).min(self.height - 1);
            f64::from(self.values[r * self.width + c])
        };
        let upper = at(left, top) * (1.0 - across) + at(left + 1.0, top) * across;
        let lower = at(left, top + 1.0) * (1.0 - across) + at(left + 1.0, top + 1.0) * across;
        upper * (1.0 - down) + lower * down
    }
}

/// Makes a globe of radius about 1, y towards the north pole, z towards longitude 0. `O(8 · 4^levels)`.
///
/// # Errors
/// See [`GlobeError`].
pub fn globe(grid: &EquirectangularGrid, meaning: GridMeaning, levels: u8) -> Result<Converted, GlobeError> {
    if !(1..=11).contains(&levels) {
        return Err(GlobeError::Levels { levels });
    }
    let octahedron = shapes::octahedron();
    let base = BaseMesh::new(6, octahedron.faces, &[]).expect("the octahedron is a base mesh");
    let hierarchy =
        Hierarchy::new(Arc::new(base), Level(levels)).expect("11 levels have 17 million vertices");
    let directions = directions(&hierarchy, octahedron.positions);
    let radius = |direction: [f64; 3]| match meaning {
        GridMeaning::Elevation { relief, zero } => 1.0 + relief * (grid.sample(direction) - zero),
        GridMeaning::Radius => grid.sample(direction),
    };
    let positions: Vec<[f64; 3]> = directions.par_iter().map(|&d| d.map(|x| x * radius(d))).collect();
    let lengths = directions.par_iter().map(|&d| radius(d));
    if let Some(radius) = lengths.find_first(|r| *r <= 0.0) {
        return Err(GlobeError::Radius { radius });
    }
    Ok(Converted { hierarchy, positions, source: None, cleaned: Vec::new(), measured: None })
}

/// Unit vectors for every slot of the finest level: midpoints, pushed out to the sphere level by level.
fn directions(hierarchy: &Hierarchy, base: Vec<[f64; 3]>) -> Vec<[f64; 3]> {
    let mut coarser = base;
    for j in 0..hierarchy.finest().0 {
        let (coarse, fine) = (hierarchy.layout(Level(j)), hierarchy.layout(Level(j + 1)));
        coarser = (0..fine.len())
            .into_par_iter()
            .map(|s| {
                let site = fine.site(Slot(s));
                match Layout::coarsen(site) {
                    Some(even) => coarser[coarse.slot(even).index()],
                    None => {
                        let [a, b] = coarse.parents(site).map(|p| coarser[coarse.slot(p).index()]);
                        let sum: [f64; 3] = std::array::from_fn(|c| a[c] + b[c]);
                        let length = (sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]).sqrt();
                        sum.map(|x| x / length)
                    }
                }
            })
            .collect();
    }
    coarser
}
