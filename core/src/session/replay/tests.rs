use super::*;
use crate::edit::{Kind, Move};
use crate::hierarchy::{BaseMesh, Hierarchy, Level};
use crate::mesh::shapes;
use crate::surface::{Form, Placement, UpAxis};
use crate::wavelet::{Scheme, Wavelet};
use std::sync::Arc;

fn ball() -> Surface {
    let mesh = shapes::octahedron();
    let base = BaseMesh::new(6, mesh.faces, &[]).expect("a base mesh");
    let hierarchy = Hierarchy::new(Arc::new(base), Level(4)).expect("small");
    let count = hierarchy.layout(Level(4)).len() as i32;
    let positions: Vec<[i32; 3]> = (0..count).map(|v| [v * 1000, -700 * v, (v * v) % 4001]).collect();
    let placement =
        Placement { origin: [0.0; 3], step: 1.0 / f64::from(1 << 20), up: UpAxis::Y, unit: String::new() };
    let form = Form { scheme: Scheme::Linear, wavelet: Wavelet::Disc(1), precision: 20, placement };
    Surface::from_finest(hierarchy, form, positions).expect("weights")
}

fn moved(vertex: u32) -> Entry {
    let delta = [0.01 * f64::from(vertex), 0.02, -0.03];
    let (radius, falloff) = (Some(0.7), None);
    Entry::Edit(Edit::Move(Move {
        kind: Kind::Scaling,
        level: 1,
        vertex,
        delta,
        radius,
        falloff,
        mirror: None,
        v: 1,
    }))
}

/// A long log is opened in bounded memory: steps are put away while it is replayed, not after, and those that its lines
/// undo come back.
#[test]
fn history_stays_within_its_budget_while_a_log_is_replayed() {
    const BUDGET: usize = 4 << 10;
    let (mut surface, mut record, mut attic) = (ball(), Record::new(), Attic::default());
    attic.set_budget(BUDGET);
    let mut hashes = vec![surface.hash()];
    let mut put_away = 0;
    for k in 0..60 {
        replay_entry(&mut surface, (&mut record, &mut attic), &moved(k % 18)).expect("it fits");
        hashes.push(surface.hash());
        assert!(attic.in_memory() <= BUDGET, "after {k}: {}", attic.in_memory());
        let bytes = |packed: &Packed| packed.handle().lock().expect("free").in_memory();
        put_away = record.entries().filter(|entry| bytes(entry.as_ref().packed()) == 0).count();
    }
    assert!(put_away > 20, "{put_away}");
    for (entry, there) in
        [(Entry::Undo(60), 0), (Entry::Redo(25), 25), (Entry::Undo(3), 22), (Entry::Redo(38), 60)]
    {
        replay_entry(&mut surface, (&mut record, &mut attic), &entry).expect("as many steps");
        assert_eq!(surface.hash(), hashes[there], "{entry:?}");
        assert!(attic.in_memory() <= BUDGET, "{entry:?}: {}", attic.in_memory());
    }
}
