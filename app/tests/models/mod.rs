//! Model files that tests start from.
#![allow(dead_code, unreachable_pub)]

use crate::program::Workplace;
use bozzetto_core::mesh::{TriangleMesh, shapes};
use std::fmt::Write;
use std::io::Cursor;

/// A mesh as OBJ text.
pub fn obj(mesh: &TriangleMesh) -> String {
    let mut text = String::new();
    for [x, y, z] in &mesh.positions {
        writeln!(text, "v {x} {y} {z}").expect("strings grow");
    }
    for face in &mesh.faces {
        let [a, b, c] = face.map(|v| v + 1);
        writeln!(text, "f {a} {b} {c}").expect("strings grow");
    }
    text
}

/// An octahedron split `levels` times, its vertices pushed out to a sphere with a few waves on it.
pub fn wavy_ball(levels: u32) -> TriangleMesh {
    let mut mesh = shapes::subdivide(&shapes::octahedron(), levels);
    for p in &mut mesh.positions {
        let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
        let radius = 1.0 + 0.1 * (7.0 * p[0]).sin() * (5.0 * p[1]).cos();
        *p = p.map(|x| x / length * radius);
    }
    mesh
}

/// Writes the wavy ball, three levels over an octahedron, as `ball.obj`, and imports it as `ball.boz`.
pub fn ball_boz(work: &Workplace) {
    work.write("ball.obj", obj(&wavy_ball(3)));
    work.succeeds(&["import", "ball.obj", "-o", "ball.boz"]);
}

/// A 16-bit grey PNG: `value(column, row)` from 0 to 65535.
pub fn grey_png(width: u32, height: u32, value: impl Fn(u32, u32) -> u16) -> Vec<u8> {
    let picture = image::ImageBuffer::from_fn(width, height, |x, y| image::Luma([value(x, y)]));
    let mut bytes = Cursor::new(Vec::new());
    image::DynamicImage::ImageLuma16(picture).write_to(&mut bytes, image::ImageFormat::Png).expect("a PNG");
    bytes.into_inner()
}

/// The vertices and faces of an OBJ file as the program writes it.
pub fn read_obj(text: &str) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["v", x, y, z] => mesh.positions.push([x, y, z].map(|word| word.parse().expect("a number"))),
            ["f", a, b, c] => {
                mesh.faces.push([a, b, c].map(|word| word.parse::<u32>().expect("an index") - 1))
            }
            _ => {}
        }
    }
    mesh
}
