//! The engine's parts in detail, for developers: `cargo bench -p bozzetto-core`. `bozzetto bench` measures the whole and
//! compares it with baselines.

use bozzetto_core::edit::{Edit, Kind, Move, Step, plan};
use bozzetto_core::file::{Metadata, Model, decode, encode};
use bozzetto_core::hierarchy::{BaseMesh, Hierarchy, Layout, Level, Slot};
use bozzetto_core::mesh::shapes;
use bozzetto_core::surface::{FormOptions, Surface};
use bozzetto_core::wavelet::rows::{Instructions, analyse_level_into, synthesise_level_into};
use bozzetto_core::wavelet::{Wavelet, lifting};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::path::Path;
use std::sync::Arc;

/// An octahedron split so often, with waves on it.
fn ball(levels: u8, wavelet: Wavelet) -> Surface {
    let mesh = shapes::octahedron();
    let base = BaseMesh::new(mesh.positions.len() as u32, mesh.faces, &[]).expect("a base mesh");
    let hierarchy = Hierarchy::new(Arc::new(base), Level(levels)).expect("few levels");
    let layout = hierarchy.layout(Level(levels));
    let at = |slot: u32| place(layout, &mesh.positions, Slot(slot));
    let positions: Vec<[f64; 3]> = (0..layout.len()).map(at).collect();
    let options = FormOptions { wavelet, ..FormOptions::default() };
    Surface::from_positions(hierarchy, &positions, &options).expect("a small model")
}

fn place(layout: &Layout, corners: &[[f64; 3]], slot: Slot) -> [f64; 3] {
    let (face, b) = layout.chart(layout.site(slot));
    let face = layout.base().faces()[face as usize];
    let flat: [f64; 3] =
        std::array::from_fn(|c| (0..3).map(|k| corners[face[k] as usize][c] * f64::from(b[k])).sum());
    let length = flat.iter().map(|x| x * x).sum::<f64>().sqrt();
    let waves = 1.0 + 0.02 * (40.0 * flat[0] / length).sin();
    flat.map(|x| x / length * waves)
}

/// One level of analysis and synthesis, the finest, by implementation and wavelet.
fn levels(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("level");
    for levels in [6, 8, 9] {
        for wavelet in Wavelet::ALL {
            let surface = ball(levels, wavelet);
            let (hierarchy, filters) = (surface.hierarchy(), surface.filters());
            let level = Level(levels - 1);
            let name = |what: &str| BenchmarkId::new(format!("{what}, {wavelet}"), levels);
            let mut finer = surface.scaling(level.finer()).to_vec();
            let mut coarser = surface.scaling(level).to_vec();
            let mut details = surface.wavelets(level).to_vec();
            group.throughput(Throughput::Elements(finer.len() as u64));
            for instructions in [Instructions::Detected, Instructions::Narrower, Instructions::Baseline] {
                group.bench_function(name(&format!("analysis, {instructions:?}")), |bencher| {
                    bencher.iter(|| {
                        let output = (details.as_mut_slice(), coarser.as_mut_slice());
                        analyse_level_into(hierarchy, filters, level, instructions, &finer, output);
                    });
                });
                group.bench_function(name(&format!("synthesis, {instructions:?}")), |bencher| {
                    bencher.iter(|| {
                        let input = (coarser.as_slice(), details.as_slice());
                        synthesise_level_into(hierarchy, filters, level, instructions, input, &mut finer);
                    });
                });
            }
            if levels == 6 {
                group.bench_function(name("analysis, plain"), |bencher| {
                    bencher.iter(|| lifting::analyse_level(hierarchy, filters, level, &finer));
                });
            }
        }
    }
    group.finish();
}

/// A scaling coefficient of every level, made and undone.
fn edits(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("edit and undo");
    for levels in [7, 9] {
        let mut surface = ball(levels, Wavelet::Disc(2));
        for level in 0..=levels {
            let vertex = surface.hierarchy().layout(Level(level)).len() * 5 / 8;
            let delta = [0.004, 0.002, -0.003];
            let kind = Kind::Scaling;
            let edit = Edit::Move(Move {
                kind,
                level,
                vertex,
                delta,
                radius: None,
                falloff: None,
                mirror: None,
                v: 1,
            });
            group.bench_function(BenchmarkId::new(format!("of {levels} levels"), level), |bencher| {
                bencher.iter(|| {
                    let plan = plan(&surface, &edit).expect("it exists");
                    let (mut step, _) = Step::apply(&mut surface, edit.clone(), plan).expect("in range");
                    undo::Edit::edit(&mut step, &mut surface);
                    undo::Edit::undo(&mut step, &mut surface)
                });
            });
        }
    }
    group.finish();
}

/// Wavelet files in memory.
fn files(criterion: &mut Criterion) {
    let model = Model::new(ball(7, Wavelet::Disc(2)), None, Metadata::default());
    let bytes = encode(&model);
    criterion.bench_function("encode", |bencher| bencher.iter(|| encode(&model)));
    criterion.bench_function("decode", |bencher| bencher.iter(|| decode(&bytes, Path::new("ball.boz"))));
}

criterion_group!(benches, levels, edits, files);
criterion_main!(benches);
