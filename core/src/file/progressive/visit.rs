//! Every odd vertex of a level with what lies around it, by rising id.

use crate::hierarchy::{Layout, Site};

/// An odd vertex and its surroundings, by slot.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place<'a> {
    pub(super) odd: u32,
    /// In `M^{j+1}`, as those near.
    pub(super) slot: u32,
    /// Its neighbours in `M^{j+1}`.
    pub(super) near: &'a [u32],
    /// In `M^j`.
    pub(super) parents: [u32; 2],
}

/// Calls back for every odd vertex of a level until one is refused, and says which. `O(n_{j+1})`; inside base faces
/// everything is found by additions.
#[inline(always)]
pub(super) fn visit(
    coarse: &Layout,
    fine: &Layout,
    mut each: impl FnMut(Place) -> Result<(), u32>,
) -> Result<(), u32> {
    let (n, base) = (coarse.segments(), coarse.base().clone());
    let mut odd = 0;
    for edge in 0..base.edges().len() as u32 {
        for t in (1..2 * n).step_by(2) {
            anywhere(coarse, fine, Site::Edge { edge, t }, odd, &mut each)?;
            odd += 1;
        }
    }
    for face in 0..base.faces().len() as u32 {
        for r in 1..2 * n - 1 {
            let last = 2 * n - r - 1;
            let inner = 1 < r && 2 < last;
            let at = |layout: &Layout, r: u32| layout.row(face, r).0.wrapping_sub(1);
            let rows = if inner { [at(fine, r - 1), at(fine, r), at(fine, r + 1)] } else { [0; 3] };
            let above = if inner { [at(coarse, r / 2), at(coarse, r.div_ceil(2))] } else { [0; 2] };
            let first_step = if r % 2 == 1 { 1 } else { 2 };
            for i in (1..=last).step_by(first_step) {
                if inner && 1 < i && i < last {
                    let [down, row, up] = rows.map(|row| row + i);
                    let near = [row - 1, row + 1, down, down + 1, up, up - 1];
                    let parents = match (i % 2, r % 2) {
                        (1, 0) => [above[0] + i / 2, above[0] + i.div_ceil(2)],
                        (0, 1) => [above[0] + i / 2, above[1] + i / 2],
                        _ => [above[0] + i.div_ceil(2), above[1] + i / 2],
                    };
                    each(Place { odd, slot: row, near: &near, parents })?;
                } else {
                    anywhere(coarse, fine, Site::Face { face, i, r }, odd, &mut each)?;
                }
                odd += 1;
            }
        }
    }
    Ok(())
}

/// A vertex wherever it lies.
fn anywhere(
    coarse: &Layout,
    fine: &Layout,
    site: Site,
    odd: u32,
    each: &mut impl FnMut(Place) -> Result<(), u32>,
) -> Result<(), u32> {
    let (mut near, mut count) = ([0; 6], 0);
    fine.for_each_neighbour(site, |site| {
        near[count] = fine.slot(site).0;
        count += 1;
    });
    let parents = coarse.parents(site).map(|site| coarse.slot(site).0);
    each(Place { odd, slot: fine.slot(site).0, near: &near[..count], parents })
}
