use super::*;
use crate::conversion::fit::turned_faces;
use crate::conversion::pulls::{Look, Pulls};
use crate::conversion::unfold::MOST_LOOKS;
use crate::conversion::watch::Watch;
use crate::mesh::shapes::{octahedron, subdivide};
use crate::mesh::{BoundingVolumes, TriangleMesh};
use std::sync::Arc;

/// An ellipsoid around 0 with radii 1, 1 and `height`.
fn ellipsoid(times: u32, height: f64) -> TriangleMesh {
    let mut mesh = subdivide(&octahedron(), times);
    for p in &mut mesh.positions {
        *p = (DVec3::from(*p).normalize() * DVec3::new(1.0, 1.0, height)).to_array();
    }
    mesh
}

/// A coarse mesh that is drawn to an input.
struct Drawn<'a> {
    coarse: TriangleMesh,
    target: Target<'a>,
    fitted: Fitted,
    places: Vec<DVec3>,
}

impl<'a> Drawn<'a> {
    fn to(input: &'a TriangleMesh, coarse: TriangleMesh) -> Self {
        let target = Target::new(input).expect("faces").sampled(coarse.faces.len());
        let fitted = Fitted::new(coarse.positions.len(), &coarse.faces);
        let places = coarse.positions.iter().map(|&p| DVec3::from(p)).collect();
        Self { coarse, target, fitted, places }
    }

    fn mending<'m>(&'m self, sheets: &'m [DVec3]) -> Mending<'m> {
        let Self { target, fitted, places, .. } = self;
        Mending { target, fitted, sheets, places, unfolding: MOST_LOOKS, briefly: false }
    }

    fn pulls(&self, positions: &[DVec3]) -> Arc<Pulls> {
        let pulls = Watch::new(&self.target, &self.fitted).look(positions, Look::Close, &|| true);
        pulls.unwrap_or_else(|_| panic!("nobody asked to stop"))
    }
}

/// Mends a coarse ellipsoid some of whose vertices were moved; returns the places and the result.
fn mended(height: f64, moved: impl Fn(DVec3) -> DVec3) -> (Vec<DVec3>, Vec<DVec3>, usize) {
    let input = ellipsoid(5, height);
    let drawn = Drawn::to(&input, ellipsoid(4, height));
    let Drawn { coarse, fitted, places, .. } = &drawn;
    let tree = BoundingVolumes::build(&input).expect("faces");
    let normal = |f| {
        let [a, b, c] = input.corners(f).map(DVec3::from);
        (b - a).cross(c - a).normalize_or_zero()
    };
    let sheets: Vec<DVec3> = coarse.positions.iter().map(|&p| normal(tree.closest(p).face)).collect();
    let mending = drawn.mending(&sheets);
    let start: Vec<DVec3> = places.iter().map(|&p| moved(p)).collect();
    let pulls = drawn.pulls(&start);
    let Ok((result, stay)) = mending.run(Iterate { positions: start, pulls }, &|_| true) else {
        panic!("nobody asked to stop")
    };
    let outward: Vec<DVec3> = coarse
        .faces
        .iter()
        .map(|f| {
            let [a, b, c] = f.map(|v| places[v as usize]);
            (b - a).cross(c - a)
        })
        .collect();
    let turned = turned_faces(fitted, &result, &outward).iter().filter(|turned| **turned).count();
    assert_eq!(stay, turned, "those that stay turned over are counted");
    (drawn.places, result, turned)
}

#[test]
fn a_fold_is_undone_and_the_rest_stays() {
    let pole = DVec3::Z;
    let fold = |p: DVec3| if p.distance(pole) < 1e-9 { DVec3::new(0.25, 0.05, 0.97) } else { p };
    let (places, result, turned) = mended(1.0, fold);
    assert_eq!(turned, 0);
    for (place, at) in places.iter().zip(&result) {
        assert!((at.length() - 1.0).abs() < 0.01, "{at}");
        assert!(place.distance(pole) < 1.2 || at == place, "{place} moved to {at}");
    }
}

#[test]
fn sheets_of_a_thin_plate_stay_apart() {
    // A piece of the upper sheet hangs below the lower one, where everything near faces the other way.
    let sink = |p: DVec3| if p.z > 0.0 && p.truncate().length() < 0.15 { p - DVec3::Z * 0.025 } else { p };
    let (places, result, turned) = mended(0.01, sink);
    assert_eq!(turned, 0);
    for (place, at) in places.iter().zip(&result) {
        let height = 0.01 * (1.0 - at.truncate().length_squared()).max(0.0).sqrt();
        assert!((at.z.abs() - height).abs() < 2e-3, "{place} is at {at}");
        assert!(place.z.abs() < 1e-3 || place.z * at.z > 0.0, "{place} is at {at}");
    }
}

#[test]
fn what_there_is_no_time_for_stays_bad_and_where_it_is() {
    let input = ellipsoid(5, 1.0);
    let drawn = Drawn::to(&input, ellipsoid(4, 1.0));
    let places = &drawn.places;
    let (mending, pulls) = (drawn.mending(places), drawn.pulls(places));
    let (bad, mut positions) = ([3, 40, 800], places.clone());
    let Ok((left, used)) = mending.pass(&PASSES[0], &mut positions, &pulls, &bad, 0, &|_| true) else {
        panic!("nobody asked to stop")
    };
    assert_eq!((left, used), (bad.to_vec(), 0));
    assert!(positions == *places);
}

/// The smallest parts are chosen while the faces they have together are allowed.
#[test]
fn the_smallest_places_are_mended_first() {
    let input = ellipsoid(5, 1.0);
    let drawn = Drawn::to(&input, ellipsoid(4, 1.0));
    let Drawn { coarse, places, .. } = &drawn;
    let (mending, pulls) = (drawn.mending(places), drawn.pulls(places));
    let at = |direction: DVec3, times: usize| {
        let mut near: Vec<u32> = (0..coarse.faces.len() as u32).collect();
        let middle = |f: u32| coarse.faces[f as usize].iter().map(|&v| places[v as usize]).sum::<DVec3>();
        near.sort_by(|&f, &g| middle(g).dot(direction).total_cmp(&middle(f).dot(direction)));
        near.truncate(times);
        near
    };
    let mut bad = [at(DVec3::Z, 1), at(-DVec3::Z, 60)].concat();
    bad.sort_unstable();
    let patch = Patch::around(&mending, &pulls, &bad, 1);
    assert_eq!(patch.parts, 2);
    let (all, faces) = patch.smallest_parts(usize::MAX);
    assert_eq!((all, faces), (vec![true; 2], patch.own));
    let (chosen, few) = patch.smallest_parts(patch.own - 1);
    let north = patch.face_part[patch.faces.iter().position(|f| at(DVec3::Z, 1).contains(f)).expect("there")];
    assert!(chosen[north as usize] && !chosen[1 - north as usize] && few < faces / 2, "{chosen:?} {few}");
    assert_eq!(patch.smallest_parts(0), (vec![false; 2], 0));
}

/// Whether to go on is asked in proportion to the work, whatever the size of a part.
#[test]
fn a_large_part_is_looked_at_with_many_questions() {
    let input = ellipsoid(5, 1.0);
    let drawn = Drawn::to(&input, ellipsoid(5, 1.0));
    let Drawn { coarse, target, places, .. } = &drawn;
    let (mending, pulls) = (drawn.mending(places), drawn.pulls(places));
    let bad: Vec<u32> = (0..coarse.faces.len() as u32).collect();
    let patch = Patch::around(&mending, &pulls, &bad, 1);
    let asked = std::cell::Cell::new(0);
    let go_on = || {
        asked.set(asked.get() + 1);
        true
    };
    assert!(patch.look(target, &mut None, places, &[true], &go_on).is_ok());
    let queries = patch.samples.len() + patch.own * POINTS.len();
    assert!(asked.get() > queries / 25_000, "{} questions, {queries} queries", asked.get());
    for last in 0..asked.get() {
        let left = std::cell::Cell::new(last);
        let go_on = || left.replace(left.get().saturating_sub(1)) > 0;
        assert!(patch.look(target, &mut None, places, &[true], &go_on).is_err(), "question {last}");
    }
}
