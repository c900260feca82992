//! What can be wrong with a mesh file, said in one sentence.
//!
//! The sentence has three parts: the file and the place in it, what is wrong there, and how to mend it.
//! Text from the file or its name is shown escaped and cut short, so the sentence stays on one line.

use std::fmt;

use super::{LARGEST_COORDINATE, LARGEST_COUNT};

/// Why a mesh file was not read. `Display` is one sentence naming the file, the place and the mend.
#[derive(Debug, thiserror::Error)]
pub enum MeshFileError {
    /// The operating system did not give the file's contents.
    #[error("{file}: the file cannot be read ({source}); check its name and your permission to read it")]
    Unreadable {
        /// The file, as the caller named it.
        file: String,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The path is a directory or a device.
    #[error("{file}: this is not a regular file; name a mesh file itself")]
    NotAFile {
        /// The path, as the caller named it.
        file: String,
    },
    /// No reader for this extension.
    #[error("{file}: {found} cannot be read as a mesh; convert it to .obj, .ply, .stl, .glb or .off")]
    Unsupported {
        /// The file, as the caller named it.
        file: String,
        /// The extension, or that there is none.
        found: String,
    },
    /// Reading was given up.
    #[error("{file}: reading it was cancelled; open it again to read it whole")]
    Cancelled {
        /// The file, as the caller named it.
        file: String,
    },
    /// The contents are wrong.
    #[error("{file}{place}: {defect}")]
    Malformed {
        /// The file, as the caller named it.
        file: String,
        /// Where in the file.
        place: Place,
        /// What is wrong there, and the mend.
        defect: Defect,
    },
}

impl MeshFileError {
    pub(super) fn unreadable(name: &str, source: std::io::Error) -> Self {
        Self::Unreadable { file: on_one_line(name), source }
    }

    pub(super) fn not_a_file(name: &str) -> Self {
        Self::NotAFile { file: on_one_line(name) }
    }

    pub(super) fn unsupported(name: &str, extension: Option<&str>) -> Self {
        let found = match extension {
            Some(extension) => format!("a .{} file", excerpt(extension.as_bytes())),
            None => "a file without an extension".to_owned(),
        };
        Self::Unsupported { file: on_one_line(name), found }
    }

    pub(super) fn cancelled(name: &str) -> Self {
        Self::Cancelled { file: on_one_line(name) }
    }

    pub(super) fn malformed(name: &str, place: Place, defect: Defect) -> Self {
        Self::Malformed { file: on_one_line(name), place, defect }
    }
}

/// Where in a file something is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    Whole,
    /// A line, counted from 1.
    Line(u64),
    /// An element of a binary file, counted from 0.
    Element {
        /// The element's name in the file's header, such as `vertex`.
        name: String,
        /// Its number among the elements of that name.
        index: u64,
    },
}

impl fmt::Display for Place {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole => Ok(()),
            Self::Line(line) => write!(out, ", line {line}"),
            Self::Element { name, index } => write!(out, ", {name} {index} (counting from 0)"),
        }
    }
}

/// What is wrong with a mesh file's contents. `Display` is the end of the sentence: defect and mend.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Defect {
    /// Nothing but white space.
    #[error("the file is empty; export the model again")]
    Empty,
    /// Another format, or none.
    #[error("this is not {format} ({reason}); check that the extension matches the contents")]
    NotThisFormat {
        /// The format expected, with an article.
        format: &'static str,
        /// How it shows.
        reason: String,
    },
    /// A part of the header that cannot be used.
    #[error("{problem}; export the model again, or correct the header")]
    Header {
        /// What is wrong.
        problem: String,
    },
    /// No vertex in the file.
    #[error("there is no vertex in it; check that the file holds a mesh and export it again")]
    NoVertices,
    /// No face in the file.
    #[error("there is no face in it, only points; export the model with its faces")]
    NoFaces,
    /// Too many vertices or faces.
    #[error("there are more than {LARGEST_COUNT} {what}; split or decimate the model first")]
    TooMany {
        /// What there is too much of, in the plural.
        what: &'static str,
    },
    /// The header promises more than the file has bytes for.
    #[error(
        "the header declares {declared} {what}, more than {bytes} bytes can hold; the file was cut \
         short or its header is wrong, so export the model again"
    )]
    Oversized {
        /// The elements, in the plural.
        what: String,
        /// How many are declared.
        declared: u64,
        /// The length of the part of the file that holds them.
        bytes: u64,
    },
    /// The file ends before the last element.
    #[error("the file ends after {found} of {declared} {what}; it was cut short, so export or copy it again")]
    Truncated {
        /// The elements, in the plural.
        what: String,
        /// How many there are.
        found: u64,
        /// How many are declared.
        declared: u64,
    },
    /// The reading was given up.
    #[error("reading it was cancelled; open it again to read it whole")]
    Cancelled,
    /// The file ends before a part that every file of the format has.
    #[error("the file ends before {part}; it was cut short, so export or copy it again")]
    CutShort {
        /// What is missing.
        part: &'static str,
    },
    /// A scene that contradicts itself or the format.
    #[error("{problem}; export the model again")]
    Scene {
        /// What is wrong.
        problem: String,
    },
    /// A feature of the format for which there is no reader.
    #[error("{feature} cannot be read; export the model again without it")]
    Feature {
        /// The feature, with an article.
        feature: String,
    },
    /// A line or an element that does not hold what its header says.
    #[error("the element does not hold what the header declares; correct it or export the model again")]
    BadElement,
    /// Fewer than three coordinates.
    #[error(
        "a vertex needs three coordinates but has {found}; add what is missing or export the model again"
    )]
    TooFewCoordinates {
        /// How many there are.
        found: usize,
    },
    /// A coordinate that is not a number.
    #[error("the coordinate '{token}' is not a number; write it in decimal digits with a point")]
    NotANumber {
        /// The text.
        token: String,
    },
    /// A coordinate that is not finite.
    #[error("the coordinate '{token}' is not finite; repair the model where it was made and export it again")]
    NotFinite {
        /// The text.
        token: String,
    },
    /// A coordinate too large to compute with.
    #[error(
        "the coordinate {token} is beyond {LARGEST_COORDINATE:e}; scale the model down and export it again"
    )]
    TooLarge {
        /// The text.
        token: String,
    },
    /// Fewer than three corners.
    #[error(
        "a face needs at least three corners but has {found}; remove that face or export the model again"
    )]
    TooFewCorners {
        /// How many there are.
        found: u64,
    },
    /// A vertex index that is not a whole number.
    #[error("the vertex index '{token}' is not a whole number; correct it or export the model again")]
    NotAnIndex {
        /// The text.
        token: String,
    },
    /// Index 0 where vertices count from 1.
    #[error("it refers to vertex 0 but vertices count from 1; export the model again or correct that index")]
    IndexZero,
    /// An index of a vertex that does not exist.
    #[error(
        "it refers to vertex {index} but there are only {vertices}, counted from {base}; export the \
         model again or correct that index"
    )]
    IndexBeyond {
        /// The index.
        index: i64,
        /// How many vertices there are.
        vertices: u64,
        /// The number of the first vertex in this format.
        base: u8,
    },
    /// A relative index that reaches before the first vertex.
    #[error(
        "it refers {back} vertices back but only {vertices} precede it; export the model again or \
         correct that index"
    )]
    IndexBefore {
        /// How far back.
        back: u64,
        /// How many vertices precede the face.
        vertices: u64,
    },
    /// An index below 0 where vertices count from 0.
    #[error("it refers to vertex {index}, below 0; export the model again or correct that index")]
    NegativeIndex {
        /// The index.
        index: i64,
    },
    /// The machine is out of memory.
    #[error("there is not enough memory to read it; close other programs or decimate the model first")]
    OutOfMemory,
    /// A parser gave up where the checks before it saw nothing wrong.
    #[error("the contents cannot be made sense of; export the model again, in another format if need be")]
    Parser,
}

/// Why a mesh was not written. The caller knows the file's name and adds it.
#[derive(Debug, thiserror::Error)]
pub enum MeshWriteError {
    /// The writer failed.
    #[error("the mesh cannot be written ({0}); check the space and the permissions there")]
    Io(#[from] std::io::Error),
    /// A coordinate the format cannot hold.
    #[error("vertex {vertex} has a coordinate that the format cannot hold; scale the model down")]
    Coordinate {
        /// The vertex, counted from 0.
        vertex: usize,
    },
    /// A face that refers to a vertex that does not exist.
    #[error("face {face} refers beyond the {vertices} vertices there are; repair the mesh first")]
    VertexIndex {
        /// The face, counted from 0.
        face: usize,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A mesh the format has no form for.
    #[error("a mesh without faces has no form in glTF; write it as .obj, .ply or .off")]
    NoFaces,
    /// A mesh larger than the format's 32-bit lengths.
    #[error("the mesh is larger than the 4 GiB that {format} can hold; write it as .ply")]
    TooLarge {
        /// The format.
        format: &'static str,
    },
}

/// The characters of a file's text that an error shows at most.
const EXCERPT: usize = 32;

/// A piece of a file for an error message: escaped, and cut short.
pub(super) fn excerpt(text: &[u8]) -> String {
    excerpt_of(text, EXCERPT)
}

/// At most `most` characters of a text for an error message, escaped.
pub(super) fn excerpt_of(text: &[u8], most: usize) -> String {
    let shown = String::from_utf8_lossy(&text[..text.len().min(4 * most)]);
    let mut excerpt: String = shown.chars().take(most).flat_map(char::escape_debug).collect();
    if shown.chars().count() > most || text.len() > 4 * most {
        excerpt.push('…');
    }
    excerpt
}

/// A file's name with anything that would break the line escaped.
fn on_one_line(name: &str) -> String {
    let escape = |c: char| if c.is_control() { c.escape_default().collect() } else { String::from(c) };
    name.chars().map(escape).collect()
}
