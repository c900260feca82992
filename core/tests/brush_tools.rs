//! Each brush does what its name says.

mod memory_disk;
mod samples;

use bozzetto_core::edit::{Dab, Edit, Falloff, Mirror, Stroke, Tool};
use bozzetto_core::hierarchy::{Level, Slot};
use bozzetto_core::session::Session;
use bozzetto_core::surface::Surface;
use memory_disk::session_of;
use samples::{ball, contents, stroke};

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
            stroked(&mut session, stroke(tool, level, 0.3), &[[0.3, 1.0, 0.2]]);
            let raised = radius_at(session.surface(), [0.3, 1.0, 0.2]) - before;
            assert!(raised > 0.004 && raised < 0.05, "{tool:?} at level {level}: {raised}");
            stroked(&mut session, Stroke { strength: -1.0, ..stroke(tool, level, 0.3) }, &[[0.3, 1.0, 0.2]]);
            let dug = radius_at(session.surface(), [0.3, 1.0, 0.2]) - before;
            assert!(dug < raised, "{tool:?} at level {level}: {dug}, {raised}");
        }
        let mut session = session_of(ball(5));
        let top = radius_at(session.surface(), [0.0, 1.0, 0.0]);
        for _ in 0..6 {
            stroked(
                &mut session,
                Stroke { strength: 1.0, ..stroke(Tool::Flatten, level, 0.5) },
                &[[0.0, 1.0, 0.0]],
            );
        }
        let flat = radius_at(session.surface(), [0.0, 1.0, 0.0]);
        assert!(flat < top - 0.02, "flattened from {top} to {flat}");
        let mut session = session_of(ball(5));
        stroked(&mut session, stroke(Tool::Crease, level, 0.3), &[[0.0, 1.0, 0.0]]);
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
    stroked(&mut session, Stroke { strength: 1.0, ..stroke(Tool::Pinch, 5, 0.4) }, &[[0.0, 1.0, 0.0]; 3]);
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
        stroked(&mut session, Stroke { falloff: Some(Falloff::Constant), ..stroke(tool, 3, 0.5) }, &[at; 3]);
        let surface = session.surface();
        let share = energy(surface, 3, at) / fine;
        assert!(range.contains(&share), "{tool:?}: {share}");
        let left = energy(surface, 0, at) - energy(surface, 3, at);
        assert!((left / coarse - 1.0).abs() < 1e-9, "{tool:?} leaves coarser detail: {left} of {coarse}");
        assert!((0..3).all(|j| surface.wavelets(Level(j)) == start.wavelets(Level(j))), "{tool:?}");
    }
    // Only the chosen levels are erased.
    let mut session = session_of(start.clone());
    stroked(&mut session, Stroke { to: Some(3), ..stroke(Tool::Erase, 3, 0.5) }, &[at]);
    assert!(session.surface().wavelets(Level(4)) == start.wavelets(Level(4)));
    assert!(session.surface().wavelets(Level(3)) != start.wavelets(Level(3)));
}

/// Smoothing ends in a smooth surface, not in the flat faces of the level.
#[test]
fn smoothing_a_ball_keeps_it_round() {
    let smooth = |tool| {
        let mut session = session_of(ball(6));
        let words = Stroke { strength: 1.0, falloff: Some(Falloff::Constant), ..stroke(tool, 2, 0.7) };
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
        let stroke = Stroke { strength: 1.0, ..stroke(Tool::Draw, level, 0.05) };
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
        let stroke = Stroke { mirror: Some(mirror), ..stroke(Tool::Draw, 5, 0.2) };
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
    stroked(&mut alone, stroke(Tool::Draw, 5, 0.2), &[[0.4, 0.7, 0.5], [0.1, 0.7, 0.5]]);
    assert!((height(alone.surface(), [0.4, 0.7, 0.5]) - raised).abs() < 2e-3);
    assert!((height(alone.surface(), [-0.4, 0.7, 0.5]) - untouched).abs() < 1e-6, "no mirror, no image");
}

#[test]
fn a_mask_keeps_what_it_covers() {
    let at = [0.0, 1.0, 0.0];
    let mut session = session_of(ball(5));
    let constant = Some(Falloff::Constant);
    let mask = Stroke { strength: 1.0, falloff: constant, ..stroke(Tool::Mask, 0, 0.3) };
    stroked(&mut session, mask.clone(), &[at]);
    let start = contents(session.surface());
    let masked: Vec<usize> =
        (0..start[5].len()).filter(|&s| session.surface().mask().value(Slot(s as u32)) > 0).collect();
    assert!(masked.len() > 20);
    for tool in [Tool::Draw, Tool::Inflate, Tool::Pinch] {
        stroked(&mut session, Stroke { falloff: constant, ..stroke(tool, 5, 0.6) }, &[at]);
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
        let stroke = Stroke { strength: 1.0, from: Some(from), v, ..stroke(Tool::Copy, 3, 0.3) };
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
