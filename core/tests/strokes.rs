//! Brush strokes: whole and exact on every awkward mesh, undone and replayed to the bit, and each tool does what its
//! name says.

mod memory_disk;
mod samples;

use bozzetto_core::disk::Vfs;
use bozzetto_core::edit::{Dab, Edit, EditError, Falloff, Mirror, Step, Stroke, Tool, plan};
use bozzetto_core::file::{Metadata, Model, encode};
use bozzetto_core::hierarchy::{Level, Slot};
use bozzetto_core::mesh::shapes;
use bozzetto_core::session::{OpenOptions, Session, SessionError, open_model};
use bozzetto_core::surface::{LIMIT, Surface};
use bozzetto_core::wavelet::Wavelet;
use memory_disk::MemoryDisk;
use samples::{Numbers, assert_consistent, ball, contents, model, on_threads, surface};
use std::path::Path;
use std::sync::Arc;

fn words(tool: Tool, level: u8, radius: f64) -> Stroke {
    Stroke {
        tool,
        level,
        radius,
        strength: 0.5,
        falloff: None,
        mirror: None,
        to: None,
        from: Some([0.3, 0.1, -0.2]),
        dabs: Vec::new(),
        v: 1,
    }
}

/// A stroke of a few dabs near places of the surface.
fn random_stroke(numbers: &mut Numbers, surface: &Surface) -> Stroke {
    let finest = surface.finest();
    let size = surface.form().placement.step * f64::from(1 << 24);
    let tool = Tool::ALL[numbers.below(Tool::ALL.len() as u32) as usize];
    let falloffs = [None, Some(Falloff::Linear), Some(Falloff::Sharp), Some(Falloff::Constant)];
    let planes = |numbers: &mut Numbers| Mirror {
        x: (numbers.below(2) == 0).then(|| surface.form().placement.origin[0]),
        y: None,
        z: (numbers.below(3) == 0).then(|| surface.form().placement.origin[2]),
    };
    let mirror = (numbers.below(3) == 0).then(|| planes(numbers));
    let dabs = (0..=numbers.below(5))
        .map(|_| {
            let slot = Slot(numbers.below(surface.scaling(finest).len() as u32));
            Dab {
                strength: 0.5 + 0.5 * numbers.signed(),
                size: 1.0 + 0.5 * numbers.signed(),
                ..Dab::new(surface.position(finest, slot))
            }
        })
        .collect();
    Stroke {
        strength: 0.7 * numbers.signed(),
        falloff: falloffs[numbers.below(4) as usize],
        mirror,
        to: (tool == Tool::Erase && finest > Level::BASE && numbers.below(2) == 0)
            .then(|| numbers.below(u32::from(finest.0)) as u8),
        from: Some(surface.position(finest, Slot(0))),
        v: 1 + numbers.below(tool.latest_version()),
        dabs,
        ..words(
            tool,
            numbers.below(u32::from(finest.0) + 1) as u8,
            size * (0.02 + 0.3 * (numbers.signed() + 1.0)),
        )
    }
}

#[test]
fn strokes_are_whole_and_undone_exactly_on_awkward_meshes() {
    for (name, mesh) in shapes::awkward() {
        for (wavelet, sharp) in [(Wavelet::Disc(2), 1), (Wavelet::Disc(0), 0)] {
            let mut surface = surface(&mesh, wavelet, sharp, 3, 7);
            let mut numbers = Numbers(mesh.faces.len() as u64);
            let mut steps = Vec::new();
            for _ in 0..8 {
                let edit = Edit::Stroke(random_stroke(&mut numbers, &surface));
                let before = (contents(&surface), surface.mask().clone());
                let planned = plan(&surface, &edit).unwrap_or_else(|e| panic!("{name}: {edit:?}: {e}"));
                match Step::apply(&mut surface, edit.clone(), planned) {
                    Ok((step, _)) => steps.push((step, before, edit)),
                    Err(EditError::BeyondLimit) => {
                        assert!(contents(&surface) == before.0, "{name}: {edit:?}")
                    }
                    Err(error) => panic!("{name}: {edit:?}: {error}"),
                }
            }
            assert_consistent(&surface);
            let last = (contents(&surface), surface.mask().values().to_vec());
            for (step, before, edit) in steps.iter_mut().rev() {
                undo::Edit::undo(step, &mut surface);
                assert!(contents(&surface) == before.0, "{name}: undo of {edit:?}");
                let mask = before.1.values();
                let now = surface.mask().values();
                assert!(
                    mask == now || mask.is_empty() && now.iter().all(|&m| m == 0),
                    "{name}: mask, {edit:?}"
                );
            }
            for (step, ..) in &mut steps {
                // The first call only tells that the edit is already there.
                let _ = undo::Edit::edit(step, &mut surface);
                undo::Edit::edit(step, &mut surface);
            }
            assert_eq!(contents(&surface), last.0, "{name}: redo");
            assert_eq!(surface.mask().values(), last.1, "{name}: redo of the mask");
            assert_consistent(&surface);
        }
    }
}

/// What is reported as moved is what moved, and the boxes for finding places follow it.
#[test]
fn dabs_report_what_moved_and_places_are_found_as_on_a_fresh_surface() {
    for (name, mesh) in shapes::awkward().into_iter().take(8) {
        let disk = MemoryDisk::default();
        let mut session = Session::new(Arc::new(disk), model(&mesh, Wavelet::Disc(2), 1, 4, 3));
        let mut numbers = Numbers(11);
        for round in 0..6 {
            let stroke = random_stroke(&mut numbers, session.surface());
            session.begin_brush(Stroke { dabs: Vec::new(), ..stroke.clone() }).expect("a sensible stroke");
            for dab in &stroke.dabs {
                let before = session.surface().clone();
                let Ok(changes) = session.dab(*dab) else { continue };
                let now = session.surface();
                let moved = match changes.at(now.finest()) {
                    bozzetto_core::surface::Moved::Some(runs) => runs.slots().collect::<Vec<_>>(),
                    _ => Vec::new(),
                };
                let finest = now.finest();
                for (slot, (old, new)) in before.scaling(finest).iter().zip(now.scaling(finest)).enumerate() {
                    let told = moved.binary_search(&Slot(slot as u32)).is_ok();
                    assert!(old == new || told, "{name}, {round}: slot {slot} moved unreported");
                }
            }
            session.end_stroke();
            let now = session.surface();
            let fresh = Surface::from_finest(
                now.hierarchy().as_ref().clone(),
                now.form().clone(),
                now.scaling(now.finest()).to_vec(),
            )
            .expect("as before");
            for _ in 0..20 {
                let p = std::array::from_fn(|_| numbers.signed() * f64::from(1 << 25));
                assert_eq!(now.nearest(p), fresh.nearest(p), "{name}, {round}: {p:?}");
            }
        }
    }
}

/// The closest point is the closest of all triangles' points.
#[test]
fn the_nearest_place_is_the_nearest() {
    let (_, mesh) = shapes::awkward().into_iter().find(|(n, _)| *n == "genus 2").expect("a known mesh");
    let surface = surface(&mesh, Wavelet::Disc(1), 0, 3, 5);
    let finest = surface.finest();
    let positions = surface.scaling(finest);
    let mut numbers = Numbers(2);
    for _ in 0..40 {
        let p: [f64; 3] = std::array::from_fn(|_| numbers.signed() * f64::from(1 << 25));
        let found = surface.nearest(p);
        let distance = |q: [f64; 3]| (0..3).map(|c| (p[c] - q[c]) * (p[c] - q[c])).sum::<f64>();
        assert!(
            (distance(found.point) - found.squared_distance).abs() <= 1e-9 * found.squared_distance + 1.0
        );
        // No corner and no point sampled in a triangle is closer.
        for face in surface.hierarchy().triangles(finest) {
            for (a, b) in [(1.0, 0.0), (0.0, 1.0), (0.0, 0.0), (0.4, 0.3), (0.2, 0.7), (0.5, 0.5)] {
                let weights = [a, b, 1.0 - a - b];
                let q = std::array::from_fn(|c| {
                    (0..3).map(|k| weights[k] * f64::from(positions[face[k] as usize][c])).sum::<f64>()
                });
                assert!(distance(q) >= found.squared_distance * (1.0 - 1e-9), "{p:?}");
            }
        }
        let (triangle, weights) = found.address.triangle(finest);
        let layout = surface.hierarchy().layout(finest);
        let again: [f64; 3] = std::array::from_fn(|c| {
            let corner = |k: usize| {
                let [i, r] = triangle.corners()[k];
                let site = layout.site_at(triangle.face, [layout.segments() - i - r, i, r]);
                f64::from(positions[layout.slot(site).index()][c])
            };
            (0..3).map(|k| weights[k] * corner(k)).sum()
        });
        assert!(distance(again).sqrt() <= found.squared_distance.sqrt() * (1.0 + 1e-6) + 1e3, "{found:?}");
    }
}

fn session_on(disk: &MemoryDisk, mesh: &bozzetto_core::mesh::TriangleMesh) -> Session {
    disk.put("a.boz", &encode(&model(mesh, Wavelet::Disc(2), 1, 3, 23)));
    reopened(disk).expect("a sound pair")
}

fn reopened(disk: &MemoryDisk) -> Result<Session, SessionError> {
    let vfs: Arc<dyn Vfs> = Arc::new(disk.clone());
    Ok(Session::open(vfs, Path::new("a.boz"), OpenOptions::default(), &|_| true)?.session)
}

#[test]
fn live_strokes_replay_to_the_same_bits_on_any_number_of_threads() {
    for (name, mesh) in shapes::awkward().into_iter().take(9) {
        let disk = MemoryDisk::default();
        let mut session = session_on(&disk, &mesh);
        let mut numbers = Numbers(77);
        for round in 0..12 {
            let stroke = random_stroke(&mut numbers, session.surface());
            let before = (contents(session.surface()), session.history_len());
            session.begin_brush(Stroke { dabs: Vec::new(), ..stroke.clone() }).expect("a sensible stroke");
            for dab in &stroke.dabs {
                let _ = session.dab(*dab);
            }
            if round % 4 == 3 {
                session.cancel_stroke();
                assert!((contents(session.surface()), session.history_len()) == before, "{name}: cancelled");
            } else {
                session.end_stroke();
                if round % 5 == 2 {
                    session.undo();
                }
            }
        }
        assert_consistent(session.surface());
        session.save().expect("a sound disk");
        let (hash, mask) = (session.hash(), session.surface().mask().clone());
        session.close().expect("a sound disk");
        for threads in [1, 5] {
            let again = on_threads(threads, || reopened(&disk).expect("a sound pair"));
            assert_eq!(again.hash(), hash, "{name}, {threads} threads");
            let (a, b) = (again.surface().mask().values(), mask.values());
            assert!(a == b || a.iter().chain(b).all(|&m| m == 0), "{name}: the mask comes back with the log");
            again.close().expect("a sound disk");
        }
        let (read, _) = open_model(&disk, Path::new("a.boz"), OpenOptions::default()).expect("a sound pair");
        assert_eq!(read.surface.hash(), hash, "{name}");
    }
}

fn session_of(surface: Surface) -> Session {
    Session::new(Arc::new(MemoryDisk::default()), Model::new(surface, None, Metadata::default()))
}

fn stroked(session: &mut Session, stroke: Stroke, dabs: &[[f64; 3]]) {
    let dabs = dabs.iter().map(|&at| Dab::new(at)).collect();
    session.edit(Edit::Stroke(Stroke { dabs, ..stroke })).expect("a sensible stroke");
}

fn height(surface: &Surface, direction: [f64; 3]) -> f64 {
    let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
    let placement = &surface.form().placement;
    let at: [f64; 3] = std::array::from_fn(|c| direction[c] / length);
    // Down from high above: the closest point to a far point is the highest nearby.
    let steps = std::array::from_fn(|c| (at[c] * 1.3 - placement.origin[c]) / placement.step);
    let found = surface.nearest(steps);
    let p: [f64; 3] = std::array::from_fn(|c| placement.origin[c] + placement.step * found.point[c]);
    p.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// How far the vertex that lies most in a direction is from the origin.
fn radius_at(surface: &Surface, direction: [f64; 3]) -> f64 {
    let finest = surface.finest();
    let along = |p: [f64; 3]| {
        let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
        (0..3).map(|c| p[c] * direction[c]).sum::<f64>() / length
    };
    let vertices = (0..surface.scaling(finest).len() as u32).map(|s| surface.position(finest, Slot(s)));
    let most = vertices.max_by(|a, b| along(*a).total_cmp(&along(*b))).expect("there are vertices");
    most.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// The energy of the details of the levels from `from` on, near a direction.
fn energy(surface: &Surface, from: u8, near: [f64; 3]) -> f64 {
    let hierarchy = surface.hierarchy();
    let mut sum = 0.0;
    for level in (from..surface.finest().0).map(Level) {
        let (coarse, fine) = (hierarchy.layout(level), hierarchy.layout(level.finer()));
        for odd in (0..coarse.odd_len()).map(bozzetto_core::hierarchy::Odd) {
            let p = surface.position(level.finer(), fine.slot(coarse.odd_site(odd)));
            let far: f64 = (0..3).map(|c| (p[c] - near[c]) * (p[c] - near[c])).sum();
            if far < 0.05 {
                let d = surface.wavelets(level)[odd.index()];
                sum += d.iter().map(|&x| f64::from(x) * f64::from(x)).sum::<f64>();
            }
        }
    }
    sum
}

#[test]
fn brushes_raise_dig_and_level() {
    for level in [5, 3] {
        for tool in [Tool::Draw, Tool::Clay, Tool::Inflate] {
            let mut session = session_of(ball(5));
            let before = radius_at(session.surface(), [0.3, 1.0, 0.2]);
            stroked(&mut session, words(tool, level, 0.3), &[[0.3, 1.0, 0.2]]);
            let raised = radius_at(session.surface(), [0.3, 1.0, 0.2]) - before;
            assert!(raised > 0.004 && raised < 0.05, "{tool:?} at level {level}: {raised}");
            stroked(&mut session, Stroke { strength: -1.0, ..words(tool, level, 0.3) }, &[[0.3, 1.0, 0.2]]);
            let dug = radius_at(session.surface(), [0.3, 1.0, 0.2]) - before;
            assert!(dug < raised, "{tool:?} at level {level}: {dug}, {raised}");
        }
        let mut session = session_of(ball(5));
        let top = radius_at(session.surface(), [0.0, 1.0, 0.0]);
        for _ in 0..6 {
            stroked(
                &mut session,
                Stroke { strength: 1.0, ..words(Tool::Flatten, level, 0.5) },
                &[[0.0, 1.0, 0.0]],
            );
        }
        let flat = radius_at(session.surface(), [0.0, 1.0, 0.0]);
        assert!(flat < top - 0.02, "flattened from {top} to {flat}");
        let mut session = session_of(ball(5));
        stroked(&mut session, words(Tool::Crease, level, 0.3), &[[0.0, 1.0, 0.0]]);
        assert!(radius_at(session.surface(), [0.0, 1.0, 0.0]) < top - 0.004, "a crease digs");
    }
}

#[test]
fn pinching_draws_vertices_together() {
    let mut session = session_of(ball(5));
    let spread = |surface: &Surface| {
        let near = |p: &[f64; 3]| p[1] > 0.0 && p[0] * p[0] + p[2] * p[2] < 0.01;
        let finest = surface.finest();
        (0..surface.scaling(finest).len())
            .filter(|&s| near(&surface.position(finest, Slot(s as u32))))
            .count()
    };
    let before = spread(session.surface());
    stroked(&mut session, Stroke { strength: 1.0, ..words(Tool::Pinch, 5, 0.4) }, &[[0.0, 1.0, 0.0]; 3]);
    let after = spread(session.surface());
    assert!(after > before + before / 4, "{before} vertices near the pole, then {after}");
}

#[test]
fn smoothing_sharpening_and_erasing_act_on_finer_detail_alone() {
    let at = [0.5, 0.6, 0.6];
    let start = ball(5);
    let (fine, coarse) = (energy(&start, 3, at), energy(&start, 0, at) - energy(&start, 3, at));
    for (tool, range) in [(Tool::Smooth, 0.0..0.5), (Tool::Sharpen, 1.5..9.0), (Tool::Erase, 0.0..0.5)] {
        let mut session = session_of(start.clone());
        stroked(&mut session, Stroke { falloff: Some(Falloff::Constant), ..words(tool, 3, 0.5) }, &[at; 3]);
        let surface = session.surface();
        let share = energy(surface, 3, at) / fine;
        assert!(range.contains(&share), "{tool:?}: {share}");
        let left = energy(surface, 0, at) - energy(surface, 3, at);
        assert!((left / coarse - 1.0).abs() < 1e-9, "{tool:?} leaves coarser detail: {left} of {coarse}");
        assert!((0..3).all(|j| surface.wavelets(Level(j)) == start.wavelets(Level(j))), "{tool:?}");
    }
    // Only the chosen levels are erased.
    let mut session = session_of(start.clone());
    stroked(&mut session, Stroke { to: Some(3), ..words(Tool::Erase, 3, 0.5) }, &[at]);
    assert!(session.surface().wavelets(Level(4)) == start.wavelets(Level(4)));
    assert!(session.surface().wavelets(Level(3)) != start.wavelets(Level(3)));
}

/// Smoothing ends in a smooth surface, not in the flat faces of the level.
#[test]
fn smoothing_a_ball_keeps_it_round() {
    let smooth = |tool| {
        let mut session = session_of(ball(6));
        let words = Stroke { strength: 1.0, falloff: Some(Falloff::Constant), ..words(tool, 2, 0.7) };
        stroked(&mut session, words, &[[0.0, 0.0, 1.0]; 4]);
        let surface = session.surface();
        let finest = surface.finest();
        // Angles between neighbouring faces around the touched place.
        let mut worst: f64 = 0.0;
        for slot in (0..surface.scaling(finest).len() as u32).map(Slot) {
            let p = surface.position(finest, slot);
            if p[2] < 0.9 {
                continue;
            }
            let layout = surface.hierarchy().layout(finest);
            let ring = layout.ring(layout.site(slot)).around;
            let at = |s| surface.position(finest, layout.slot(s));
            let normals: Vec<[f64; 3]> = (0..ring.len())
                .map(|k| {
                    let (a, b) = (at(ring[k]), at(ring[(k + 1) % ring.len()]));
                    let (u, v): ([f64; 3], [f64; 3]) =
                        (std::array::from_fn(|c| a[c] - p[c]), std::array::from_fn(|c| b[c] - p[c]));
                    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
                    let length = n.iter().map(|x| x * x).sum::<f64>().sqrt();
                    n.map(|x| x / length)
                })
                .collect();
            for k in 0..normals.len() {
                let (a, b) = (normals[k], normals[(k + 1) % normals.len()]);
                let cosine: f64 = (0..3).map(|c| a[c] * b[c]).sum();
                worst = worst.max(cosine.clamp(-1.0, 1.0).acos().to_degrees());
            }
        }
        worst
    };
    let (round, faceted) = (smooth(Tool::Smooth), smooth(Tool::Erase));
    assert!(round < 0.5 * faceted, "smooth {round}°, erased {faceted}°");
}

#[test]
fn a_small_brush_on_a_coarse_level_moves_the_point_it_touches() {
    for level in [0, 1, 2] {
        let mut session = session_of(ball(5));
        let direction = [0.31, 0.83, 0.22];
        let before = height(session.surface(), direction);
        let stroke = Stroke { strength: 1.0, ..words(Tool::Draw, level, 0.05) };
        stroked(&mut session, stroke, &[direction]);
        let raised = height(session.surface(), direction) - before;
        // A tenth of the radius along the level's normal, which is not quite the finest level's.
        assert!((raised - 0.005).abs() < 0.0015, "level {level}: {raised}");
    }
}

#[test]
fn mirrored_strokes_are_mirrored_in_space() {
    let reflected = |mirror: Mirror, signs: [f64; 3]| {
        let mut session = session_of(ball(5));
        let stroke = Stroke { mirror: Some(mirror), ..words(Tool::Draw, 5, 0.2) };
        stroked(&mut session, stroke, &[[0.4, 0.7, 0.5], [0.1, 0.7, 0.5]]);
        let surface = session.surface();
        for direction in [[0.4, 0.7, 0.5], [0.05, 0.7, 0.5], [0.3, 0.6, 0.55]] {
            let image = std::array::from_fn(|c| direction[c] * signs[c]);
            let (here, there) = (height(surface, direction), height(surface, image));
            assert!((here - there).abs() < 1e-4, "{direction:?}: {here} and {there}");
        }
        height(surface, [0.4, 0.7, 0.5])
    };
    let plane = Some(0.0);
    let raised = reflected(Mirror { x: plane, y: None, z: None }, [-1.0, 1.0, 1.0]);
    reflected(Mirror { x: plane, y: plane, z: plane }, [-1.0, -1.0, -1.0]);
    let mut alone = session_of(ball(5));
    let untouched = height(alone.surface(), [-0.4, 0.7, 0.5]);
    stroked(&mut alone, words(Tool::Draw, 5, 0.2), &[[0.4, 0.7, 0.5], [0.1, 0.7, 0.5]]);
    assert!((height(alone.surface(), [0.4, 0.7, 0.5]) - raised).abs() < 2e-3);
    assert!((height(alone.surface(), [-0.4, 0.7, 0.5]) - untouched).abs() < 1e-6, "no mirror, no image");
}

#[test]
fn a_mask_keeps_what_it_covers() {
    let at = [0.0, 1.0, 0.0];
    let mut session = session_of(ball(5));
    let constant = Some(Falloff::Constant);
    let mask = Stroke { strength: 1.0, falloff: constant, ..words(Tool::Mask, 0, 0.3) };
    stroked(&mut session, mask.clone(), &[at]);
    let start = contents(session.surface());
    let masked: Vec<usize> =
        (0..start[5].len()).filter(|&s| session.surface().mask().value(Slot(s as u32)) > 0).collect();
    assert!(masked.len() > 20);
    for tool in [Tool::Draw, Tool::Inflate, Tool::Pinch] {
        stroked(&mut session, Stroke { falloff: constant, ..words(tool, 5, 0.6) }, &[at]);
    }
    let now = session.surface().scaling(Level(5));
    assert!(masked.iter().all(|&s| now[s] == start[5][s]), "masked vertices stay");
    assert!(now != start[5].as_slice(), "others move");
    // Half masked is half moved, and a negative stroke takes the mask away.
    stroked(&mut session, Stroke { strength: -1.0, radius: 4.0, ..mask }, &[at]);
    assert!(session.surface().mask().values().iter().all(|&m| m == 0));
    session.undo();
    assert!(session.surface().mask().value(Slot(masked[0] as u32)) > 0, "undo brings the mask back");
}

/// Surface hashes after the stroke below by version.
const COPIED: [&str; 2] = ["b7d2803c4b1696f10227123c4287eb90", "2c3c04a2e676b9e42bc9e7536256f26a"];

#[test]
fn copied_detail_appears_elsewhere() {
    let mut surface = ball(5);
    // Detail on one side only.
    let mut positions = surface.scaling(Level(5)).to_vec();
    for p in &mut positions {
        if p[0] < 0 {
            let length = p.iter().map(|&x| f64::from(x) * f64::from(x)).sum::<f64>().sqrt();
            let radius = f64::from(1 << 24) * 0.97;
            *p = p.map(|x| (f64::from(x) / length * radius) as i32);
        }
    }
    surface = Surface::from_finest(surface.hierarchy().as_ref().clone(), surface.form().clone(), positions)
        .expect("as before");
    let (from, to) = ([0.7, 0.2, 0.6], [-0.7, 0.2, 0.6]);
    // How far vertices near the place are above and below their mean.
    let relief = |surface: &Surface| {
        let near = |p: &[f64; 3]| (0..3).all(|c| (p[c] - to[c]).abs() < 0.15);
        let vertices =
            (0..surface.scaling(Level(5)).len() as u32).map(|s| surface.position(Level(5), Slot(s)));
        let radii: Vec<f64> =
            vertices.filter(near).map(|p| p.iter().map(|x| x * x).sum::<f64>().sqrt()).collect();
        let mean = radii.iter().sum::<f64>() / radii.len() as f64;
        radii.iter().map(|r| (r - mean).abs()).fold(0.0, f64::max)
    };
    let before = relief(&surface);
    let mut session = session_of(surface);
    let original = session.hash();
    let mut hashes = Vec::new();
    for v in 1..=Tool::Copy.latest_version() {
        let stroke = Stroke { strength: 1.0, from: Some(from), v, ..words(Tool::Copy, 3, 0.3) };
        stroked(&mut session, stroke.clone(), &[to]);
        let after = relief(session.surface());
        assert!(before < 1e-3 && after > 0.004, "version {v}: {before}, then {after}");
        hashes.push(session.hash());
        let nowhere = Edit::Stroke(Stroke { from: None, ..stroke });
        let none = session.edit(nowhere).expect_err("nowhere to copy from");
        assert!(none.to_string().contains("from"), "{none}");
        session.undo();
        assert_eq!(session.hash(), original);
    }
    // Each version replays as it always did.
    let shown: Vec<String> = hashes.iter().map(ToString::to_string).collect();
    assert_eq!(shown, COPIED);
}

#[test]
fn strokes_without_sense_are_refused_and_change_nothing() {
    let mut session = session_of(ball(3));
    let hash = session.hash();
    let good = Stroke { dabs: vec![Dab::new([0.0, 1.0, 0.0])], ..words(Tool::Draw, 3, 0.2) };
    let bad = [
        Stroke { radius: 0.0, ..good.clone() },
        Stroke { radius: f64::NAN, ..good.clone() },
        Stroke { strength: f64::INFINITY, ..good.clone() },
        Stroke { level: 4, ..good.clone() },
        Stroke { v: 2, ..good.clone() },
        Stroke { tool: Tool::Erase, to: Some(3), ..good.clone() },
        Stroke { dabs: vec![Dab { size: -1.0, ..Dab::new([0.0; 3]) }], ..good.clone() },
        Stroke { dabs: vec![Dab::new([f64::NAN, 0.0, 0.0])], ..good.clone() },
        Stroke { dabs: vec![Dab::new([0.0; 3]); 5000], ..good.clone() },
        Stroke { mirror: Some(Mirror { x: Some(f64::NAN), y: None, z: None }), ..good.clone() },
        Stroke { strength: f64::from(LIMIT), ..good.clone() },
        Stroke { strength: 1e300, radius: 1e300, ..good.clone() },
    ];
    for stroke in bad {
        let text = format!("{stroke:?}");
        assert!(session.edit(Edit::Stroke(stroke)).is_err(), "{text}");
        assert_eq!(session.hash(), hash, "{text}");
        assert_eq!(session.history_len(), 0, "{text}");
    }
    session.edit(Edit::Stroke(good)).expect("the one that is fine");
}

#[test]
fn a_long_stroke_goes_on_as_a_new_one() {
    let mut session = session_of(ball(3));
    session.begin_brush(words(Tool::Draw, 3, 0.2)).expect("a sensible stroke");
    for at in 0..4100 {
        let turn = f64::from(at) * 0.01;
        session.dab(Dab { strength: 0.01, ..Dab::new([turn.cos(), 0.2, turn.sin()]) }).expect("in range");
    }
    session.end_stroke();
    let counts: Vec<usize> = session
        .history()
        .map(|edit| match edit {
            Edit::Stroke(stroke) => stroke.dabs.len(),
            other => panic!("{other}"),
        })
        .collect();
    assert_eq!(counts, [4096, 4]);
}
