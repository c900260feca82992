use crate::io::tests::refusal;
use crate::io::{MeshFormat, read_mesh_bytes};
use crate::mesh::TriangleMesh;

fn read(text: &str) -> TriangleMesh {
    read_mesh_bytes(MeshFormat::Off, text.as_bytes(), "model").unwrap_or_else(|error| panic!("{error}"))
}

const BODY: &str = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

#[test]
fn the_counts_stand_on_the_keywords_line_or_the_next_or_without_a_keyword() {
    let heads = [
        "OFF\n3 1 0\n",
        "OFF 3 1 0\n",
        "OFF3 1 0\n",
        "3 1 0\n",
        "OFF\n3 1\n",
        "# first\n\nOFF # keyword\r\n\r\n# counts\r\n3 1 2 # edges\r\n",
        "COFF\n3 1 0\n",
        "NOFF 3 1 0\n",
        "STOFF\n3 1 0\n",
        "STCNOFF\n3 1 0\n",
    ];
    for head in heads {
        let mesh = read(&format!("{head}{BODY}"));
        assert_eq!(mesh.positions, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], "{head}");
        assert_eq!(mesh.faces, [[0, 1, 2]], "{head}");
    }
}

#[test]
fn extra_columns_blank_lines_and_comments_are_passed_over() {
    let text = "CNOFF\n3 2 0\n0 0 0  0 0 1  255 0 0 255\n\n1 0 0 # corner\n# between\n0 1 0\n3 0 1 2 0.5 0.5 0.5\n  3 2 1 0 7";
    assert_eq!(read(text).faces, [[0, 1, 2], [2, 1, 0]]);
}

#[test]
fn polygons_become_triangles() {
    let text = "OFF\n5 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0.5 2 0\n4 0 1 2 3\n5 0 1 2 4 3\n";
    assert_eq!(read(text).faces.len(), 2 + 3);
}

#[test]
fn errors_name_the_line_and_the_mend() {
    let cases = [
        ("PLY\n3 1 0\n".to_owned(), "line 1: this is not an OFF file (it begins with 'PLY')"),
        ("4OFF\n3 1 0\n".to_owned(), "line 1: this is not an OFF file"),
        ("OFF BINARY\n".to_owned(), "line 1: the binary variant of OFF is not read"),
        ("OFF".to_owned(), "the counts of vertices and faces are missing"),
        ("OFF\n3 x 0\n".to_owned(), "line 2: '3 x 0' are not the counts"),
        ("OFF\n-3 1 0\n".to_owned(), "line 2: '-3 1 0' are not the counts"),
        ("OFF\n0 0 0\n".to_owned(), "there is no vertex in it"),
        ("OFF\n1 0 0\n0 0 0\n".to_owned(), "there is no face in it"),
        (
            "OFF\n1000000000 1 0\n0 0 0\n".to_owned(),
            "the header declares 1000000000 vertices, more than 25 bytes can hold",
        ),
        ("OFF\n9999999999999 1 0\n".to_owned(), "more than 2147483648 vertices"),
        ("OFF\n3 4 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n".to_owned(), "the file ends after 1 of 4 faces"),
        ("OFF\n5 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n".to_owned(), "the file ends after 4 of 5 vertices"),
        (
            format!("OFF\n3 1 0\n{}", BODY.replace("1 0 0", "1 0")),
            "line 4: a vertex needs three coordinates but has 2",
        ),
        (
            format!("OFF\n3 1 0\n{}", BODY.replace("1 0 0", "1 NaN 0")),
            "line 4: the coordinate 'NaN' is not finite",
        ),
        (
            format!("OFF\n3 1 0\n{}", BODY.replace("3 0 1 2", "3 0 1 3")),
            "line 6: it refers to vertex 3 but there are only 3, counted from 0",
        ),
        (
            format!("OFF\n3 1 0\n{}", BODY.replace("3 0 1 2", "3 0 1 -1")),
            "line 6: it refers to vertex -1, below 0",
        ),
        (
            format!("OFF\n3 1 0\n{}", BODY.replace("3 0 1 2", "3 0 1.5 2")),
            "line 6: the vertex index '1.5' is not a whole number",
        ),
        (
            format!("OFF\n3 1 0\n{}", BODY.replace("3 0 1 2", "2 0 1 2")),
            "line 6: a face needs at least three corners but has 2",
        ),
        (
            format!("OFF\n3 1 0\n{}", BODY.replace("3 0 1 2", "-7 0 1 2")),
            "line 6: a face needs at least three corners",
        ),
        (
            format!("OFF\n3 1 0\n{}", BODY.replace("3 0 1 2", "4 0 1 2")),
            "line 6: the element does not hold what",
        ),
    ];
    for (text, expected) in cases {
        let message = refusal(MeshFormat::Off, text.as_bytes());
        assert!(message.contains(expected), "{message}\nnot: {expected}");
    }
}
