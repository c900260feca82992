use super::*;

/// A flat unit square of `2 n²` triangles at height `z`.
fn grid(n: u32, z: f64) -> TriangleMesh {
    let at = |i: u32| f64::from(i) / f64::from(n);
    let positions = (0..=n).flat_map(|row| (0..=n).map(move |column| [at(column), at(row), z])).collect();
    let faces = (0..n).flat_map(|row| {
        (0..n).flat_map(move |column| {
            let corner = row * (n + 1) + column;
            [[corner, corner + 1, corner + n + 2], [corner, corner + n + 2, corner + n + 1]]
        })
    });
    TriangleMesh::new(positions, faces.collect())
}

/// The grid with every vertex moved up by a little, differently.
fn rough_grid(n: u32) -> TriangleMesh {
    let mut mesh = grid(n, 0.0);
    for (index, position) in mesh.positions.iter_mut().enumerate() {
        position[2] = (index * 7919 % 101) as f64 * 1e-4;
    }
    mesh
}

fn measure(a: &TriangleMesh, b: &TriangleMesh, samples: usize) -> Comparison {
    compare(a, b, &CompareOptions { samples, seed: 1 }, &|_| true).unwrap()
}

#[test]
fn a_shifted_grid_is_at_its_shift() {
    let (a, b) = (grid(10, 0.0), grid(7, 0.25));
    let found = measure(&a, &b, 2000);
    let expected = 0.25 / 2f64.sqrt();
    for way in [found.a_to_b, found.b_to_a] {
        for value in [way.mean, way.rms, way.max] {
            assert!((value - expected).abs() < 1e-14, "{found:?}");
        }
    }
    assert_eq!(found.diagonal, 2f64.sqrt());
    assert!((found.psnr.unwrap() + 20.0 * expected.log10()).abs() < 1e-10);
}

#[test]
fn a_surface_is_at_distance_zero_from_itself_however_it_is_cut() {
    for other in [grid(9, 0.5), grid(4, 0.5)] {
        let found = measure(&grid(9, 0.5), &other, 5000);
        assert_eq!((found.rms, found.max, found.psnr), (0.0, 0.0, None));
    }
    let rough = rough_grid(12);
    assert_eq!(measure(&rough, &rough, 5000).max, 0.0);
}

#[test]
fn the_two_directions_differ_where_one_surface_has_more() {
    // B is A and a far triangle: A lies on B, B does not lie on A.
    let a = grid(4, 0.0);
    let mut b = a.clone();
    let first = b.positions.len() as u32;
    b.positions.extend([[0.0, 0.0, 3.0], [1.0, 0.0, 3.0], [0.0, 1.0, 3.0]]);
    b.faces.push([first, first + 1, first + 2]);
    let found = measure(&a, &b, 3000);
    assert_eq!(found.a_to_b, OneWay::default());
    assert!((found.b_to_a.max - 3.0 / 2f64.sqrt()).abs() < 1e-14);
    // The far triangle is one third of B's area.
    assert!((found.b_to_a.mean - 1.0 / 2f64.sqrt()).abs() < 1e-3, "{found:?}");
    assert_eq!((found.rms, found.max), (found.b_to_a.rms, found.b_to_a.max));
}

#[test]
fn a_single_raised_vertex_sets_the_maximum() {
    let a = grid(20, 0.0);
    let mut b = a.clone();
    b.positions[210][2] = 0.01;
    // So few samples cannot find the peak; the vertices do.
    assert!((measure(&a, &b, 1).b_to_a.max - 0.01 / 2f64.sqrt()).abs() < 1e-15);
}

#[test]
fn a_peak_between_the_samples_is_found() {
    let top = DVec3::new(0.7, 0.3, 0.02);
    let (a, mut b) = (grid(1, 0.0), grid(100, 0.0));
    for p in &mut b.positions {
        let from_top = (DVec3::from(*p) - top).truncate().length() / 0.1;
        p[2] = if from_top < 1.0 { top.z * (1.0 - from_top * from_top).powi(2) } else { 0.0 };
    }
    // Samples of the square lie some 0.06 apart, and it has no vertex near the bump.
    let found = measure(&a, &b, 256).a_to_b.max * 2f64.sqrt();
    assert!(found > 0.985 * top.z && found <= top.z * 1.000_001, "{found}");
}

#[test]
fn unreferenced_vertices_count_for_nothing() {
    let a = grid(3, 0.0);
    let mut b = a.clone();
    b.positions.push([50.0, 50.0, 50.0]);
    assert_eq!(measure(&b, &a, 500), measure(&a, &a, 500));
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let (a, b) = (rough_grid(30), grid(17, 0.003));
    let with_threads = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let found = pool.install(|| measure(&a, &b, 20_000));
        let ways = [found.a_to_b, found.b_to_a].map(|way| [way.mean, way.rms, way.max].map(f64::to_bits));
        (ways, found.psnr.map(f64::to_bits))
    };
    let one = with_threads(1);
    assert_eq!(one, with_threads(2));
    assert_eq!(one, with_threads(7));
}

#[test]
fn the_seed_moves_the_samples() {
    let (a, b) = (rough_grid(8), grid(3, 0.0));
    let with_seed = |seed| compare(&a, &b, &CompareOptions { samples: 300, seed }, &|_| true).unwrap();
    assert_eq!(with_seed(5), with_seed(5));
    assert_ne!(with_seed(5).a_to_b.mean, with_seed(6).a_to_b.mean);
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let (grid, none) = (grid(2, 0.0), TriangleMesh::default());
    let options = CompareOptions::default();
    assert_eq!(compare(&none, &grid, &options, &|_| true), Err(CompareError::FirstEmpty));
    assert_eq!(compare(&grid, &none, &options, &|_| true), Err(CompareError::SecondEmpty));
    let point = TriangleMesh::new(vec![[1.0; 3]], vec![[0, 0, 0]]);
    assert_eq!(compare(&point, &grid, &options, &|_| true), Err(CompareError::NoExtent));
}

#[test]
fn progress_rises_to_one_and_can_cancel() {
    let (a, b) = (grid(8, 0.0), grid(5, 0.1));
    let options = CompareOptions { samples: 200_000, seed: 1 };
    let calls = std::cell::RefCell::new(Vec::new());
    let watch = |fraction: f32| {
        calls.borrow_mut().push(fraction);
        true
    };
    compare(&a, &b, &options, &watch).unwrap();
    let calls = calls.into_inner();
    assert!(calls.is_sorted() && calls.first() == Some(&0.0) && calls.last() == Some(&1.0), "{calls:?}");
    let stop = |fraction: f32| fraction < 0.5;
    assert_eq!(compare(&a, &b, &options, &stop), Err(CompareError::Cancelled));
}

#[test]
fn the_report_is_valid_json() {
    let found = measure(&grid(2, 0.0), &grid(3, 0.0), 100);
    let json = serde_json::to_value(found).unwrap();
    assert!(json["psnr"].is_null());
    assert_eq!(json["a_to_b"]["rms"], 0.0);
    let keys: Vec<&str> = json.as_object().unwrap().keys().map(String::as_str).collect();
    assert_eq!(keys, ["a_to_b", "b_to_a", "diagonal", "max", "psnr", "rms"]);
}
