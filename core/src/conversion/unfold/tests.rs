use super::*;
use crate::conversion::held::Held;
use crate::conversion::pulls::Look;
use crate::conversion::watch::Watch;
use crate::mesh::TriangleMesh;
use crate::mesh::shapes::{octahedron, subdivide};

fn ball(times: u32) -> TriangleMesh {
    let mut mesh = subdivide(&octahedron(), times);
    mesh.positions.iter_mut().for_each(|p| *p = DVec3::from(*p).normalize().to_array());
    mesh
}

/// Half of the ball, so that it has a boundary.
fn cap(times: u32) -> TriangleMesh {
    let half = octahedron();
    let above = |f: &[u32; 3]| f.iter().all(|&v| half.positions[v as usize][2] >= 0.0);
    let faces: Vec<[u32; 3]> = half.faces.iter().copied().filter(above).collect();
    let mut used: Vec<u32> = faces.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let number = |v: u32| used.binary_search(&v).expect("used") as u32;
    let faces = faces.iter().map(|f| f.map(number)).collect();
    let positions = used.iter().map(|&v| half.positions[v as usize]).collect();
    let mut mesh = subdivide(&TriangleMesh::new(positions, faces), times);
    mesh.positions.iter_mut().for_each(|p| *p = DVec3::from(*p).normalize().to_array());
    mesh
}

/// Unfolds a coarse mesh some of whose vertices were moved and one may be fixed there; returns their true places, where they are
/// then, and the turned faces before and after.
fn unfolded(
    meshes: [TriangleMesh; 2],
    moved: impl Fn(DVec3) -> DVec3,
    fixed: Option<usize>,
    looks: u64,
) -> (Vec<DVec3>, Vec<DVec3>, [usize; 2]) {
    unfolded_from(meshes, moved, fixed, looks, usize::MAX)
}

/// The same, told of so many of the turned faces.
fn unfolded_from(
    [input, coarse]: [TriangleMesh; 2],
    moved: impl Fn(DVec3) -> DVec3,
    fixed: Option<usize>,
    looks: u64,
    told: usize,
) -> (Vec<DVec3>, Vec<DVec3>, [usize; 2]) {
    let target = Target::new(&input).expect("faces").sampled(coarse.faces.len());
    let mut fitted = Fitted::new(coarse.positions.len(), &coarse.faces);
    fitted.held = fixed.map_or_else(Held::default, |v| Held::fixing(v, coarse.positions.len()));
    let places: Vec<DVec3> = coarse.positions.iter().map(|&p| DVec3::from(p)).collect();
    let Ok(pulls) = Watch::new(&target, &fitted).look(&places, Look::Close, &|| true) else {
        panic!("nobody asked to stop")
    };
    let unfolding = Unfolding { target: &target, fitted: &fitted, places: &places, pulls: &pulls, looks };
    let turned = |positions: &[DVec3]| {
        let mut cursor = target.tree.cursor();
        let corners = |f: &[u32; 3]| f.map(|v| positions[v as usize]);
        let turned = |f: &u32| target.beside(corners(&coarse.faces[*f as usize]), &mut cursor).0 <= 0.0;
        (0..coarse.faces.len() as u32).filter(turned).collect::<Vec<_>>()
    };
    let mut positions: Vec<DVec3> = places.iter().map(|&p| moved(p)).collect();
    let before = turned(&positions);
    assert!(unfolding.run(&mut positions, &before[..told.min(before.len())], &|| true).is_ok());
    let after = turned(&positions);
    (places, positions, [before.len(), after.len()])
}

#[test]
fn a_turned_face_is_turned_back_and_the_rest_stays() {
    let pole = DVec3::Z;
    let fold = |p: DVec3| if p.distance(pole) < 1e-9 { DVec3::new(0.2, 0.03, 0.979) } else { p };
    let (places, result, [before, after]) = unfolded([ball(5), ball(4)], fold, None, MOST_LOOKS);
    assert!(before > 0 && after == 0, "{before} {after}");
    for (place, at) in places.iter().zip(&result) {
        assert!((at.length() - 1.0).abs() < 0.01, "{at}");
        assert!(place.distance(pole) < 0.5 || at == place, "{place} moved to {at}");
    }
}

/// Several vertices changed places: no single one can make it good.
#[test]
fn a_knot_of_faces_is_shaken_loose() {
    let swap = |p: DVec3| {
        let near = p.distance(DVec3::Z);
        if near < 0.3 { DVec3::new(-p.x, p.y, p.z) } else { p }
    };
    let (places, result, [before, after]) = unfolded([ball(5), ball(4)], swap, None, MOST_LOOKS);
    assert!(before > 4 && after == 0, "{before} {after}");
    let off = result.iter().map(|at| (at.length() - 1.0).abs()).fold(0.0, f64::max);
    assert!(off < 0.02, "{off}");
    let far = |place: &DVec3| place.distance(DVec3::Z) > 1.0;
    assert!(places.iter().zip(&result).all(|(place, at)| !far(place) || place == at));
}

/// A step may turn a face back and another over that was less so: as if it had not been told of that one.
#[test]
fn faces_turned_over_on_the_way_are_turned_back_too() {
    let swap = |p: DVec3| if p.distance(DVec3::Z) < 0.3 { DVec3::new(-p.x, p.y, p.z) } else { p };
    let (_, _, [before, after]) = unfolded_from([ball(5), ball(4)], swap, None, MOST_LOOKS, 1);
    assert!(before > 4 && after == 0, "{before} {after}");
}

/// A corner that stays lies outside all its neighbours: they come round it.
#[test]
fn neighbours_follow_a_corner_that_keeps_its_place() {
    let pole = ball(4).positions.iter().position(|p| p[2] > 1.0 - 1e-9).expect("a pole");
    let there = DVec3::new(0.25, 0.03, 0.968).normalize();
    let fold = |p: DVec3| if p.z > 1.0 - 1e-9 { there } else { p };
    let (places, result, [before, after]) = unfolded([ball(5), ball(4)], fold, Some(pole), MOST_LOOKS);
    assert!(before > 0 && after == 0, "{before} {after}");
    assert_eq!(result[pole], there);
    let far = |place: &DVec3| place.distance(DVec3::Z) > 1.0;
    assert!(places.iter().zip(&result).all(|(place, at)| !far(place) || place == at));
}

/// What is turned stays turned when so much has been looked at; nothing is left half done.
#[test]
fn no_more_is_looked_at_than_is_allowed() {
    let swap = |p: DVec3| if p.distance(DVec3::Z) < 0.3 { DVec3::new(-p.x, p.y, p.z) } else { p };
    let after = |looks: u64| {
        let (places, result, [before, after]) = unfolded([ball(5), ball(4)], swap, None, looks);
        let stays = places.iter().zip(&result).all(|(&place, &at)| swap(place) == at);
        (before, after, stays)
    };
    let (before, left, stays) = after(0);
    assert!(left == before && stays, "{before} {left}");
    let (_, some, stays) = after(50_000);
    assert!(0 < some && some < before && !stays, "{before} {some}");
}

/// Neither is a shake begun that may look at nothing, nor does one go on once it has looked at all it may: but for what it takes
/// to see whether it was any good.
#[test]
fn a_shake_ends_when_enough_has_been_looked_at() {
    let (input, coarse) = (ball(5), ball(4));
    let target = Target::new(&input).expect("faces").sampled(coarse.faces.len());
    let fitted = Fitted::new(coarse.positions.len(), &coarse.faces);
    let places: Vec<DVec3> = coarse.positions.iter().map(|&p| DVec3::from(p)).collect();
    let Ok(pulls) = Watch::new(&target, &fitted).look(&places, Look::Close, &|| true) else {
        panic!("nobody asked to stop")
    };
    let swap = |p: &DVec3| if p.distance(DVec3::Z) < 0.3 { DVec3::new(-p.x, p.y, p.z) } else { *p };
    let swapped: Vec<DVec3> = places.iter().map(swap).collect();
    let looked_at = |looks: u64| {
        let unfolding = Unfolding { target: &target, fitted: &fitted, places: &places, pulls: &pulls, looks };
        let (mut positions, mut near) = (swapped.clone(), unfolding.near());
        let corners = |f: &[u32; 3]| f.map(|v| swapped[v as usize]);
        let turned = |f: &[u32; 3]| target.beside(corners(f), &mut target.tree.cursor()).0 <= 0.0;
        let face = coarse.faces.iter().position(turned).expect("a turned face");
        assert!(unfolding.shake(face as u32, &mut positions, &mut near, &|| true).is_ok());
        assert!(
            looks < 2 || 0 < near.compared && near.compared < near.looked_at(),
            "{} compared",
            near.compared
        );
        (near.looked_at(), positions == swapped)
    };
    assert_eq!(looked_at(0), (0, true));
    let (all, _) = looked_at(u64::MAX);
    let (few, _) = looked_at(1);
    assert!(20 * few < all, "{few} of {all}");
}

#[test]
fn vertices_of_a_boundary_stay_on_it() {
    let coarse = cap(5);
    let x = coarse.positions.iter().map(|&p| DVec3::from(p)).filter(|p| p.z.abs() < 1e-9);
    let rim = x.min_by(|p, q| p.distance(DVec3::X).total_cmp(&q.distance(DVec3::X))).expect("a rim");
    let turn = DVec3::new(libm::cos(0.08), libm::sin(0.08), 0.0);
    let fold = |p: DVec3| if p.distance(rim) < 1e-9 { turn } else { p };
    let (_, result, [before, after]) = unfolded([cap(6), coarse], fold, None, MOST_LOOKS);
    assert!(before > 0 && after == 0, "{before} {after}");
    let of_rim = result.iter().filter(|at| at.z.abs() < 1e-9).count();
    assert_eq!(of_rim, 128, "all vertices of the rim are still in its plane");
}

#[test]
fn it_can_be_stopped() {
    let (input, coarse) = (ball(4), ball(3));
    let target = Target::new(&input).expect("faces").sampled(coarse.faces.len());
    let fitted = Fitted::new(coarse.positions.len(), &coarse.faces);
    let mut places: Vec<DVec3> = coarse.positions.iter().map(|&p| DVec3::from(p)).collect();
    let Ok(pulls) = Watch::new(&target, &fitted).look(&places, Look::Close, &|| true) else {
        panic!("nobody asked to stop")
    };
    let true_places = places.clone();
    let unfolding = Unfolding {
        target: &target,
        fitted: &fitted,
        places: &true_places,
        pulls: &pulls,
        looks: MOST_LOOKS,
    };
    assert!(unfolding.run(&mut places, &[0], &|| false).is_err());
}
