//! Random simplifications, cuts and welds of small meshes: a seed gives the mesh.

use super::shapes::{ball, bumped, soup};
use crate::samples::Numbers;
use bozzetto_core::conversion::{ConversionOptions, Remesh};
use bozzetto_core::mesh::TriangleMesh;
use bozzetto_core::mesh::shapes::{
    disc, double_torus, octahedron, pretzel, subdivide, tetrahedron, together, torus,
};

/// A damaged mesh and how to convert it.
pub(crate) fn case(seed: u64) -> (TriangleMesh, ConversionOptions) {
    let mut numbers = Numbers(seed);
    let mut mesh = sample(&mut numbers);
    for _ in 0..1 + numbers.below(6) {
        let kind = numbers.below(12);
        damage(&mut mesh, kind, &mut numbers);
        if mesh.faces.is_empty() {
            break;
        }
    }
    let options = ConversionOptions {
        levels: (numbers.below(4) == 0).then(|| 1 + numbers.below(3) as u8),
        remesh: if numbers.below(4) == 0 { Remesh::Always } else { Remesh::Auto },
        base_faces: (numbers.below(3) == 0).then(|| 4 + numbers.below(300) as usize),
        tolerance: None,
        sharp_angle: None,
        symmetric: None,
    };
    (mesh, options)
}

fn sample(numbers: &mut Numbers) -> TriangleMesh {
    match numbers.below(8) {
        0 => ball(),
        1 => bumped(&subdivide(&tetrahedron(), 3)),
        2 => bumped(&torus(12, 16)),
        3 => bumped(&subdivide(&pretzel(3), 1)),
        4 => bumped(&subdivide(&disc(7), 3)),
        5 => bumped(&subdivide(&double_torus(), 2)),
        6 => together(&[ball(), bumped(&torus(6, 9)), disc(12), octahedron()]),
        _ => soup(&ball()),
    }
}

fn damage(mesh: &mut TriangleMesh, kind: u32, numbers: &mut Numbers) {
    let faces = mesh.faces.len() as u32;
    let vertices = mesh.positions.len() as u32;
    let some = |most: u32, numbers: &mut Numbers| 1 + numbers.below(most);
    match kind {
        // Simplify: edges collapse whatever that does to the topology.
        0 | 1 => {
            for _ in 0..some(faces / 3 + 1, numbers) {
                let face = mesh.faces[numbers.below(faces) as usize];
                let corner = numbers.below(3) as usize;
                collapse(mesh, face[corner], face[(corner + 1) % 3], numbers.below(2) == 0);
            }
            if numbers.below(2) == 0 {
                mesh.faces.retain(|f| f[0] != f[1] && f[1] != f[2] && f[2] != f[0]);
            }
        }
        // Cut: single faces, or all within a ball.
        2 => (0..some(faces / 8 + 1, numbers)).for_each(|_| {
            let count = mesh.faces.len() as u32;
            if count > 0 {
                mesh.faces.swap_remove(numbers.below(count) as usize);
            }
        }),
        3 => {
            let centre = mesh.positions[numbers.below(vertices) as usize];
            let radius = 0.1 + 0.4 * numbers.signed().abs();
            let squared = |p: [f64; 3]| (0..3).map(|k| (p[k] - centre[k]).powi(2)).sum::<f64>();
            let positions = &mesh.positions;
            mesh.faces.retain(|f| squared(positions[f[0] as usize]) > radius * radius);
        }
        // Cut apart: some faces get vertices of their own.
        4 => (0..some(faces / 4 + 1, numbers)).for_each(|_| {
            let (face, corner) = (numbers.below(faces) as usize, numbers.below(3) as usize);
            mesh.positions.push(mesh.positions[mesh.faces[face][corner] as usize]);
            mesh.faces[face][corner] = mesh.positions.len() as u32 - 1;
        }),
        // Weld vertices that have nothing to do with each other.
        5 => (0..some(6, numbers)).for_each(|_| {
            collapse(mesh, numbers.below(vertices), numbers.below(vertices), numbers.below(2) == 0)
        }),
        6 => (0..some(faces / 4 + 1, numbers))
            .for_each(|_| mesh.faces[numbers.below(faces) as usize].swap(0, 1)),
        7 => (0..some(20, numbers)).for_each(|_| {
            let mut face = mesh.faces[numbers.below(faces) as usize];
            if numbers.below(2) == 0 {
                face.swap(1, 2);
            }
            mesh.faces.push(face);
        }),
        // Faces across everything.
        8 => (0..some(12, numbers))
            .for_each(|_| mesh.faces.push(std::array::from_fn(|_| numbers.below(vertices)))),
        // Vertices moved: a little, far, or onto a neighbour.
        9 => (0..some(vertices / 3 + 1, numbers)).for_each(|_| {
            let vertex = numbers.below(vertices) as usize;
            let reach = [1e-3, 0.1, 1.0][numbers.below(3) as usize];
            mesh.positions[vertex] = mesh.positions[vertex].map(|x| x + reach * numbers.signed());
        }),
        10 => (0..some(30, numbers)).for_each(|_| {
            let face = mesh.faces[numbers.below(faces) as usize];
            mesh.positions[face[0] as usize] = mesh.positions[face[1] as usize];
        }),
        // Squeezed or blown up.
        _ => {
            let factors: [f64; 3] =
                std::array::from_fn(|_| [1.0, 1.0, 1e-3, 1e3, 0.0][numbers.below(5) as usize]);
            mesh.positions.iter_mut().for_each(|p| *p = std::array::from_fn(|k| p[k] * factors[k]));
        }
    }
}

/// Makes `gone` the vertex `kept`, which may move between them.
fn collapse(mesh: &mut TriangleMesh, kept: u32, gone: u32, halfway: bool) {
    if halfway {
        let (p, q) = (mesh.positions[kept as usize], mesh.positions[gone as usize]);
        mesh.positions[kept as usize] = std::array::from_fn(|k| (p[k] + q[k]) * 0.5);
    }
    mesh.faces.iter_mut().flatten().filter(|v| **v == gone).for_each(|v| *v = kept);
}
