//! Wavefront OBJ.
//!
//! Read in one pass, as the file comes: of the text only a block is ever in memory. A face may refer to vertices that come
//! later, so indices beyond those so far are judged at the end; a wrong vertex is told before a wrong face, wherever they
//! stand.
//!
//! Read: `v` (a weight or a colour after the coordinates is ignored) and `f` with `v`, `v/vt`, `v//vn` and
//! `v/vt/vn` corners, absolute or relative; `l` and `s`, which mark sharp edges. All other keywords are passed over.

use std::io::{BufRead, Write};

use super::polygon::Polygons;
use super::text::{ContinuedLines, Decimal, Lines, coordinates, words};
use super::watch::Watch;
use super::{Defect, LARGEST_COUNT, Parsed, Place};
use crate::mesh::TriangleMesh;
use blocks::Blocks;
use indices::Indices;
use marks::Marks;

mod blocks;
mod indices;
mod marks;

/// Parses a whole file.
pub(super) fn parse(file: &mut impl BufRead, watch: &Watch<'_>) -> Parsed<TriangleMesh> {
    let mut model = Model::new()?;
    let mut blocks = Blocks::new(file);
    let mut read = 0;
    while let Some(block) = blocks.next() {
        let lines = if read == 0 { Lines::new(block) } else { Lines::after(block, read) };
        let mut lines = ContinuedLines(lines);
        for (number, line) in lines.by_ref() {
            watch.pass()?;
            model.line(number, &line)?;
        }
        read = lines.0.number();
    }
    watch.ask()?;
    model.finish()
}

/// What a file holds, in the making.
struct Model {
    positions: Vec<[f64; 3]>,
    polygons: Polygons,
    /// Corners of the face on the line.
    corners: Vec<u32>,
    indices: Indices,
    marks: Marks,
    /// The first thing wrong that is no vertex.
    wrong: Option<(Place, Defect)>,
}

impl Model {
    fn new() -> Parsed<Self> {
        Ok(Self {
            positions: Vec::new(),
            polygons: Polygons::with_room(0)?,
            corners: Vec::new(),
            indices: Indices::default(),
            marks: Marks::default(),
            wrong: None,
        })
    }

    /// Takes a line in.
    fn line(&mut self, number: u64, line: &[u8]) -> Parsed<()> {
        let mut words = words(line);
        let keyword = words.next();
        if keyword == Some(b"v") {
            let position = coordinates(words).map_err(|defect| (Place::Line(number), defect))?;
            self.positions.push(position);
            return Ok(());
        }
        if self.wrong.is_none() {
            let preceding = self.positions.len() as u64;
            let done = match keyword {
                Some(b"f") => self.face(words, [number, preceding]),
                Some(b"l") => self.marks.line(words, |word| self.indices.vertex(word, [number, preceding])),
                Some(b"s") => {
                    self.marks.group(words.next(), self.polygons.len() as u64);
                    Ok(())
                }
                _ => Ok(()),
            };
            self.wrong = done.err().map(|defect| (Place::Line(number), defect));
        }
        Ok(())
    }

    fn face<'a>(&mut self, words: impl Iterator<Item = &'a [u8]>, at: [u64; 2]) -> Result<(), Defect> {
        self.corners.clear();
        for word in words {
            self.corners.push(self.indices.vertex(word, at)?);
        }
        let found = self.corners.len() as u64;
        if found < 3 {
            return Err(Defect::TooFewCorners { found });
        }
        self.polygons.push(&self.corners);
        Ok(())
    }

    /// The mesh, if everything it refers to was there.
    fn finish(self) -> Parsed<TriangleMesh> {
        let vertices = self.positions.len() as u64;
        match vertices {
            0 => return Err((Place::Whole, Defect::NoVertices)),
            1..=LARGEST_COUNT => {}
            _ => return Err((Place::Whole, Defect::TooMany { what: "vertices" })),
        }
        if let Some(wrong) = self.indices.beyond(vertices).or(self.wrong) {
            return Err(wrong);
        }
        match self.polygons.len() as u64 {
            0 => return Err((Place::Whole, Defect::NoFaces)),
            1..=LARGEST_COUNT => {}
            _ => return Err((Place::Whole, Defect::TooMany { what: "faces" })),
        }
        let groups = self.marks.has_borders();
        let arities: Vec<u32> = if groups { self.polygons.arities().collect() } else { Vec::new() };
        let faces = self.polygons.into_triangles(&self.positions)?;
        let sharp = self.marks.sharp_edges(&faces, &arities);
        Ok(TriangleMesh::new(self.positions, faces).with_sharp_edges(sharp))
    }
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
