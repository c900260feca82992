//! Stanford PLY: ASCII and binary of either byte order in, binary little-endian out.
//!
//! `ply-rs-bw` parses the header and, one at a time, the elements; everything around that is here, because
//! it has to know how many elements there can be before it believes a header. Read are the scalar
//! properties `x`, `y`, `z` of `vertex`, of any number type, the list `vertex_indices` or `vertex_index` of
//! `face`, of any integer type, and `vertex1` and `vertex2` of `edge`, which mark sharp edges. Other properties
//! and elements are passed over.

use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};

use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType,
};

use super::error::excerpt;
use super::polygon::Polygons;
use super::text::{Decimal, Lines, check_coordinate, index_from_zero};
use super::watch::Watch;
use super::{Defect, Parsed, Place, with_room};
use crate::mesh::TriangleMesh;
use edge::Edge;

mod edge;
mod header;

/// Parses a whole file.
pub(super) fn parse(bytes: &[u8], watch: &Watch<'_>) -> Parsed<TriangleMesh> {
    let parsed = catch_unwind(AssertUnwindSafe(|| parse_unguarded(bytes, watch)));
    parsed.unwrap_or(Err((Place::Whole, Defect::Parser)))
}

fn parse_unguarded(bytes: &[u8], watch: &Watch<'_>) -> Parsed<TriangleMesh> {
    let (header, payload, lines) = header::read(bytes)?;
    header::check(&header, payload.len() as u64)?;
    let vertices = header.elements.get("vertex").map_or(0, |vertex| vertex.count);
    let mut positions: Vec<[f64; 3]> = with_room(vertices)?;
    let faces = header.elements.get("face").map_or(0, |face| face.count);
    let mut polygons = Polygons::with_room(faces)?;
    let mut corners: Vec<u32> = Vec::new();
    let mut sharp = Vec::new();

    let mut source = Source { header: &header, payload, lines: Lines::after(payload, lines) };
    for definition in header.elements.values() {
        for index in 0..definition.count as u64 {
            watch.pass()?;
            match definition.name.as_str() {
                "vertex" => {
                    let (place, vertex): (Place, Vertex) = source.element(definition, index)?;
                    positions.push(vertex.position().map_err(|defect| (place, defect))?);
                }
                "face" => {
                    let (place, face): (Place, Face) = source.element(definition, index)?;
                    face.check(vertices as u64, &mut corners).map_err(|defect| (place, defect))?;
                    polygons.push(&corners);
                }
                edge::NAME => {
                    let (place, edge): (Place, Edge) = source.element(definition, index)?;
                    sharp.extend(edge.ends(vertices as u64).map_err(|defect| (place, defect))?);
                }
                _ => drop(source.element::<Skipped>(definition, index)?),
            }
        }
    }
    let faces = polygons.into_triangles(&positions)?;
    Ok(TriangleMesh::new(positions, faces).with_sharp_edges(sharp))
}

/// The part of the file after the header.
struct Source<'a> {
    header: &'a Header,
    /// What is left of a binary payload.
    payload: &'a [u8],
    /// What is left of an ASCII payload.
    lines: Lines<'a>,
}

impl Source<'_> {
    /// The next element, which must be of `definition`, and its place.
    fn element<E: PropertyAccess>(&mut self, definition: &ElementDef, index: u64) -> Parsed<(Place, E)> {
        let parser = Parser::<E>::new();
        let truncated = || Defect::Truncated {
            what: format!("elements '{}'", excerpt(definition.name.as_bytes())),
            found: index,
            declared: definition.count as u64,
        };
        if self.header.encoding == Encoding::Ascii {
            let line = self.lines.find(|(_, line)| !line.trim_ascii().is_empty());
            let (number, line) = line.ok_or_else(|| (Place::Whole, truncated()))?;
            let place = Place::Line(number);
            return match parser.read_ascii_element(&tidy(line), definition) {
                Ok(element) => Ok((place, element)),
                Err(_) => Err((place, Defect::BadElement)),
            };
        }
        let parsed = match self.header.encoding {
            Encoding::BinaryBigEndian => parser.read_big_endian_element(&mut self.payload, definition),
            _ => parser.read_little_endian_element(&mut self.payload, definition),
        };
        let place = Place::Element { name: excerpt(definition.name.as_bytes()), index };
        match parsed {
            Ok(element) => Ok((place, element)),
            Err(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => {
                Err((Place::Whole, truncated()))
            }
            Err(_) => Err((place, Defect::BadElement)),
        }
    }
}

/// An ASCII line with its numbers in the form that `ply-rs-bw` takes: it refuses `.5`, `1.` and `nan`,
/// of which the last shall be named by the check of coordinates, so it becomes a number too large for any.
fn tidy(line: &[u8]) -> String {
    let mut tidy = String::with_capacity(line.len() + 8);
    for word in line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()) {
        let word = String::from_utf8_lossy(word);
        let plain = word.ends_with(|c: char| c.is_ascii_digit())
            && word.trim_start_matches(['-', '+']).starts_with(|c: char| c.is_ascii_digit())
            && !word.contains(".e")
            && !word.contains(".E");
        match word.parse::<f64>() {
            Ok(number) if !plain && number.is_finite() => tidy.push_str(&format!("{number:e}")),
            Ok(number) if !plain => tidy.push_str(if number < 0.0 { "-1e999" } else { "1e999" }),
            _ => tidy.push_str(&word),
        }
        tidy.push(' ');
    }
    tidy
}

/// A vertex in the making.
struct Vertex([Option<f64>; 3]);

impl Vertex {
    fn position(&self) -> Result<[f64; 3], Defect> {
        let mut position = [0.0; 3];
        for (found, (x, given)) in position.iter_mut().zip(self.0).enumerate() {
            let given = given.ok_or(Defect::TooFewCoordinates { found })?;
            *x = check_coordinate(given, || Decimal(given).to_string())?;
        }
        Ok(position)
    }
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self([None; 3])
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let axis = match name {
            "x" => 0,
            "y" => 1,
            "z" => 2,
            _ => return PropertyAccessResult::Ignored,
        };
        self.0[axis] = match property {
            Property::Char(x) => Some(x.into()),
            Property::UChar(x) => Some(x.into()),
            Property::Short(x) => Some(x.into()),
            Property::UShort(x) => Some(x.into()),
            Property::Int(x) => Some(x.into()),
            Property::UInt(x) => Some(x.into()),
            Property::Float(x) => Some(x.into()),
            Property::Double(x) => Some(x),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// A face in the making: its vertex indices as the file has them.
struct Face(Vec<i64>);

impl Face {
    /// Checks the corners and puts them in place of those of the face before.
    fn check(&self, vertices: u64, corners: &mut Vec<u32>) -> Result<(), Defect> {
        let found = self.0.len() as u64;
        if found < 3 {
            return Err(Defect::TooFewCorners { found });
        }
        corners.clear();
        for &index in &self.0 {
            corners.push(index_from_zero(index, vertices)?);
        }
        Ok(())
    }
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self(Vec::new())
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !header::VERTEX_LISTS.contains(&name) {
            return PropertyAccessResult::Ignored;
        }
        self.0 = match property {
            Property::ListChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListInt(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUInt(list) => list.into_iter().map(i64::from).collect(),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// An element that is read past.
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}

/// Writes binary little-endian. Coordinates are `float` where that holds every one of them exactly, else
/// `double`; vertex indices are `int`, or `uint` where an `int` could not hold them. Sharp edges, if there are any, are
/// elements `edge`.
pub(super) fn write(mesh: &TriangleMesh, out: &mut dyn Write) -> std::io::Result<()> {
    let single = mesh.positions.iter().flatten().all(|&x| f64::from(x as f32) == x);
    let coordinate = if single { "float" } else { "double" };
    let index = if mesh.positions.len() <= i32::MAX as usize { "int" } else { "uint" };
    writeln!(out, "ply\nformat binary_little_endian 1.0\ncomment Bozzetto")?;
    writeln!(out, "element vertex {}", mesh.positions.len())?;
    ["x", "y", "z"].iter().try_for_each(|axis| writeln!(out, "property {coordinate} {axis}"))?;
    writeln!(out, "element face {}", mesh.faces.len())?;
    writeln!(out, "property list uchar {index} vertex_indices")?;
    if !mesh.sharp_edges.is_empty() {
        writeln!(out, "element {} {}", edge::NAME, mesh.sharp_edges.len())?;
        edge::ENDS.iter().try_for_each(|end| writeln!(out, "property {index} {end}"))?;
    }
    writeln!(out, "end_header")?;
    for x in mesh.positions.iter().flatten() {
        if single {
            out.write_all(&(*x as f32).to_le_bytes())?;
        } else {
            out.write_all(&x.to_le_bytes())?;
        }
    }
    for face in &mesh.faces {
        out.write_all(&[3])?;
        face.iter().try_for_each(|vertex| out.write_all(&vertex.to_le_bytes()))?;
    }
    mesh.sharp_edges.iter().flatten().try_for_each(|vertex| out.write_all(&vertex.to_le_bytes()))?;
    Ok(())
}

#[cfg(test)]
mod tests;
