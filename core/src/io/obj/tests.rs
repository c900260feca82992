use crate::io::tests::refusal;
use crate::io::{MeshFormat, read_mesh_bytes};
use crate::mesh::TriangleMesh;

fn read(text: &str) -> TriangleMesh {
    read_mesh_bytes(MeshFormat::Obj, text.as_bytes(), "model").unwrap_or_else(|error| panic!("{error}"))
}

fn refused(text: &str) -> String {
    refusal(MeshFormat::Obj, text.as_bytes())
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn vertices_keep_their_numbers_through_groups_objects_and_materials() {
    let text = format!(
        "# made up\nmtllib none.mtl\no a\nv 9 9 9\n{SQUARE}vt 0 0\nvn 0 0 1\ng x\nusemtl red\nf 4 3 2\n\
         o b\nusemtl blue\ns off\nl 1 2\np 1\nv 0 0 0\nf 6/1 2//1 3/1/1\n"
    );
    let mesh = read(&text);
    assert_eq!(mesh.positions.len(), 6);
    assert_eq!(mesh.positions[0], [9.0; 3]);
    assert_eq!(mesh.faces, [[3, 2, 1], [5, 1, 2]]);
}

#[test]
fn meshes_of_one_to_four_vertices_keep_their_numbers() {
    // The polygon that fixes the numbering is then a point, a line, a triangle, a quadrilateral.
    for vertices in 1..=4 {
        let text = format!("{}f 1 1 1\nf {vertices} 1 1\n", "v 1 2 3\n".repeat(vertices));
        let mesh = read(&text);
        assert_eq!(mesh.positions, vec![[1.0, 2.0, 3.0]; vertices]);
        assert_eq!(mesh.faces, [[0, 0, 0], [vertices as u32 - 1, 0, 0]]);
    }
}

#[test]
fn faces_may_come_before_their_vertices() {
    assert_eq!(read(&format!("f 1 2 3\n{SQUARE}")).faces, [[0, 1, 2]]);
}

#[test]
fn relative_indices_count_back_from_the_line_they_stand_on() {
    assert_eq!(read(&format!("{SQUARE}f -4 -3 -2\nv 5 5 5\nf -1 1 -2\n")).faces, [[0, 1, 2], [4, 0, 3]]);
}

#[test]
fn lines_carried_on_colours_weights_and_comments_are_taken() {
    let text =
        "v 0 0 0 1 0 0 # red\nv 1 0 \\\n 0\nv 0 1 0 1.0\nv 0 0 \\\r\n 2 0.5 0.5\n# C:\\\nf 1 2 \\\n3#!\n";
    let mesh = read(text);
    assert_eq!(mesh.positions, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0]]);
    assert_eq!(mesh.faces, [[0, 1, 2]]);
}

#[test]
fn comments_in_another_encoding_do_no_harm() {
    let mut bytes = b"# caf\xe9 \xff\n".to_vec();
    bytes.extend(format!("g d\u{e9}j\u{e0}\n{SQUARE}f 1 2 3\n").into_bytes());
    assert!(read_mesh_bytes(MeshFormat::Obj, &bytes, "model").is_ok());
}

#[test]
fn positions_are_read_in_double_precision() {
    let mesh = read("v 0.1 -16777217 3.141592653589793\nf 1 1 1\n");
    assert_eq!(mesh.positions, [[0.1, -16_777_217.0, std::f64::consts::PI]]);
}

#[test]
fn polygons_become_triangles_in_their_place() {
    let mesh = read(&format!("{SQUARE}v 0.5 0.5 0\nf 1 2 3 4\nf 3 2 1\nf 1 2 3 4 5\n"));
    assert_eq!(mesh.faces.len(), 2 + 1 + 3);
    assert_eq!(mesh.faces[2], [2, 1, 0]);
}

#[test]
fn errors_name_the_line_and_the_mend() {
    assert_eq!(
        refused(&format!("{SQUARE}\nf 1 2 9000\n")),
        "model, line 6: it refers to vertex 9000 but there are only 4, counted from 1; export the model again or \
         correct that index"
    );
    let cases = [
        (format!("{SQUARE}f 1 0 2\n"), "line 5: it refers to vertex 0"),
        (format!("{SQUARE}f 1 2 -5\n"), "line 5: it refers 5 vertices back but only 4 precede it"),
        (format!("f 1 2 -1\n{SQUARE}"), "line 1: it refers 1 vertices back but only 0 precede it"),
        (format!("{SQUARE}f 1 2\n"), "line 5: a face needs at least three corners but has 2"),
        (format!("{SQUARE}f\n"), "line 5: a face needs at least three corners but has 0"),
        (format!("{SQUARE}f 1 2 x\n"), "line 5: the vertex index 'x' is not a whole number"),
        (format!("{SQUARE}f 1 2 /3\n"), "line 5: the vertex index '/3' is not a whole number"),
        (format!("{SQUARE}f 1 2 99999999999999999999\n"), "is not a whole number"),
        (format!("{SQUARE}f 1 2 -9223372036854775808\n"), "line 5: it refers 9223372036854775808"),
        // The first thing wrong is told, vertices before faces.
        (format!("f 9 1 2\nf 1 2 x\n{SQUARE}f 1 2 7\n"), "line 1: it refers to vertex 9"),
        (format!("f 4 1 2\nf 1 2 x\n{SQUARE}f 1 2 7\n"), "line 2: the vertex index 'x'"),
        (format!("f 4 1 2\nf 6 1 8\n{SQUARE}f 1 2 7\nl 1 9\n"), "line 2: it refers to vertex 6"),
        (format!("f 1 2 x\n{SQUARE}v 0 nan 0\n"), "line 6: the coordinate 'nan'"),
        (format!("{SQUARE}f 1 2 9223372036854775807\n"), "line 5: it refers to vertex 9223372036854775807"),
        ("v 0 0\nf 1 1 1\n".to_owned(), "line 1: a vertex needs three coordinates but has 2"),
        ("v 0 \\\n 0\nv 0 0 nan\nf 1 1 1\n".to_owned(), "line 1: a vertex needs three"),
        ("v 0 0 0\nv 0 nan 0\nf 1 1 1\n".to_owned(), "line 2: the coordinate 'nan' is not finite"),
        ("v 0 0 -inf\nf 1 1 1\n".to_owned(), "line 1: the coordinate '-inf' is not finite"),
        ("v 0 0 1e400\nf 1 1 1\n".to_owned(), "line 1: the coordinate '1e400' is not finite"),
        ("v 0 0 2e30\nf 1 1 1\n".to_owned(), "line 1: the coordinate 2e30 is beyond 1e30"),
        ("v 0 0 1,5\nf 1 1 1\n".to_owned(), "line 1: the coordinate '1,5' is not a number"),
        ("f 1 2 3\n".to_owned(), "there is no vertex in it"),
        (SQUARE.to_owned(), "there is no face in it"),
        (format!("{SQUARE}l 1 2 3\n"), "there is no face in it"),
    ];
    for (text, expected) in cases {
        let message = refused(&text);
        assert!(message.contains(expected), "{message}\nnot: {expected}");
    }
}

#[test]
fn a_long_word_is_cut_short_in_the_message() {
    let message = refused(&format!("v 0 0 {}\u{7}\nf 1 1 1\n", "q".repeat(10_000)));
    assert!(message.contains("qqq…'"), "{message}");
}

#[test]
fn lines_mark_the_edges_they_run_along() {
    let mesh = read(&format!("{SQUARE}l 3/7 2 1\nf 1 2 3 4\nl -1 -2\nl 2 1\nl 2\n"));
    assert_eq!(mesh.sharp_edges, [[0, 1], [1, 2], [2, 3]]);
    assert!(refused(&format!("{SQUARE}f 1 2 3\nl 1 5\n")).contains("line 6"));
}

#[test]
fn edges_between_two_smoothing_groups_are_sharp() {
    let faces = "f 1 2 3\ns 2\nf 1 3 4\ns 1\nf 4 3 5 6\n";
    let more = "v 1 2 0\nv 0 2 0\n";
    assert_eq!(read(&format!("{SQUARE}{more}s 1\n{faces}")).sharp_edges, [[0, 2], [2, 3]]);
    // The first face is in no group, and says nothing.
    assert_eq!(read(&format!("{SQUARE}{more}s off\n{faces}")).sharp_edges, [[2, 3]]);
    assert_eq!(read(&format!("{SQUARE}{more}s 3\nf 1 2 3\ns off\nf 1 3 4\n")).sharp_edges, [[0u32; 2]; 0]);
}
