//! The awkward meshes, each with a name and what must become of it.

use crate::samples::Numbers;
use bozzetto_core::mesh::TriangleMesh;
use bozzetto_core::mesh::shapes::{
    bipyramid, disc, double_torus, octahedron, pretzel, subdivide, tetrahedron, together, torus, triangle,
};
use std::f64::consts::TAU;

/// What must become of a mesh.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Fate {
    /// A surface of so many components, this genus and so many boundary loops.
    Surface([u32; 3]),
    /// A surface of a topology that only cleaning knows.
    Something,
    /// A refusal that says this.
    Refused(&'static str),
}

use Fate::{Refused, Something, Surface};

/// A name, a mesh and its fate.
pub(crate) type Case = (&'static str, TriangleMesh, Fate);

/// All of them.
pub(crate) fn all() -> Vec<Case> {
    [
        tiny(),
        soups(),
        no_manifolds(),
        one_sided(),
        flat_and_thin(),
        scales(),
        many(),
        crossing(),
        open(),
        nothing(),
    ]
    .concat()
}

const BALL: [u32; 3] = [1, 0, 0];

/// A ball without subdivision connectivity: one vertex is split off an edge.
pub(crate) fn ball() -> TriangleMesh {
    bumped(&split_edge(&subdivide(&octahedron(), 3), 0))
}

/// Puts a vertex on the first edge of a face.
fn split_edge(mesh: &TriangleMesh, face: usize) -> TriangleMesh {
    let mut mesh = mesh.clone();
    let [a, b, c] = mesh.faces[face];
    let middle = mesh.positions.len() as u32;
    let (p, q) = (mesh.positions[a as usize], mesh.positions[b as usize]);
    mesh.positions.push(std::array::from_fn(|k| (p[k] + q[k]) * 0.5));
    mesh.faces[face] = [a, middle, c];
    mesh.faces.push([middle, b, c]);
    let other = mesh.faces.iter().position(|f| f.contains(&a) && f.contains(&b));
    if let Some(other) = other {
        let k = mesh.faces[other].iter().position(|&v| v == b).expect("an end");
        let [b, a, d] = [0, 1, 2].map(|i| mesh.faces[other][(k + i) % 3]);
        mesh.faces[other] = [b, middle, d];
        mesh.faces.push([middle, a, d]);
    }
    mesh
}

/// The same mesh, no longer flat anywhere.
pub(crate) fn bumped(mesh: &TriangleMesh) -> TriangleMesh {
    let mut mesh = mesh.clone();
    for p in &mut mesh.positions {
        let bump = 0.04 * ((3.0 * p[0]).sin() + (4.0 * p[1]).cos() + (2.5 * p[2]).sin());
        *p = [p[0] + bump, p[1] - 0.5 * bump, p[2] + 0.7 * bump];
    }
    mesh
}

/// A grid of `columns × rows` squares over `(0..1)²`, wherever `place` puts it; `names` may make vertices one.
fn grid(
    [columns, rows]: [u32; 2],
    names: impl Fn(u32, u32) -> u32,
    place: impl Fn(f64, f64) -> [f64; 3],
) -> TriangleMesh {
    let mut mesh = TriangleMesh::new(vec![[0.0; 3]; ((columns + 1) * (rows + 1)) as usize], Vec::new());
    for j in (0..=rows).rev() {
        for i in (0..=columns).rev() {
            let (u, v) = (f64::from(i) / f64::from(columns), f64::from(j) / f64::from(rows));
            mesh.positions[names(i, j) as usize] = place(u, v);
        }
    }
    for j in 0..rows {
        for i in 0..columns {
            let [a, b, c, d] = [names(i, j), names(i + 1, j), names(i + 1, j + 1), names(i, j + 1)];
            mesh.faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

fn plain_grid(columns: u32, rows: u32, place: impl Fn(f64, f64) -> [f64; 3]) -> TriangleMesh {
    grid([columns, rows], |i, j| j * (columns + 1) + i, place)
}

fn moved(mesh: &TriangleMesh, place: impl Fn([f64; 3]) -> [f64; 3]) -> TriangleMesh {
    TriangleMesh::new(mesh.positions.iter().map(|&p| place(p)).collect(), mesh.faces.clone())
}

fn scaled(mesh: &TriangleMesh, factor: f64) -> TriangleMesh {
    moved(mesh, |p| p.map(|x| x * factor))
}

/// Several meshes in one, where they are.
fn joined(parts: &[TriangleMesh]) -> TriangleMesh {
    let mut whole = TriangleMesh::default();
    for part in parts {
        let first = whole.positions.len() as u32;
        whole.positions.extend(&part.positions);
        whole.faces.extend(part.faces.iter().map(|f| f.map(|v| v + first)));
    }
    whole
}

/// Every face with vertices of its own.
pub(crate) fn soup(mesh: &TriangleMesh) -> TriangleMesh {
    TriangleMesh::new(
        mesh.faces.iter().flatten().map(|&v| mesh.positions[v as usize]).collect(),
        (0..mesh.faces.len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect(),
    )
}

/// A cube from `low` on, 12 faces, as part of a bigger mesh.
fn cube(low: [f64; 3]) -> TriangleMesh {
    moved(&pretzel(0), |p| std::array::from_fn(|k| low[k] + p[k]))
}

/// One vertex for all at the same place.
fn welded(mesh: &TriangleMesh) -> TriangleMesh {
    let mut numbers = std::collections::BTreeMap::new();
    let mut positions = Vec::new();
    let faces = mesh.faces.iter().map(|f| {
        f.map(|v| {
            let p = mesh.positions[v as usize];
            *numbers.entry(p.map(f64::to_bits)).or_insert_with(|| {
                positions.push(p);
                positions.len() as u32 - 1
            })
        })
    });
    let faces = faces.collect();
    TriangleMesh::new(positions, faces)
}

fn tiny() -> Vec<Case> {
    let square = TriangleMesh::new(
        vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
        vec![[0, 1, 2], [0, 2, 3]],
    );
    let mut back_to_back = triangle();
    back_to_back.faces.push([0, 2, 1]);
    vec![
        ("one triangle", triangle(), Surface([1, 0, 1])),
        ("two triangles", square, Surface([1, 0, 1])),
        ("two triangles back to back", back_to_back.clone(), Surface([1, 0, 1])),
        ("two triangles back to back, apart", soup(&back_to_back), Surface([1, 0, 1])),
        ("tetrahedron", tetrahedron(), Surface(BALL)),
        ("octahedron", octahedron(), Surface(BALL)),
        ("the least torus", seven_vertex_torus(), Surface([1, 1, 0])),
    ]
}

fn seven_vertex_torus() -> TriangleMesh {
    let faces =
        (0..7u32).flat_map(|i| [[i, (i + 1) % 7, (i + 3) % 7], [i, (i + 3) % 7, (i + 2) % 7]]).collect();
    let positions =
        (0..7).map(|v| f64::from(v) * 2.4).map(|t| [t.cos() + 0.1 * t, t.sin(), (1.7 * t).cos()]).collect();
    TriangleMesh::new(positions, faces)
}

fn soups() -> Vec<Case> {
    let mut repeated = ball();
    let count = repeated.positions.len() as u32;
    repeated.positions.extend(repeated.positions.clone());
    repeated.positions.extend([[9.0; 3]; 50]);
    repeated.faces.iter_mut().step_by(2).for_each(|f| *f = f.map(|v| v + count));
    let mut degenerate = ball();
    degenerate.faces.extend([[0, 0, 1], [2, 3, 2], [5, 5, 5]]);
    let mut doubled = ball();
    doubled.faces.extend(doubled.faces.clone());
    let mut two_sided = ball();
    two_sided.faces.extend(two_sided.faces.clone().iter().map(|f| [f[1], f[0], f[2]]));
    let mut turned = ball();
    turned.faces.iter_mut().step_by(3).for_each(|f| f.swap(0, 1));
    let mut inside_out = ball();
    inside_out.faces.iter_mut().for_each(|f| f.swap(0, 1));
    let mut nearly = ball();
    nearly.positions.push(nearly.positions[9].map(|x| x + 1e-9));
    let face = nearly.faces.iter().position(|f| f.contains(&9)).expect("it is used");
    nearly.faces[face] =
        nearly.faces[face].map(|v| if v == 9 { nearly.positions.len() as u32 - 1 } else { v });
    vec![
        ("soup", soup(&ball()), Surface(BALL)),
        ("soup of a subdivided octahedron", soup(&subdivide(&octahedron(), 3)), Surface(BALL)),
        ("repeated and unused vertices", repeated, Surface(BALL)),
        ("faces with a repeated corner", degenerate, Surface(BALL)),
        ("every face twice", doubled, Surface(BALL)),
        ("every face from both sides", two_sided, Surface(BALL)),
        ("every third face turned", turned, Surface(BALL)),
        ("inside out", inside_out, Surface(BALL)),
        ("two vertices nearly at one place", nearly, Surface([1, 0, 1])),
    ]
}

fn no_manifolds() -> Vec<Case> {
    let mut finned = ball();
    finned.positions.push([2.0, 2.0, 2.0]);
    let [a, b, _] = finned.faces[7];
    finned.faces.push([a, b, finned.positions.len() as u32 - 1]);
    let pages: Vec<TriangleMesh> = (0..5)
        .map(|page| f64::from(page) / 5.0 * TAU)
        .map(|angle| {
            plain_grid(
                4,
                6,
                move |u, v| if u == 0.0 { [0.0, 0.0, v] } else { [u * angle.cos(), u * angle.sin(), v] },
            )
        })
        .collect();
    let edge = welded(&joined(&[cube([0.0; 3]), cube([1.0, 3.0, 0.0])]));
    let corner = welded(&joined(&[cube([0.0; 3]), cube([1.0, 3.0, 1.0])]));
    let mut bow = joined(&[triangle(), moved(&triangle(), |p| [-p[0], -p[1], p[2]])]);
    bow = welded(&bow);
    let pinched = welded(&moved(&torus(12, 16), |p| {
        let near = p[0] > 0.5 && p[1].abs() < 1e-9;
        if near { [1.0, 0.0, 0.0] } else { p }
    }));
    let mut hairy = ball();
    for face in (0..40).step_by(5) {
        let [a, b, _] = hairy.faces[face];
        let p = hairy.positions[a as usize].map(|x| 1.4 * x);
        hairy.positions.push(p);
        hairy.faces.push([a, b, hairy.positions.len() as u32 - 1]);
    }
    vec![
        ("fin on an edge", finned, Surface([2, 0, 1])),
        ("book of five pages", welded(&joined(&pages)), Surface([5, 0, 5])),
        ("two cubes along an edge", edge, Surface([2, 0, 0])),
        ("two cubes at a corner", corner, Surface([2, 0, 0])),
        ("bow tie", bow, Surface([2, 0, 2])),
        ("pinched torus", pinched, Surface(BALL)),
        ("hairy ball", hairy, Surface([9, 0, 8])),
        ("wall through a ball", walled(), Something),
    ]
}

/// A ball with a disc over its equator: three sheets meet all round.
fn walled() -> TriangleMesh {
    let ball = subdivide(&octahedron(), 3);
    let mut mesh = ball.clone();
    let centre = mesh.positions.len() as u32;
    mesh.positions.push([0.0; 3]);
    for f in &ball.faces {
        for k in 0..3 {
            let (a, b) = (f[k], f[(k + 1) % 3]);
            if a < b && ball.positions[a as usize][2] == 0.0 && ball.positions[b as usize][2] == 0.0 {
                mesh.faces.push([a, b, centre]);
            }
        }
    }
    mesh
}

fn one_sided() -> Vec<Case> {
    // The last column is the first one, upside down or not.
    let band = |columns: u32, rows: u32| {
        grid(
            [columns, rows],
            move |i, j| if i == columns { (rows - j) * (columns + 1) } else { j * (columns + 1) + i },
            |u, v| {
                let (turn, half, off) = (TAU * u, TAU * u * 0.5, v - 0.5);
                let ring = 1.0 + off * half.cos();
                [ring * turn.cos(), ring * turn.sin(), off * half.sin()]
            },
        )
    };
    let (columns, rows) = (24, 10);
    let bottle = grid(
        [columns, rows],
        |i, j| match (i % columns, j % rows) {
            (0, j) if i == columns => ((rows - j) % rows) * (columns + 1),
            (i, j) => j * (columns + 1) + i,
        },
        |u, v| {
            let (turn, half, round) = (TAU * u, TAU * u * 0.5, TAU * v);
            let (s, t) = (round.sin(), (2.0 * round).sin());
            let ring = 2.0 + half.cos() * s - half.sin() * t;
            [ring * turn.cos(), ring * turn.sin(), half.sin() * s + half.cos() * t]
        },
    );
    let plane = [
        [0, 1, 4],
        [0, 1, 5],
        [0, 2, 3],
        [0, 2, 5],
        [0, 3, 4],
        [1, 2, 3],
        [1, 2, 4],
        [1, 3, 5],
        [2, 4, 5],
        [3, 4, 5],
    ];
    let positions = (0..6).map(|v| f64::from(v) * 1.9).map(|t| [t.cos(), t.sin(), (0.7 * t).sin()]).collect();
    let plane = TriangleMesh::new(positions, plane.to_vec());
    vec![
        ("Möbius strip", band(20, 4), Surface([1, 0, 1])),
        ("Möbius strip of one row", band(9, 1), Something),
        ("Klein bottle", bottle, Something),
        ("projective plane of six vertices", plane.clone(), Something),
        ("projective plane", subdivide(&plane, 2), Something),
    ]
}

fn flat_and_thin() -> Vec<Case> {
    let flat = plain_grid(20, 15, |u, v| [u, 0.7 * v, 0.0]);
    let mut holed = flat.clone();
    holed.faces.retain(|f| {
        let [x, y, _] = flat.positions[f[0] as usize];
        (x - 0.4).abs() > 0.1 || (y - 0.3).abs() > 0.1
    });
    let tube = |length: f64| {
        grid([8, 60], |i, j| j * 9 + i % 8, move |u, v| [(TAU * u).cos(), (TAU * u).sin(), length * v])
    };
    let mut line = plain_grid(6, 6, |u, v| [u + v, u + v, u + v]);
    line.faces.push([0, 1, 2]);
    let mut slivered = ball();
    for face in (0..100).step_by(9) {
        slivered = split_edge(&slivered, face);
    }
    let fan = |corners: u32| {
        let positions =
            (0..=corners).map(|k| f64::from(k) / f64::from(corners)).map(|t| [t, 1e-4 * t * t, 0.0]);
        let positions: Vec<[f64; 3]> = std::iter::once([0.0, -1.0, 0.0]).chain(positions).collect();
        TriangleMesh::new(positions, (0..corners).map(|k| [0, k + 1, k + 2]).collect())
    };
    vec![
        ("flat sheet", flat, Surface([1, 0, 1])),
        ("flat sheet with a hole", holed, Something),
        (
            "flat disc of split triangles",
            moved(&subdivide(&disc(7), 2), |p| [p[0], p[1], 0.0]),
            Surface([1, 0, 1]),
        ),
        ("ball pressed flat", moved(&ball(), |p| [p[0], p[1], 0.0]), Surface(BALL)),
        ("needle, a thousand to one", split_edge(&tube(2e3), 9), Surface([1, 0, 2])),
        ("needle, a million to one", split_edge(&tube(2e6), 9), Surface([1, 0, 2])),
        ("all on one line", line, Refused("no face with area")),
        ("slivers without area", slivered, Surface(BALL)),
        ("fan of needles", fan(150), Surface([1, 0, 1])),
        ("strip of one row", plain_grid(200, 1, |u, v| [40.0 * u, v, (9.0 * u).sin()]), Surface([1, 0, 1])),
    ]
}

fn scales() -> Vec<Case> {
    let far = |offset: f64| moved(&ball(), |p| [p[0] + offset, p[1] - offset, p[2] + 0.3 * offset]);
    let stray = joined(&[ball(), moved(&triangle(), |p| [p[0] + 1e7, p[1], p[2]])]);
    vec![
        ("as large as can be read", scaled(&ball(), 0.9e30), Surface(BALL)),
        ("tiny, 1e-30", scaled(&ball(), 1e-30), Surface(BALL)),
        ("tiny, 1e-150", scaled(&ball(), 1e-150), Refused("too small")),
        ("tiny beyond squaring", scaled(&ball(), 1e-250), Refused("too small")),
        ("far away, 1e7", far(1e7), Surface(BALL)),
        ("so far away that it is coarse, 1e15", far(1e15), Something),
        ("so far away that it is nothing, 1e25", far(1e25), Refused("no face with area")),
        ("a ball and a triangle far away", stray, Something),
        ("scales a million apart", moved(&ball(), |p| [p[0] * 1e6, p[1], p[2] * 1e-6]), Something),
    ]
}

fn many() -> Vec<Case> {
    let mut numbers = Numbers(7);
    let zoo: Vec<TriangleMesh> = (0..30)
        .map(|k| match k % 3 {
            0 => bumped(&subdivide(&tetrahedron(), 1)),
            1 => scaled(&torus(4, 5), 0.8),
            _ => disc(3 + k),
        })
        .collect();
    let mut dust = |count: usize, size: f64| {
        let parts = (0..count).map(|_| {
            let middle: [f64; 3] = std::array::from_fn(|_| numbers.signed());
            moved(&tetrahedron(), |p| std::array::from_fn(|k| middle[k] + size * p[k]))
        });
        joined(&parts.collect::<Vec<_>>())
    };
    let specks = joined(&[ball(), dust(10_000, 1e-9)]);
    let dust = dust(2_500, 0.004);
    let nested: Vec<TriangleMesh> = (1..9).map(|k| scaled(&ball(), f64::from(k))).collect();
    vec![
        ("genus 2", split_edge(&double_torus(), 3), Surface([1, 2, 0])),
        ("genus 130", split_edge(&pretzel(130), 3), Surface([1, 130, 0])),
        ("thirty components", together(&zoo), Surface([30, 10, 10])),
        ("dust of 10,000 faces", dust, Surface([2500, 0, 0])),
        ("a ball and 10,000 specks", specks, Surface(BALL)),
        ("nested balls", joined(&nested), Surface([8, 0, 0])),
    ]
}

fn crossing() -> Vec<Case> {
    let through = joined(&[ball(), moved(&ball(), |p| [p[0] + 0.7, p[1], p[2]])]);
    let knotted = bumped(&moved(&split_edge(&torus(8, 40), 0), |p| [p[0] * p[1], p[1], p[2] + p[0]]));
    let mut numbers = Numbers(3);
    let mut spiky = ball();
    spiky.positions.iter_mut().for_each(|p| *p = p.map(|x| x * (1.0 + 0.4 * numbers.signed())));
    let mut corner = || std::array::from_fn(|_| numbers.signed());
    let heap = TriangleMesh::new(
        (0..600).map(|_| corner()).collect(),
        (0..200).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect(),
    );
    let tangle = TriangleMesh::new(
        (0..40).map(|_| corner()).collect(),
        (0..300).map(|_| std::array::from_fn(|_| numbers.below(40))).collect(),
    );
    vec![
        ("two balls through each other", through, Surface([2, 0, 0])),
        ("torus through itself", knotted, Something),
        ("ball of spikes", spiky, Surface(BALL)),
        ("heap of triangles", heap, Surface([200, 0, 200])),
        ("tangle of forty vertices", tangle, Something),
    ]
}

fn open() -> Vec<Case> {
    let sieve = {
        let mut sheet = plain_grid(21, 21, |u, v| [u, v, 0.1 * (5.0 * u).sin()]);
        let faces = std::mem::take(&mut sheet.faces);
        let keep = |square: u32| !(square % 21 % 2 == 1 && square / 21 % 2 == 1);
        sheet.faces = faces
            .chunks(2)
            .zip(0..)
            .filter(|(_, square)| keep(*square))
            .flat_map(|(f, _)| f.to_vec())
            .collect();
        sheet
    };
    let mut slit = ball();
    slit.faces.remove(40);
    vec![
        ("open fan of 100", disc(100), Surface([1, 0, 1])),
        ("poles of valence 300", bumped(&bipyramid(300)), Surface(BALL)),
        ("sieve of 100 holes", sieve, Surface([1, 0, 101])),
        ("ball without one face", slit, Surface([1, 0, 1])),
        (
            "tube of three sides",
            grid([3, 9], |i, j| j * 4 + i % 3, |u, v| [(TAU * u).cos(), (TAU * u).sin(), 3.0 * v]),
            Surface([1, 0, 2]),
        ),
    ]
}

fn nothing() -> Vec<Case> {
    let point = TriangleMesh::new(vec![[1.0, 2.0, 3.0]; 9], vec![[0, 1, 2], [3, 4, 5], [6, 7, 8]]);
    let repeated = TriangleMesh::new(vec![[0.0; 3], [1.0; 3]], vec![[0, 0, 1], [1, 1, 0]]);
    let no_faces = TriangleMesh::new(octahedron().positions, Vec::new());
    vec![
        ("no vertex", TriangleMesh::default(), Refused("no faces")),
        ("no face", no_faces, Refused("no faces")),
        ("all at one point", point, Refused("no face with area")),
        ("repeated corners only", repeated, Refused("no face with area")),
        ("subdivided triangle without area", scaled(&subdivide(&triangle(), 2), 0.0), Refused("")),
    ]
}
