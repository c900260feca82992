//! Importing from the command line: up axis and unit, and the report.

mod models;
mod program;

use bozzetto_core::mesh::TriangleMesh;
use models::{obj, read_obj, wavy_ball};
use program::{Workplace, one_object, skipped};

/// A wavy ball without subdivision connectivity, far from the origin and tall along z.
fn tall() -> TriangleMesh {
    let mut mesh = wavy_ball(3);
    mesh.positions.iter_mut().for_each(|p| *p = [p[0] + 10.0, p[1] - 20.0, 2.0 * p[2] + 30.0]);
    let [a, b, c] = mesh.faces.pop().expect("faces");
    let middle =
        std::array::from_fn(|k| [a, b, c].iter().map(|&v| mesh.positions[v as usize][k]).sum::<f64>() / 3.0);
    let m = mesh.positions.len() as u32;
    mesh.positions.push(middle);
    mesh.faces.extend([[a, b, m], [b, c, m], [c, a, m]]);
    mesh
}

const SMALL: [&str; 4] = ["--levels", "2", "--base-faces", "40"];

/// Environment in which no adapter can be found, whatever this machine has.
const NO_ADAPTER: [(&str, &str); 3] = [
    ("WGPU_BACKEND", "vulkan"),
    ("VK_DRIVER_FILES", "/nowhere/none.json"),
    ("VK_ICD_FILENAMES", "/nowhere/none.json"),
];

/// The up axis and the unit are kept, and nothing is turned or scaled by them: export gives the coordinates that
/// came in.
#[test]
fn up_axis_and_unit_are_kept_and_coordinates_come_back() {
    let work = Workplace::new();
    let mesh = wavy_ball(3);
    work.write("ball.obj", obj(&mesh));
    let mut exports = Vec::new();
    for (up, unit) in [("x", "m"), ("y", "unknown"), ("z", "mm"), ("z", "cm"), ("z", "in")] {
        let imported = work.json(&["import", "ball.obj", "-o", "ball.boz", "--up", up, "--unit", unit]);
        let shown = if unit == "unknown" { "" } else { unit };
        for report in [&imported, &work.json(&["info", "ball.boz"])] {
            assert_eq!((report["up"].as_str(), report["unit"].as_str()), (Some(up), Some(shown)));
        }
        work.succeeds(&["export", "ball.boz", "-o", "out.obj"]);
        let out = read_obj(&work.text("out.obj"));
        let compared = work.json(&["compare", "ball.obj", "out.obj"]);
        assert!(compared["max"].as_f64().expect("a number") < 1e-7, "{up}: {compared}");
        // Base vertices keep their order, so the first is the first of the file.
        let apart = (0..3).map(|k| (out.positions[0][k] - mesh.positions[0][k]).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-6, "{up}: {:?}", out.positions[0]);
        exports.push(work.read("out.obj"));
    }
    assert!(exports.iter().all(|export| *export == exports[0]), "the same coordinates whatever is up");
    for wrong in [["--up", "w"], ["--unit", "furlong"]] {
        let outcome = work.run(&[&["import", "ball.obj", "-o", "out.boz"][..], &wrong].concat());
        assert_eq!(outcome.status, 2, "{outcome:?}");
    }
}

/// Edges that the file marks become sharp, and leave with the export.
#[test]
fn marked_edges_are_kept_and_exported() {
    let work = Workplace::new();
    let mesh = tall();
    let ring = |v: u32| mesh.positions[v as usize][2] == 30.0;
    let mut text = obj(&mesh);
    for &[a, b, c] in &mesh.faces {
        for [a, b] in [[a, b], [b, c], [c, a]].into_iter().filter(|ends| ends.iter().all(|&v| ring(v))) {
            text += &format!("l {} {}\n", a + 1, b + 1);
        }
    }
    work.write("ring.obj", text);
    work.write("plain.obj", obj(&mesh));
    for (name, marked) in [("ring", true), ("plain", false)] {
        let (model, wavelets) = (format!("{name}.obj"), format!("{name}.boz"));
        work.json(&[&["import", &model, "-o", &wavelets][..], &SMALL].concat());
        let sharp = work.json(&["info", &wavelets])["sharp_edges"].as_u64().expect("a count");
        work.succeeds(&["export", &wavelets, "-o", "out.obj"]);
        let lines = work.text("out.obj").lines().filter(|line| line.starts_with("l ")).count() as u64;
        assert_eq!((sharp > 2, lines), (marked, 4 * sharp), "{name}");
    }
}

/// The base mesh is mirrored where the mesh nearly is its own mirror image, and refused with how far it is off elsewhere.
#[test]
fn a_base_mesh_is_mirrored_along_an_axis() {
    let work = Workplace::new();
    let mut mesh = tall();
    mesh.positions.iter_mut().for_each(|p| p[0] += 0.3 * (p[1] + 20.0).powi(2));
    work.write("ball.obj", obj(&mesh));
    let import =
        |more: &[&'static str]| [&["import", "ball.obj", "-o", "ball.boz"][..], &SMALL, more].concat();
    let plain = work.json(&import(&[]));
    for axis in ["z", "Z"] {
        let json = work.json(&import(&["--symmetric", axis]));
        let faces = json["base_faces"].as_u64().expect("a count");
        assert!(faces <= 40 && faces.is_multiple_of(2), "{faces}");
        assert_ne!(json["hash"], plain["hash"]);
    }
    work.refuses(&import(&["--symmetric", "x"]), &["ball.obj", "mirrored along x", "% of its diagonal"]);
    let outcome = work.run(&import(&["--symmetric", "up"]));
    assert!(outcome.status == 2 && outcome.stderr.contains("x, y, z"), "{outcome:?}");
    // Vertices that are kept are not mirrored, and that is said.
    work.write("regular.obj", obj(&wavy_ball(2)));
    let kept = work.json(&["import", "regular.obj", "-o", "kept.boz", "--symmetric", "x"]);
    let said = kept["cleaned"].to_string();
    assert!(said.contains("not made symmetric along x"), "{said}");
}

/// A model whose z axis is up is drawn upright: as its copy, turned, whose y axis is.
#[test]
fn a_model_with_z_up_is_drawn_upright() {
    let work = Workplace::new();
    let mut mesh = wavy_ball(3);
    mesh.positions.iter_mut().for_each(|p| p[2] *= 2.0);
    work.write("z.obj", obj(&mesh));
    mesh.positions.iter_mut().for_each(|p| *p = [p[0], p[2], -p[1]]);
    work.write("y.obj", obj(&mesh));
    mesh.positions.iter_mut().for_each(|p| *p = [p[1], -p[0], p[2]]);
    work.write("x.obj", obj(&mesh));
    let picture = |name: &str, up: &str| {
        work.succeeds(&["import", name, "-o", "up.boz", "--up", up]);
        let outcome = work.run(&["render", "up.boz", "-o", "up.png", "--size", "200x200"]);
        if outcome.status != 0 && outcome.stderr.contains("adapter") {
            skipped("a_model_with_z_up_is_drawn_upright", &outcome.stderr);
            return None;
        }
        Some(image::load_from_memory(&work.read("up.png")).expect("a PNG").into_rgba8())
    };
    let Some(upright) = picture("y.obj", "y") else { return };
    let differs = |other: &image::RgbaImage| {
        upright
            .pixels()
            .zip(other.pixels())
            .filter(|(a, b)| (0..3).any(|c| a.0[c].abs_diff(b.0[c]) > 8))
            .count()
    };
    for (name, up) in [("z.obj", "z"), ("x.obj", "x")] {
        let same = differs(&picture(name, up).expect("an adapter"));
        let lying = differs(&picture(name, "y").expect("an adapter"));
        assert!(same < 100 && lying > 2000, "{name}: {same} pixels differ upright, {lying} lying");
    }
}

/// Everything a report is to tell, and nothing fetched from elsewhere.
#[test]
fn a_report_is_whole_and_on_its_own() {
    let work = Workplace::new();
    let mut mesh = tall();
    mesh.positions.push([0.0; 3]);
    work.write("ball.obj", obj(&mesh));
    let arguments =
        ["import", "ball.obj", "-o", "ball.boz", "--report", "ball.html", "--unit", "mm", "--json"];
    let outcome = work.run(&[&arguments[..], &SMALL, &["--tolerance", "1e-9"]].concat());
    assert!(outcome.status == 0 && outcome.stderr.is_empty(), "{outcome:?}");
    let json = one_object(&outcome.stdout);
    assert_eq!(json["tolerance_met"], false);
    let page = work.text("ball.html");
    for part in [
        "<title>Import of ball.obj</title>",
        "prefers-color-scheme: dark",
        "mesh to surface",
        "surface to mesh",
        "mean",
        "rms",
        "maximum",
        "\u{202f}mm",
        "not met",
        "above 15°",
        "faces at a vertex",
        "Boundary loops",
        "1 vertex that no face uses was left out",
        "at most 40",
        "2-disc",
        "24 bits",
        "Simplify it to a base mesh",
        "Make the wavelets",
        "SHA-256",
        "ball.boz",
        json["hash"].as_str().expect("a hash"),
    ] {
        assert!(page.contains(part), "{part} is missing");
    }
    let source = work.json(&["info", "ball.obj"]);
    assert_eq!(source["vertices"], 259);
    assert!(page.starts_with("<!DOCTYPE html>") && page.trim_end().ends_with("</html>"));
    for elsewhere in ["http:", "https:", "src=\"/", "<script", "<link", "@import", "url("] {
        assert!(!page.contains(elsewhere), "{elsewhere} reaches outside");
    }
    assert!(page.len() < 3 << 20, "{} bytes", page.len());
    if page.contains("There are no pictures") {
        skipped("a_report_is_whole_and_on_its_own", "no graphics adapter");
        return;
    }
    let pictures: Vec<&str> = page.split("src=\"data:image/png;base64,").skip(1).collect();
    assert_eq!(pictures.len(), 4, "before, after, base mesh, error");
    assert!(
        page.contains("linear-gradient") && page.contains("≥ 1.00e-7\u{202f}%"),
        "a legend up to the tolerance"
    );
    for picture in pictures {
        let data = picture.split('"').next().expect("the address ends");
        let mut bytes = Vec::new();
        for four in data.as_bytes().chunks(4) {
            bytes.extend(decode(four));
        }
        let picture = image::load_from_memory(&bytes).expect("a PNG");
        assert_eq!((picture.width(), picture.height()), (640, 560));
    }
}

/// Three bytes, or fewer, from four characters of base64.
fn decode(four: &[u8]) -> Vec<u8> {
    const DIGITS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let digits: Vec<u32> = four
        .iter()
        .take_while(|&&c| c != b'=')
        .map(|c| DIGITS.iter().position(|d| d == c).expect("base64") as u32)
        .collect();
    let whole = (0..4).fold(0, |whole, k| whole << 6 | digits.get(k).copied().unwrap_or(0));
    whole.to_be_bytes()[1..digits.len()].to_vec()
}

/// Without an adapter the report says so and is written all the same.
#[test]
fn a_report_without_pictures_says_why() {
    let work = Workplace::new();
    work.write("ball.obj", obj(&tall()));
    let arguments = [&["import", "ball.obj", "-o", "ball.boz", "--report", "ball.html"][..], &SMALL].concat();
    let outcome = work.run_with(&arguments, &NO_ADAPTER);
    assert_eq!(outcome.status, 0, "{outcome:?}");
    let page = work.text("ball.html");
    assert!(page.contains("There are no pictures: no graphics adapter"), "it says why");
    assert!(!page.contains("<img") && page.contains("surface to mesh") && page.contains("</html>"));
}

/// Names are text, whatever they hold; a mesh with subdivision connectivity has a report too.
// Windows has no such names.
#[cfg(unix)]
#[test]
fn a_hostile_name_is_only_text() {
    let work = Workplace::new();
    let name = "<img src=x onerror=alert(1)>&\"'.obj";
    work.write(name, obj(&wavy_ball(2)));
    let outcome = work.run_with(&["import", name, "-o", "<b>.boz", "--report", "report.html"], &NO_ADAPTER);
    assert_eq!(outcome.status, 0, "{outcome:?}");
    let page = work.text("report.html");
    assert!(page.contains("Import of &lt;img src=x onerror=alert(1)&gt;&amp;&quot;&#39;.obj"), "escaped");
    assert!(!page.contains("<img") && !page.contains("<b>.boz") && !page.contains("&\"'"));
    assert!(page.contains("its vertices were kept") && page.contains("2 levels over 8 base faces"));
}

/// Refused before any work, or not written at all.
#[test]
fn a_report_is_replaced_in_one_step_or_not_at_all() {
    let work = Workplace::new();
    work.write("ball.obj", obj(&wavy_ball(2)));
    work.write("old.html", "old");
    let import = |mesh: &str, report: &str, naming: &[&str]| {
        work.refuses(&["import", mesh, "-o", "out.boz", "--report", report], naming)
    };
    import("ball.obj", "report.pdf", &["report.pdf", ".html"]);
    import("ball.obj", "missing/report.html", &["missing", "no folder"]);
    std::fs::create_dir(work.path("folder.html")).expect("a folder");
    import("ball.obj", "folder.html", &["folder.html", "not a regular file"]);
    work.write("broken.obj", "v 0 0 0\nf 1 2 3\n");
    import("broken.obj", "old.html", &["broken.obj", "line 2"]);
    assert_eq!(work.text("old.html"), "old");
    let outcome =
        work.run_with(&["import", "ball.obj", "-o", "out.boz", "--report", "old.html"], &NO_ADAPTER);
    assert_eq!(outcome.status, 0, "{outcome:?}");
    assert!(work.text("old.html").starts_with("<!DOCTYPE html>"));
    assert_eq!(work.contents().keys().filter(|name| name.starts_with("old")).count(), 1, "nothing beside it");
}
