//! Elevation grids on the sphere, and their reduction to a small equirectangular image.
//!
//! Guarantees: the reduction is the mean over each output pixel's area on the sphere, so the global mean is kept up
//! to rounding; rows run north to south and columns from longitude −180° eastward whatever the source's order.
//!
//! Non-guarantees: the source must be evenly spaced and cover the whole globe; anything else is refused.

use anyhow::{Result, ensure};

/// What is added to metres before they are stored as 16-bit grey levels: the deepest sea floor stays positive.
pub const METRES_OFFSET: f64 = 11_000.0;

/// A global elevation grid whose samples are the means (or centre values) of cells around them.
pub struct ElevationGrid {
    longitudes: Vec<f64>,
    latitudes: Vec<f64>,
    metres: Vec<f64>,
}

/// A grid in image order: row 0 is the northernmost, column 0 begins at longitude −180°.
pub struct ReducedGrid {
    /// Pixels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Mean elevations in metres, row by row.
    pub metres: Vec<f64>,
}

/// One source cell's share in an output cell.
struct Share {
    source: usize,
    weight: f64,
}

impl ElevationGrid {
    /// A grid from its axes in degrees and its samples, one row of longitudes per latitude.
    ///
    /// # Errors
    /// When sizes do not fit together, an axis is not evenly spaced, the axes do not span the globe, or a sample is
    /// no height of the Earth (±12 km).
    pub fn new(longitudes: Vec<f64>, latitudes: Vec<f64>, metres: Vec<f64>) -> Result<Self> {
        ensure!(longitudes.len() > 1 && latitudes.len() > 1, "the grid needs two rows and two columns");
        ensure!(
            metres.len() == longitudes.len() * latitudes.len(),
            "{} samples do not fill {} x {} places",
            metres.len(),
            longitudes.len(),
            latitudes.len()
        );
        let across = even_step(&longitudes, "longitude")? * longitudes.len() as f64;
        ensure!((across.abs() - 360.0).abs() < 0.01, "the longitudes span {across} degrees, not 360");
        let down = even_step(&latitudes, "latitude")? * (latitudes.len() - 1) as f64;
        ensure!((179.0..=180.01).contains(&down.abs()), "the latitudes span {down} degrees, not 180");
        if let Some(at) = metres.iter().position(|m| !(-12_000.0..=12_000.0).contains(m)) {
            let (row, column) = (at / longitudes.len(), at % longitudes.len());
            anyhow::bail!("row {row}, column {column}: {} is no height of the Earth in metres", metres[at]);
        }
        Ok(Self { longitudes, latitudes, metres })
    }

    /// Box-filters the grid to `width` × `height` pixels: the mean over each pixel's area on the sphere.
    ///
    /// Cost: proportional to the source's size plus the output's, axis by axis.
    pub fn reduce(&self, width: u32, height: u32) -> ReducedGrid {
        let columns: Vec<Vec<Share>> = (0..width)
            .map(|column| {
                let edge = |c: u32| -180.0 + 360.0 * f64::from(c) / f64::from(width);
                longitude_shares(&self.longitudes, edge(column), edge(column + 1))
            })
            .collect();
        let mut metres = Vec::with_capacity(width as usize * height as usize);
        for row in 0..height {
            let edge = |r: u32| 90.0 - 180.0 * f64::from(r) / f64::from(height);
            let rows = latitude_shares(&self.latitudes, edge(row + 1), edge(row));
            for shares in &columns {
                metres.push(self.mean(&rows, shares));
            }
        }
        ReducedGrid { width, height, metres }
    }

    fn mean(&self, rows: &[Share], columns: &[Share]) -> f64 {
        let (mut sum, mut area) = (0.0, 0.0);
        for row in rows {
            let start = row.source * self.longitudes.len();
            for column in columns {
                let weight = row.weight * column.weight;
                sum += weight * self.metres[start + column.source];
                area += weight;
            }
        }
        sum / area
    }
}

impl ReducedGrid {
    /// The samples as grey levels: metres plus [`METRES_OFFSET`], rounded and kept within 16 bits.
    pub fn grey_levels(&self) -> Vec<u16> {
        self.metres.iter().map(|m| (m + METRES_OFFSET).round().clamp(0.0, 65_535.0) as u16).collect()
    }
}

fn even_step(axis: &[f64], name: &str) -> Result<f64> {
    let step = (axis[axis.len() - 1] - axis[0]) / (axis.len() - 1) as f64;
    for (at, pair) in axis.windows(2).enumerate() {
        let found = pair[1] - pair[0];
        ensure!((found - step).abs() < 0.01 * step.abs(), "{name} {at}: a step of {found}, elsewhere {step}");
    }
    Ok(step)
}

/// The cells of a periodic longitude axis that overlap `west..east` degrees, weighted by overlap.
fn longitude_shares(axis: &[f64], west: f64, east: f64) -> Vec<Share> {
    let half = 180.0 / axis.len() as f64;
    let mut shares = Vec::new();
    for (source, &centre) in axis.iter().enumerate() {
        for turn in [-720.0, -360.0, 0.0, 360.0, 720.0] {
            let weight = (east.min(centre + turn + half) - west.max(centre + turn - half)).max(0.0);
            if weight > 1e-9 {
                shares.push(Share { source, weight });
            }
        }
    }
    shares
}

/// The cells of a latitude axis that overlap `south..north` degrees, weighted by their area on the sphere.
fn latitude_shares(axis: &[f64], south: f64, north: f64) -> Vec<Share> {
    let half = ((axis[axis.len() - 1] - axis[0]) / (axis.len() - 1) as f64).abs() / 2.0;
    let mut shares = Vec::new();
    for (source, &centre) in axis.iter().enumerate() {
        let (low, high) = ((centre - half).max(south), (centre + half).min(north));
        let weight = high.to_radians().sin() - low.to_radians().sin();
        if high > low && weight > 1e-12 {
            shares.push(Share { source, weight });
        }
    }
    shares
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of 8 × 5 samples whose value tells its place, in the source order asked for.
    fn grid(from_greenwich: bool, ascending: bool) -> ElevationGrid {
        let start = if from_greenwich { 22.5 } else { -157.5 };
        let longitudes: Vec<f64> = (0..8).map(|i| start + 45.0 * f64::from(i)).collect();
        let sign = if ascending { 1.0 } else { -1.0 };
        let latitudes: Vec<f64> = (0..5).map(|j| sign * (-90.0 + 45.0 * f64::from(j))).collect();
        let value = |lat: f64, lon: f64| lat * 10.0 + (lon + 540.0).rem_euclid(360.0) / 1000.0;
        let metres = latitudes.iter().flat_map(|&y| longitudes.iter().map(move |&x| value(y, x))).collect();
        ElevationGrid::new(longitudes, latitudes, metres).expect("a well formed grid")
    }

    #[test]
    fn source_order_does_not_matter() {
        let reference = grid(false, false).reduce(4, 2).metres;
        for (from_greenwich, ascending) in [(true, false), (false, true), (true, true)] {
            let other = grid(from_greenwich, ascending).reduce(4, 2).metres;
            for (a, b) in reference.iter().zip(&other) {
                assert!((a - b).abs() < 1e-9, "{reference:?} {other:?}");
            }
        }
    }

    #[test]
    fn north_comes_first_and_columns_run_east_from_the_date_line() {
        let reduced = grid(true, true).reduce(8, 2);
        assert!(reduced.metres[0] > 0.0 && reduced.metres[8] < 0.0);
        assert!(reduced.metres[0] < reduced.metres[1] && reduced.metres[6] < reduced.metres[7]);
    }

    #[test]
    fn a_constant_stays_constant() {
        let mut source = grid(true, true);
        source.metres.fill(-4321.0);
        let reduced = source.reduce(5, 3);
        assert!(reduced.metres.iter().all(|m| (m + 4321.0).abs() < 1e-9));
        assert!(reduced.grey_levels().iter().all(|&g| g == 6679));
    }

    #[test]
    fn gaps_and_fill_values_are_refused() {
        let axis: Vec<f64> = (0..8).map(|i| 45.0 * f64::from(i)).collect();
        let rows: Vec<f64> = (0..5).map(|j| -90.0 + 45.0 * f64::from(j)).collect();
        assert!(ElevationGrid::new(axis.clone(), rows.clone(), vec![-1e34; 40]).is_err());
        assert!(ElevationGrid::new(axis[..6].to_vec(), rows.clone(), vec![0.0; 30]).is_err());
        assert!(ElevationGrid::new(axis, rows, vec![0.0; 39]).is_err());
    }
}
