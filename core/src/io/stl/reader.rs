//! Reading STL: triangles whose corners at the same place become one vertex.
//!
//! Vertices are the distinct positions in order of first use (0 and −0 are one place), compared exactly as
//! the file gives them: `f32` in binary, decimals in text. Normals and attributes are passed over; several
//! solids in one text become one mesh. Many binary files begin with the word `solid` too, so a file whose
//! length fits the count in its header is binary, and so is one with a zero byte before its first face.

use std::collections::HashMap;

use crate::io::polygon::triangulate;
use crate::io::text::{Decimal, Lines, check_coordinate, coordinates, words};
use crate::io::watch::Watch;
use crate::io::{Defect, LARGEST_COUNT, Parsed, Place, with_room};
use crate::mesh::TriangleMesh;

/// Bytes before the first face of a binary file: 80 of any kind and the count.
const BINARY_HEADER: usize = 84;
/// Bytes of a face in a binary file: normal, corners, two of any kind.
const BINARY_FACE: usize = 50;

/// Parses a whole file.
pub(in crate::io) fn parse(bytes: &[u8], watch: &Watch) -> Parsed<TriangleMesh> {
    let count = bytes
        .get(80..BINARY_HEADER)
        .map(|count| u32::from_le_bytes([count[0], count[1], count[2], count[3]]));
    let fits = |count: u32| binary_length(count) == bytes.len() as u64;
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    let named = text.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    let printable = !bytes[..bytes.len().min(BINARY_HEADER)].contains(&0);
    match count {
        Some(count) if fits(count) || !(named && printable) => parse_binary(bytes, count, watch),
        _ if named => parse_text(bytes, watch),
        _ => {
            let reason = "it does not begin with 'solid' and is too short for the binary form".to_owned();
            Err((Place::Whole, Defect::NotThisFormat { format: "an STL file", reason }))
        }
    }
}

fn binary_length(faces: u32) -> u64 {
    BINARY_HEADER as u64 + BINARY_FACE as u64 * u64::from(faces)
}

fn parse_binary(bytes: &[u8], declared: u32, watch: &Watch) -> Parsed<TriangleMesh> {
    if declared == 0 {
        return Err((Place::Whole, Defect::NoFaces));
    }
    if binary_length(declared) > bytes.len() as u64 {
        let (what, bytes) = ("faces".to_owned(), (bytes.len() - BINARY_HEADER) as u64);
        return Err((Place::Whole, Defect::Oversized { what, declared: declared.into(), bytes }));
    }
    let mut places = Places::default();
    let mut faces = with_room(declared as usize)?;
    let records = bytes[BINARY_HEADER..].chunks_exact(BINARY_FACE).take(declared as usize);
    for (index, record) in (0u64..).zip(records) {
        watch.pass()?;
        let place = || Place::Element { name: "face".to_owned(), index };
        let mut corners = [0; 3];
        for (corner, vector) in corners.iter_mut().zip(record[12..48].as_chunks::<12>().0) {
            let mut position = [0.0; 3];
            for (x, &bytes) in position.iter_mut().zip(vector.as_chunks().0) {
                let given = f64::from(f32::from_le_bytes(bytes));
                *x = check_coordinate(given, || Decimal(given).to_string())
                    .map_err(|defect| (place(), defect))?;
            }
            *corner = places.vertex(position)?;
        }
        faces.push(corners);
    }
    Ok(TriangleMesh::new(places.positions, faces))
}

/// Only `vertex`, `endloop` and the ends of solids count; all other words are passed over. A loop of more than three
/// corners is cut into triangles.
fn parse_text(bytes: &[u8], watch: &Watch) -> Parsed<TriangleMesh> {
    let mut places = Places::default();
    let (mut corners, mut arities) = (Vec::new(), Vec::new());
    let (mut open, mut ended) = (0u32, false);
    for (number, line) in Lines::new(bytes) {
        watch.pass()?;
        let mut words = words(line);
        while let Some(word) = words.next() {
            let is = |keyword: &str| word.eq_ignore_ascii_case(keyword.as_bytes());
            if is("vertex") {
                let position = coordinates(&mut words).map_err(|defect| (Place::Line(number), defect))?;
                corners.push(places.vertex(position)?);
                open += 1;
            } else if is("endloop") {
                if open < 3 {
                    return Err((Place::Line(number), Defect::TooFewCorners { found: open.into() }));
                }
                arities.push(std::mem::take(&mut open));
            } else if is("solid") || is("endsolid") {
                // The rest of the line is a name.
                ended = is("endsolid");
                break;
            }
        }
    }
    if open > 0 || !ended {
        return Err((Place::Whole, Defect::CutShort { part: "'endsolid'" }));
    }
    if arities.is_empty() {
        return Err((Place::Whole, Defect::NoFaces));
    }
    let faces = triangulate(&places.positions, &corners, &arities)?;
    Ok(TriangleMesh::new(places.positions, faces))
}

/// The distinct positions so far, and the number of each. The map's own hash function cannot be driven into
/// collisions by a file.
#[derive(Default)]
struct Places {
    positions: Vec<[f64; 3]>,
    numbers: HashMap<[u64; 3], u32>,
}

impl Places {
    fn vertex(&mut self, position: [f64; 3]) -> Parsed<u32> {
        // Adding 0 makes −0 and 0 the same.
        let key = position.map(|x| (x + 0.0).to_bits());
        if let Some(&vertex) = self.numbers.get(&key) {
            return Ok(vertex);
        }
        let vertex = self.positions.len() as u64;
        if vertex >= LARGEST_COUNT {
            return Err((Place::Whole, Defect::TooMany { what: "vertices" }));
        }
        let room = self.numbers.try_reserve(1).is_ok() && self.positions.try_reserve(1).is_ok();
        if !room {
            return Err((Place::Whole, Defect::OutOfMemory));
        }
        self.numbers.insert(key, vertex as u32);
        self.positions.push(position);
        Ok(vertex as u32)
    }
}
