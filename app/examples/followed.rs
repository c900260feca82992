//! What a window prepares for the graphics card after every dab, and when it shows another level: on a million vertices.
//!
//! ```text
//! cargo run -p bozzetto --example followed [LEVELS]
//! ```
//!
//! The core's own part of a dab is timed by `cargo run --release -p bozzetto-core --example strokes`.

use bozzetto::display::{PickTree, ShownVertices};
use bozzetto_core::disk::Disk;
use bozzetto_core::edit::{Dab, Stroke, Tool};
use bozzetto_core::file::{Metadata, Model};
use bozzetto_core::hierarchy::{BaseMesh, Hierarchy, Level, Slot};
use bozzetto_core::mesh::shapes;
use bozzetto_core::session::Session;
use bozzetto_core::surface::{FormOptions, Surface};
use std::sync::Arc;
use std::time::Instant;

fn ball(levels: u8) -> Surface {
    let mesh = shapes::octahedron();
    let base = Arc::new(BaseMesh::new(6, mesh.faces.clone(), &[]).expect("a base mesh"));
    let hierarchy = Hierarchy::new(base, Level(levels)).expect("fits");
    let layout = hierarchy.layout(Level(levels));
    let positions: Vec<[f64; 3]> = (0..layout.len())
        .map(|slot| {
            let (face, b) = layout.chart(layout.site(Slot(slot)));
            let corners = hierarchy.base().faces()[face as usize].map(|v| mesh.positions[v as usize]);
            let p: [f64; 3] = std::array::from_fn(|c| (0..3).map(|k| f64::from(b[k]) * corners[k][c]).sum());
            let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
            p.map(|x| x / length)
        })
        .collect();
    Surface::from_positions(hierarchy, &positions, &FormOptions::default()).expect("a ball")
}

fn report(name: &str, mut milliseconds: Vec<f64>, goal: &str) {
    milliseconds.sort_by(f64::total_cmp);
    let at = |share: f64| milliseconds[((milliseconds.len() - 1) as f64 * share).round() as usize];
    println!("{name:<28} median {:8.3} ms   p99 {:8.3} ms   {goal}", at(0.5), at(0.99));
}

fn since(begun: Instant) -> f64 {
    begun.elapsed().as_secs_f64() * 1e3
}

fn main() {
    let levels = std::env::args().nth(1).map_or(9, |x| x.parse().expect("a number of levels"));
    let surface = ball(levels);
    let finest = surface.finest();
    println!("{} vertices", surface.scaling(finest).len());
    let mut session = Session::new(Arc::new(Disk), Model::new(surface, None, Metadata::default()));
    let mut shown = ShownVertices::new(session.surface(), finest);
    let mut tree = PickTree::new(session.surface().hierarchy(), &shown);
    for level in [finest.0, finest.0.saturating_sub(3)] {
        let mut times = Vec::new();
        for round in 0..8 {
            let words = Stroke {
                tool: Tool::Draw,
                level,
                radius: 0.05,
                strength: 0.5,
                falloff: None,
                mirror: None,
                to: None,
                from: None,
                dabs: Vec::new(),
                v: 1,
            };
            session.begin_brush(words).expect("a sensible stroke");
            for dab in 0..80 {
                let turn = f64::from(dab) * 0.0125 + f64::from(round);
                let at = [turn.cos(), 0.1 * f64::from(round) - 0.4, turn.sin()];
                let changes = session.dab(Dab::new(at)).expect("in range");
                let begun = Instant::now();
                shown.follow(session.surface(), changes.at(finest));
                tree.follow(session.surface(), &shown, changes.at(finest));
                times.push(since(begun));
            }
            session.end_stroke();
        }
        report(&format!("dab followed, level {level}"), times, "beside the core's part");
    }
    for level in [finest, Level(finest.0 - 1), Level(finest.0 - 3)] {
        let mut times = Vec::new();
        for _ in 0..9 {
            let begun = Instant::now();
            let shown = ShownVertices::new(session.surface(), level);
            let tree = PickTree::new(session.surface().hierarchy(), &shown);
            times.push(since(begun));
            drop(tree);
        }
        report(&format!("level {level} shown"), times, "goal: 50 ms");
    }
}
