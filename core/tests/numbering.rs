//! The public numbering: nested, a bijection, and the same for ever.

use bozzetto_core::hierarchy::{BaseMesh, Hierarchy, Layout, Level, Odd, PublicId, Site, Slot};
use bozzetto_core::mesh::{TriangleMesh, shapes};
use std::sync::Arc;

fn hierarchy(mesh: &TriangleMesh, finest: u8) -> Hierarchy {
    let base = BaseMesh::new(mesh.positions.len() as u32, mesh.faces.clone(), &[]).expect("a base mesh");
    Hierarchy::new(Arc::new(base), Level(finest)).expect("small")
}

#[test]
fn ids_are_a_nested_bijection_on_every_awkward_base() {
    for (name, mesh) in shapes::awkward() {
        let meshes = hierarchy(&mesh, 4);
        for j in 0..=4 {
            let layout = meshes.layout(Level(j));
            let mut seen = vec![false; layout.len() as usize];
            for slot in 0..layout.len() {
                let site = layout.site(Slot(slot));
                assert_eq!(layout.slot(site), Slot(slot), "{name}: slot and site at level {j}");
                let id = layout.public_id(site);
                assert!(
                    !std::mem::replace(&mut seen[id.0 as usize], true),
                    "{name}: id {id} twice at level {j}"
                );
                assert_eq!(layout.site_of(id), site, "{name}: id {id} back to its site");
                if j < 4 {
                    let finer = meshes.layout(Level(j + 1));
                    assert_eq!(finer.public_id(Layout::refine(site)), id, "{name}: id {id} one level finer");
                }
            }
            assert!(seen.iter().all(|&s| s), "{name}: ids 0..n_{j} all occur");
        }
    }
}

#[test]
fn counts_follow_the_formula() {
    for (name, mesh) in shapes::awkward() {
        let meshes = hierarchy(&mesh, 5);
        let base = meshes.base();
        let (v, e, f) = (base.vertex_count(), base.edges().len() as u32, base.faces().len() as u32);
        for j in 0..=5u32 {
            let n = 1 << j;
            let expected = v + e * (n - 1) + f * ((n - 1) * (n.max(2) - 2) / 2);
            assert_eq!(meshes.layout(Level(j as u8)).len(), expected, "{name}, level {j}");
            if j < 5 {
                let (here, finer) = (meshes.layout(Level(j as u8)), meshes.layout(Level(j as u8 + 1)));
                assert_eq!(here.odd_len(), finer.len() - here.len(), "{name}, odd vertices of level {j}");
            }
        }
    }
}

#[test]
fn odd_vertices_lie_halfway_between_their_parents() {
    for (name, mesh) in shapes::awkward() {
        let meshes = hierarchy(&mesh, 4);
        for j in 0..4 {
            let (coarse, fine) = (meshes.layout(Level(j)), meshes.layout(Level(j + 1)));
            for odd in 0..coarse.odd_len() {
                let site = coarse.odd_site(Odd(odd));
                assert_eq!(coarse.odd_at(site), Odd(odd), "{name}");
                assert_eq!(fine.public_id(site), PublicId(coarse.len() + odd), "{name}");
                let [a, b] = coarse.parents(site);
                assert_eq!(coarse.midpoint(a, b), site, "{name}: midpoint of the parents");
                let ring = fine.ring(site).around;
                assert!(
                    ring.contains(&Layout::refine(a)) && ring.contains(&Layout::refine(b)),
                    "{name}: neighbours"
                );
            }
        }
    }
}

/// Rings are symmetric, and their triangles are exactly the level's triangles.
#[test]
fn rings_agree_with_triangles_and_edges() {
    for (name, mesh) in shapes::awkward() {
        let meshes = hierarchy(&mesh, 3);
        for j in 0..=3 {
            let layout = meshes.layout(Level(j));
            let mut from_rings = Vec::new();
            let mut edges = Vec::new();
            for slot in 0..layout.len() {
                let ring = layout.ring(layout.site(Slot(slot)));
                let around: Vec<u32> = ring.around.iter().map(|&s| layout.slot(s).0).collect();
                for at in 0..ring.faces() {
                    from_rings.push(rotated([slot, around[at], around[(at + 1) % around.len()]]));
                }
                edges.extend(around.iter().filter(|&&o| slot < o).map(|&o| [slot, o]));
            }
            from_rings.sort_unstable();
            let mut triangles: Vec<[u32; 3]> =
                meshes.triangles(Level(j)).into_iter().flat_map(|t| [rotated(t); 3]).collect();
            triangles.sort_unstable();
            assert_eq!(from_rings, triangles, "{name}, level {j}");
            edges.sort_unstable();
            let mut listed: Vec<[u32; 2]> =
                meshes.edges(Level(j)).into_iter().map(|[a, b]| [a.min(b), a.max(b)]).collect();
            listed.sort_unstable();
            assert_eq!(edges, listed, "{name}, edges of level {j}");
        }
    }
}

fn rotated(face: [u32; 3]) -> [u32; 3] {
    let lowest = (0..3).min_by_key(|&k| face[k]).expect("three corners");
    [face[lowest], face[(lowest + 1) % 3], face[(lowest + 2) % 3]]
}

/// Ids that must never change: files, scripts and logs name them.
#[test]
fn golden_ids() {
    let meshes = hierarchy(&shapes::octahedron(), 4);
    let layout = meshes.layout(Level(4));
    let id = |site| layout.public_id(site).0;
    assert_eq!(id(Site::Base(5)), 5);
    assert_eq!(id(Site::Edge { edge: 0, t: 8 }), 6);
    assert_eq!(id(Site::Edge { edge: 11, t: 8 }), 17);
    assert_eq!(id(Site::Edge { edge: 0, t: 4 }), 18);
    assert_eq!(id(Site::Edge { edge: 0, t: 12 }), 19);
    assert_eq!(id(Site::Face { face: 0, i: 4, r: 4 }), 42);
    assert_eq!(id(Site::Face { face: 0, i: 8, r: 4 }), 43);
    assert_eq!(id(Site::Face { face: 0, i: 4, r: 8 }), 44);
    assert_eq!(id(Site::Face { face: 7, i: 4, r: 8 }), 65);
    assert_eq!(id(Site::Face { face: 0, i: 1, r: 1 }), 354);
    assert_eq!(id(Site::Face { face: 3, i: 1, r: 2 }), 620);
    assert_eq!(layout.len(), 1026);
}
