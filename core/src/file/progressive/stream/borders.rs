//! Places where a stream can be cut, and how far what is read there is from the whole.

use super::Telling;

/// A place where a stream can be cut at no loss.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::file) struct Border {
    /// How many bytes are read here.
    pub(in crate::file) position: usize,
    /// The root of the mean squared distance to the whole, in steps; 0 only where nothing is missing.
    pub(in crate::file) error: f64,
}

/// A stream and its borders, the last its end.
pub(in crate::file) struct Encoded {
    pub(in crate::file) telling: Telling,
    pub(in crate::file) bytes: Vec<u8>,
    pub(in crate::file) borders: Vec<Border>,
}

impl Encoded {
    /// The error after so many bytes, from the first border on: in a block, which goes from vertex to vertex, the square
    /// falls evenly.
    pub(in crate::file) fn error_at(&self, position: usize) -> f64 {
        match self.borders.partition_point(|border| border.position <= position) {
            0 => self.borders[0].error,
            at if at == self.borders.len() => self.borders[at - 1].error,
            at => between(self.borders[at - 1], self.borders[at], position),
        }
    }
}

fn between(before: Border, after: Border, position: usize) -> f64 {
    let share = (position - before.position) as f64 / (after.position - before.position) as f64;
    let squared = |border: Border| border.error * border.error;
    ((1.0 - share) * squared(before) + share * squared(after)).sqrt()
}

/// Borders of which some are measured, the first and the last among them: at the others errors are taken to fall evenly,
/// or, before the end, their squares.
pub(super) fn filled(measured: &[(usize, Option<f64>)]) -> Vec<Border> {
    let mut borders: Vec<Border> = Vec::with_capacity(measured.len());
    for (at, &(position, error)) in measured.iter().enumerate() {
        let error = error.unwrap_or_else(|| {
            let next = |&(position, error): &(usize, Option<f64>)| Some(Border { position, error: error? });
            let after = measured[at..].iter().find_map(next).expect("the last is measured");
            let before = borders[at - 1];
            let share =
                (position - before.position) as f64 / (after.position - before.position).max(1) as f64;
            match after.error > 0.0 {
                true => before.error + share * (after.error - before.error),
                false => between(before, after, position.min(after.position)),
            }
        });
        borders.push(Border { position, error });
    }
    borders
}

/// Borders are measured that are so many bytes at least from the last one measured.
const MEASURED_EVERY: usize = 128;

/// And so far from one after `before` bytes: the more vertices, the longer measuring takes beside writing.
pub(super) fn measured_after(before: usize, vertices: usize) -> usize {
    let apart = match vertices {
        0..=16_384 => before / 4,
        16_385..=65_536 => before,
        _ => 3 * before,
    };
    apart.max(MEASURED_EVERY)
}
