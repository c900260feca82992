//! Detection of subdivision connectivity: any subdivided mesh is recognised however its file is ordered, with the base
//! mesh and the numbering that the rules give, and nothing else is.

mod samples;

use bozzetto_core::conversion::{ConversionError, ConversionOptions, Remesh, convert};
use bozzetto_core::hierarchy::detection::{Detected, detect};
use bozzetto_core::hierarchy::{FINEST_LEVEL, Layout, Level, Odd, Slot};
use bozzetto_core::mesh::connectivity::NotManifold;
use bozzetto_core::mesh::{Connectivity, TriangleMesh, shapes};
use bozzetto_core::surface::Surface;
use samples::Numbers;

/// A mesh as another program might have written it, and what became of its vertices.
struct Shuffled {
    mesh: TriangleMesh,
    /// The new index of each old vertex.
    moved: Vec<u32>,
}

/// Vertices and faces in another order, faces rotated, one in `flips` turned round (none with 0), and vertices of no
/// face in between.
fn shuffle(mesh: &TriangleMesh, seed: u64, flips: u32) -> Shuffled {
    let mut numbers = Numbers(seed);
    let unused = numbers.below(4);
    let count = mesh.positions.len() as u32;
    let moved = numbers.permutation(count + unused);
    let mut positions = vec![[9e9, -9e9, 9e9]; moved.len()];
    for (old, position) in mesh.positions.iter().enumerate() {
        positions[moved[old] as usize] = *position;
    }
    let faces = numbers.permutation(mesh.faces.len() as u32).into_iter().map(|face| {
        let mut face = mesh.faces[face as usize].map(|v| moved[v as usize]);
        face.rotate_left(numbers.below(3) as usize);
        if flips > 0 && numbers.below(flips) == 0 {
            face.swap(0, 2);
        }
        face
    });
    let faces = faces.collect();
    Shuffled { mesh: TriangleMesh::new(positions, faces), moved: moved[..count as usize].to_vec() }
}

fn find(mesh: &TriangleMesh, most: u8) -> Option<Detected> {
    detect(mesh.positions.len() as u32, &mesh.faces, most).expect("an orientable manifold")
}

/// The face rotated so that its lowest corner comes first.
fn rotated([a, b, c]: [u32; 3]) -> [u32; 3] {
    [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().expect("three")
}

fn sorted(faces: impl Iterator<Item = [u32; 3]>) -> Vec<[u32; 3]> {
    let mut faces: Vec<[u32; 3]> = faces.map(rotated).collect();
    faces.sort_unstable();
    faces
}

/// The rules that hold for whatever is found: numbering of the base mesh, each vertex once, and the finest triangles
/// are the file's, oriented like the first face of their component.
fn assert_rules(mesh: &TriangleMesh, found: &Detected, what: &str) {
    let base = found.hierarchy.base();
    let corners = &found.source[..base.vertex_count() as usize];
    assert!(corners.is_sorted_by(|a, b| a < b), "{what}: base vertices by ascending source index");
    assert_eq!(base.faces(), sorted(base.faces().iter().copied()), "{what}: base faces in order");
    let mut used: Vec<u32> = mesh.faces.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let mut source = found.source.clone();
    source.sort_unstable();
    assert_eq!(source, used, "{what}: every used vertex once");
    let oriented = Connectivity::build(mesh.positions.len() as u32, mesh.faces.clone()).expect("a manifold");
    let finest = found.hierarchy.triangles(found.hierarchy.finest());
    let finest = finest.into_iter().map(|f| f.map(|slot| found.source[slot as usize]));
    assert_eq!(
        sorted(finest),
        sorted(oriented.faces().iter().copied()),
        "{what}: the triangles are the file's"
    );
    let first = mesh.faces[0];
    assert!(oriented.faces()[0] == first, "{what}: the first face keeps its orientation");
}

/// A base mesh subdivided and shuffled is found again: these very vertices and faces.
fn assert_found(base: &TriangleMesh, levels: u32, seed: u64, flips: u32, what: &str) {
    let fine = shapes::subdivide(base, levels);
    let Shuffled { mesh, moved } = shuffle(&fine, seed, flips);
    let found = find(&mesh, FINEST_LEVEL).unwrap_or_else(|| panic!("{what}: not detected"));
    assert_eq!(u32::from(found.hierarchy.finest().0), levels, "{what}");
    assert_rules(&mesh, &found, what);
    let mut corners: Vec<u32> = moved[..base.positions.len()].to_vec();
    corners.sort_unstable();
    assert_eq!(found.source[..corners.len()], corners, "{what}: the base vertices");
    let rank = |v: u32| corners.binary_search(&moved[v as usize]).expect("a base vertex") as u32;
    let unoriented = |mut face: [u32; 3]| {
        face.sort_unstable();
        face
    };
    let expected = sorted(base.faces.iter().map(|f| unoriented(f.map(rank))));
    let faces = sorted(found.hierarchy.base().faces().iter().map(|&f| unoriented(f)));
    assert_eq!(faces, expected, "{what}: the base faces");
    if flips == 0 {
        let expected = sorted(base.faces.iter().map(|f| f.map(rank)));
        assert_eq!(found.hierarchy.base().faces(), expected, "{what}: they keep their orientation");
    }
    // Odd vertices lie in the middle of their parents: the whole map is right, not only its shape.
    let position = |slot: Slot| mesh.positions[found.source[slot.index()] as usize];
    for j in (0..found.hierarchy.finest().0).map(Level) {
        let coarse = found.hierarchy.layout(j);
        let finest = |slot| found.hierarchy.refine_slot(j.finer(), found.hierarchy.finest(), slot);
        let fine = found.hierarchy.layout(j.finer());
        for odd in (0..coarse.odd_len()).map(|o| coarse.odd_site(Odd(o))) {
            let [a, b] = coarse.parents(odd).map(|p| position(finest(fine.slot(Layout::refine(p)))));
            let middle: [f64; 3] = std::array::from_fn(|c| (a[c] + b[c]) * 0.5);
            assert_eq!(position(finest(fine.slot(odd))), middle, "{what}, level {j}");
        }
    }
}

#[test]
fn subdivided_meshes_are_found_however_they_are_ordered() {
    let bases = [
        ("octahedron", shapes::octahedron()),
        ("tetrahedron", shapes::tetrahedron()),
        ("triangle", shapes::triangle()),
        ("disc", shapes::disc(5)),
        ("regular disc", shapes::disc(6)),
        ("valence 12", shapes::bipyramid(12)),
        ("genus 2", shapes::double_torus()),
        ("genus 3", shapes::pretzel(3)),
    ];
    for (name, base) in &bases {
        for levels in 1..=4 {
            for seed in 0..6 {
                let flips = [0, 2, 7][seed as usize % 3];
                assert_found(base, levels, seed, flips, &format!("{name}, {levels} levels, seed {seed}"));
            }
        }
    }
}

/// Without an extraordinary vertex there are several base meshes; the one through the lowest vertex is taken.
#[test]
fn regular_tori_start_at_the_lowest_vertex() {
    let level = |across, around, seed| {
        let Shuffled { mesh, .. } = shuffle(&shapes::torus(across, around), seed, 3);
        let found = find(&mesh, FINEST_LEVEL);
        if let Some(found) = &found {
            assert_rules(&mesh, found, &format!("torus {across} × {around}, seed {seed}"));
            let lowest = *mesh.faces.iter().flatten().min().expect("faces");
            assert_eq!(found.source[0], lowest, "torus {across} × {around}, seed {seed}");
        }
        found.map_or(0, |found| found.hierarchy.finest().0)
    };
    for seed in 0..10 {
        // A half has to be a simplicial complex itself: at least three across and around.
        for (across, around, levels) in [
            (4, 3, 0),
            (4, 4, 0),
            (5, 6, 0),
            (6, 5, 0),
            (7, 7, 0),
            (8, 6, 1),
            (6, 6, 1),
            (8, 8, 1),
            (10, 6, 1),
            (12, 12, 2),
            (12, 6, 1),
            (16, 12, 2),
            (24, 24, 3),
            (48, 24, 3),
        ] {
            assert_eq!(level(across, around, seed), levels, "torus {across} × {around}, seed {seed}");
        }
    }
    for levels in 1..=4 {
        let fine = shuffle(&shapes::subdivide(&shapes::torus(4, 3), levels), u64::from(levels), 2).mesh;
        let found = find(&fine, FINEST_LEVEL).expect("a subdivided torus");
        assert_eq!(u32::from(found.hierarchy.finest().0), levels);
        assert_eq!((found.hierarchy.base().faces().len(), found.hierarchy.base().genus()), (24, 1));
        assert_rules(&fine, &found, "subdivided torus");
    }
}

/// A tube without an extraordinary vertex: only a vertex on its boundary can tell even rows from odd ones.
#[test]
fn regular_tubes_start_on_the_boundary() {
    for (across, rows, levels) in [(6, 4, 1), (6, 2, 1), (12, 4, 2), (12, 8, 2), (6, 3, 0), (5, 4, 0)] {
        // A torus with its last row of quadrilaterals taken out, along which it closes.
        let mut tube = shapes::torus(across, rows + 1);
        tube.faces.truncate((2 * across * rows) as usize);
        for seed in 0..12 {
            let Shuffled { mesh, .. } = shuffle(&tube, seed, 3);
            let found = find(&mesh, FINEST_LEVEL);
            let what = format!("tube {across} × {rows}, seed {seed}");
            assert_eq!(found.as_ref().map_or(0, |f| f.hierarchy.finest().0), levels, "{what}");
            if let Some(found) = found {
                assert_rules(&mesh, &found, &what);
                let connectivity =
                    Connectivity::build(mesh.positions.len() as u32, mesh.faces.clone()).expect("a manifold");
                let lowest = (0..connectivity.vertex_count()).find(|&v| connectivity.is_boundary(v));
                let base = &found.source[..found.hierarchy.base().vertex_count() as usize];
                assert!(base.contains(&lowest.expect("a boundary")), "{what}");
            }
        }
    }
}

#[test]
fn components_share_the_least_level() {
    for (a, b) in [(3, 1), (1, 4), (2, 2), (3, 0), (0, 2)] {
        let parts = [shapes::subdivide(&shapes::octahedron(), a), shapes::subdivide(&shapes::disc(5), b)];
        let least = a.min(b);
        for seed in 0..5 {
            let Shuffled { mesh, .. } = shuffle(&shapes::together(&parts), seed, 3);
            match find(&mesh, FINEST_LEVEL) {
                None => assert_eq!(least, 0, "{a} and {b} levels"),
                Some(found) => {
                    assert_eq!(u32::from(found.hierarchy.finest().0), least, "{a} and {b} levels");
                    let base = found.hierarchy.base();
                    assert_eq!(base.components(), 2);
                    assert_eq!(base.faces().len(), (8 << (2 * (a - least))) + (5 << (2 * (b - least))));
                    assert_rules(&mesh, &found, &format!("{a} and {b} levels, seed {seed}"));
                }
            }
        }
    }
}

#[test]
fn levels_can_be_capped() {
    let Shuffled { mesh, .. } = shuffle(&shapes::subdivide(&shapes::octahedron(), 4), 5, 4);
    for most in 1..=6u8 {
        let found = find(&mesh, most).expect("a subdivided mesh");
        let levels = most.min(4);
        assert_eq!(found.hierarchy.finest(), Level(levels));
        assert_eq!(found.hierarchy.base().faces().len(), 8 << (2 * (4 - levels)));
        assert_rules(&mesh, &found, &format!("at most {most} levels"));
        let options = ConversionOptions { levels: Some(most), ..Default::default() };
        assert_eq!(convert(&mesh, &options).expect("the same").hierarchy.finest(), Level(levels));
    }
    assert!(find(&mesh, 0).is_none(), "J = 0 does not count as detected");
}

/// One edge turned, one face gone, one vertex cut off: no longer subdivided.
#[test]
fn what_is_not_subdivided_is_not_found() {
    for (name, base) in [("octahedron", shapes::octahedron()), ("genus 2", shapes::double_torus())] {
        let fine = shapes::subdivide(&base, 2);
        let connectivity =
            Connectivity::build(fine.positions.len() as u32, fine.faces.clone()).expect("sound");
        for h in (0..3 * fine.faces.len() as u32).step_by(7) {
            // The edge between two faces runs between their other corners instead.
            let opposite = |h: u32| connectivity.origin(bozzetto_core::mesh::connectivity::previous(h));
            let (twin, [a, b]) = (connectivity.twin(h), [connectivity.origin(h), connectivity.target(h)]);
            let (c, d) = (opposite(h), opposite(twin));
            let mut turned = fine.clone();
            turned.faces[(h / 3) as usize] = [a, d, c];
            turned.faces[(twin / 3) as usize] = [b, c, d];
            assert!(find(&turned, FINEST_LEVEL).is_none(), "{name}: edge {a}, {b} turned");
        }
        for gone in 0..fine.faces.len() {
            let mut holed = fine.clone();
            holed.faces.remove(gone);
            assert!(find(&holed, FINEST_LEVEL).is_none(), "{name}: without face {gone}");
            holed.faces.push(fine.faces[gone]);
            assert!(find(&holed, FINEST_LEVEL).is_some(), "{name}: with face {gone} again");
        }
        let mut split = fine.clone();
        let middle = split.positions.len() as u32;
        let [a, b, c] = split.faces.pop().expect("faces");
        split.positions.push([0.0; 3]);
        split.faces.extend([[a, b, middle], [b, c, middle], [c, a, middle]]);
        assert!(find(&split, FINEST_LEVEL).is_none(), "{name}: one face in three");
    }
    // Two triangles back to back are a manifold, but no simplicial complex and so no base mesh either.
    let pillow = TriangleMesh { faces: vec![[0, 1, 2], [0, 2, 1]], ..shapes::triangle() };
    assert!(find(&pillow, FINEST_LEVEL).is_none());
    let own = convert(&pillow, &ConversionOptions { remesh: Remesh::Never, ..Default::default() });
    assert!(matches!(own, Err(ConversionError::NotABaseMesh(_))));
    for (name, mesh) in shapes::awkward() {
        assert!(find(&mesh, FINEST_LEVEL).is_none(), "{name} itself");
        let remeshed = convert(&mesh, &Default::default()).expect(name);
        assert!(remeshed.source.is_none() && remeshed.measured.is_some(), "{name} is remeshed");
        let (base, before) =
            (remeshed.hierarchy.base(), Connectivity::build(mesh.positions.len() as u32, mesh.faces.clone()));
        let before = before.expect("a manifold");
        assert_eq!(
            (base.components(), base.genus(), base.boundary_loops()),
            (before.components(), before.genus(), before.boundary_loops()),
            "{name}: remeshing keeps the topology"
        );
        let own =
            convert(&mesh, &ConversionOptions { remesh: Remesh::Never, ..Default::default() }).expect(name);
        assert_eq!((own.hierarchy.finest(), own.source), (Level(0), None), "{name} as its own base");
    }
}

#[test]
fn a_soup_of_a_subdivided_mesh_keeps_its_vertices() {
    let whole = shapes::subdivide(&shapes::pretzel(2), 2);
    let soup = TriangleMesh::new(
        whole.faces.iter().flatten().map(|&v| whole.positions[v as usize]).collect(),
        (0..whole.faces.len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect(),
    );
    let converted = convert(&soup, &ConversionOptions::default()).expect("a conversion");
    assert!(converted.hierarchy.finest() >= Level(2) && converted.measured.is_none());
    let repeated = soup.positions.len() - whole.positions.len();
    assert_eq!(
        converted.cleaned,
        [format!("{repeated} vertices were merged with another at the same place")]
    );
    let source = converted.source.expect("vertices of the file");
    for (position, &v) in converted.positions.iter().zip(&source) {
        let first = soup.positions.iter().position(|p| p == position);
        assert_eq!(first, Some(v as usize), "the first vertex at the place stands for all");
    }
    // As it is, the soup is triangles of their own.
    let own =
        convert(&soup, &ConversionOptions { remesh: Remesh::Never, ..Default::default() }).expect("soup");
    assert_eq!((own.hierarchy.base().components() as usize, own.source), (soup.faces.len(), None));
}

#[test]
fn a_face_of_a_missing_vertex_is_an_error_however_one_converts() {
    let mut mesh = shapes::octahedron();
    mesh.faces.push([0, 1, 6]);
    for remesh in [Remesh::Auto, Remesh::Always, Remesh::Never] {
        let converted = convert(&mesh, &ConversionOptions { remesh, ..Default::default() });
        let error = NotManifold::MissingVertex { face: 8, vertex: 6 };
        assert_eq!(converted.err(), Some(ConversionError::NotManifold(error)), "{remesh:?}");
    }
}

#[test]
fn what_is_no_manifold_is_an_error() {
    let of = |mesh: &TriangleMesh| {
        let count = mesh.positions.len() as u32;
        let found = detect(count, &mesh.faces, FINEST_LEVEL).map(|found| found.is_some());
        let imported = convert(mesh, &ConversionOptions { remesh: Remesh::Never, ..Default::default() });
        let error = found.expect_err("not a manifold");
        assert_eq!(imported.err(), Some(ConversionError::NotManifold(error.clone())));
        error
    };
    let fine = shapes::subdivide(&shapes::octahedron(), 2);
    let [a, b, _] = fine.faces[0];
    let count = fine.positions.len() as u32;
    let with = |more: u32, faces: &[[u32; 3]]| {
        let mut mesh = fine.clone();
        mesh.positions.extend((0..more).map(|k| [f64::from(k), 5.0, 5.0]));
        mesh.faces.extend(faces);
        mesh
    };
    assert_eq!(of(&with(1, &[[a, b, count]])), NotManifold::Edge { a: a.min(b), b: a.max(b) });
    assert_eq!(of(&with(2, &[[a, count, count + 1]])), NotManifold::Vertex { vertex: a });
    let face = fine.faces.len() as u32;
    assert_eq!(of(&with(1, &[[a, count, count]])), NotManifold::Degenerate { face, vertex: count });
    assert_eq!(of(&with(0, &[[a, b, count]])), NotManifold::MissingVertex { face, vertex: count });
    // A band of triangles closed with a twist, subdivided or not.
    let band = TriangleMesh::new(
        (0..5).map(|k| [f64::from(k), f64::from(k * k % 3), 1.0]).collect(),
        (0..5u32).map(|k| [k, (k + 1) % 5, (k + 2) % 5]).collect(),
    );
    for levels in 0..3 {
        let band = shapes::subdivide(&band, levels);
        let NotManifold::NotOrientable { a, b } = of(&band) else { panic!("a Möbius band") };
        let shared = band.faces.iter().filter(|f| f.contains(&a) && f.contains(&b)).count();
        assert_eq!(shared, 2, "the edge that is named is one between two faces");
    }
}

/// What an import makes of positions and sources: each slot has its vertex's position, to half a step.
#[test]
fn imports_keep_every_vertex() {
    for (name, base) in shapes::awkward() {
        let Shuffled { mesh, .. } = shuffle(&shapes::subdivide(&base, 2), 77, 5);
        let imported = convert(&mesh, &Default::default()).expect(name);
        let source = imported.source.expect("subdivision connectivity");
        let surface = Surface::from_positions(imported.hierarchy, &imported.positions, &Default::default());
        let surface = surface.expect("small valences");
        let (finest, step) = (surface.finest(), surface.form().placement.step);
        let unused = mesh.positions.len() - source.len();
        assert_eq!(imported.cleaned.len(), usize::from(unused > 0), "{name}: {:?}", imported.cleaned);
        for (slot, &v) in source.iter().enumerate() {
            let (at, wanted) = (surface.position(finest, Slot(slot as u32)), mesh.positions[v as usize]);
            for c in 0..3 {
                assert!((at[c] - wanted[c]).abs() <= 0.500_001 * step, "{name}, slot {slot}");
            }
        }
    }
}
