//! The boundary and the sharp edges of a base mesh as curves: vertices on them slide along them and nowhere else.
//!
//! A chain runs from pinned vertex to pinned vertex, or round. A place on it is a parameter: edges passed, and the
//! part of the next.

use super::domain::Address;
use crate::hierarchy::BaseMesh;

/// Which edges are curves, and how they follow one another.
#[derive(Debug)]
pub(super) struct Curves {
    chains: Vec<Chain>,
    /// For each edge of the base mesh its chain and place in it, and whether the chain runs from its low end.
    of_edge: Vec<Option<(u32, u32, bool)>>,
    /// For each vertex its two curve edges; `None` for vertices off curves and for pinned ones.
    through: Vec<Option<[u32; 2]>>,
    on_curve: Vec<bool>,
}

#[derive(Debug)]
struct Chain {
    edges: Vec<(u32, bool)>,
    closed: bool,
}

impl Curves {
    /// The boundary edges and the sharp ones; `pinned` vertices end chains, and so do those where not two edges meet.
    pub(super) fn new(base: &BaseMesh, pinned: &[bool]) -> Self {
        let count = base.edges().len() as u32;
        let is_curve = |e: u32| base.is_boundary_edge(e) || base.is_sharp(e);
        let mut at_vertex: Vec<Vec<u32>> = vec![Vec::new(); base.vertex_count() as usize];
        for e in (0..count).filter(|&e| is_curve(e)) {
            base.edges()[e as usize].iter().for_each(|&v| at_vertex[v as usize].push(e));
        }
        let through: Vec<Option<[u32; 2]>> = at_vertex
            .iter()
            .zip(pinned)
            .map(|(edges, &pinned)| if pinned { None } else { edges.as_slice().try_into().ok() })
            .collect();
        let mut curves = Self {
            chains: Vec::new(),
            of_edge: vec![None; count as usize],
            through,
            on_curve: at_vertex.iter().map(|edges| !edges.is_empty()).collect(),
        };
        // Chains that end first, then round ones.
        for round in [false, true] {
            for e in (0..count).filter(|&e| is_curve(e)) {
                for from_low in [true, false] {
                    let start = base.edges()[e as usize][usize::from(!from_low)];
                    if curves.of_edge[e as usize].is_none()
                        && (round || curves.through[start as usize].is_none())
                    {
                        curves.follow(base, e, from_low);
                    }
                }
            }
        }
        curves
    }

    fn follow(&mut self, base: &BaseMesh, first: u32, from_low: bool) {
        let chain = self.chains.len() as u32;
        let mut edges = Vec::new();
        let (mut e, mut forward, mut closed) = (first, from_low, false);
        loop {
            self.of_edge[e as usize] = Some((chain, edges.len() as u32, forward));
            edges.push((e, forward));
            let end = base.edges()[e as usize][usize::from(forward)];
            let Some(pair) = self.through[end as usize] else { break };
            e = if pair[0] == e { pair[1] } else { pair[0] };
            if self.of_edge[e as usize].is_some() {
                closed = e == first;
                break;
            }
            forward = base.edges()[e as usize][0] == end;
        }
        self.chains.push(Chain { edges, closed });
    }

    /// The two curve edges of a vertex that may slide.
    pub(super) fn through(&self, vertex: u32) -> Option<[u32; 2]> {
        self.through[vertex as usize]
    }

    /// Whether the edge is a curve.
    pub(super) fn holds(&self, edge: u32) -> bool {
        self.of_edge[edge as usize].is_some()
    }

    /// Whether the vertex lies on a curve.
    pub(super) fn passes(&self, vertex: u32) -> bool {
        self.on_curve[vertex as usize]
    }

    /// The weighted mean along the curve that all the addresses are on; `None` if there is none.
    pub(super) fn blend(&self, base: &BaseMesh, parts: &[(f64, Address)]) -> Option<Address> {
        // A chain from a pinned vertex round to itself passes that twice: the nearer pass counts.
        let blends = self.parameters(base, parts.first()?.1).into_iter().filter_map(|(chain, from)| {
            let (mut sum, mut farthest) = (0.0, 0.0f64);
            for &(weight, address) in parts {
                let off = self.off(base, address, chain, from)?;
                sum += weight * off;
                farthest = farthest.max(off.abs());
            }
            Some((farthest, chain, from + sum))
        });
        let (_, chain, t) = blends.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(self.at(base, chain, t))
    }

    /// How far along a chain an address is from a place on it, the shorter way; `None` if it is not on the chain.
    fn off(&self, base: &BaseMesh, address: Address, chain: u32, from: f64) -> Option<f64> {
        let Chain { edges, closed } = &self.chains[chain as usize];
        let length = edges.len() as f64;
        let near = |t: f64| {
            let off = t - from;
            if *closed { off - length * (off / length).round() } else { off }
        };
        let own = self.parameters(base, address).into_iter().filter(|own| own.0 == chain);
        own.map(|own| near(own.1)).min_by(|a, b| a.abs().total_cmp(&b.abs()))
    }

    /// The chains an address is on, and where.
    fn parameters(&self, base: &BaseMesh, address: Address) -> Vec<(u32, f64)> {
        let mut found = Vec::with_capacity(2);
        let edges = base.face_edges(address.face);
        let corners = base.faces()[address.face as usize];
        for k in 0..3 {
            if address.b[(k + 2) % 3] != 0.0 {
                continue;
            }
            let along = address.b[(k + 1) % 3];
            // At a corner every curve through the vertex counts, also those of other faces.
            if along == 0.0 || along == 1.0 {
                let v = corners[if along == 0.0 { k } else { (k + 1) % 3 }];
                self.at_vertex(base, v, &mut found);
            } else if let Some((chain, place, forward)) = self.of_edge[edges[k] as usize] {
                let from_low = base.edges()[edges[k] as usize][0] == corners[k];
                let t = if from_low == forward { along } else { 1.0 - along };
                found.push((chain, f64::from(place) + t));
            }
        }
        found
    }

    fn at_vertex(&self, base: &BaseMesh, v: u32, found: &mut Vec<(u32, f64)>) {
        for &(face, corner) in &base.fan(v).corners {
            let edges = base.face_edges(face);
            for k in [usize::from(corner), (usize::from(corner) + 2) % 3] {
                if let Some((chain, place, forward)) = self.of_edge[edges[k] as usize] {
                    let low = base.edges()[edges[k] as usize][0] == v;
                    let at = (chain, f64::from(place) + if low == forward { 0.0 } else { 1.0 });
                    if !found.contains(&at) {
                        found.push(at);
                    }
                }
            }
        }
    }

    fn at(&self, base: &BaseMesh, chain: u32, t: f64) -> Address {
        let Chain { edges, closed } = &self.chains[chain as usize];
        let length = edges.len() as f64;
        let t = if *closed { t - length * (t / length).floor() } else { t.clamp(0.0, length) };
        let place = (t as usize).min(edges.len() - 1);
        let (edge, forward) = edges[place];
        let along = (t - place as f64).clamp(0.0, 1.0);
        self.on_edge(base, edge, if forward { along } else { 1.0 - along })
    }

    /// The point of an edge at a part of the way from its low end.
    pub(super) fn on_edge(&self, base: &BaseMesh, edge: u32, from_low: f64) -> Address {
        let side = base.sides(edge)[0].expect("an edge has a face");
        let k = usize::from(side.k);
        let low_first = base.edges()[edge as usize][0] == base.faces()[side.face as usize][k];
        let along = if low_first { from_low } else { 1.0 - from_low };
        let mut b = [0.0; 3];
        b[k] = 1.0 - along;
        b[(k + 1) % 3] = along;
        Address { face: side.face, b }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A loop with one pinned vertex begins and ends there: a place shortly before the end is near it, not a whole
    /// loop away.
    #[test]
    fn a_pinned_vertex_is_near_both_ends_of_its_loop() {
        let base = BaseMesh::new(5, (0..4).map(|k| [k, (k + 1) % 4, 4]).collect(), &[]).expect("a fan");
        assert_eq!(base.boundary_loops(), 1);
        let curves = Curves::new(&base, &[true, false, false, false, false]);
        let ends = [[0, 1], [0, 3]];
        for near in ends {
            let edge = base.edges().iter().position(|&e| e == near).expect("a side") as u32;
            let [pinned, close] = [0.0, 0.25].map(|from_low| curves.on_edge(&base, edge, from_low));
            for parts in [[(0.5, pinned), (0.5, close)], [(0.5, close), (0.5, pinned)]] {
                let middle = curves.blend(&base, &parts).expect("both are on the boundary");
                let wanted = curves.on_edge(&base, edge, 0.125);
                assert_eq!(middle.face, wanted.face, "{near:?}");
                assert!((0..3).all(|k| (middle.b[k] - wanted.b[k]).abs() < 1e-12), "{near:?}: {middle:?}");
            }
        }
    }
}
