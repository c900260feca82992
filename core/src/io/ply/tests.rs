use crate::io::tests::{awkward, bits, refusal, written};
use crate::io::{MeshFormat, read_mesh_bytes};
use crate::mesh::TriangleMesh;

fn read(bytes: &[u8]) -> TriangleMesh {
    read_mesh_bytes(MeshFormat::Ply, bytes, "model").unwrap_or_else(|error| panic!("{error}"))
}

const HEAD: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n";
const BODY: &str = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

/// The triangle in binary, all numbers through `bytes_of`, with the given header words and list type.
fn binary(
    encoding: &str,
    list: &str,
    count: &[u8],
    index: impl Fn(u8) -> Vec<u8>,
    float: impl Fn(f64) -> Vec<u8>,
) -> Vec<u8> {
    let mut bytes = HEAD.replace("ascii", encoding).replace("property list uchar int", list).into_bytes();
    for x in [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
        bytes.extend(float(x));
    }
    bytes.extend(count);
    (0..3).for_each(|vertex| bytes.extend(index(vertex)));
    bytes
}

#[test]
fn every_byte_order_and_integer_type_is_read() {
    let little = |x: f64| (x as f32).to_le_bytes().to_vec();
    let big = |x: f64| (x as f32).to_be_bytes().to_vec();
    let files = [
        format!("{HEAD}{BODY}").into_bytes(),
        format!("{HEAD}{BODY}").replace('\n', "\r\n").into_bytes(),
        format!("{HEAD}{BODY}").replace("vertex_indices", "vertex_index").into_bytes(),
        binary("binary_little_endian", "property list uchar int", &[3], |v| vec![v, 0, 0, 0], little),
        binary("binary_big_endian", "property list int uint", &[0, 0, 0, 3], |v| vec![0, 0, 0, v], big),
        binary("binary_little_endian", "property list ushort short", &[3, 0], |v| vec![v, 0], little),
        binary("binary_big_endian", "property list int8 uint8", &[3], |v| vec![v], big),
        binary("binary_big_endian", "property list uint16 char", &[0, 3], |v| vec![v], big),
        binary("binary_little_endian", "property list uint32 uint16", &[3, 0, 0, 0], |v| vec![v, 0], little),
    ];
    for bytes in files {
        let mesh = read(&bytes);
        assert_eq!(mesh.positions, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        assert_eq!(mesh.faces, [[0, 1, 2]], "{}", String::from_utf8_lossy(&bytes));
    }
}

#[test]
fn other_properties_elements_and_orders_are_passed_over() {
    let text = "ply\nformat ascii 1.0\ncomment faces first\nobj_info x\nelement face 2\nproperty list uchar float uv\n\
        property list uchar int vertex_indices\nproperty int flags\nelement camera 1\nproperty float f\n\
        element vertex 4\nproperty uchar red\nproperty double z\nproperty double y\nproperty double x\nend_header\n\
        2 .5 1. 3 0 1 2 7\n0 4 0 1 2 3 7\n\n35.0\n255 0 0 0\n255 0.1 0 1\n255 0 1 1e0\n255 -.5 1 0\n";
    let mesh = read(text.as_bytes());
    assert_eq!(mesh.positions[1], [1.0, 0.0, 0.1]);
    assert_eq!(mesh.positions[3], [0.0, 1.0, -0.5]);
    assert_eq!(mesh.faces.len(), 3);
}

#[test]
fn comments_in_another_encoding_do_no_harm() {
    let mut bytes = b"ply\nformat ascii 1.0\ncomment caf\xe9\n".to_vec();
    bytes.extend_from_slice(&format!("{HEAD}{BODY}").as_bytes()["ply\nformat ascii 1.0\n".len()..]);
    assert_eq!(read(&bytes).faces, [[0, 1, 2]]);
}

#[test]
fn written_coordinates_are_float_only_where_that_is_exact() {
    let mut mesh = awkward();
    assert!(String::from_utf8_lossy(&written(&mesh, MeshFormat::Ply)).contains("property double x"));
    mesh.positions.iter_mut().flatten().for_each(|x| *x = f64::from(x.clamp(-1e29, 1e29) as f32));
    let bytes = written(&mesh, MeshFormat::Ply);
    assert!(String::from_utf8_lossy(&bytes).contains("property float x"));
    assert_eq!(bits(&read(&bytes)), bits(&mesh));
}

#[test]
fn errors_name_the_place_and_the_mend() {
    let file = |from: &str, to: &str| format!("{HEAD}{BODY}").replacen(from, to, 1);
    let cases = [
        ("solid x".to_owned(), "line 1: this is not a PLY file"),
        ("ply\nformat ascii 1.0\n".to_owned(), "the line 'end_header' is missing"),
        (file("format ascii 1.0", "format text 1.0"), "line 2: this is not a line of a PLY header"),
        (file("element vertex 3", "element vertex -3"), "line 3: this is not a line of a PLY header"),
        (file("element vertex 3", "element vertex 0"), "there is no vertex in it"),
        (file("element vertex 3", "element point 3"), "there is no vertex in it"),
        (file("element face 1", "element face 0"), "there is no face in it"),
        (file("element vertex 3", "element vertex 3000000"), "declares 3000000 elements 'vertex', more than"),
        (file("element face 1", "element face 18446744073709551615"), "more than 2147483648 faces"),
        (
            file("element face 1", "element x 18446744073709551615\nelement face 1"),
            "gives the elements 'x' no properties",
        ),
        (
            file("element face 1", "element x 9\nproperty float q\nelement face 1"),
            "declares 9 elements 'x', more than",
        ),
        (file("property float z", "property float w"), "lacks one of the properties x, y and z"),
        (file("property float z", "property list uchar float z"), "lacks one of the properties x, y and z"),
        (file("property float z", "property float x"), "have the same name"),
        (file("element face 1", "element vertex 1"), "have the same name"),
        (file("uchar int vertex_indices", "uchar float vertex_indices"), "needs one list of integers"),
        (file("uchar int vertex_indices", "uchar int other"), "needs one list of integers"),
        (file("uchar int vertex_indices", "float int vertex_indices"), "a count that is not an integer"),
        (file("1 0 0\n", "1 0\n"), "line 11: the element does not hold what"),
        (file("1 0 0\n", "1 0 abc\n"), "line 11: the element does not hold what"),
        (file("1 0 0\n", "1 nan 0\n"), "line 11: the coordinate 'inf' is not finite"),
        (file("1 0 0\n", "1 0 2e30\n"), "line 11: the coordinate 2"),
        (file("3 0 1 2", "3 0 1 3"), "line 13: it refers to vertex 3 but there are only 3, counted from 0"),
        (file("3 0 1 2", "3 0 1 -2"), "line 13: it refers to vertex -2, below 0"),
        (file("3 0 1 2", "2 0 1"), "line 13: a face needs at least three corners but has 2"),
        (file("3 0 1 2", "9 0 1 2"), "line 13: the element does not hold what"),
        (file("3 0 1 2\n", "\n\n\n"), "the file ends after 0 of 1 elements 'face'"),
    ];
    for (text, expected) in cases {
        let message = refusal(MeshFormat::Ply, text.as_bytes());
        assert!(message.contains(expected), "{message}\nnot: {expected}\n{text}");
    }
}

#[test]
fn binary_errors_name_the_element() {
    let infinite = |x: f64| (if x == 1.0 { f32::INFINITY } else { 0.0 }).to_le_bytes().to_vec();
    let little = |x: f64| (x as f32).to_le_bytes().to_vec();
    let list = "property list uchar int";
    let refused = |bytes: &[u8]| refusal(MeshFormat::Ply, bytes);
    let bytes = binary("binary_little_endian", list, &[3], |v| vec![v, 0, 0, 0], infinite);
    assert!(refused(&bytes).contains("vertex 1 (counting from 0): the coordinate 'inf' is not finite"));
    let bytes = binary("binary_little_endian", list, &[3], |v| vec![v, v, 0, 0], little);
    assert!(refused(&bytes).contains("face 0 (counting from 0): it refers to vertex 257"));
    let bytes = binary("binary_little_endian", list, &[3], |v| vec![v, 0, 0, 0xff], little);
    assert!(refused(&bytes).contains("below 0"));
    let bytes = binary("binary_little_endian", list, &[255], |v| vec![v, 0, 0, 0], little);
    assert!(refused(&bytes).contains("the file ends after 0 of 1 elements 'face'"));
    let bytes =
        binary("binary_little_endian", "property list int int", &[255; 4], |v| vec![v, 0, 0, 0], little);
    assert!(refused(&bytes).contains("face 0 (counting from 0): the element does not hold"));
}

#[test]
fn elements_edge_mark_sharp_edges() {
    let with = |properties: &str, lines: &str| {
        let element =
            format!("element edge 2\nproperty int vertex1\nproperty int vertex2\n{properties}end_header");
        format!("{}{BODY}{lines}", HEAD.replace("end_header", &element)).into_bytes()
    };
    assert_eq!(read(&with("", "2 1\n0 2\n")).sharp_edges, [[0, 2], [1, 2]]);
    assert_eq!(read(&with("property uchar red\n", "2 1 0\n0 2 0\n")).sharp_edges, [[0, 2], [1, 2]]);
    for smooth in ["property uchar sharp\n", "property float crease\n"] {
        assert_eq!(read(&with(smooth, "2 1 0\n0 2 1\n")).sharp_edges, [[0, 2]]);
    }
    let beyond = refusal(MeshFormat::Ply, &with("", "2 1\n0 3\n"));
    assert!(beyond.contains("line 18"), "{beyond}");
}
