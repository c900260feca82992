//! Exactness of the integer transform, its constant stencil, and the quality of coarse parts.

use bozzetto_core::hierarchy::{BaseMesh, Hierarchy, Layout, Level, Slot};
use bozzetto_core::mesh::{TriangleMesh, shapes};
use bozzetto_core::wavelet::lifting::{analyse_level, synthesise_level};
use bozzetto_core::wavelet::weights::WeightSolver;
use bozzetto_core::wavelet::{Filters, Wavelet};
use std::collections::BTreeMap;
use std::sync::Arc;

fn hierarchy(mesh: &TriangleMesh, sharp: &[[u32; 2]], finest: u8) -> Hierarchy {
    let base = BaseMesh::new(mesh.positions.len() as u32, mesh.faces.clone(), sharp).expect("a base mesh");
    Hierarchy::new(Arc::new(base), Level(finest)).expect("small")
}

/// Numbers without pattern, the same every time (SplitMix64).
fn noise(count: u32, range: i64, seed: u64) -> Vec<[i32; 3]> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) as i64).rem_euclid(2 * range + 1) - range
    };
    (0..count).map(|_| std::array::from_fn(|_| next() as i32)).collect()
}

#[test]
fn synthesis_inverts_analysis_on_every_awkward_base() {
    for (name, mesh) in shapes::awkward() {
        let first_edge = [mesh.faces[0][0], mesh.faces[0][1]];
        for sharp in [vec![], vec![first_edge]] {
            let meshes = hierarchy(&mesh, &sharp, 5);
            for wavelet in Wavelet::ALL {
                let filters = Filters::new(&meshes, wavelet).expect("small valences");
                for level in (0..5).map(Level) {
                    let finer = noise(meshes.layout(level.finer()).len(), 1 << 24, 7);
                    let (details, coarser) = analyse_level(&meshes, &filters, level, &finer);
                    let back = synthesise_level(&meshes, &filters, level, &coarser, &details);
                    assert!(back == finer, "{name}, {wavelet}, level {level}, {} sharp edges", sharp.len());
                }
            }
        }
    }
}

/// Every tap that the filters use, constant stencil or explicit row, is the transpose of the solved weights.
#[test]
fn filters_are_the_transposed_weights() {
    let shapes =
        shapes::awkward().into_iter().flat_map(|(name, mesh)| [(name, mesh.clone(), 0), (name, mesh, 2)]);
    for (name, mesh, sharp) in shapes {
        let marks: Vec<[u32; 2]> = mesh.faces.iter().take(sharp).map(|f| [f[0], f[1]]).collect();
        let meshes = hierarchy(&mesh, &marks, 6);
        for wavelet in [Wavelet::Disc(0), Wavelet::Disc(1), Wavelet::Disc(2)] {
            let filters = Filters::new(&meshes, wavelet).expect("small valences");
            // Level 4 and 5 have regular vertices for every k.
            for level in [0, 3, 4].map(Level) {
                let layout = meshes.layout(level);
                if layout.len() > 6000 {
                    continue;
                }
                let mut expected = BTreeMap::new();
                let solver = WeightSolver::default();
                for odd in 0..layout.odd_len() {
                    let odd = bozzetto_core::hierarchy::Odd(odd);
                    let stencil = solver.stencil(layout, layout.odd_site(odd), wavelet);
                    for (v, w) in stencil.vertices.iter().zip(stencil.weights) {
                        expected.insert((layout.slot(*v), odd), w);
                    }
                }
                let mut used = BTreeMap::new();
                for slot in 0..layout.len() {
                    filters.for_each_tap(layout, layout.site(Slot(slot)), |odd, w| {
                        assert!(used.insert((Slot(slot), odd), w).is_none(), "{name}: a tap twice");
                    });
                }
                assert!(expected == used, "{name}, {wavelet}, level {level}");
            }
        }
    }
}

/// The 72 taps of the regular 2-disc update fall into the eight classes that docs/FORMAT.md lists.
#[test]
fn golden_regular_stencils() {
    let meshes = hierarchy(&shapes::triangle(), &[], 6);
    let classes = |wavelet| {
        let filters = Filters::new(&meshes, wavelet).expect("small valences");
        let layout = meshes.layout(Level(5));
        let centre = layout.site_at(0, [10, 11, 11]);
        let mut classes: BTreeMap<i32, u32> = BTreeMap::new();
        filters.for_each_tap(layout, centre, |_, w| *classes.entry(w).or_default() += 1);
        classes.into_iter().map(|(w, taps)| (taps, w)).collect::<Vec<_>>()
    };
    assert_eq!(classes(Wavelet::Disc(0)), [(6, 187_246)]);
    assert_eq!(
        classes(Wavelet::Disc(2)),
        [(12, -29644), (6, -27397), (6, -16645), (6, 1622), (12, 2424), (12, 6266), (12, 8833), (6, 204_385)]
    );
}

/// L2 distance of white noise from its coarse part, over that from the nearest coarse function: root mean square of
/// twelve draws, for a single draw on a small base strays by a few parts in a thousand.
#[test]
fn coarse_parts_are_near_least_squares() {
    for (name, mesh) in [
        ("octahedron", shapes::octahedron()),
        ("tetrahedron", shapes::tetrahedron()),
        ("torus", shapes::torus(4, 3)),
        ("disc", shapes::disc(6)),
    ] {
        let meshes = hierarchy(&mesh, &[], 4);
        let level = Level(3);
        let fine = meshes.layout(level.finer());
        let draws: Vec<Vec<[i32; 3]>> = (11..15).map(|seed| noise(fine.len(), 1 << 24, seed)).collect();
        let mut best = 0.0;
        let mut of_wavelet = [0.0; 4];
        for finer in &draws {
            let parts = Wavelet::ALL.map(|wavelet| {
                let filters = Filters::new(&meshes, wavelet).expect("small valences");
                analyse_level(&meshes, &filters, level, finer).1
            });
            for channel in 0..3 {
                let target: Vec<f64> = finer.iter().map(|c| f64::from(c[channel])).collect();
                best += squared_distance(&meshes, level, &least_squares(&meshes, level, &target), &target);
                for (sum, part) in of_wavelet.iter_mut().zip(&parts) {
                    let part: Vec<f64> = part.iter().map(|c| f64::from(c[channel])).collect();
                    *sum += squared_distance(&meshes, level, &part, &target);
                }
            }
        }
        for (wavelet, low, high) in [
            (Wavelet::Lazy, 1.35, 2.0),
            (Wavelet::Disc(0), 1.03, 1.11),
            (Wavelet::Disc(1), 1.0, 1.007),
            (Wavelet::Disc(2), 1.0, 1.0003),
        ] {
            let ratio = (of_wavelet[usize::from(wavelet.code())] / best).sqrt();
            println!("{name}, {wavelet}: {ratio:.5}");
            assert!((low..=high).contains(&ratio), "{name}, {wavelet}: {ratio}");
        }
    }
}

/// Squared L2 distance between a function of `V^j` and one of `V^{j+1}`.
fn squared_distance(meshes: &Hierarchy, level: Level, coarser: &[f64], target: &[f64]) -> f64 {
    let (coarse, fine) = (meshes.layout(level), meshes.layout(level.finer()));
    let difference: Vec<f64> = (0..fine.len())
        .map(|s| {
            let site = fine.site(Slot(s));
            let value = match Layout::coarsen(site) {
                Some(even) => coarser[coarse.slot(even).index()],
                None => {
                    coarse.parents(site).map(|p| coarser[coarse.slot(p).index()]).iter().sum::<f64>() / 2.0
                }
            };
            value - target[s as usize]
        })
        .collect();
    inner_product(meshes, level.finer(), &difference, &difference)
}

/// `⟨f, g⟩` of two functions of `V^j`, every face with the same area.
fn inner_product(meshes: &Hierarchy, level: Level, f: &[f64], g: &[f64]) -> f64 {
    let of_face = |t: [u32; 3]| {
        let (f, g) = (t.map(|s| f[s as usize]), t.map(|s| g[s as usize]));
        let products: f64 = (0..3).map(|k| f[k] * g[k]).sum();
        f.iter().sum::<f64>() * g.iter().sum::<f64>() + products
    };
    meshes.triangles(level).into_iter().map(of_face).sum()
}

/// The nearest function of `V^j` to one of `V^{j+1}`, by conjugate gradients on the normal equations.
fn least_squares(meshes: &Hierarchy, level: Level, target: &[f64]) -> Vec<f64> {
    let (coarse, fine) = (meshes.layout(level), meshes.layout(level.finer()));
    let prolong = |x: &[f64]| -> Vec<f64> {
        (0..fine.len())
            .map(|s| {
                let site = fine.site(Slot(s));
                match Layout::coarsen(site) {
                    Some(even) => x[coarse.slot(even).index()],
                    None => coarse.parents(site).map(|p| x[coarse.slot(p).index()]).iter().sum::<f64>() / 2.0,
                }
            })
            .collect()
    };
    let triangles = meshes.triangles(level.finer());
    let restricted_mass = |f: &[f64]| -> Vec<f64> {
        let mut mass = vec![0.0; f.len()];
        for t in &triangles {
            let sum: f64 = t.iter().map(|&s| f[s as usize]).sum();
            for &s in t {
                mass[s as usize] += sum + f[s as usize];
            }
        }
        let mut restricted = vec![0.0; coarse.len() as usize];
        for (s, m) in mass.iter().enumerate() {
            let site = fine.site(Slot(s as u32));
            match Layout::coarsen(site) {
                Some(even) => restricted[coarse.slot(even).index()] += m,
                None => {
                    for p in coarse.parents(site) {
                        restricted[coarse.slot(p).index()] += m / 2.0;
                    }
                }
            }
        }
        restricted
    };
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut x = vec![0.0; coarse.len() as usize];
    let mut residual = restricted_mass(target);
    let mut direction = residual.clone();
    let mut size = dot(&residual, &residual);
    let start = size;
    while size > 1e-26 * start {
        let image = restricted_mass(&prolong(&direction));
        let step = size / dot(&direction, &image);
        for ((x, r), (d, i)) in x.iter_mut().zip(&mut residual).zip(direction.iter().zip(&image)) {
            *x += step * d;
            *r -= step * i;
        }
        let new = dot(&residual, &residual);
        for (d, r) in direction.iter_mut().zip(&residual) {
            *d = r + new / size * *d;
        }
        size = new;
    }
    x
}
