use super::*;
use crate::io::tests::{refusal, written};
use crate::io::{MeshFormat, read_mesh_bytes};
use crate::mesh::shapes;

#[test]
fn faces_carry_their_corners_and_normals() {
    let positions = vec![[0.0, 0.0, 1.5], [2.0, 0.0, 1.5], [0.0, 3.0, 1.5]];
    let mesh = TriangleMesh::new(positions, vec![[0, 1, 2], [0, 0, 1]]);
    let mut bytes = Vec::new();
    write(&mesh, &mut bytes).unwrap();
    assert_eq!(bytes.len(), 84 + 2 * 50);
    assert!(!bytes.starts_with(b"solid"));
    assert_eq!(bytes[80..84], 2u32.to_le_bytes());
    let floats = |face: usize| -> Vec<f32> {
        let record = &bytes[84 + 50 * face..][..48];
        record.as_chunks().0.iter().map(|&bytes| f32::from_le_bytes(bytes)).collect()
    };
    assert_eq!(floats(0), [0.0, 0.0, 1.0, 0.0, 0.0, 1.5, 2.0, 0.0, 1.5, 0.0, 3.0, 1.5]);
    assert_eq!(floats(1)[..3], [0.0; 3]);
    assert_eq!(bytes[84 + 48..84 + 50], [0, 0]);
}

fn read(bytes: &[u8]) -> TriangleMesh {
    read_mesh_bytes(MeshFormat::Stl, bytes, "model").unwrap_or_else(|error| panic!("{error}"))
}

const FACET: &str =
    "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 1e0 0\n endloop\nendfacet\n";

#[test]
fn corners_at_the_same_place_become_one_vertex() {
    let mut mesh = shapes::octahedron();
    mesh.positions[0][1] = -0.0;
    let read = read(&written(&mesh, MeshFormat::Stl));
    assert_eq!(read.positions.len(), 6);
    assert_eq!(read.faces[..2], [[0, 1, 2], [1, 3, 2]], "numbered by first use");
    for (face, expected) in (0..8).zip(mesh.faces) {
        assert_eq!(read.corners(FaceIndex(face)), expected.map(|v| mesh.positions[v as usize]));
    }
}

#[test]
fn text_is_read_however_it_is_laid_out() {
    let plain = format!("solid name of vertex 1\n{FACET}endsolid name\n");
    let expected =
        TriangleMesh::new(vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]);
    assert_eq!(read(plain.as_bytes()), expected);
    assert_eq!(read(plain.replace('\n', "\r\n").as_bytes()), expected);
    let one_line = format!("solid\n{}\nendsolid", FACET.replace('\n', " "));
    assert_eq!(read(one_line.as_bytes()), expected);
    assert_eq!(
        read(
            b"\xef\xbb\xbf  SOLID x\nOUTER LOOP\nVERTEX 0 0 0\nVERTEX 1 0 0\nVERTEX 0 1 0\nENDLOOP\nENDSOLID"
        ),
        expected
    );
    let two = read(format!("{plain}{}", plain.replace("1e0", "2")).as_bytes());
    assert_eq!((two.positions.len(), two.faces.clone()), (4, vec![[0, 1, 2], [0, 1, 3]]));
    let four = plain.replace("  vertex 1 0 0\n", "  vertex 1 0 0\n  vertex 1 1 0\n");
    assert_eq!(read(four.as_bytes()).faces.len(), 2);
}

#[test]
fn binary_is_told_from_text_by_its_length_or_a_zero() {
    let mesh = shapes::tetrahedron();
    let mut bytes = written(&mesh, MeshFormat::Stl);
    bytes[..80].copy_from_slice(&[b' '; 80]);
    bytes[..6].copy_from_slice(b"solid ");
    assert_eq!(read(&bytes).faces.len(), 4);
    // A tail that does not belong there.
    bytes.extend(b"tail");
    assert_eq!(read(&bytes).faces.len(), 4);
}

#[test]
fn errors_name_the_place_and_the_mend() {
    let whole = format!("solid a\n{FACET}endsolid a\n");
    let with = |from: &str, to: &str| whole.replacen(from, to, 1).into_bytes();
    let mut binary = written(&shapes::tetrahedron(), MeshFormat::Stl);
    let mut nan = binary.clone();
    nan[84 + 50 + 12..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
    let mut far = binary.clone();
    far[84 + 100 + 20..][..4].copy_from_slice(&2e30f32.to_le_bytes());
    binary[80] = 5;
    let cases: [(Vec<u8>, &str); 12] = [
        (b"solid a\nendsolid a\n".to_vec(), "there is no face in it"),
        (b"not a mesh".to_vec(), "this is not an STL file (it does not begin with 'solid'"),
        (vec![0; 84], "there is no face in it"),
        (binary, "the header declares 5 faces, more than 200 bytes can hold"),
        (nan, "face 1 (counting from 0): the coordinate 'NaN' is not finite"),
        (far, "face 2 (counting from 0): the coordinate 2.0000000300949324e30 is beyond"),
        (with("vertex 1 0 0", "vertex 1 0"), "line 5: a vertex needs three coordinates but has 2"),
        (with("vertex 1 0 0", "vertex 1 inf 0"), "line 5: the coordinate 'inf' is not finite"),
        (with("vertex 1 0 0", "vertex one 0 0"), "line 5: the coordinate 'one' is not a number"),
        (with("vertex 1 0 0", ""), "line 7: a face needs at least three corners but has 2"),
        (with("endsolid a\n", ""), "the file ends before 'endsolid'"),
        (whole.as_bytes()[..60].to_vec(), "the file ends before 'endsolid'"),
    ];
    for (bytes, expected) in cases {
        let message = refusal(MeshFormat::Stl, &bytes);
        assert!(message.contains(expected), "{message}\nnot: {expected}");
    }
}
