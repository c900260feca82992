//! The vertices that corners refer to.

use crate::io::error::excerpt;
use crate::io::text::whole;
use crate::io::{Defect, LARGEST_COUNT, Place};

/// Turns corners into vertices, and keeps in mind those that must still come.
#[derive(Default)]
pub(super) struct Indices {
    /// Indices that were higher than all before them and than the vertices so far, with their lines. The first index beyond
    /// the last vertex, if there is one, is among them.
    ahead: Vec<[u64; 2]>,
}

impl Indices {
    /// The vertex, counted from 0, that a corner such as `7`, `7/2` or `-1//3` on a line refers to, with so many vertices
    /// before it. Negative indices count back from there.
    pub(super) fn vertex(&mut self, corner: &[u8], [line, preceding]: [u64; 2]) -> Result<u32, Defect> {
        let digits = corner.split(|&byte| byte == b'/').next().unwrap_or(corner);
        let index = whole(digits).map_err(|_| Defect::NotAnIndex { token: excerpt(corner) })?;
        let magnitude = index.unsigned_abs();
        let from_one = match index {
            0 => return Err(Defect::IndexZero),
            1.. => {
                if magnitude > preceding && self.ahead.last().is_none_or(|last| last[0] < magnitude) {
                    self.ahead.push([magnitude, line]);
                }
                // What is beyond any count is refused at the end.
                magnitude.min(LARGEST_COUNT)
            }
            _ if magnitude > preceding => {
                return Err(Defect::IndexBefore { back: magnitude, vertices: preceding });
            }
            _ => preceding - magnitude + 1,
        };
        Ok((from_one - 1) as u32)
    }

    /// The first corner that refers beyond so many vertices.
    pub(super) fn beyond(&self, vertices: u64) -> Option<(Place, Defect)> {
        let &[index, line] = self.ahead.iter().find(|[index, _]| *index > vertices)?;
        Some((Place::Line(line), Defect::IndexBeyond { index: index as i64, vertices, base: 1 }))
    }
}
