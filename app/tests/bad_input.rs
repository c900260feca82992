//! Input files that are missing, are something else, or hold no surface: each is refused with one sentence that names
//! the file, and nothing is written.

mod models;
mod program;

use models::{ball_boz, grey_png};
use program::Workplace;

/// Every command with `INPUT` where its input file goes. `ball.boz` and `script.edits` are good files.
const COMMANDS: [&[&str]; 13] = [
    &["info", "INPUT"],
    &["info", "INPUT", "--json"],
    &["import", "INPUT", "-o", "out.boz"],
    &["import", "INPUT", "-o", "out.boz", "--json"],
    &["export", "INPUT", "-o", "out.obj"],
    &["coefficients", "INPUT", "--csv", "out.csv"],
    &["compare", "INPUT", "ball.boz"],
    &["compare", "ball.boz", "INPUT", "--json"],
    &["replay", "INPUT", "script.edits", "-o", "out.boz"],
    &["bake", "INPUT", "-o", "out.boz"],
    &["verify", "INPUT"],
    &["verify", "ball.boz", "--against", "INPUT"],
    &["render", "INPUT", "-o", "out.png"],
];

/// A folder with good files in it, some of them where outputs go.
fn workplace() -> Workplace {
    let work = Workplace::new();
    ball_boz(&work);
    work.write("script.edits", "{\"edit\":\"gain\",\"level\":1,\"factor\":2}\n");
    for output in ["out.boz", "out.obj", "out.csv", "out.png"] {
        work.write(output, "what was here before");
    }
    work
}

fn every_command_refuses(work: &Workplace, input: &str) {
    for command in COMMANDS {
        let arguments: Vec<&str> = command.iter().map(|&a| if a == "INPUT" { input } else { a }).collect();
        work.refuses(&arguments, &[input]);
    }
}

#[test]
fn missing_files() {
    let work = workplace();
    for input in [
        "missing.boz",
        "missing.obj",
        "no/such/folder.ply",
        "missing.stl",
        "missing.glb",
        "missing.off",
        "missing",
        "missing.xyz",
    ] {
        every_command_refuses(&work, input);
    }
    work.refuses(&["globe", "missing.png", "-o", "out.boz"], &["missing.png"]);
    work.refuses(&["replay", "ball.boz", "missing.edits", "-o", "out.boz"], &["missing.edits"]);
}

#[test]
fn folders() {
    let work = workplace();
    for input in ["folder.boz", "folder.obj", "folder.ply", "folder.edits", "folder.png"] {
        std::fs::create_dir(work.path(input)).expect("a folder");
        every_command_refuses(&work, input);
    }
    work.refuses(&["globe", "folder.png", "-o", "out.boz"], &["folder.png"]);
    work.refuses(&["replay", "ball.boz", "folder.edits", "-o", "out.boz"], &["folder.edits"]);
}

#[test]
fn files_of_something_else() {
    let work = workplace();
    // Bytes without pattern, the same every time.
    let mut state = 1u32;
    let mut junk: Vec<u8> = (0..3000)
        .map(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        })
        .collect();
    junk[0] = b'v';
    let pictures = grey_png(4, 2, |x, y| (x + y) as u16);
    let contents: [(&str, &[u8]); 6] = [
        ("empty", b""),
        ("blank", b" \n\t\n"),
        ("junk", &junk),
        ("words", b"Once upon a time\nthere was a mesh.\n"),
        ("zeros", &[0; 500]),
        ("picture", &pictures),
    ];
    for (what, bytes) in contents {
        for extension in ["boz", "obj", "ply", "stl", "glb", "off"] {
            let name = format!("{what}.{extension}");
            work.write(&name, bytes);
            every_command_refuses(&work, &name);
        }
        if what != "picture" {
            let name = format!("{what}.png");
            work.write(&name, bytes);
            work.refuses(&["globe", &name, "-o", "out.boz"], &[&name]);
        }
        if !bytes.is_ascii() {
            let name = format!("{what}.edits");
            work.write(&name, bytes);
            work.refuses(&["replay", "ball.boz", &name, "-o", "out.boz"], &[&name, "line 1"]);
        }
    }
    // A wavelet file under a mesh's name and the other way round.
    work.write("wavelets.obj", work.read("ball.boz"));
    work.refuses(&["import", "wavelets.obj", "-o", "out.boz"], &["wavelets.obj"]);
    work.write("mesh.boz", work.read("ball.obj"));
    every_command_refuses(&work, "mesh.boz");
}

/// Commands that take a mesh.
fn every_reader_refuses(work: &Workplace, mesh: &str, naming: &[&str]) {
    work.refuses(&["import", mesh, "-o", "out.boz"], &[&[mesh], naming].concat());
    every_reader_as_it_is_refuses(work, mesh, naming);
}

/// Commands that take a mesh as it is.
fn every_reader_as_it_is_refuses(work: &Workplace, mesh: &str, naming: &[&str]) {
    let naming = [&[mesh], naming].concat();
    work.refuses(&["import", mesh, "-o", "out.boz", "--remesh", "never", "--json"], &naming);
    work.refuses(&["info", mesh, "--json"], &naming);
    work.refuses(&["render", mesh, "-o", "out.png"], &naming);
}

#[test]
fn numbers_that_no_mesh_can_have() {
    let work = workplace();
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    let meshes = [
        ("nan.obj", "v 0 0 0\nv nan 0 0\nv 1 1 0\nf 1 2 3\n".to_owned(), "line 2"),
        ("infinite.obj", "v 0 0 0\nv 1 0 0\nv 1 -inf 0\nf 1 2 3\n".to_owned(), "line 3"),
        ("huge.obj", "v 0 0 0\nv 1 0 0\nv 1 1e300 0\nf 1 2 3\n".to_owned(), "line 3"),
        ("word.obj", "v 0 0 0\nv 1 zero 0\nv 1 1 0\nf 1 2 3\n".to_owned(), "line 2"),
        ("flat.obj", "v 0 0\nv 1 0\nv 1 1\nf 1 2 3\n".to_owned(), "line 1"),
        ("beyond.obj", format!("{square}f 1 2 3\nf 1 3 5\n"), "line 6"),
        ("zero.obj", format!("{square}f 1 2 3\nf 0 1 3\n"), "line 6"),
        ("back.obj", format!("{square}f 1 2 3\nf -1 -2 -5\n"), "line 6"),
        ("pair.obj", format!("{square}f 1 2 3\nf 1 3\n"), "line 6"),
        ("points.obj", square.to_owned(), "no face"),
        ("faces.obj", "f 1 2 3\n".to_owned(), "no vertex"),
        ("nan.off", "OFF\n3 1 0\n0 0 0\n1 nan 0\n1 1 0\n3 0 1 2\n".to_owned(), "line 4"),
        ("beyond.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n3 0 1 3\n".to_owned(), "line 6"),
        ("negative.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n1 1 0\n3 0 1 -1\n".to_owned(), "line 6"),
        ("points.off", "OFF\n3 0 0\n0 0 0\n1 0 0\n1 1 0\n".to_owned(), "no face"),
        ("short.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n".to_owned(), "2 of 3"),
        ("greedy.off", "OFF\n4000000000 1 0\n0 0 0\n".to_owned(), "more than"),
        ("nan.ply", ply("nan 0 0", "3 0 1 2"), "line 11"),
        ("beyond.ply", ply("1 0 0", "3 0 1 3"), "line 13"),
        ("negative.ply", ply("1 0 0", "3 0 1 -1"), "line 13"),
        ("points.ply", ply("1 0 0", "").replace("element face 1", "element face 0"), "no face"),
        ("nan.stl", stl("nan 0 0"), "line 5"),
        ("pair.stl", stl("").replace("vertex \n", ""), "line 6"),
        ("cut.stl", stl("1 0 0").replace("endsolid", ""), "endsolid"),
        ("points.stl", "solid\nendsolid\n".to_owned(), "no face"),
    ];
    for (name, content, place) in meshes {
        work.write(name, content);
        every_reader_refuses(&work, name, &[place]);
    }
}

/// A triangle as STL text with its second corner given.
fn stl(corner: &str) -> String {
    format!(
        "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex {corner}\nvertex 1 1 0\nendloop\nendfacet\n\
         endsolid\n"
    )
}

/// A triangle as ASCII PLY with its second vertex and its face given.
fn ply(vertex: &str, face: &str) -> String {
    format!(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
         element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n{vertex}\n1 1 0\n{face}\n"
    )
}

#[test]
fn meshes_that_are_no_surface() {
    let work = workplace();
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1 1 1\nv -1 0 0\nv 0 -1 0\n";
    let mobius = "f 1 2 3\nf 2 3 4\nf 3 4 5\nf 4 5 1\nf 5 1 2\n";
    let meshes = [
        ("edge.obj", "f 1 2 3\nf 1 2 4\nf 1 2 5\n", "edge between vertices 0 and 1"),
        ("vertex.obj", "f 1 2 3\nf 1 4 5\n", "around vertex 0"),
        ("mobius.obj", mobius, "one-sided"),
        ("degenerate.obj", "f 1 2 3\nf 1 3 3\n", "vertex 2 twice"),
    ];
    for (name, faces, what) in meshes {
        work.write(name, format!("{corners}{faces}"));
        every_reader_as_it_is_refuses(&work, name, &[what]);
    }
    work.write("point.obj", "v 1 2 3\nv 1 2 3\nv 1 2 3\nf 1 2 3\n");
    every_reader_refuses(&work, "point.obj", &[]);
    work.write("line.off", "OFF\n4 2 0\n0 0 0\n1 1 1\n2 2 2\n3 3 3\n3 0 1 2\n3 1 2 3\n");
    work.refuses(&["import", "line.off", "-o", "out.boz"], &["line.off", "no face with area"]);
    // A pillow of two faces is a manifold, but no two faces of a base mesh may have the same corners.
    work.write("twice.obj", format!("{corners}f 1 2 3\nf 1 3 2\n"));
    work.refuses(&["import", "twice.obj", "-o", "out.boz", "--remesh", "never"], &["same three corners"]);
    // What is no manifold is repaired and converted otherwise, and what was repaired is said.
    for name in ["edge.obj", "vertex.obj", "mobius.obj", "degenerate.obj", "twice.obj"] {
        for remesh in [&[][..], &["--remesh", "auto"], &["--remesh", "always"]] {
            let report = work.json(&[&["import", name, "-o", "repaired.boz"], remesh].concat());
            assert!(!report["cleaned"].as_array().expect("a list").is_empty(), "{name}, {remesh:?}");
            work.succeeds(&["verify", "repaired.boz"]);
        }
    }
    // A manifold without subdivision connectivity is converted, or stands as its own base mesh.
    work.write("lone.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    work.succeeds(&["import", "lone.obj", "-o", "lone.boz", "--remesh", "never"]);
    work.succeeds(&["import", "lone.obj", "-o", "lone.boz"]);
}
