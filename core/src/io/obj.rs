//! Wavefront OBJ.
//!
//! Reading takes two steps. The first checks the `v` and `f` lines, for `tobj`, which parses them in the
//! second, names no line in its errors, takes NaN for a number, overflows on far negative indices, and
//! refuses lines carried on with `\` or colours on some vertices only. What passes is handed on as a
//! clean text that holds those lines and nothing else: three coordinates a vertex, plain absolute
//! indices, no groups, objects or materials (at which `tobj` would start a mesh with its own numbering).
//!
//! `tobj` numbers vertices by first use. So the clean text begins its faces with one polygon of all
//! vertices in order, which pins every number to the file's own; that polygon is taken off again.
//!
//! Read: `v` (a weight or a colour after the coordinates is ignored) and `f` with `v`, `v/vt`, `v//vn` and
//! `v/vt/vn` corners, absolute or relative; `l` and `s`, which mark sharp edges. All other keywords are passed over.

use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};

use super::polygon::triangulate;
use super::text::{ContinuedLines, Decimal, Lines, coordinates, whole, words};
use super::watch::{Watch, WatchedBytes};
use super::{Defect, LARGEST_COUNT, Parsed, Place};
use crate::mesh::TriangleMesh;
use marks::Marks;

mod marks;

/// Parses a whole file.
pub(super) fn parse(bytes: &[u8], watch: &Watch<'_>) -> Parsed<TriangleMesh> {
    let (mut clean, vertices) = clean_vertices(bytes, watch)?;
    let marks = clean_faces(bytes, vertices, &mut clean, watch)?;
    let parsed = parse_clean(&clean, watch);
    watch.ask()?;
    let parsed = parsed.ok_or((Place::Whole, Defect::Parser))?;
    drop(clean);
    let (positions, corners, arities) =
        without_numbering(parsed, vertices as usize).ok_or((Place::Whole, Defect::Parser))?;
    let faces = triangulate(&positions, &corners, &arities)?;
    let sharp = marks.sharp_edges(&faces, &arities);
    Ok(TriangleMesh::new(positions, faces).with_sharp_edges(sharp))
}

/// The checked `v` lines, one a line, and how many there are.
fn clean_vertices(bytes: &[u8], watch: &Watch<'_>) -> Parsed<(Vec<u8>, u64)> {
    let mut clean = Vec::new();
    let mut vertices = 0u64;
    for (number, line) in ContinuedLines(Lines::new(bytes)) {
        watch.pass()?;
        let mut words = words(&line);
        if words.next() != Some(b"v") {
            continue;
        }
        clean.push(b'v');
        let copied = words.inspect(|word| {
            clean.push(b' ');
            clean.extend_from_slice(word);
        });
        coordinates(copied).map_err(|defect| (Place::Line(number), defect))?;
        clean.push(b'\n');
        vertices += 1;
    }
    match vertices {
        0 => Err((Place::Whole, Defect::NoVertices)),
        1..=LARGEST_COUNT => Ok((clean, vertices)),
        _ => Err((Place::Whole, Defect::TooMany { what: "vertices" })),
    }
}

/// Appends the polygon that fixes the numbering and the checked `f` lines with absolute indices; gives what marks edges.
fn clean_faces(bytes: &[u8], vertices: u64, clean: &mut Vec<u8>, watch: &Watch<'_>) -> Parsed<Marks> {
    clean.push(b'f');
    (1..=vertices).for_each(|vertex| push_index(clean, vertex));
    clean.push(b'\n');

    let mut faces = 0u64;
    let mut preceding = 0u64;
    let mut marks = Marks::default();
    for (number, line) in ContinuedLines(Lines::new(bytes)) {
        watch.pass()?;
        let mut words = words(&line);
        match words.next() {
            Some(b"v") => preceding += 1,
            Some(b"f") => {
                faces += 1;
                clean.push(b'f');
                let mut found = 0u64;
                for corner in words {
                    let vertex = absolute_index(corner, preceding, vertices);
                    push_index(clean, vertex.map_err(|defect| (Place::Line(number), defect))?);
                    found += 1;
                }
                if found < 3 {
                    return Err((Place::Line(number), Defect::TooFewCorners { found }));
                }
                clean.push(b'\n');
            }
            Some(b"l") => {
                marks.line(words, preceding, vertices).map_err(|defect| (Place::Line(number), defect))?;
            }
            Some(b"s") => marks.group(words.next(), faces),
            _ => {}
        }
    }
    match faces {
        0 => Err((Place::Whole, Defect::NoFaces)),
        1..=LARGEST_COUNT => Ok(marks),
        _ => Err((Place::Whole, Defect::TooMany { what: "faces" })),
    }
}

fn push_index(clean: &mut Vec<u8>, index: u64) {
    clean.push(b' ');
    clean.extend_from_slice(index.to_string().as_bytes());
}

/// The vertex, counted from 1, that a corner such as `7`, `7/2` or `-1//3` refers to. Positive indices
/// may refer to vertices that come later in the file, negative ones count back from the face's line.
fn absolute_index(corner: &[u8], preceding: u64, vertices: u64) -> Result<u64, Defect> {
    let digits = corner.split(|&byte| byte == b'/').next().unwrap_or(corner);
    let index = whole(digits).map_err(|_| Defect::NotAnIndex { token: super::error::excerpt(corner) })?;
    let magnitude = index.unsigned_abs();
    match index {
        0 => Err(Defect::IndexZero),
        1.. if magnitude > vertices => Err(Defect::IndexBeyond { index, vertices, base: 1 }),
        1.. => Ok(magnitude),
        _ if magnitude > preceding => Err(Defect::IndexBefore { back: magnitude, vertices: preceding }),
        _ => Ok(preceding - magnitude + 1),
    }
}

/// What `tobj` makes of a clean text; `None` if it fails after all, or is to stop.
fn parse_clean(clean: &[u8], watch: &Watch<'_>) -> Option<tobj::Mesh> {
    let options = tobj::LoadOptions {
        single_index: false,
        triangulate: false,
        ignore_points: false,
        ignore_lines: false,
    };
    let no_materials = |_: &std::path::Path| Err(tobj::LoadError::OpenFileFailed);
    let mut clean = WatchedBytes::new(clean, watch);
    let parsed = catch_unwind(AssertUnwindSafe(|| tobj::load_obj_buf(&mut clean, &options, no_materials)));
    let (models, _) = parsed.ok()?.ok()?;
    let mut models = models.into_iter();
    let model = models.next()?;
    models.next().is_none().then_some(model.mesh)
}

/// Positions, corners and arities without the first polygon; `None` if that did not fix the numbering.
#[expect(clippy::type_complexity, reason = "three parallel arrays, taken apart by the only caller")]
fn without_numbering(mesh: tobj::Mesh, vertices: usize) -> Option<(Vec<[f64; 3]>, Vec<u32>, Vec<u32>)> {
    let positions: Vec<[f64; 3]> = mesh.positions.as_chunks().0.to_vec();
    let mut corners = mesh.indices;
    let mut arities = mesh.face_arities;
    if arities.is_empty() {
        // How tobj says that every face is a triangle.
        arities = vec![3; corners.len() / 3];
    }
    let numbered = corners.len() >= vertices && (0u32..).zip(&corners[..vertices]).all(|(i, &v)| i == v);
    let complete = arities.iter().map(|&arity| u64::from(arity)).sum::<u64>() == corners.len() as u64;
    if positions.len() != vertices || !numbered || !complete || arities.first() != Some(&(vertices as u32)) {
        return None;
    }
    corners.drain(..vertices);
    arities.remove(0);
    Some((positions, corners, arities))
}

/// Writes `v` and `f` lines, and an `l` line for each sharp edge.
pub(super) fn write(mesh: &TriangleMesh, out: &mut dyn Write) -> std::io::Result<()> {
    writeln!(out, "# Bozzetto: {} vertices, {} faces", mesh.positions.len(), mesh.faces.len())?;
    for &[x, y, z] in &mesh.positions {
        writeln!(out, "v {} {} {}", Decimal(x), Decimal(y), Decimal(z))?;
    }
    for &[a, b, c] in &mesh.faces {
        writeln!(out, "f {} {} {}", u64::from(a) + 1, u64::from(b) + 1, u64::from(c) + 1)?;
    }
    for &[a, b] in &mesh.sharp_edges {
        writeln!(out, "l {} {}", u64::from(a) + 1, u64::from(b) + 1)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests;
