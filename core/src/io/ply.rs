//! Stanford PLY: ASCII and binary of either byte order in, binary little-endian out.
//!
//! `ply-rs-bw` parses the header and, one at a time, the elements; everything around that is here, because
//! it has to know how many elements there can be before it believes a header. Read are the scalar
//! properties `x`, `y`, `z` of `vertex`, of any number type, the list `vertex_indices` or `vertex_index` of
//! `face`, of any integer type, and `vertex1` and `vertex2` of `edge`, which mark sharp edges. Other properties
//! and elements are passed over.

use std::io::{BufRead, Read, Write};
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

/// Parses a file of `length` bytes. Binary elements are read as the file comes, text only when all of it is there.
pub(super) fn parse(file: &mut impl BufRead, length: u64, watch: &Watch<'_>) -> Parsed<TriangleMesh> {
    let parsed = catch_unwind(AssertUnwindSafe(|| parse_unguarded(file, length, watch)));
    parsed.unwrap_or(Err((Place::Whole, Defect::Parser)))
}

fn parse_unguarded(file: &mut impl BufRead, length: u64, watch: &Watch<'_>) -> Parsed<TriangleMesh> {
    let text = header::take(file)?;
    let header = header::read(&text)?;
    header::check(&header, length.saturating_sub(text.len()))?;
    if header.encoding == Encoding::Ascii {
        let mut payload = Vec::new();
        let whole = file.read_to_end(&mut payload);
        whole.map_err(|_| (Place::Whole, Defect::OutOfMemory))?;
        return Source { header: &header, payload: Ascii(Lines::after(&payload, text.lines)) }.mesh(watch);
    }
    Source { header: &header, payload: Binary(file) }.mesh(watch)
}

/// Where elements come from.
trait Payload {
    /// Reads an element of `definition`; its place, or where that is not known before it is there, `None`.
    fn element<E: PropertyAccess>(&mut self, encoding: Encoding, definition: &ElementDef) -> Element<E>;
}

/// An element, or why there is none.
enum Element<E> {
    /// It, with its line if the file has lines.
    Here(E, Option<u64>),
    /// The file ends before it.
    Missing,
    /// It cannot be read.
    Bad(Option<u64>),
}

/// What is left of a binary file.
struct Binary<'a, R>(&'a mut R);

impl<R: BufRead> Payload for Binary<'_, R> {
    fn element<E: PropertyAccess>(&mut self, encoding: Encoding, definition: &ElementDef) -> Element<E> {
        let parser = Parser::<E>::new();
        let parsed = match encoding {
            Encoding::BinaryBigEndian => parser.read_big_endian_element(self.0, definition),
            _ => parser.read_little_endian_element(self.0, definition),
        };
        match parsed {
            Ok(element) => Element::Here(element, None),
            Err(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => Element::Missing,
            Err(_) => Element::Bad(None),
        }
    }
}

/// What is left of a text.
struct Ascii<'a>(Lines<'a>);

impl Payload for Ascii<'_> {
    fn element<E: PropertyAccess>(&mut self, _: Encoding, definition: &ElementDef) -> Element<E> {
        let Some((number, line)) = self.0.find(|(_, line)| !line.trim_ascii().is_empty()) else {
            return Element::Missing;
        };
        match Parser::<E>::new().read_ascii_element(&tidy(line), definition) {
            Ok(element) => Element::Here(element, Some(number)),
            Err(_) => Element::Bad(Some(number)),
        }
    }
}

/// The part of the file after the header.
struct Source<'a, P> {
    header: &'a Header,
    payload: P,
}

impl<P: Payload> Source<'_, P> {
    fn mesh(mut self, watch: &Watch<'_>) -> Parsed<TriangleMesh> {
        let header = self.header;
        let vertices = header.elements.get("vertex").map_or(0, |vertex| vertex.count);
        let mut positions: Vec<[f64; 3]> = with_room(vertices)?;
        let faces = header.elements.get("face").map_or(0, |face| face.count);
        let mut polygons = Polygons::with_room(faces)?;
        let mut corners: Vec<u32> = Vec::new();
        let mut sharp = Vec::new();
        for definition in header.elements.values() {
            for index in 0..definition.count as u64 {
                watch.pass()?;
                match definition.name.as_str() {
                    "vertex" => {
                        let (place, vertex): (_, Vertex) = self.element(definition, index)?;
                        positions.push(vertex.position().map_err(|defect| (place(), defect))?);
                    }
                    "face" => {
                        let (place, face): (_, Face) = self.element(definition, index)?;
                        face.check(vertices as u64, &mut corners).map_err(|defect| (place(), defect))?;
                        polygons.push(&corners);
                    }
                    edge::NAME => {
                        let (place, edge): (_, Edge) = self.element(definition, index)?;
                        sharp.extend(edge.ends(vertices as u64).map_err(|defect| (place(), defect))?);
                    }
                    _ => drop(self.element::<Skipped>(definition, index)?),
                }
            }
        }
        let faces = polygons.into_triangles(&positions)?;
        Ok(TriangleMesh::new(positions, faces).with_sharp_edges(sharp))
    }

    /// The next element, which must be of `definition`, and how to say its place.
    fn element<'d, E: PropertyAccess>(
        &mut self,
        definition: &'d ElementDef,
        index: u64,
    ) -> Parsed<(impl Fn() -> Place + 'd, E)> {
        let place = move |line: Option<u64>| match line {
            Some(line) => Place::Line(line),
            None => Place::Element { name: excerpt(definition.name.as_bytes()), index },
        };
        match self.payload.element(self.header.encoding, definition) {
            Element::Here(element, line) => Ok((move || place(line), element)),
            Element::Bad(line) => Err((place(line), Defect::BadElement)),
            Element::Missing => {
                let what = format!("elements '{}'", excerpt(definition.name.as_bytes()));
                let declared = definition.count as u64;
                Err((Place::Whole, Defect::Truncated { what, found: index, declared }))
            }
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
