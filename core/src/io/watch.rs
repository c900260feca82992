//! Asking, while a file is parsed, whether to go on.

use super::{Defect, Parsed, Place};
use std::cell::{Cell, RefCell};

/// Lines or elements parsed between two questions: a hundredth of a second at most.
const STRIDE: u32 = 4096;

/// The question whether to go on, asked now and then; after the first no it is not asked again.
pub(super) struct Watch<'a> {
    go_on: RefCell<&'a mut dyn FnMut() -> bool>,
    passed: Cell<u32>,
    refused: Cell<bool>,
}

impl<'a> Watch<'a> {
    /// A watch that asks `go_on`.
    pub(super) fn new(go_on: &'a mut dyn FnMut() -> bool) -> Self {
        Self { go_on: RefCell::new(go_on), passed: Cell::new(0), refused: Cell::new(false) }
    }

    /// Counts a line or an element; an error if the work is to stop.
    pub(super) fn pass(&self) -> Parsed<()> {
        self.passed.set(self.passed.get().wrapping_add(1));
        if self.passed.get().is_multiple_of(STRIDE) { self.ask() } else { Ok(()) }
    }

    /// Asks at once; an error if the work is to stop.
    pub(super) fn ask(&self) -> Parsed<()> {
        if !self.refused.get() && !(*self.go_on.borrow_mut())() {
            self.refused.set(true);
        }
        if self.refused.get() { Err((Place::Whole, Defect::Cancelled)) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use crate::io::{MeshFileError, MeshFormat, read_mesh_bytes_while, write_mesh};
    use crate::mesh::shapes;

    /// A text PLY file of the same mesh, since the writer makes binary ones.
    fn text_ply(mesh: &crate::mesh::TriangleMesh) -> Vec<u8> {
        let mut text = format!(
            "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
             element face {}\nproperty list uchar int vertex_indices\nend_header\n",
            mesh.positions.len(),
            mesh.faces.len()
        );
        for [x, y, z] in &mesh.positions {
            text += &format!("{x:e} {y:e} {z:e}\n");
        }
        for [a, b, c] in &mesh.faces {
            text += &format!("3 {a} {b} {c}\n");
        }
        text.into_bytes()
    }

    fn text_stl(mesh: &crate::mesh::TriangleMesh) -> Vec<u8> {
        let mut text = String::from("solid\n");
        for face in &mesh.faces {
            text += "facet normal 0 0 0\nouter loop\n";
            for [x, y, z] in face.map(|v| mesh.positions[v as usize]) {
                text += &format!("vertex {x:e} {y:e} {z:e}\n");
            }
            text += "endloop\nendfacet\n";
        }
        (text + "endsolid\n").into_bytes()
    }

    #[test]
    fn a_refusal_is_the_last_question_in_every_format() {
        let mesh = shapes::subdivide(&shapes::octahedron(), 6);
        let mut files = vec![(MeshFormat::Ply, text_ply(&mesh)), (MeshFormat::Stl, text_stl(&mesh))];
        for format in MeshFormat::WRITABLE {
            let mut bytes = Vec::new();
            write_mesh(&mesh, format, &mut bytes).expect("written");
            files.push((format, bytes));
        }
        for (format, bytes) in files {
            let up_to = |last: usize| {
                let mut asked = 0;
                let mut go_on = || {
                    asked += 1;
                    asked <= last
                };
                (read_mesh_bytes_while(format, &bytes, "mesh", &mut go_on), asked)
            };
            let (done, all) = up_to(usize::MAX);
            // Vertices of STL are numbered anew.
            assert_eq!(done.expect("a mesh").faces.len(), mesh.faces.len(), "{format:?}");
            assert!(all >= 8, "{format:?} asked {all} times only for 32,768 faces");
            for last in 0..all {
                let (result, asked) = up_to(last);
                let cancelled = matches!(result, Err(MeshFileError::Cancelled { .. }));
                assert!(
                    cancelled && asked == last + 1,
                    "{format:?}, the {last}th answer: {result:?}, {asked}"
                );
            }
        }
    }
}
