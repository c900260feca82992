//! `--bytes`, `--psnr` and `--keep`: as much of a surface as a size or a distance allows, as a wavelet file or a mesh.

mod models;
mod program;

use models::ball_boz;
use program::Workplace;

#[test]
fn a_wavelet_file_of_so_many_bytes() {
    let work = Workplace::new();
    ball_boz(&work);
    let mut before = f64::INFINITY;
    for bytes in ["400", "900", "2000"] {
        work.succeeds(&["export", "ball.boz", "-o", "small.boz", "--bytes", bytes]);
        let length = work.read("small.boz").len();
        assert!(length <= bytes.parse().expect("a number"), "{length} of {bytes} bytes");
        let info = work.json(&["info", "small.boz"]);
        assert_eq!(info["complete"], true);
        assert_eq!(info["bytes"], length);
        let rms = work.json(&["compare", "ball.boz", "small.boz"])["rms"].as_f64().expect("a number");
        assert!(rms < before, "{bytes} bytes: {rms} after {before}");
        before = rms;
    }
    work.refuses(&["export", "ball.boz", "-o", "small.boz", "--bytes", "20"], &["ball.boz", "bytes"]);
    work.refuses(&["export", "ball.boz", "-o", "small.boz", "--level", "1"], &["small.boz", "--level"]);
    let both = work.run(&["export", "ball.boz", "-o", "small.boz", "--bytes", "900", "--psnr", "60"]);
    assert_eq!(both.status, 2, "{}", both.stderr);
}

#[test]
fn a_file_as_near_as_asked_for() {
    let work = Workplace::new();
    ball_boz(&work);
    work.succeeds(&["export", "ball.boz", "-o", "near.boz", "--psnr", "50"]);
    work.succeeds(&["export", "ball.boz", "-o", "near.obj", "--psnr", "50"]);
    for near in ["near.boz", "near.obj"] {
        let psnr = work.json(&["compare", "ball.boz", near])["psnr"].as_f64().expect("a number");
        assert!((50.0..65.0).contains(&psnr), "{near}: {psnr} dB");
    }
    assert!(work.read("near.boz").len() < work.read("ball.boz").len() / 2);
    work.succeeds(&["import", "ball.obj", "-o", "imported.boz", "--psnr", "50"]);
    let psnr = work.json(&["compare", "ball.obj", "imported.boz"])["psnr"].as_f64().expect("a number");
    assert!((50.0..65.0).contains(&psnr), "imported: {psnr} dB");
}

/// An import keeps what an export of the same surface keeps, and says how far that is from the mesh.
#[test]
fn an_import_keeps_a_share() {
    let work = Workplace::new();
    ball_boz(&work);
    work.succeeds(&["export", "ball.boz", "-o", "exported.boz", "--keep", "0.2"]);
    let imported = work.json(&["import", "ball.obj", "-o", "imported.boz", "--keep", "0.2"]);
    assert_eq!(imported["hash"], work.json(&["info", "exported.boz"])["hash"]);
    assert_ne!(imported["hash"], work.json(&["info", "ball.boz"])["hash"], "something is left out");
    let rms = work.json(&["compare", "ball.obj", "imported.boz"])["rms"].as_f64().expect("a number");
    assert_eq!(imported["rms"].as_f64(), Some(rms));
    let compact = ["import", "ball.obj", "-o", "no.boz", "--purpose", "compact", "--keep", "0.2"];
    work.refuses(&compact, &["--keep"]);
}

#[test]
fn a_compact_import_is_smaller_than_one_for_editing() {
    let work = Workplace::new();
    let mut mesh = models::wavy_ball(3);
    let split = mesh.faces.pop().expect("faces");
    let middle = [0, 1, 2].map(|k| split.map(|v| mesh.positions[v as usize][k]).iter().sum::<f64>() / 3.0);
    let m = mesh.positions.len() as u32;
    mesh.positions.push(middle);
    mesh.faces.extend((0..3).map(|k| [split[k], split[(k + 1) % 3], m]));
    work.write("scan.obj", models::obj(&mesh));
    let import =
        |output: &str, more: &[&str]| work.json(&[&["import", "scan.obj", "-o", output][..], more].concat());
    let edit = import("edit.boz", &["--psnr", "48"]);
    let compact = import("compact.boz", &["--purpose", "compact", "--psnr", "48"]);
    assert_eq!(edit["tried"], 1);
    assert!(compact["tried"].as_u64() > Some(3), "{compact}");
    let length = |name: &str| work.read(name).len();
    assert!(10 * length("compact.boz") < 9 * length("edit.boz"), "{compact} after {edit}");
    let psnr = work.json(&["compare", "scan.obj", "compact.boz"])["psnr"].as_f64().expect("a number");
    assert!((48.0..49.0).contains(&psnr), "{psnr} dB");
    let bytes = length("compact.boz").to_string();
    let again = import("again.boz", &["--purpose", "compact", "--bytes", &bytes]);
    assert!(length("again.boz") <= length("compact.boz"));
    assert!(again["rms"].as_f64() < Some(1.25 * compact["rms"].as_f64().expect("a number")), "{again}");
    let fixed =
        import("fixed.boz", &["--purpose", "compact", "--psnr", "45", "--wavelet", "1", "--levels", "2"]);
    assert_eq!((&fixed["levels"], &fixed["wavelet"]), (&2.into(), &"1".into()), "{fixed}");
    let refused = ["import", "scan.obj", "-o", "no.boz", "--purpose", "compact", "--tolerance", "1e-3"];
    work.refuses(&refused, &["--tolerance", "--psnr"]);
}

#[test]
fn the_curve_falls_to_nothing() {
    let work = Workplace::new();
    ball_boz(&work);
    let info = work.json(&["info", "ball.boz"]);
    let curve = info["curve"].as_array().expect("points");
    let errors: Vec<f64> = curve.iter().map(|p| p["error"].as_f64().expect("a number")).collect();
    assert!(errors.len() > 3 && errors.last() == Some(&0.0), "{errors:?}");
    assert!(errors.windows(2).all(|pair| pair[1] <= 1.1 * pair[0]), "{errors:?}");
    assert!(work.run(&["info", "ball.boz"]).stdout.contains("curve"));
}

#[test]
fn what_keeping_costs_is_said() {
    let work = Workplace::new();
    ball_boz(&work);
    let mut before = f64::INFINITY;
    for keep in ["0.05", "0.3", "1"] {
        let said = work.json(&["export", "ball.boz", "-o", "kept.boz", "--keep", keep]);
        let number = |key: &str| said[key].as_f64().expect("a number");
        let rms = work.json(&["compare", "ball.boz", "kept.boz"])["rms"].as_f64().expect("a number");
        assert!((number("rms") - rms).abs() <= 1e-9, "{keep}: {said}, {rms} measured");
        assert!(number("rms") < before && number("rms") <= 1.01 * number("in_domain"), "{keep}: {said}");
        assert!((number("predicted") - number("in_domain")).abs() <= 0.2 * number("in_domain"), "{said}");
        before = number("rms");
    }
    assert_eq!(before, 0.0);
    let text = work.run(&["export", "ball.boz", "-o", "kept.obj", "--keep", "0.3"]).stdout;
    assert!(text.contains("kept") && text.contains("rms") && text.contains("dropped"), "{text}");
    assert_eq!(work.run(&["export", "ball.boz", "-o", "kept.obj"]).stdout, "");
}

#[test]
fn adaptive_meshes_have_fewer_faces() {
    let work = Workplace::new();
    ball_boz(&work);
    let light = ["export", "ball.boz", "-o", "light.obj", "--adaptive"];
    let by_kept = work.json(&[&light[..], &["--keep", "0.3"]].concat());
    let by_tolerance = work.json(&[&light[..], &["--tolerance", "0.05"]].concat());
    for said in [&by_kept, &by_tolerance] {
        assert!(said["faces"].as_u64() < Some(400) && said["faces_of_finest"] == 512, "{said}");
    }
    assert!(by_tolerance["max"].as_f64() <= Some(0.05) && by_tolerance["max"].as_f64() > Some(0.001));
    assert_eq!(by_kept["tolerance"], by_kept["in_domain"]);
    let mesh = models::read_obj(&String::from_utf8(work.read("light.obj")).expect("text"));
    assert_eq!(by_tolerance["faces"], mesh.faces.len());
    assert_eq!(by_tolerance["vertices"], mesh.positions.len());
    let all = work.json(&light);
    assert_eq!(all["faces"], 512);
    work.refuses(&["export", "ball.boz", "-o", "light.boz", "--adaptive"], &["light.boz", "--adaptive"]);
    for wrong in [["--adaptive", "--level", "1"], ["--keep", "0.3", "--tolerance"]] {
        let run = work.run(&[&["export", "ball.boz", "-o", "light.obj"][..], &wrong].concat());
        assert_eq!(run.status, 2, "{}", run.stderr);
    }
}
