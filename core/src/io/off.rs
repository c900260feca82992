//! The object file format of Geomview, OFF.
//!
//! Read line by line: an optional keyword (`OFF` with any of the prefixes `ST`, `C`, `N`), the counts on its
//! line or the next, a vertex a line, a face a line. Columns after the coordinates (normals, colours,
//! texture coordinates) and after a face's corners (colours) are ignored; a `#` begins a comment. The
//! binary and the four-dimensional variants are refused.

use std::io::Write;

use super::error::excerpt;
use super::polygon::triangulate;
use super::text::{Decimal, Lines, coordinates, index_from_zero, whole, words};
use super::watch::Watch;
use super::{Defect, LARGEST_COUNT, Parsed, Place, with_room};
use crate::mesh::TriangleMesh;

/// The fewest bytes of a vertex line, `0 0 0` and its end.
const LEAST_VERTEX: u64 = 6;
/// The fewest bytes of a face line, `3 0 0 0` and its end.
const LEAST_FACE: u64 = 8;

/// The lines that hold more than a comment.
struct Content<'a>(Lines<'a>);

impl<'a> Iterator for Content<'a> {
    type Item = (u64, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        self.0.find(|(_, line)| words(line).next().is_some())
    }
}

/// Parses a whole file.
pub(super) fn parse(bytes: &[u8], watch: &Watch<'_>) -> Parsed<TriangleMesh> {
    let mut lines = Content(Lines::new(bytes));
    let [vertices, faces] = read_counts(&mut lines)?;
    let length = bytes.len() as u64;
    for (what, declared, least) in [("vertices", vertices, LEAST_VERTEX), ("faces", faces, LEAST_FACE)] {
        if declared > LARGEST_COUNT {
            return Err((Place::Whole, Defect::TooMany { what }));
        }
        // One more byte: the last line may lack its end.
        if declared * least > length + 1 {
            return Err((Place::Whole, Defect::Oversized { what: what.to_owned(), declared, bytes: length }));
        }
    }
    if vertices == 0 {
        return Err((Place::Whole, Defect::NoVertices));
    }
    if faces == 0 {
        return Err((Place::Whole, Defect::NoFaces));
    }
    let positions = read_positions(&mut lines, vertices, watch)?;
    let (corners, arities) = read_polygons(&mut lines, faces, vertices, watch)?;
    let faces = triangulate(&positions, &corners, &arities)?;
    Ok(TriangleMesh::new(positions, faces))
}

/// The counts of vertices and faces; that of edges, which follows, is not needed.
fn read_counts(lines: &mut Content<'_>) -> Parsed<[u64; 2]> {
    let not_off = |line: &[u8]| Defect::NotThisFormat {
        format: "an OFF file",
        reason: format!("it begins with '{}'", excerpt(words(line).next().unwrap_or_default())),
    };
    let (mut number, mut line) = lines.next().ok_or((Place::Whole, Defect::Empty))?;
    let trimmed = line.trim_ascii();
    let begins_with_digit = trimmed.first().is_some_and(u8::is_ascii_digit);
    let keyword_end = trimmed.windows(3).position(|window| window == b"OFF").map(|start| start + 3);
    let after = match keyword_end {
        Some(end) if is_keyword(&trimmed[..end]) => &trimmed[end..],
        // The keyword may be left out.
        _ if begins_with_digit && !trimmed.starts_with(b"4OFF") => trimmed,
        _ => return Err((Place::Line(number), not_off(trimmed))),
    };
    if after.trim_ascii_start().starts_with(b"BINARY") {
        let problem = "the binary variant of OFF is not read".to_owned();
        return Err((Place::Line(number), Defect::Header { problem }));
    }
    line = after;
    if words(line).next().is_none() {
        let missing = Defect::Header { problem: "the counts of vertices and faces are missing".to_owned() };
        (number, line) = lines.next().ok_or((Place::Whole, missing))?;
    }
    let mut counts = words(line).map(|word| whole(word).ok().and_then(|count| u64::try_from(count).ok()));
    match (counts.next().flatten(), counts.next().flatten()) {
        (Some(vertices), Some(faces)) => Ok([vertices, faces]),
        _ => {
            let problem =
                format!("'{}' are not the counts of vertices and faces", excerpt(line.trim_ascii()));
            Err((Place::Line(number), Defect::Header { problem }))
        }
    }
}

/// `OFF` with any of the prefixes `ST`, `C` and `N`, in that order.
fn is_keyword(word: &[u8]) -> bool {
    let strip = |word: &mut &[u8], prefix: &[u8]| *word = word.strip_prefix(prefix).unwrap_or(word);
    let mut rest = word;
    [&b"ST"[..], b"C", b"N"].into_iter().for_each(|prefix| strip(&mut rest, prefix));
    rest == b"OFF"
}

fn read_positions(lines: &mut Content<'_>, vertices: u64, watch: &Watch<'_>) -> Parsed<Vec<[f64; 3]>> {
    let mut positions = with_room(vertices as usize)?;
    for found in 0..vertices {
        watch.pass()?;
        let truncated = Defect::Truncated { what: "vertices".to_owned(), found, declared: vertices };
        let (number, line) = lines.next().ok_or((Place::Whole, truncated))?;
        positions.push(coordinates(words(line)).map_err(|defect| (Place::Line(number), defect))?);
    }
    Ok(positions)
}

/// The corners of all polygons and how many each has.
fn read_polygons(
    lines: &mut Content<'_>,
    faces: u64,
    vertices: u64,
    watch: &Watch<'_>,
) -> Parsed<(Vec<u32>, Vec<u32>)> {
    let mut corners = Vec::new();
    let mut arities = with_room(faces as usize)?;
    for found in 0..faces {
        watch.pass()?;
        let truncated = Defect::Truncated { what: "faces".to_owned(), found, declared: faces };
        let (number, line) = lines.next().ok_or((Place::Whole, truncated))?;
        let arity =
            read_polygon(line, vertices, &mut corners).map_err(|defect| (Place::Line(number), defect))?;
        arities.push(arity);
    }
    Ok((corners, arities))
}

fn read_polygon(line: &[u8], vertices: u64, corners: &mut Vec<u32>) -> Result<u32, Defect> {
    let mut words = words(line);
    let arity = whole(words.next().unwrap_or_default())?;
    let too_few = |found| Defect::TooFewCorners { found };
    // Longer than any line, so the missing corners are noticed below.
    let arity = u32::try_from(arity.max(0)).unwrap_or(u32::MAX);
    if arity < 3 {
        return Err(too_few(u64::from(arity)));
    }
    for _ in 0..arity {
        let word = words.next().ok_or(Defect::BadElement)?;
        corners.push(index_from_zero(whole(word)?, vertices)?);
    }
    Ok(arity)
}

/// Writes the keyword, the counts, the vertices and the faces.
pub(super) fn write(mesh: &TriangleMesh, out: &mut dyn Write) -> std::io::Result<()> {
    writeln!(out, "OFF\n{} {} 0", mesh.positions.len(), mesh.faces.len())?;
    for &[x, y, z] in &mesh.positions {
        writeln!(out, "{} {} {}", Decimal(x), Decimal(y), Decimal(z))?;
    }
    for &[a, b, c] in &mesh.faces {
        writeln!(out, "3 {a} {b} {c}")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests;
