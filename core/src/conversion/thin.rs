//! Thinning of very large meshes: collapses in passes, each over the cheap edges.
//!
//! A pass prices all edges, several threads side by side, and then collapses those below a limit, each checked again,
//! face by face rather than cheapest first: what lies together on the surface lies together in memory, and on a million
//! faces waiting for that is what costs most. Guarantees: an oriented manifold of the same topology; the same result at
//! any number of threads.

use super::collapse::{Attempt, Collapser};
use super::costs::Costs;
use super::density::Density;
use super::simplify::{Cancelled, LADDER, STRIDE, ask};
use super::working_mesh::WorkingMesh;
use rayon::prelude::*;

/// A pass that takes away less than this part of what is still too much is the last.
const WORTHWHILE: f64 = 0.05;
/// Up to this part more faces than asked for will do.
const ENOUGH: f64 = 0.02;

/// Collapses edges until about `target` faces are left or little more can go. `progress` takes the fraction done and
/// returns whether to go on. Cost: some 6 µs a collapse.
///
/// # Errors
/// The progress function asked to stop.
pub(super) fn thin(
    mesh: &mut WorkingMesh,
    target: usize,
    density: &Density,
    progress: &dyn Fn(f32) -> bool,
) -> Result<(), Cancelled> {
    let (start, rules) = (mesh.live_count(), &LADDER[0]);
    ask(&|| progress(0.0))?;
    let mut costs = Costs::new(mesh, density, target);
    let mut collapser = Collapser::default();
    loop {
        let before = mesh.live_count();
        let excess = before.saturating_sub(target);
        if (excess as f64) < ENOUGH * target as f64 {
            break;
        }
        ask(&|| progress((start - before) as f32 / (start - target) as f32))?;
        let (edges, limit) = cheap(mesh, &costs, excess);
        for (attempt, &ends) in edges.iter().enumerate() {
            let done = (start - mesh.live_count()) as f32 / (start - target) as f32;
            if attempt.is_multiple_of(STRIDE) && !progress(done) {
                return Err(Cancelled);
            }
            if mesh.live_count() <= target {
                break;
            }
            // What was collapsed meanwhile may have taken an end away, or made the edge dear.
            if mesh.sides(ends[0], ends[1]) == [None; 2] || price(mesh, &costs, ends) > limit {
                continue;
            }
            if let Attempt::Done { kept, gone } = collapser.collapse(mesh, None, &costs.quadrics, ends, rules)
            {
                costs.join(mesh, kept, gone);
            }
        }
        if ((before - mesh.live_count()) as f64) < WORTHWHILE * excess as f64 {
            break;
        }
    }
    Ok(())
}

/// As many of the cheapest edges as there are faces too many, in the order of the faces, and the most that one costs.
fn cheap(mesh: &WorkingMesh, costs: &Costs, excess: usize) -> (Vec<[u32; 2]>, f64) {
    let edges_of = |f: u32| {
        let [a, b, c] = mesh.face(f);
        // An edge runs up in one of its faces; one of the boundary may run down in its only one.
        let alone = |a, b| mesh.is_boundary(a) && mesh.is_boundary(b) && mesh.sides(a, b).contains(&None);
        let once = move |&[a, b]: &[u32; 2]| a < b || alone(a, b);
        [[a, b], [b, c], [c, a]].into_iter().filter(once).map(|[a, b]| [a.min(b), a.max(b)])
    };
    let live: Vec<u32> = mesh.live_faces().collect();
    let priced: Vec<(f64, [u32; 2])> = live
        .par_iter()
        .flat_map_iter(|&f| edges_of(f).map(|ends| (price(mesh, costs, ends), ends)))
        .collect();
    let mut prices: Vec<f64> = priced.iter().map(|&(price, _)| price).collect();
    let most = excess.min(prices.len() - 1);
    let limit = *prices.select_nth_unstable_by(most, f64::total_cmp).1;
    (priced.into_iter().filter(|&(price, _)| price <= limit).map(|(_, ends)| ends).collect(), limit)
}

/// What an edge costs by its quadrics and the density alone.
fn price(mesh: &WorkingMesh, costs: &Costs, ends: [u32; 2]) -> f64 {
    costs.place(mesh, ends).1 + costs.crowding(ends)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conversion::creases::Creases;
    use crate::mesh::{Connectivity, TriangleMesh, shapes};
    use glam::DVec3;

    fn thinned(mesh: &TriangleMesh, target: usize) -> WorkingMesh {
        let connectivity = Connectivity::build(mesh.positions.len() as u32, mesh.faces.clone()).unwrap();
        let positions = mesh.positions.iter().map(|&p| DVec3::from(p)).collect();
        let mut working = WorkingMesh::new(positions, &connectivity);
        let density = Density::new(mesh, &connectivity, target as f64, &Creases::default());
        thin(&mut working, target, &density, &|_| true).expect("not cancelled");
        working
    }

    #[test]
    fn topology_is_kept_and_most_faces_go() {
        for (name, mesh) in shapes::awkward() {
            let fine = shapes::subdivide(&mesh, 4);
            let working = thinned(&fine, fine.faces.len() / 4);
            let count = working.positions.len() as u32;
            let faces: Vec<[u32; 3]> = working.live_faces().map(|f| working.face(f)).collect();
            let after = Connectivity::build(count, faces).expect(name);
            let before = Connectivity::build(count, fine.faces.clone()).expect(name);
            let figures = |c: &Connectivity| (c.genus(), c.components(), c.boundary_loops());
            assert_eq!(figures(&after), figures(&before), "{name}");
            let left = working.live_count();
            assert!(left * 2 < fine.faces.len(), "{name}: {left} of {} faces", fine.faces.len());
        }
    }

    #[test]
    fn the_same_at_any_number_of_threads() {
        let mesh = shapes::subdivide(&shapes::octahedron(), 5);
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| thinned(&mesh, 2000).compact())
        };
        assert_eq!(on(1), on(3));
    }
}
