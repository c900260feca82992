//! A mesh through every command: import, info, export, compare, verify, and the help of each.

mod models;
mod program;

use bozzetto_core::mesh::TriangleMesh;
use models::{ball_boz, obj, read_obj, wavy_ball};
use program::Workplace;
use serde_json::{Value, json};

/// Vertices of the ball's levels 0 to 3: an octahedron with 6 vertices, 12 edges and 8 faces, split.
const COUNTS: [usize; 4] = [6, 18, 66, 258];
/// Half a step of a model of this size, over its diagonal, and the rounding of the wavelets behind it.
const QUANTISATION: f64 = 1e-7;

#[track_caller]
fn has_keys(object: &Value, keys: &[&str]) {
    for key in keys {
        assert!(!object[key].is_null(), "{key} is missing or null: {object}");
    }
}

const INFO_KEYS: [&str; 15] = [
    "vertices",
    "faces",
    "levels",
    "base_vertices",
    "base_faces",
    "components",
    "genus",
    "boundary_loops",
    "channels",
    "scheme",
    "wavelet",
    "precision",
    "complete",
    "bytes",
    "hash",
];

#[test]
fn import_and_info_report_what_is_there() {
    let work = Workplace::new();
    work.write("ball.obj", obj(&wavy_ball(3)));
    let imported = work.json(&["import", "ball.obj", "-o", "ball.boz", "--tolerance", "1e-6"]);
    has_keys(&imported, &INFO_KEYS);
    has_keys(&imported, &["seconds", "cleaned", "rms", "max", "tolerance_met"]);
    assert_eq!(imported["tolerance_met"], true);
    assert!(imported["max"].as_f64().expect("a number") < QUANTISATION, "{imported}");
    assert!(imported["rms"].as_f64() <= imported["max"].as_f64(), "{imported}");
    assert_eq!(imported["cleaned"], Value::Array(Vec::new()));

    let info = work.json(&["info", "ball.boz"]);
    for key in INFO_KEYS {
        assert_eq!(info[key], imported[key], "{key}");
    }
    let expected = json!({
        "vertices": 258, "faces": 512, "levels": 3, "base_vertices": 6, "base_faces": 8, "components": 1,
        "genus": 0, "boundary_loops": 0, "channels": ["x", "y", "z"], "scheme": "linear", "wavelet": "2",
        "precision": 24, "complete": true, "bytes": work.read("ball.boz").len(),
    });
    for (key, value) in expected.as_object().expect("an object") {
        assert_eq!(info[key], *value, "{key}");
    }
    // Without a tolerance there is nothing to meet.
    assert_eq!(work.json(&["import", "ball.obj", "-o", "ball.boz"])["tolerance_met"], Value::Null);
    // A mesh has the same figures as its wavelet file, and the text names them too.
    let mesh = work.json(&["info", "ball.obj"]);
    assert_eq!(mesh["hash"], info["hash"]);
    let text = work.succeeds(&["info", "ball.boz"]);
    assert!(
        text.contains("258 vertices, 512 faces") && text.contains(info["hash"].as_str().unwrap()),
        "{text}"
    );
}

/// STL and GLB go through every command that takes a mesh, and keep the connectivity they were written with.
#[test]
fn stl_and_glb_are_meshes_like_any_other() {
    let work = Workplace::new();
    ball_boz(&work);
    for mesh in ["ball.stl", "ball.glb"] {
        work.succeeds(&["export", "ball.boz", "-o", mesh]);
        let imported = work.json(&["import", mesh, "-o", "again.boz"]);
        assert_eq!((&imported["levels"], &imported["base_faces"]), (&json!(3), &json!(8)), "{mesh}");
        assert_eq!(work.json(&["info", mesh])["vertices"], 258, "{mesh}");
        let distance = work.json(&["compare", "ball.boz", mesh])["max"].as_f64().expect("a number");
        assert!(distance < QUANTISATION, "{mesh}: {distance}");
        work.succeeds(&["verify", "ball.boz", "--against", mesh]);
    }
}

/// Options of import reach the file.
#[test]
fn import_options_are_kept() {
    let work = Workplace::new();
    work.write("ball.obj", obj(&wavy_ball(3)));
    let precise = |bits: &str| {
        let report = work.json(&["import", "ball.obj", "-o", "out.boz", "--precision", bits]);
        assert_eq!(report["precision"].to_string(), bits);
        report["max"].as_f64().expect("a number")
    };
    assert!(precise("8") > 100.0 * precise("16"), "fewer bits, larger steps");
    for (levels, faces) in [("1", 128), ("2", 32), ("3", 8), ("9", 8)] {
        let report = work.json(&["import", "ball.obj", "-o", "out.boz", "--levels", levels]);
        assert_eq!(report["base_faces"], faces, "at most {levels} levels");
    }
    for wavelet in ["lazy", "0", "1"] {
        let report = work.json(&["import", "ball.obj", "-o", "out.boz", "--wavelet", wavelet]);
        assert_eq!(report["wavelet"], wavelet);
    }
}

#[test]
fn every_level_exports_in_every_format() {
    let work = Workplace::new();
    ball_boz(&work);
    for (level, count) in COUNTS.iter().enumerate() {
        let name = |extension: &str| format!("{level}.{extension}");
        for extension in ["obj", "ply", "stl", "glb", "off"] {
            let arguments = ["export", "ball.boz", "-o", &name(extension), "--level", &level.to_string()];
            assert_eq!(work.succeeds(&arguments), "");
        }
        let mesh = read_obj(&work.text(&name("obj")));
        let faces = 8 << (2 * level);
        assert_eq!((mesh.positions.len(), mesh.faces.len()), (*count, faces));
        for extension in ["ply", "off"] {
            let compared = work.json(&["compare", &name("obj"), &name(extension), "--samples", "1000"]);
            assert_eq!(compared["max"], 0.0, "level {level} as {extension}");
            let info = work.json(&["info", &name(extension)]);
            assert_eq!((&info["vertices"], &info["faces"]), (&(*count).into(), &faces.into()));
        }
        check_stl(&work.read(&name("stl")), &mesh);
        check_glb(&work.read(&name("glb")), &mesh);
    }
    work.succeeds(&["export", "ball.boz", "-o", "finest.obj"]);
    assert!(work.read("finest.obj") == work.read("3.obj"), "the finest level is the default");
}

/// Corners of binary STL, 50 bytes a triangle after 84 of header.
fn check_stl(bytes: &[u8], mesh: &TriangleMesh) {
    assert_eq!(bytes.len(), 84 + 50 * mesh.faces.len());
    for (face, triangle) in mesh.faces.iter().zip(bytes[84..].chunks(50)) {
        for (&vertex, corner) in face.iter().zip(triangle[12..48].chunks(12)) {
            assert_eq!(floats(corner), mesh.positions[vertex as usize].map(|x| x as f32));
        }
    }
}

/// Positions of binary glTF: the JSON chunk says where in the binary chunk they lie.
fn check_glb(bytes: &[u8], mesh: &TriangleMesh) {
    let length = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("4 bytes")) as usize;
    assert_eq!((&bytes[..4], length(8)), (b"glTF".as_slice(), bytes.len()));
    let json: Value = serde_json::from_slice(&bytes[20..20 + length(12)]).expect("the JSON chunk");
    let binary = &bytes[28 + length(12)..];
    let primitive = &json["meshes"][0]["primitives"][0];
    let number = |value: &Value| value.as_u64().expect("a whole number") as usize;
    let accessor = |of: &Value| &json["accessors"][number(of)];
    let positions = accessor(&primitive["attributes"]["POSITION"]);
    assert_eq!(number(&positions["count"]), mesh.positions.len());
    assert_eq!(number(&accessor(&primitive["indices"])["count"]), 3 * mesh.faces.len());
    let view = &json["bufferViews"][number(&positions["bufferView"])];
    let start = view["byteOffset"].as_u64().unwrap_or(0) as usize;
    for (position, bytes) in mesh.positions.iter().zip(binary[start..].chunks(12)) {
        assert_eq!(floats(bytes), position.map(|x| x as f32));
    }
}

fn floats(bytes: &[u8]) -> [f32; 3] {
    std::array::from_fn(|c| f32::from_le_bytes(bytes[4 * c..4 * c + 4].try_into().expect("4 bytes")))
}

/// The ids of a level are the first of the next. Lazy coefficients are samples, so there they stay in place too.
#[test]
fn vertex_ids_are_nested() {
    let work = Workplace::new();
    work.write("ball.obj", obj(&wavy_ball(3)));
    for wavelet in ["lazy", "2"] {
        work.succeeds(&["import", "ball.obj", "-o", "ball.boz", "--wavelet", wavelet]);
        let levels: Vec<TriangleMesh> = (0..4)
            .map(|level| {
                work.succeeds(&["export", "ball.boz", "-o", "level.obj", "--level", &level.to_string()]);
                read_obj(&work.text("level.obj"))
            })
            .collect();
        for pair in levels.windows(2) {
            let [coarse, fine] = pair else { unreachable!("windows of two") };
            let count = coarse.positions.len();
            let same = coarse.positions[..] == fine.positions[..count];
            assert_eq!(same, wavelet == "lazy", "{wavelet}: level of {count} vertices");
            // Splitting a face leaves a triangle with one old corner at each of its corners, and a middle one.
            let mut corners: Vec<u32> =
                fine.faces.iter().flatten().copied().filter(|&v| v < count as u32).collect();
            let mut expected: Vec<u32> = coarse.faces.iter().flatten().copied().collect();
            corners.sort_unstable();
            expected.sort_unstable();
            assert_eq!(corners, expected, "{wavelet}: old corners of the level above {count} vertices");
        }
    }
}

#[test]
fn compare_and_verify() {
    let work = Workplace::new();
    ball_boz(&work);
    let compared = work.json(&["compare", "ball.obj", "ball.boz"]);
    has_keys(&compared, &["a_to_b", "b_to_a", "rms", "max", "psnr", "diagonal"]);
    for way in ["a_to_b", "b_to_a"] {
        has_keys(&compared[way], &["mean", "rms", "max"]);
        assert!(compared[way]["max"].as_f64().expect("a number") < QUANTISATION, "{compared}");
    }
    assert!(compared["psnr"].as_f64().expect("a number") > 120.0, "{compared}");
    let bounds = wavy_ball(3).diagonal();
    assert!((compared["diagonal"].as_f64().expect("a number") - bounds).abs() < 1e-9, "{compared}");
    // A surface and itself; and one that differs.
    assert_eq!(work.json(&["compare", "ball.boz", "ball.boz"])["psnr"], Value::Null);
    work.succeeds(&["export", "ball.boz", "-o", "coarse.obj", "--level", "1"]);
    assert!(work.json(&["compare", "ball.boz", "coarse.obj"])["max"].as_f64().expect("a number") > 0.01);
    assert!(work.succeeds(&["compare", "ball.obj", "ball.boz"]).contains("dB"));

    let verified = work.succeeds(&["verify", "ball.boz", "--against", "ball.obj"]);
    let hash = work.json(&["info", "ball.boz"])["hash"].as_str().expect("a hash").to_owned();
    assert!(verified.contains(&hash) && verified.contains("bit for bit"), "{verified}");
}

/// Leaving out small wavelets brings the surface nearer the more are kept, and all of them give it back.
#[test]
fn export_keeps_the_largest_wavelets() {
    let work = Workplace::new();
    ball_boz(&work);
    let error = |fraction: &str| {
        work.succeeds(&["export", "ball.boz", "-o", "kept.obj", "--keep", fraction]);
        work.json(&["compare", "ball.boz", "kept.obj"])["rms"].as_f64().expect("a number")
    };
    let errors = ["0", "0.1", "0.4", "0.8", "1"].map(error);
    assert!(errors.is_sorted_by(|a, b| a > b), "{errors:?}");
    assert_eq!(errors[4], 0.0, "{errors:?}");
}

#[test]
fn every_command_has_help_with_an_example() {
    let work = Workplace::new();
    let overview = work.succeeds(&["--help"]);
    assert!(overview.contains("Example:"), "{overview}");
    let commands: Vec<&str> = overview
        .lines()
        .skip_while(|line| *line != "Commands:")
        .skip(1)
        .take_while(|line| line.starts_with("  "))
        .filter_map(|line| line.split_whitespace().next())
        .filter(|command| *command != "help")
        .collect();
    for command in
        ["import", "globe", "info", "coefficients", "export", "compare", "replay", "bake", "verify", "render"]
    {
        assert!(commands.contains(&command), "{command}: {overview}");
    }
    for command in commands {
        let help = work.succeeds(&[command, "--help"]);
        assert!(help.contains(&format!("Example: bozzetto {command}")), "{help}");
    }
    assert!(work.contents().is_empty(), "help writes nothing");
}
