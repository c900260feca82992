//! How long strokes take: every brush on a sphere of a million vertices, its relief made of many sizes.
//!
//! ```text
//! cargo run --release -p bozzetto-core --example strokes [LEVELS]
//! ```

use bozzetto_core::disk::Disk;
use bozzetto_core::edit::{Dab, Edit, Kind, Move, Stroke, Tool};
use bozzetto_core::file::{Metadata, Model};
use bozzetto_core::hierarchy::{BaseMesh, Hierarchy, Level, Slot};
use bozzetto_core::mesh::shapes;
use bozzetto_core::session::Session;
use bozzetto_core::surface::{FormOptions, Surface};
use std::sync::Arc;
use std::time::{Duration, Instant};

fn sphere(levels: u8) -> Surface {
    let mesh = shapes::octahedron();
    let base = Arc::new(BaseMesh::new(6, mesh.faces.clone(), &[]).expect("a base mesh"));
    let hierarchy = Hierarchy::new(base, Level(levels)).expect("fits");
    let layout = hierarchy.layout(Level(levels));
    let positions: Vec<[f64; 3]> = (0..layout.len())
        .map(|slot| {
            let (face, b) = layout.chart(layout.site(Slot(slot)));
            let corners = hierarchy.base().faces()[face as usize].map(|v| mesh.positions[v as usize]);
            let p: [f64; 3] =
                std::array::from_fn(|c| (0..3).map(|k| f64::from(b[k]) * corners[k][c]).sum::<f64>());
            let length = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
            let q = p.map(|x| x / length);
            let wave = |f: f64| (f * q[0]).sin() * (f * q[1]).sin() * (f * q[2]).sin() / f;
            let radius = 1.0 + wave(7.0) + wave(31.0) + wave(200.0);
            q.map(|x| x * radius)
        })
        .collect();
    Surface::from_positions(hierarchy, &positions, &FormOptions::default()).expect("a sphere")
}

fn report(name: &str, mut times: Vec<Duration>, more: &str) {
    times.sort();
    let at = |share: f64| times[((times.len() - 1) as f64 * share) as usize].as_secs_f64() * 1e3;
    println!("{name:<24} median {:8.3} ms   p99 {:8.3} ms   {more}", at(0.5), at(0.99));
}

fn main() {
    let levels = std::env::args().nth(1).map_or(9, |x| x.parse().expect("a number of levels"));
    let surface = sphere(levels);
    let finest = surface.finest();
    println!("{} vertices", surface.scaling(finest).len());
    let mut session = Session::new(Arc::new(Disk), Model::new(surface, None, Metadata::default()));
    session.surface().nearest([0.0; 3]);
    for tool in Tool::ALL {
        for level in [finest.0, finest.0.saturating_sub(3)] {
            let (mut dabs, mut ends, mut undos, mut touched, mut bytes) =
                (Vec::new(), Vec::new(), Vec::new(), 0, 0);
            for stroke in 0..6 {
                let words = Stroke {
                    tool,
                    level,
                    radius: 0.05,
                    strength: 0.5,
                    falloff: None,
                    mirror: None,
                    to: None,
                    from: Some([-1.0, 0.2, 0.1]),
                    dabs: Vec::new(),
                    v: tool.latest_version(),
                };
                session.begin_brush(words).expect("a sensible stroke");
                for dab in 0..80 {
                    let turn = f64::from(dab) * 0.0125 + f64::from(stroke);
                    let at = [turn.cos(), 0.3 * f64::from(stroke) - 0.7, turn.sin()];
                    let begun = Instant::now();
                    let changes = session.dab(Dab::new(at)).expect("in range");
                    dabs.push(begun.elapsed());
                    if let bozzetto_core::surface::Moved::Some(runs) = changes.at(finest) {
                        touched += runs.len();
                    }
                }
                let begun = Instant::now();
                session.end_stroke();
                ends.push(begun.elapsed());
                bytes +=
                    session.history().last().map_or(0, |e| serde_json::to_string(e).expect("data").len());
                let begun = Instant::now();
                session.undo();
                undos.push(begun.elapsed());
            }
            let count = touched / dabs.len();
            report(&format!("{} at level {level}", tool.name()), dabs, &format!("{count} vertices a dab"));
            report("    end of the stroke", ends, &format!("{} bytes a line", bytes / 6));
            report("    undo", undos, "");
        }
    }
    for (name, level) in [("raw handle", 0), ("raw handle", 3)] {
        let edit = Move {
            kind: Kind::Scaling,
            level,
            vertex: 2,
            delta: [0.0; 3],
            radius: None,
            falloff: None,
            v: 1,
        };
        session.begin_stroke(edit).expect("it exists");
        let mut steps = Vec::new();
        for step in 1..20 {
            let begun = Instant::now();
            session.drag_to([0.01 * f64::from(step), 0.0, 0.0]).expect("in range");
            steps.push(begun.elapsed());
        }
        session.cancel_stroke();
        report(&format!("{name} at level {level}"), steps, "");
    }
    assert!(session.history().all(|e| matches!(e, Edit::Stroke(_))));
}
