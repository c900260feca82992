//! One suite over every implementation of the transform: the plain reference, rows with the processor's best
//! instructions, without AVX-512 and with the target's own, on one thread and on several. All give the same bits.

use bozzetto_core::hierarchy::{BaseMesh, Hierarchy, Level};
use bozzetto_core::mesh::{TriangleMesh, shapes};
use bozzetto_core::wavelet::rows::{Instructions, analyse_level_into, synthesise_level_into};
use bozzetto_core::wavelet::{Filters, Wavelet, lifting};
use std::sync::Arc;

type Values<const N: usize> = Vec<[i32; N]>;

/// An implementation, as the suite calls it.
#[derive(Debug, Clone, Copy)]
enum Implementation {
    Plain,
    Rows(Instructions, usize),
}

const ALL: [Implementation; 5] = [
    Implementation::Plain,
    Implementation::Rows(Instructions::Detected, 1),
    Implementation::Rows(Instructions::Narrower, 1),
    Implementation::Rows(Instructions::Baseline, 1),
    Implementation::Rows(Instructions::Detected, 3),
];

impl Implementation {
    fn analyse<const N: usize>(
        self,
        meshes: &Hierarchy,
        filters: &Filters,
        level: Level,
        finer: &[[i32; N]],
    ) -> (Values<N>, Values<N>) {
        let Self::Rows(instructions, threads) = self else {
            return lifting::analyse_level(meshes, filters, level, finer);
        };
        let layout = meshes.layout(level);
        // Whatever stands there before is written over.
        let (mut details, mut coarser) =
            (vec![[7; N]; layout.odd_len() as usize], vec![[7; N]; layout.len() as usize]);
        on_threads(threads, || {
            let output = (details.as_mut_slice(), coarser.as_mut_slice());
            analyse_level_into(meshes, filters, level, instructions, finer, output);
        });
        (details, coarser)
    }

    fn synthesise<const N: usize>(
        self,
        meshes: &Hierarchy,
        filters: &Filters,
        level: Level,
        coarser: &[[i32; N]],
        details: &[[i32; N]],
    ) -> Values<N> {
        let Self::Rows(instructions, threads) = self else {
            return lifting::synthesise_level(meshes, filters, level, coarser, details);
        };
        let mut finer = vec![[7; N]; meshes.layout(level.finer()).len() as usize];
        on_threads(threads, || {
            synthesise_level_into(meshes, filters, level, instructions, (coarser, details), &mut finer);
        });
        finer
    }
}

fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a thread pool").install(work)
}

fn hierarchy(mesh: &TriangleMesh, sharp: &[[u32; 2]], finest: u8) -> Hierarchy {
    let base = BaseMesh::new(mesh.positions.len() as u32, mesh.faces.clone(), sharp).expect("a base mesh");
    Hierarchy::new(Arc::new(base), Level(finest)).expect("small")
}

/// Numbers without pattern below `2^bits` in magnitude, the same every time (SplitMix64).
fn noise<const N: usize>(count: u32, bits: u32, seed: u64) -> Values<N> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) as i32) >> (31 - bits)
    };
    (0..count).map(|_| std::array::from_fn(|_| next())).collect()
}

/// Every implementation agrees with the reference at a level, both ways, and synthesis inverts analysis.
fn check<const N: usize>(meshes: &Hierarchy, filters: &Filters, level: Level, bits: u32, what: &str) {
    let what = format!("{what}, {}, level {level}, {N} channels, {bits} bits", filters.wavelet());
    let layout = meshes.layout(level);
    let finer = noise::<N>(meshes.layout(level.finer()).len(), bits, 7);
    let (details, coarser) = (noise::<N>(layout.odd_len(), bits, 8), noise::<N>(layout.len(), bits, 9));
    let expected = ALL[0].analyse(meshes, filters, level, &finer);
    let synthesised = ALL[0].synthesise(meshes, filters, level, &coarser, &details);
    for each in ALL {
        let analysed = each.analyse(meshes, filters, level, &finer);
        assert!(analysed.0 == expected.0, "{each:?}: details differ: {what}");
        assert!(analysed.1 == expected.1, "{each:?}: coarser vertices differ: {what}");
        let back = each.synthesise(meshes, filters, level, &analysed.1, &analysed.0);
        assert!(back == finer, "{each:?}: synthesis does not invert analysis: {what}");
        let anew = each.synthesise(meshes, filters, level, &coarser, &details);
        assert!(anew == synthesised, "{each:?}: finer vertices differ: {what}");
    }
}

#[test]
fn all_agree_on_every_awkward_base() {
    for (name, mesh) in shapes::awkward() {
        let edges: Vec<[u32; 2]> = mesh.faces.iter().take(3).map(|f| [f[0], f[1]]).collect();
        for sharp in [0, 1, 3] {
            let finest = if mesh.faces.len() > 40 { 5 } else { 6 };
            let meshes = hierarchy(&mesh, &edges[..sharp.min(edges.len())], finest);
            for wavelet in Wavelet::ALL {
                let filters = Filters::new(&meshes, wavelet).expect("small valences");
                for level in (0..finest).map(Level) {
                    check::<3>(&meshes, &filters, level, 24, &format!("{name}, {sharp} sharp"));
                }
            }
        }
    }
}

/// Rows long enough for several strips, and windows that slide.
#[test]
fn all_agree_on_long_rows() {
    for (name, mesh) in [("triangle", shapes::triangle()), ("torus", shapes::torus(3, 3))] {
        let meshes = hierarchy(&mesh, &[], 8);
        let level = Level(if name == "triangle" { 7 } else { 5 });
        for wavelet in Wavelet::ALL {
            let filters = Filters::new(&meshes, wavelet).expect("small valences");
            check::<3>(&meshes, &filters, level, 24, name);
            check::<1>(&meshes, &filters, level, 24, name);
            check::<4>(&meshes, &filters, level, 24, name);
        }
    }
    let meshes = hierarchy(&shapes::triangle(), &[], 9);
    check::<3>(
        &meshes,
        &Filters::new(&meshes, Wavelet::Disc(2)).expect("small"),
        Level(8),
        20,
        "one triangle",
    );
}

#[test]
fn all_agree_for_any_number_of_channels() {
    let meshes = hierarchy(&shapes::torus(4, 3), &[], 5);
    let filters = Filters::new(&meshes, Wavelet::Disc(2)).expect("small valences");
    check::<1>(&meshes, &filters, Level(4), 24, "torus");
    check::<2>(&meshes, &filters, Level(4), 24, "torus");
    check::<4>(&meshes, &filters, Level(4), 24, "torus");
    check::<6>(&meshes, &filters, Level(4), 24, "torus");
}

/// Where 32-bit class sums would overflow, the level goes to the reference.
#[test]
fn all_agree_beyond_the_limit() {
    let meshes = hierarchy(&shapes::octahedron(), &[], 6);
    for wavelet in Wavelet::ALL {
        let filters = Filters::new(&meshes, wavelet).expect("small valences");
        for bits in [26, 27, 28, 31] {
            check::<3>(&meshes, &filters, Level(5), bits, "octahedron");
        }
    }
}
