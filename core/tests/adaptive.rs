//! The adaptive triangulation: no cracks, the same topology, corners on the surface, as near as asked for, and few triangles.

mod samples;

use bozzetto_core::hierarchy::{BaseMesh, Hierarchy, Level};
use bozzetto_core::lod::{adaptive_triangulation, keep_largest};
use bozzetto_core::mesh::connectivity::Connectivity;
use bozzetto_core::mesh::{CompareOptions, TriangleMesh, compare, shapes};
use bozzetto_core::surface::{Form, FormOptions, Surface};
use bozzetto_core::wavelet::Wavelet;
use samples::{on_threads, surface};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Smooth but for one bump, which asks for small triangles in one place.
fn bump(levels: u8) -> Surface {
    Surface::ball(levels, |p| {
        let away = (p[0] - 0.6).powi(2) + (p[1] - 0.64).powi(2) + (p[2] - 0.48).powi(2);
        1.0 + 0.1 * (-300.0 * away).exp()
    })
}

/// The same topology as the whole surface's: every edge of two faces that run through it opposite ways, or of one where
/// that has a boundary.
fn assert_whole(name: &str, surface: &Surface, mesh: &TriangleMesh) {
    let mut sides: HashMap<[u32; 2], u32> = HashMap::new();
    for face in &mesh.faces {
        for k in 0..3 {
            *sides.entry([face[k], face[(k + 1) % 3]]).or_default() += 1;
        }
    }
    assert!(sides.values().all(|&count| count == 1), "{name}: an edge run through twice the same way");
    let used: HashSet<u32> = mesh.faces.iter().flatten().copied().collect();
    assert_eq!(used.len(), mesh.positions.len(), "{name}: vertices without faces");
    let found = Connectivity::build(mesh.positions.len() as u32, mesh.faces.clone()).expect("a manifold");
    assert!(found.faces() == mesh.faces, "{name}: turned faces");
    let base = surface.hierarchy().base();
    assert_eq!(found.components(), base.components(), "{name}");
    assert_eq!(found.genus(), base.genus(), "{name}");
    assert_eq!(found.boundary_loops(), base.boundary_loops(), "{name}");
}

/// Whether the origin is behind a triangle.
fn outward([a, b, c]: [[f64; 3]; 3]) -> bool {
    a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
        > 0.0
}

fn assert_on_surface(name: &str, surface: &Surface, mesh: &TriangleMesh) {
    let finest = surface.to_mesh(surface.finest());
    let bits = |p: &[f64; 3]| p.map(f64::to_bits);
    let places: HashSet<[u64; 3]> = finest.positions.iter().map(bits).collect();
    assert!(mesh.positions.iter().all(|p| places.contains(&bits(p))), "{name}: a vertex off the surface");
}

#[test]
fn nothing_is_torn_on_awkward_meshes() {
    for (name, base) in shapes::awkward() {
        let whole = surface(&base, Wavelet::Disc(2), 1, 3, 7);
        let diagonal = whole.to_mesh(whole.finest()).bounds().expect("an extent").diagonal();
        for share in [0.05, 0.3] {
            let kept = keep_largest(&whole, share).surface;
            for part in [0.0, 0.1, 0.3, 0.6] {
                let mesh = adaptive_triangulation(&kept, part * diagonal);
                assert_whole(name, &whole, &mesh);
                assert_on_surface(name, &kept, &mesh);
            }
        }
    }
}

#[test]
fn large_triangles_where_it_is_flat() {
    let whole = bump(6);
    let finest = whole.to_mesh(whole.finest());
    let mut before = finest.faces.len() + 1;
    for tolerance in [1e-3, 4e-3, 1.6e-2] {
        let mesh = adaptive_triangulation(&whole, tolerance);
        assert_whole("bump", &whole, &mesh);
        assert_on_surface("bump", &whole, &mesh);
        assert!(mesh.faces.iter().all(|f| outward(f.map(|v| mesh.positions[v as usize]))), "{tolerance}");
        let options = CompareOptions { samples: 50_000, seed: 1 };
        let found = compare(&finest, &mesh, &options, &|_| true).expect("surfaces");
        let max = found.max * found.diagonal;
        assert!(max <= tolerance * 1.000_001, "{max} at {tolerance}");
        // The bound is no idle one: what is asked for is made use of.
        assert!(max > tolerance / 10.0, "{max} at {tolerance}");
        assert!(mesh.faces.len() < before, "{} faces at {tolerance}", mesh.faces.len());
        before = mesh.faces.len();
    }
    let mesh = adaptive_triangulation(&whole, 1.6e-2);
    assert!(
        mesh.faces.len() * 16 < finest.faces.len(),
        "{} of {} faces",
        mesh.faces.len(),
        finest.faces.len()
    );
    // The smallest triangles are at the bump, and nowhere else.
    let corners = |face: &[u32; 3]| face.map(|v| mesh.positions[v as usize]);
    let size = |face: &[u32; 3]| {
        let [a, b, _] = corners(face);
        (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
    };
    let longest = mesh.faces.iter().map(size).fold(0.0, f64::max);
    let small: Vec<_> = mesh.faces.iter().filter(|face| size(face) < longest / 4.0).map(corners).collect();
    let at_bump = |[p, _, _]: &[[f64; 3]; 3]| p[0] * 0.6 + p[1] * 0.64 + p[2] * 0.48 > 0.9;
    assert!(small.len() > 20 && small.iter().all(at_bump), "{} small ones", small.len());
}

#[test]
fn everything_kept_is_the_whole_mesh() {
    for (name, base) in shapes::awkward() {
        let whole = surface(&base, Wavelet::Disc(1), 0, 2, 3);
        let mesh = adaptive_triangulation(&whole, 0.0);
        let full = whole.to_mesh(whole.finest());
        assert!(mesh.positions == full.positions, "{name}");
        let sorted = |mesh: &TriangleMesh| {
            let mut faces: Vec<[u32; 3]> = mesh.faces.clone();
            for face in &mut faces {
                let least = (0..3).min_by_key(|&k| face[k]).expect("corners");
                face.rotate_left(least);
            }
            faces.sort_unstable();
            faces
        };
        assert_eq!(sorted(&mesh), sorted(&full), "{name}");
    }
}

/// A flat disc on which every wavelet of a level, on top of all coarser ones, lifts its vertex by so many steps.
fn disc_lifted(levels: u8, steps: i32) -> (TriangleMesh, Surface) {
    let base = shapes::disc(6);
    let corners = BaseMesh::new(base.positions.len() as u32, base.faces.clone(), &[]).expect("a base mesh");
    let flat = Hierarchy::new(Arc::new(corners.clone()), Level::BASE).expect("small");
    let placed = Surface::from_positions(flat, &base.positions, &FormOptions::default()).expect("a disc");
    let hierarchy = Hierarchy::new(Arc::new(corners), Level(levels)).expect("small");
    let form = Form { wavelet: Wavelet::Lazy, ..placed.form().clone() };
    let wavelets = (0..levels)
        .map(|level| vec![[0, 0, steps]; hierarchy.layout(Level(level)).odd_len() as usize])
        .collect();
    let coarsest = placed.scaling(Level::BASE).to_vec();
    (base, Surface::from_coefficients(hierarchy, form, coarsest, wavelets).expect("lifted"))
}

#[test]
fn a_flat_surface_is_its_base_mesh() {
    let (base, flat) = disc_lifted(4, 0);
    assert_eq!(adaptive_triangulation(&flat, 0.0).faces.len(), base.faces.len());
}

/// Every level alone is nearer than the tolerance, all of them together are not.
#[test]
fn what_the_levels_bend_adds_up() {
    let steps = 1 << 14;
    let (_, surface) = disc_lifted(5, steps);
    let tolerance = 2.5 * f64::from(steps) * surface.form().placement.step;
    let mesh = adaptive_triangulation(&surface, tolerance);
    let finest = surface.to_mesh(surface.finest());
    let options = CompareOptions { samples: 50_000, seed: 1 };
    let found = compare(&finest, &mesh, &options, &|_| true).expect("surfaces");
    assert!(found.max * found.diagonal <= tolerance, "{} of {tolerance}", found.max * found.diagonal);
    assert!(mesh.faces.len() < finest.faces.len(), "{} faces", mesh.faces.len());
}

#[test]
fn threads_do_not_matter() {
    let kept = keep_largest(&bump(5), 0.1).surface;
    let on = |threads| on_threads(threads, || adaptive_triangulation(&kept, 4e-3));
    let (one, three) = (on(1), on(3));
    assert!(one == three && one.faces.len() > 100);
}
