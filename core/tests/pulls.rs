//! Pulls: exact like every edit, smooth where a move makes a tent, and with detail that follows.

mod memory_disk;
mod samples;

use bozzetto_core::edit::{Edit, EditError, Falloff, Kind, Mirror, Move, Pull, Spread, Step, plan};
use bozzetto_core::file::encode;
use bozzetto_core::hierarchy::{BaseMesh, Hierarchy, Level, PublicId, Slot};
use bozzetto_core::mesh::{TriangleMesh, shapes};
use bozzetto_core::session::{OpenOptions, Session};
use bozzetto_core::surface::{FormOptions, Surface};
use bozzetto_core::wavelet::Wavelet;
use memory_disk::{MemoryDisk, session_of};
use samples::{Numbers, assert_consistent, contents, model, surface};
use std::path::Path;
use std::sync::Arc;

/// A ball without bumps.
fn round(levels: u8) -> Surface {
    Surface::ball(levels, |_| 1.0)
}

fn pull(level: u8, vertex: u32, delta: [f64; 3]) -> Pull {
    Pull::of(Kind::Scaling, level, vertex, delta)
}

fn random_pull(numbers: &mut Numbers, surface: &Surface) -> Pull {
    let finest = surface.finest();
    let size = surface.form().placement.step * f64::from(1 << 24);
    let kind = if numbers.below(3) == 0 { Kind::Wavelet } else { Kind::Scaling };
    let level = numbers.below(u32::from(finest.0) + u32::from(kind == Kind::Scaling)) as u8;
    let layout = surface.hierarchy().layout(Level(level));
    let vertex = match kind {
        Kind::Scaling => numbers.below(layout.len()),
        Kind::Wavelet => layout.len() + numbers.below(layout.odd_len()),
    };
    let delta = std::array::from_fn(|_| 0.3 * size * numbers.signed());
    let place = (numbers.below(3) == 0 && kind == Kind::Scaling)
        .then(|| surface.position(finest, Slot(numbers.below(surface.scaling(finest).len() as u32))));
    let radius = (numbers.below(3) == 0).then(|| size * (0.1 + 0.5 * (numbers.signed() + 1.0)));
    let origin = surface.form().placement.origin;
    Pull {
        vertex: place.is_none().then_some(vertex),
        at: place,
        radius,
        falloff: radius.filter(|_| numbers.below(2) == 0).map(|_| Falloff::Linear),
        spread: if numbers.below(3) == 0 { Spread::Hat } else { Spread::Smooth },
        follow: numbers.below(2) == 0,
        mirror: (numbers.below(3) == 0).then_some(Mirror { x: Some(origin[0]), y: None, z: None }),
        v: if kind == Kind::Wavelet { 3 } else { 1 + numbers.below(Pull::LATEST_VERSION) },
        kind,
        ..pull(level, 0, delta)
    }
}

#[test]
fn pulls_are_whole_and_undone_exactly_on_awkward_meshes() {
    for (name, mesh) in shapes::awkward() {
        for (wavelet, sharp) in [(Wavelet::Disc(2), 1), (Wavelet::Lazy, 2)] {
            let mut surface = surface(&mesh, wavelet, sharp, 3, 7);
            let mut numbers = Numbers(1 + mesh.faces.len() as u64);
            let mut steps = Vec::new();
            for _ in 0..8 {
                let edit = Edit::Pull(random_pull(&mut numbers, &surface));
                let before = contents(&surface);
                let planned = plan(&surface, &edit).unwrap_or_else(|e| panic!("{name}: {edit:?}: {e}"));
                match Step::apply(&mut surface, edit.clone(), planned) {
                    Ok((step, _)) => steps.push((step, before, edit)),
                    Err(EditError::BeyondLimit) => assert!(contents(&surface) == before, "{name}: {edit:?}"),
                    Err(error) => panic!("{name}: {edit:?}: {error}"),
                }
            }
            assert_consistent(&surface);
            let last = contents(&surface);
            for (step, before, edit) in steps.iter_mut().rev() {
                undo::Edit::undo(step, &mut surface);
                assert!(contents(&surface) == *before, "{name}: undo of {edit:?}");
            }
            for (step, ..) in &mut steps {
                // The first call only tells that the edit is already there.
                let _ = undo::Edit::edit(step, &mut surface);
                undo::Edit::edit(step, &mut surface);
            }
            assert!(contents(&surface) == last, "{name}: redo");
        }
    }
}

#[test]
fn dragging_gives_the_bits_of_its_one_line_whatever_the_way() {
    for (name, mesh) in shapes::awkward() {
        let disk = MemoryDisk::default();
        disk.put("a.boz", &encode(&model(&mesh, Wavelet::Disc(2), 1, 3, 23)));
        let open = || {
            let disk = Arc::new(disk.clone());
            Session::open(disk, Path::new("a.boz"), OpenOptions::default(), &|_| true)
                .expect("a sound pair")
                .session
        };
        let mut session = open();
        let mut numbers = Numbers(5);
        for round in 0..10 {
            let edit = random_pull(&mut numbers, session.surface());
            let before = contents(session.surface());
            session.begin_pull(edit).expect("a sensible pull");
            for at in 0..4 {
                let wandering = std::array::from_fn(|c| edit.delta[c] * numbers.signed());
                let _ = session.drag_to(wandering);
                if at == 2 {
                    session.preview_stroke(Level(numbers.below(4) as u8));
                }
            }
            if round % 3 == 2 {
                session.cancel_stroke();
                assert!(contents(session.surface()) == before, "{name}: cancelled {edit:?}");
                continue;
            }
            let _ = session.drag_to(edit.delta);
            session.end_stroke();
        }
        assert_consistent(session.surface());
        let hash = session.hash();
        session.close().expect("a sound disk");
        assert_eq!(open().hash(), hash, "{name}: the log says the same");
    }
}

#[test]
fn a_raw_pull_without_follow_is_the_papers_move_to_the_bit() {
    for (name, mesh) in shapes::awkward() {
        for radius in [None, Some(0.8)] {
            let start = surface(&mesh, Wavelet::Disc(2), 0, 3, 9);
            let vertex = start.hierarchy().layout(Level(1)).len() - 1;
            let delta = [0.1, -0.2, 0.05];
            let edits = [
                Edit::Pull(Pull { spread: Spread::Hat, radius, ..pull(1, vertex, delta) }),
                Edit::Move(Move {
                    kind: Kind::Scaling,
                    level: 1,
                    vertex,
                    delta,
                    radius,
                    falloff: None,
                    mirror: None,
                    v: 1,
                }),
            ];
            let [a, b] = edits.map(|edit| {
                let mut surface = start.clone();
                let planned = plan(&surface, &edit).expect("a sensible edit");
                Step::apply(&mut surface, edit, planned).expect("in range");
                contents(&surface)
            });
            assert!(a == b, "{name}, radius {radius:?}");
        }
    }
}

/// The sharpest angle between neighbouring faces, in degrees.
fn sharpest(surface: &Surface) -> f64 {
    let mesh = surface.to_mesh(surface.finest());
    let normal = |f: &[u32; 3]| {
        let [a, b, c] = f.map(|v| mesh.positions[v as usize]);
        let (u, v): ([f64; 3], [f64; 3]) =
            (std::array::from_fn(|k| b[k] - a[k]), std::array::from_fn(|k| c[k] - a[k]));
        let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let length = n.iter().map(|x| x * x).sum::<f64>().sqrt();
        n.map(|x| x / length)
    };
    let mut across = std::collections::HashMap::new();
    let mut worst: f64 = 0.0;
    for face in &mesh.faces {
        for k in 0..3 {
            let (a, b) = (face[k], face[(k + 1) % 3]);
            if let Some(other) = across.insert((a.min(b), a.max(b)), normal(face)) {
                let n = normal(face);
                let cosine: f64 = (0..3).map(|c| n[c] * other[c]).sum();
                worst = worst.max(cosine.clamp(-1.0, 1.0).acos().to_degrees());
            }
        }
    }
    worst
}

#[test]
fn a_smooth_pull_moves_its_vertex_as_asked_and_makes_no_tent() {
    for level in [0, 1, 2] {
        let angle = |spread| {
            let mut session = session_of(round(6));
            let before = session.surface().clone();
            let delta = [0.0, 0.0, 0.06];
            session.edit(Edit::Pull(Pull { spread, ..pull(level, 4, delta) })).expect("a sensible pull");
            let (layout, finest) = (before.hierarchy().layout(Level(6)), Level(6));
            let slot = layout.slot(layout.site_of(PublicId(4)));
            let moved: [f64; 3] = std::array::from_fn(|c| {
                session.surface().position(finest, slot)[c] - before.position(finest, slot)[c]
            });
            assert!(
                (0..3).all(|c| (moved[c] - delta[c]).abs() < 1e-6),
                "level {level}, {spread:?}: {moved:?}"
            );
            sharpest(session.surface())
        };
        let (smooth, tent) = (angle(Spread::Smooth), angle(Spread::Hat));
        assert!(smooth < 0.5 * tent, "level {level}: {smooth}° smooth, {tent}° with hats");
    }
}

#[test]
fn a_grabbed_place_goes_where_the_hand_goes() {
    for (level, radius) in [(6, 0.3), (3, 0.3), (1, 0.05)] {
        let mut session = session_of(round(6));
        let at = [0.31, 0.42, 0.853];
        let address = |surface: &Surface| {
            let p = &surface.form().placement;
            surface.nearest(std::array::from_fn(|c| (at[c] - p.origin[c]) / p.step)).address
        };
        let place = |surface: &Surface, address: bozzetto_core::hierarchy::Address| -> [f64; 3] {
            let layout = surface.hierarchy().layout(Level(6));
            let corners = address.corners(layout);
            std::array::from_fn(|c| {
                corners.iter().map(|&(s, w)| w * surface.position(Level(6), layout.slot(s))[c]).sum()
            })
        };
        let held = address(session.surface());
        let before = place(session.surface(), held);
        let delta = [0.05, 0.1, -0.02];
        let grab = Pull { vertex: None, at: Some(at), radius: Some(radius), ..pull(level, 0, delta) };
        session.edit(Edit::Pull(grab)).expect("a sensible pull");
        let after = place(session.surface(), held);
        for c in 0..3 {
            assert!(
                (after[c] - before[c] - delta[c]).abs() < 0.004,
                "level {level}: {before:?} to {after:?}"
            );
        }
    }
}

#[test]
fn mirrored_pulls_are_mirrored_and_raw_ones_say_when_they_have_no_partner() {
    let plane = Mirror { x: Some(0.0), y: None, z: None };
    let mut session = session_of(round(4));
    let layout_len = session.surface().hierarchy().layout(Level(2)).len();
    for vertex in [7, 19, layout_len - 1] {
        session
            .edit(Edit::Pull(Pull { mirror: Some(plane), ..pull(2, vertex, [0.05, 0.1, 0.02]) }))
            .expect("a sensible pull");
    }
    let surface = session.surface();
    for slot in (0..surface.scaling(Level(4)).len() as u32).map(Slot) {
        let p = surface.position(Level(4), slot);
        let q = [-p[0], p[1], p[2]];
        let placement = &surface.form().placement;
        let near = surface.nearest(std::array::from_fn(|c| (q[c] - placement.origin[c]) / placement.step));
        assert!(near.squared_distance.sqrt() * placement.step < 1e-3, "{p:?} has no image");
    }
    // Half a spacing off, there is no partner for a single coefficient.
    let mut session = session_of(round(4));
    let p = session.surface().position(Level(4), Slot(0));
    let raw = Pull { spread: Spread::Hat, ..pull(0, 0, [0.0, 0.1, 0.0]) };
    let off = Mirror { x: None, y: Some(p[1] + 0.4), z: None };
    assert_eq!(session.begin_pull(Pull { mirror: Some(off), ..raw }).expect("sensible"), 1);
    let on = Mirror { x: Some(0.0), y: None, z: None };
    assert_eq!(session.begin_pull(Pull { mirror: Some(on), ..raw }).expect("sensible"), 0);
}

/// An open cylinder around the y axis from −1 to 1 with rings of bumps on it.
fn cylinder(levels: u8, relief: f64) -> Surface {
    let (around, rings) = (8u32, 9u32);
    let mesh_position = |a: f64, y: f64| [0.3 * a.cos(), y, 0.3 * a.sin()];
    let mut mesh = TriangleMesh::default();
    let turn = std::f64::consts::TAU / f64::from(around);
    for r in 0..rings {
        for a in 0..around {
            mesh.positions.push(mesh_position(f64::from(a) * turn, f64::from(r) / 4.0 - 1.0));
        }
    }
    for r in 0..rings - 1 {
        for a in 0..around {
            let at = |a: u32, r: u32| r * around + a % around;
            mesh.faces.push([at(a, r), at(a, r + 1), at(a + 1, r)]);
            mesh.faces.push([at(a + 1, r), at(a, r + 1), at(a + 1, r + 1)]);
        }
    }
    let base = Arc::new(BaseMesh::new(around * rings, mesh.faces.clone(), &[]).expect("a base mesh"));
    let hierarchy = Hierarchy::new(base, Level(levels)).expect("small");
    let layout = hierarchy.layout(Level(levels));
    let parameters = |v: u32| [f64::from(v % around) * turn, f64::from(v / around) / 4.0 - 1.0];
    let positions: Vec<[f64; 3]> = (0..layout.len())
        .map(|slot| {
            let (face, b) = layout.chart(layout.site(Slot(slot)));
            let corners = hierarchy.base().faces()[face as usize].map(parameters);
            let n = f64::from(layout.segments());
            // Angles of a face that closes the round lie on one side of the cut.
            let most = corners.iter().map(|c| c[0]).fold(0.0, f64::max);
            let angle = |a: f64| if most - a > 3.0 { a + std::f64::consts::TAU } else { a };
            let a: f64 = (0..3).map(|k| f64::from(b[k]) * angle(corners[k][0])).sum::<f64>() / n;
            let y: f64 = (0..3).map(|k| f64::from(b[k]) * corners[k][1]).sum::<f64>() / n;
            let bump = 1.0 + relief / 0.3 * (16.0 * a).sin() * (50.0 * y).sin();
            let p = mesh_position(a, y);
            [p[0] * bump, p[1], p[2] * bump]
        })
        .collect();
    Surface::from_positions(hierarchy, &positions, &FormOptions::default()).expect("a cylinder")
}

/// Bends a cylinder by 90° with one pull for every coefficient of a level, so that the middle line becomes a quarter of
/// a circle. Returns the surface.
fn bent(relief: f64, follow: bool, spread: Spread) -> Surface {
    let mut session = session_of(cylinder(4, relief));
    let level = Level(0);
    let target = |p: [f64; 3]| {
        // The middle line, of length 2, on a circle: y is the arc, x goes towards its centre.
        let radius = 2.0 / std::f64::consts::FRAC_PI_2;
        let turn = p[1] / radius;
        [radius - (radius - p[0]) * turn.cos(), (radius - p[0]) * turn.sin(), p[2]]
    };
    let start = session.surface().clone();
    let layout = start.hierarchy().layout(level).clone();
    // A smooth pull takes its neighbours along: going round again brings all where they belong.
    let rounds = if spread == Spread::Smooth { 3 } else { 1 };
    for vertex in (0..rounds).flat_map(|_| 0..layout.len()) {
        // A hat moves its own coefficient alone; a smooth pull is asked for where the surface shows its vertex.
        let shown = if spread == Spread::Smooth { start.finest() } else { level };
        let slot = layout.slot(layout.site_of(PublicId(vertex)));
        let slot = start.hierarchy().refine_slot(level, shown, slot);
        let (p, q) = (session.surface().position(shown, slot), target(start.position(shown, slot)));
        let delta = std::array::from_fn(|c| q[c] - p[c]);
        let edit = match (follow, spread) {
            (false, Spread::Hat) => Edit::Move(Move {
                kind: Kind::Scaling,
                level: 0,
                vertex,
                delta,
                radius: None,
                falloff: None,
                mirror: None,
                v: 1,
            }),
            _ => Edit::Pull(Pull { follow, spread, ..pull(0, vertex, delta) }),
        };
        session.edit(edit).expect("in range");
    }
    session.surface().clone()
}

/// How relief lies on a bent cylinder: the mean ratio of its height to what it was, and the mean angle in degrees between
/// it and the surface without relief, seen on the middle rings.
fn relief_of(with: &Surface, without: &Surface, before: [&Surface; 2]) -> (f64, f64) {
    let finest = with.finest();
    let layout = with.hierarchy().layout(finest);
    let minus = |a: [f64; 3], b: [f64; 3]| -> [f64; 3] { std::array::from_fn(|c| a[c] - b[c]) };
    let length = |a: [f64; 3]| a.iter().map(|x| x * x).sum::<f64>().sqrt();
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let normal = |surface: &Surface, slot: Slot| {
        let p = surface.position(finest, slot);
        let ring: Vec<[f64; 3]> =
            layout.ring_slots(layout.site(slot)).map(|s| minus(surface.position(finest, s), p)).collect();
        let n = (0..ring.len()).fold([0.0; 3], |n, k| {
            let m = cross(ring[k], ring[(k + 1) % ring.len()]);
            std::array::from_fn(|c| n[c] + m[c])
        });
        n.map(|x| x / length(n))
    };
    let (mut ratio, mut angle, mut count) = (0.0, 0.0, 0.0);
    for slot in (0..layout.len()).map(Slot) {
        let y = before[1].position(finest, slot)[1];
        let was = minus(before[0].position(finest, slot), before[1].position(finest, slot));
        if y.abs() > 0.7 || length(was) < 0.01 {
            continue;
        }
        let now = minus(with.position(finest, slot), without.position(finest, slot));
        let tilt = |d: [f64; 3], n: [f64; 3]| {
            let cosine: f64 = (0..3).map(|c| d[c] * n[c]).sum::<f64>() / length(d);
            cosine.abs().clamp(0.0, 1.0).acos().to_degrees()
        };
        ratio += length(now) / length(was);
        angle += (tilt(now, normal(without, slot)) - tilt(was, normal(before[1], slot))).abs();
        count += 1.0;
    }
    assert!(count > 100.0);
    (ratio / count, angle / count)
}

#[test]
fn relief_keeps_its_height_and_angle_when_the_form_bends() {
    let (rough, plain) = (cylinder(4, 0.02), cylinder(4, 0.0));
    for spread in [Spread::Smooth, Spread::Hat] {
        let [(ratio, angle), (_, sheared)] = [true, false].map(|follow| {
            let (with, without) = (bent(0.02, follow, spread), bent(0.0, follow, spread));
            relief_of(&with, &without, [&rough, &plain])
        });
        println!("{spread:?}: height × {ratio:.4}, angle {angle:.2}°, without following {sheared:.2}°");
        assert!((ratio - 1.0).abs() < 0.02, "{spread:?}: height × {ratio}");
        assert!(angle < 3.0, "{spread:?}: turned by {angle}° against the surface");
        assert!(sheared > 8.0, "{spread:?}: without following, relief is {sheared}° off");
    }
}

#[test]
fn pulls_without_sense_are_refused_and_change_nothing() {
    let mut session = session_of(round(3));
    let hash = session.hash();
    let good = pull(1, 3, [0.1, 0.0, 0.0]);
    let bad = [
        Pull { level: 4, ..good },
        Pull { vertex: Some(1000), ..good },
        Pull { vertex: None, ..good },
        Pull { at: Some([0.0; 3]), ..good },
        Pull { vertex: None, at: Some([f64::NAN; 3]), ..good },
        Pull { delta: [f64::INFINITY, 0.0, 0.0], ..good },
        Pull { delta: [1e9, 0.0, 0.0], ..good },
        Pull { radius: Some(-1.0), ..good },
        Pull { falloff: Some(Falloff::Sharp), ..good },
        Pull { mirror: Some(Mirror { x: Some(f64::NAN), y: None, z: None }), ..good },
        Pull { v: 4, ..good },
        Pull { delta: [7.9, 0.0, 0.0], ..good },
        Pull { delta: [7.9, 0.0, 0.0], follow: true, ..good },
    ];
    for edit in bad {
        assert!(session.edit(Edit::Pull(edit)).is_err(), "{edit:?}");
        assert_eq!((session.hash(), session.history_len()), (hash, 0), "{edit:?}");
    }
    session.edit(Edit::Pull(good)).expect("the one that is fine");
}
