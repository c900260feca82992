//! Discs in which all is regular, unfolded onto the lattice: their weights are always the same, so nothing is solved.

use super::Wavelet;
use super::weights::{OddStencil, WeightSolver};
use crate::hierarchy::{BaseMesh, Layout, Level, Site};
use crate::mesh::shapes;
use std::sync::Arc;

/// The lattice's directions, counter-clockwise as rings run.
const DIRECTIONS: [[i32; 2]; 6] = [[1, 0], [0, 1], [-1, 1], [-1, 0], [0, -1], [1, -1]];
/// Places from −3 to 4 in both directions hold the discs of an edge from (0, 0) to (1, 0), k up to 2.
const SIDE: usize = 8;
/// On coarser levels a disc may meet itself round a base edge: it is no wider than five edges, a base edge has eight here.
const COARSEST: Level = Level(3);

/// The weights of a regular odd vertex by place.
#[derive(Debug)]
pub(super) struct RegularDisc {
    k: Option<u8>,
    weights: [[i32; SIDE]; SIDE],
}

/// A vertex of a disc.
#[derive(Debug, Clone, Copy)]
struct Placed {
    site: Site,
    place: [i32; 2],
    /// A neighbour, and the direction it lies in.
    known: Site,
    towards: usize,
}

fn cell([x, y]: [i32; 2]) -> [usize; 2] {
    [(y + 3) as usize, (x + 3) as usize]
}

impl RegularDisc {
    /// Reads them off the middle of one finely divided triangle.
    pub(super) fn new(solver: &WeightSolver, wavelet: Wavelet) -> Self {
        let mut disc = Self { k: wavelet.disc_radius(), weights: [[0; SIDE]; SIDE] };
        let Some(k) = disc.k else { return disc };
        let base = BaseMesh::new(3, shapes::triangle().faces, &[]).expect("a triangle is a base mesh");
        let layout = Layout::checked(&Arc::new(base), Level(6)).expect("a small level");
        let odd = Site::Face { face: 0, i: 43, r: 43 };
        let stencil = solver.stencil(&layout, odd, wavelet);
        for Placed { site, place, .. } in unfold(&layout, odd, k).expect("the middle is regular") {
            let at = stencil.vertices.iter().position(|&v| v == site).expect("the same disc");
            let [row, column] = cell(place);
            disc.weights[row][column] = stencil.weights[at];
        }
        disc
    }

    /// The stencil of an odd vertex; `None` if something in its disc is irregular, or the level too coarse to be sure.
    pub(super) fn stencil(&self, layout: &Layout, odd: Site) -> Option<OddStencil> {
        let placed = unfold(layout, odd, self.k.filter(|_| layout.level() >= COARSEST)?)?;
        let weight = |placed: &Placed| {
            let [row, column] = cell(placed.place);
            self.weights[row][column]
        };
        let weights = placed.iter().map(weight).collect();
        Some(OddStencil { vertices: placed.iter().map(|placed| placed.site).collect(), weights })
    }
}

/// The disc of an odd vertex, the nearest first; `None` if a vertex in it is irregular.
fn unfold(layout: &Layout, odd: Site, k: u8) -> Option<Vec<Placed>> {
    let [u, w] = layout.parents(odd);
    let mut disc = Vec::with_capacity(24);
    disc.push(Placed { site: u, place: [0, 0], known: w, towards: 0 });
    disc.push(Placed { site: w, place: [1, 0], known: u, towards: 3 });
    let mut taken = [[false; SIDE]; SIDE];
    disc.iter().for_each(|placed| {
        let [row, column] = cell(placed.place);
        taken[row][column] = true;
    });
    let mut from = 0;
    for _ in 0..k {
        let to = disc.len();
        for at in from..to {
            let Placed { site, place, known, towards } = disc[at];
            if !is_regular(layout, site) {
                return None;
            }
            let around = layout.ring(site).around;
            let first = around.iter().position(|&v| v == known)?;
            for turn in 1..6 {
                let direction = (towards + turn) % 6;
                let [dx, dy] = DIRECTIONS[direction];
                let there = [place[0] + dx, place[1] + dy];
                let [row, column] = cell(there);
                if !std::mem::replace(&mut taken[row][column], true) {
                    let neighbour = around[(first + turn) % 6];
                    let towards = (direction + 3) % 6;
                    disc.push(Placed { site: neighbour, place: there, known: site, towards });
                }
            }
        }
        from = to;
    }
    disc[from..].iter().all(|placed| is_regular(layout, placed.site)).then_some(disc)
}

/// Whether a vertex has six faces and no sharp edge.
fn is_regular(layout: &Layout, site: Site) -> bool {
    let base = layout.base();
    match site {
        Site::Base(v) => base.is_regular(v),
        Site::Edge { edge, .. } => !base.is_boundary_edge(edge) && !base.is_sharp(edge),
        Site::Face { .. } => true,
    }
}
