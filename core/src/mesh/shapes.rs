//! Small meshes of known topology, for tests, samples and demonstrations.

use super::TriangleMesh;

/// The regular octahedron with vertices on the axes: 6 vertices, 8 faces, all valences 4.
pub fn octahedron() -> TriangleMesh {
    TriangleMesh::new(
        vec![
            [1.0, 0.0, 0.0],
            [-1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, -1.0, 0.0],
            [0.0, 0.0, 1.0],
            [0.0, 0.0, -1.0],
        ],
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]],
    )
}

/// The regular tetrahedron: 4 vertices, 4 faces, all valences 3.
pub fn tetrahedron() -> TriangleMesh {
    TriangleMesh::new(
        vec![[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]],
        vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]],
    )
}

/// One triangle: the smallest surface with boundary.
pub fn triangle() -> TriangleMesh {
    TriangleMesh::new(vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])
}

/// A disc: a centre and a rim of `rim ≥ 3` vertices.
pub fn disc(rim: u32) -> TriangleMesh {
    let mut positions = vec![[0.0, 0.0, 0.3]];
    for step in 0..rim {
        let angle = f64::from(step) / f64::from(rim) * std::f64::consts::TAU;
        positions.push([angle.cos(), angle.sin(), 0.0]);
    }
    let faces = (0..rim).map(|step| [0, 1 + step, 1 + (step + 1) % rim]).collect();
    TriangleMesh::new(positions, faces)
}

/// Two cones over one rim of `rim ≥ 3` vertices: a sphere whose poles have valence `rim`.
pub fn bipyramid(rim: u32) -> TriangleMesh {
    let mut mesh = disc(rim);
    mesh.positions[0] = [0.0, 0.0, 1.0];
    let south = mesh.positions.len() as u32;
    mesh.positions.push([0.0, 0.0, -1.0]);
    mesh.faces.extend((0..rim).map(|step| [south, 1 + (step + 1) % rim, 1 + step]));
    mesh
}

/// A torus of `across × around` quadrilaterals, each split along the same diagonal: every valence is 6. Both
/// counts are at least 3.
pub fn torus(across: u32, around: u32) -> TriangleMesh {
    let mut positions = Vec::new();
    for j in 0..around {
        for i in 0..across {
            let (u, v) = (f64::from(i) / f64::from(across), f64::from(j) / f64::from(around));
            let (u, v) = (u * std::f64::consts::TAU, v * std::f64::consts::TAU);
            let ring = 1.0 + 0.4 * u.cos();
            positions.push([ring * v.cos(), ring * v.sin(), 0.4 * u.sin()]);
        }
    }
    let at = |i: u32, j: u32| (j % around) * across + i % across;
    let mut faces = Vec::new();
    for j in 0..around {
        for i in 0..across {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            faces.push([a, c, b]);
            faces.push([a, d, c]);
        }
    }
    TriangleMesh::new(positions, faces)
}

/// A flat block of unit cubes in a row with `holes` square tunnels through it: a closed surface of genus `holes`
/// with extraordinary vertices (valences 4 to 8).
pub fn pretzel(holes: u32) -> TriangleMesh {
    let (width, height) = (2 * holes + 1, 3);
    let solid = |x: i64, y: i64| {
        (0..i64::from(width)).contains(&x) && (0..height).contains(&y) && !(y == 1 && x % 2 == 1)
    };
    let mut ids = std::collections::BTreeMap::new();
    let mut mesh = TriangleMesh::new(Vec::new(), Vec::new());
    let mut corner = |mesh: &mut TriangleMesh, p: [i64; 3]| {
        *ids.entry(p).or_insert_with(|| {
            mesh.positions.push([p[0] as f64, p[1] as f64, p[2] as f64]);
            mesh.positions.len() as u32 - 1
        })
    };
    for x in 0..i64::from(width) {
        for y in 0..height {
            if !solid(x, y) {
                continue;
            }
            // Quadrilaterals seen counter-clockwise from outside.
            let mut quads = vec![
                [[x, y, 1], [x + 1, y, 1], [x + 1, y + 1, 1], [x, y + 1, 1]],
                [[x, y, 0], [x, y + 1, 0], [x + 1, y + 1, 0], [x + 1, y, 0]],
            ];
            if !solid(x - 1, y) {
                quads.push([[x, y, 0], [x, y, 1], [x, y + 1, 1], [x, y + 1, 0]]);
            }
            if !solid(x + 1, y) {
                quads.push([[x + 1, y, 0], [x + 1, y + 1, 0], [x + 1, y + 1, 1], [x + 1, y, 1]]);
            }
            if !solid(x, y - 1) {
                quads.push([[x, y, 0], [x + 1, y, 0], [x + 1, y, 1], [x, y, 1]]);
            }
            if !solid(x, y + 1) {
                quads.push([[x, y + 1, 0], [x, y + 1, 1], [x + 1, y + 1, 1], [x + 1, y + 1, 0]]);
            }
            for quad in quads {
                let [a, b, c, d] = quad.map(|p| corner(&mut mesh, p));
                mesh.faces.push([a, b, c]);
                mesh.faces.push([a, c, d]);
            }
        }
    }
    mesh
}

/// Several meshes as components of one, side by side along x.
pub fn together(parts: &[TriangleMesh]) -> TriangleMesh {
    let mut whole = TriangleMesh::new(Vec::new(), Vec::new());
    for (k, part) in parts.iter().enumerate() {
        let first = whole.positions.len() as u32;
        whole.positions.extend(part.positions.iter().map(|p| [p[0] + 3.0 * k as f64, p[1], p[2]]));
        whole.faces.extend(part.faces.iter().map(|f| f.map(|v| v + first)));
    }
    whole
}

/// Every face split 1→4 at edge midpoints, `times` times. Old vertices keep their indices.
pub fn subdivide(mesh: &TriangleMesh, times: u32) -> TriangleMesh {
    let mut mesh = mesh.clone();
    for _ in 0..times {
        let mut midpoints = rustc_hash::FxHashMap::default();
        let mut faces = Vec::with_capacity(mesh.faces.len() * 4);
        for &face in &mesh.faces {
            let mut middle = [0; 3];
            for k in 0..3 {
                let (a, b) = (face[k], face[(k + 1) % 3]);
                middle[k] = *midpoints.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    let (p, q) = (mesh.positions[a as usize], mesh.positions[b as usize]);
                    mesh.positions.push(std::array::from_fn(|axis| (p[axis] + q[axis]) * 0.5));
                    mesh.positions.len() as u32 - 1
                });
            }
            let [ab, bc, ca] = middle;
            faces.extend([[face[0], ab, ca], [ab, face[1], bc], [ca, bc, face[2]], [ab, bc, ca]]);
        }
        mesh.faces = faces;
    }
    mesh
}

/// Two seven-vertex tori (Möbius 1861: every two vertices are neighbours) joined along a face: the smallest
/// convenient surface of genus 2, 11 vertices and 26 faces.
pub fn double_torus() -> TriangleMesh {
    let torus: Vec<[u32; 3]> =
        (0..7u32).flat_map(|i| [[i, (i + 1) % 7, (i + 3) % 7], [i, (i + 3) % 7, (i + 2) % 7]]).collect();
    // The second torus meets the first in the removed face 0, 1, 3, whose corners it runs round the other way.
    let second = |v: u32| match v {
        0 => 1,
        1 => 0,
        2 => 7,
        3 => 3,
        v => v + 4,
    };
    let mut faces = torus[1..].to_vec();
    faces.extend(torus[1..].iter().map(|f| f.map(second)));
    let positions = (0..11)
        .map(|v| {
            let t = f64::from(v);
            [(t * 2.4).cos() + 0.2 * t, (t * 2.4).sin(), 0.37 * (t * 1.7).cos()]
        })
        .collect();
    TriangleMesh::new(positions, faces)
}

/// Base meshes that break careless code: boundary, valences 3 and 12, genus 0 to 4, one triangle, two components, a
/// closed torus without an extraordinary vertex. With names for messages.
pub fn awkward() -> Vec<(&'static str, TriangleMesh)> {
    vec![
        ("octahedron", octahedron()),
        ("tetrahedron", tetrahedron()),
        ("one triangle", triangle()),
        ("open disc", disc(5)),
        ("valence 12", bipyramid(12)),
        ("regular torus", torus(4, 3)),
        ("genus 2", double_torus()),
        ("genus 3", pretzel(3)),
        ("genus 4", pretzel(4)),
        ("two components", together(&[tetrahedron(), disc(7)])),
    ]
}
