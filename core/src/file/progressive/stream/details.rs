//! What is known of the levels, and the positions that it makes.

use super::base::Known;
use crate::file::progressive::frames::Frame;
use crate::file::progressive::planes::CLASSES;
use crate::file::progressive::transform::Transform;
use crate::file::progressive::visit::of_odds;
use crate::hierarchy::{Hierarchy, Layout, Level};
use crate::memory::Buffer;
use crate::surface::Vector;

/// What of one level is known.
#[derive(Debug, Default)]
pub(super) struct Details {
    /// Whether the level has begun.
    pub(super) begun: bool,
    /// By slot of `M^{j+1}`: normal part, two tangential parts, without the bits below the plane. Empty while all are zero, and
    /// when they are asked for no more.
    pub(super) known: Buffer<Vector>,
    /// By odd vertex.
    pub(super) frames: Buffer<Frame>,
    /// By class.
    pub(super) planes: [u32; 2],
    /// The first odd vertex that is still at other planes, and those.
    pub(super) cut: Option<(u32, [u32; 2])>,
    /// By slot of `M^{j+1}`, how far components are from their predictions. Empty before the level is finished, and when the
    /// next one is.
    pub(super) residuals: Buffer<Vector>,
}

impl Details {
    /// Makes room for what will be known.
    pub(super) fn hold_all(&mut self, fine: &Layout) {
        if self.known.is_empty() {
            self.known = Buffer::zeroed(fine.len() as usize);
        }
    }

    /// Whether every bit is known.
    pub(super) fn is_whole(&self) -> bool {
        self.begun && self.planes == [0; 2] && self.cut.is_none()
    }

    /// `d^j` as far as it is known.
    pub(super) fn coefficients(&self, hierarchy: &Hierarchy, level: Level) -> Buffer<Vector> {
        let (coarse, fine) = (hierarchy.layout(level), hierarchy.layout(level.finer()));
        if self.known.is_empty() {
            return Buffer::zeroed(coarse.odd_len() as usize);
        }
        let whole = self.is_whole();
        of_odds(coarse, fine, |odd, slot, _| {
            let known = self.known[slot as usize];
            if whole {
                return self.frames[odd as usize].turn_back(known);
            }
            let mut local = [0; 3];
            for (class, range) in CLASSES.into_iter().enumerate() {
                let plane = match self.cut {
                    Some((first, above)) if odd >= first => above[class],
                    _ => self.planes[class],
                };
                for c in range {
                    local[c] = restored(known[c], plane);
                }
            }
            self.frames[odd as usize].turn_back(local)
        })
    }
}

fn restored(known: i32, plane: u32) -> i32 {
    let middle = ((7i64 << plane) >> 4) as i32;
    match known {
        0 => 0,
        x if x < 0 => x.wrapping_sub(middle),
        x => x.wrapping_add(middle),
    }
}

/// What is known below a level, to make its positions of.
pub(super) struct Below<'a> {
    pub(super) transform: Transform<'a>,
    pub(super) base: Known<'a>,
    pub(super) levels: &'a [Details],
    pub(super) kept: Option<&'a (usize, Buffer<Vector>)>,
}

impl Below<'_> {
    pub(super) fn positions(&self) -> Buffer<Vector> {
        let kept = self.kept.filter(|(kept, _)| *kept <= self.levels.len());
        let from = kept.map_or(0, |(level, _)| *level);
        let middles = if kept.is_none() { self.base.middles() } else { Vec::new() };
        let below: &[Vector] = kept.map_or(&middles, |(_, positions)| positions);
        let mut positions = None::<Buffer<Vector>>;
        for (j, details) in self.levels.iter().enumerate().skip(from) {
            let (hierarchy, level) = (self.transform.hierarchy, Level(j as u8));
            let coarser = positions.as_deref().unwrap_or(below);
            positions = Some(if details.known.is_empty() {
                self.transform.subdivide(level, coarser)
            } else {
                let details = details.coefficients(hierarchy, level);
                self.transform.synthesise_level(level, coarser, details)
            });
        }
        positions.unwrap_or_else(|| below.into())
    }
}
