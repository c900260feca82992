//! Vertices at the same place.

use rustc_hash::FxHashMap;

/// For every vertex that is used the lowest used one at exactly its place, else the vertex itself.
pub(in crate::conversion) fn equal(positions: &[[f64; 3]], used: &[bool]) -> Vec<u32> {
    let mut merged: Vec<u32> = (0..positions.len() as u32).collect();
    let mut first: FxHashMap<[u64; 3], u32> = FxHashMap::default();
    for (v, p) in positions.iter().enumerate().filter(|(v, _)| used[*v]) {
        merged[v] = *first.entry(place(*p)).or_insert(v as u32);
    }
    merged
}

/// The key of a place: adding 0 makes −0 and 0 the same.
pub(super) fn place(p: [f64; 3]) -> [u64; 3] {
    p.map(|x| (x + 0.0).to_bits())
}

/// For every vertex that is used the first used one within `distance` that is not merged itself, else the vertex itself.
pub(super) fn within(positions: &[[f64; 3]], used: &[bool], distance: f64) -> Vec<u32> {
    let mut merged: Vec<u32> = (0..positions.len() as u32).collect();
    let mut cells: FxHashMap<[u64; 3], Vec<u32>> = FxHashMap::default();
    for (v, p) in positions.iter().enumerate().filter(|(v, _)| used[*v]) {
        let near = |other: u32| {
            let q = positions[other as usize];
            (0..3).map(|k| (p[k] - q[k]) * (p[k] - q[k])).sum::<f64>() <= distance * distance
        };
        let found = cells_around(p, distance)
            .filter_map(|cell| cells.get(&cell))
            .flatten()
            .find(|&&other| near(other));
        match found {
            Some(&other) => merged[v] = other,
            None => cells.entry(cell(p, distance, [0.0; 3])).or_default().push(v as u32),
        }
    }
    merged
}

fn cells_around(p: &[f64; 3], size: f64) -> impl Iterator<Item = [u64; 3]> {
    (0..27).map(move |n| cell(p, size, [n % 3, n / 3 % 3, n / 9].map(|offset| f64::from(offset) - 1.0)))
}

/// The key of the cell that holds `p`, or one `offset` cells beside it.
fn cell(p: &[f64; 3], size: f64, offset: [f64; 3]) -> [u64; 3] {
    std::array::from_fn(|k| ((p[k] / size).floor() + offset[k] + 0.0).to_bits())
}
