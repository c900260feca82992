//! What lies beyond one corner of a base face at level j + 1, seen from the face: the points near the corner that are neither
//! in the face nor across one of its edges.
//!
//! Around a regular corner six faces meet, each a sector between two spokes, which are base edges. Beyond a corner lie the
//! three sectors opposite the face's own and the four spokes around them.

use super::border::Run;
use super::chart::Chart;
use super::points::Points;
use super::window::HALO;
use crate::hierarchy::Site;

/// Steps of level j + 1 from the corner to the farthest points.
const REACH: i32 = 2 * HALO;
const SIDE: i32 = 2 * REACH + 1;

/// The spokes, counter-clockwise, in columns and rows.
const SPOKES: [[i32; 2]; 6] = [[1, 0], [0, 1], [-1, 1], [-1, 0], [0, -1], [1, -1]];

/// The points of a hexagon around a corner of which half is used; zero where the corner is not regular.
pub(super) struct Corner<const N: usize> {
    /// Which corner of the face.
    k: usize,
    /// By row and column, from `−REACH` on.
    values: Vec<[i32; N]>,
}

fn index([i, r]: [i32; 2]) -> usize {
    ((r + REACH) * SIDE + i + REACH) as usize
}

impl<const N: usize> Corner<N> {
    pub(super) fn new(k: usize) -> Self {
        Self { k, values: vec![[0; N]; (SIDE * SIDE) as usize] }
    }

    /// Collects what lies beyond the corner of a face. Points that no stencil reaches are zero: beyond extraordinary corners,
    /// and beyond the faces at the corner where those are small.
    pub(super) fn collect(&mut self, chart: &Chart, points: &Points<N>) {
        let base = chart.fine.base();
        let vertex = base.faces()[chart.face as usize][self.k];
        let n = 2 * chart.n();
        let values = &mut self.values;
        let (regular, reach) = (base.is_regular(vertex), REACH.min(n - 1));
        if !regular || reach < REACH {
            values.fill([0; N]);
        }
        values[index([0, 0])] = points.value(Site::Base(vertex));
        if !regular {
            return;
        }
        let around = &base.fan(vertex).corners;
        let own = around.iter().position(|&(face, _)| face == chart.face).expect("a face around its corner");
        for sector in 2..6 {
            let (face, corner) = around[(own + sector) % 6];
            let [along, across] = [0, 1].map(|next| SPOKES[(2 * self.k + sector + next) % 6]);
            let edge = base.face_edges(face)[usize::from(corner)];
            let forwards = base.edges()[edge as usize][0] == vertex;
            let line = points.edge(edge);
            for a in 1..=reach {
                values[index(along.map(|x| a * x))] = line.at(if forwards { a } else { n - a });
            }
            if sector == 5 {
                break;
            }
            // `a` steps along the first spoke and `b` along the second.
            let mut put = |[a, b]: [i32; 2], value| {
                values[index([0, 1].map(|x| a * along[x] + b * across[x]))] = value;
            };
            for a in 1..reach {
                let row = |r: i32| points.row(face, r as u32);
                match corner {
                    0 => (1..=reach - a).for_each(|b| put([b, a], row(a).at(b))),
                    1 => (1..=reach - a).for_each(|b| put([a, b], row(a).at(n - a - b))),
                    _ => (1..=reach - a).for_each(|b| put([a, b], row(n - a - b).at(b))),
                }
            }
        }
    }

    /// Columns of row `ρ` of the face's unfolded grid, which has `n` segments, that lie beyond the corner.
    pub(super) fn run(&self, n: i32, rho: i32) -> Run<'_, N> {
        let [i, r] = [[0, rho], [n, rho], [0, rho - n]][self.k];
        if r.abs() > REACH || (self.k == 2 && r < 0) {
            return Run::NONE;
        }
        let [from, to] = match self.k {
            0 => [(-REACH).max(-REACH - r), -r],
            1 => [0, REACH.min(REACH - r)],
            _ => [-REACH, REACH - r],
        };
        Run { first: i + from, values: &self.values[index([from, r])..=index([to, r])] }
    }
}
