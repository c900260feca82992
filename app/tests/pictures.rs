//! Pictures of a globe, drawn without a window. Where there is no graphics adapter the program says what to install,
//! and these tests say that they were skipped.

mod models;
mod program;

use image::RgbaImage;
use models::grey_png;
use program::{Workplace, skipped};

/// A folder with `globe.boz`, four levels over an octahedron; `None`, said loudly, where nothing can be drawn.
fn globe(test: &str) -> Option<Workplace> {
    let work = Workplace::new();
    let hills = |x: u32, y: u32| ((x * 7 % 32) * 1000 + (y * 5 % 16) * 2000) as u16;
    work.write("grey.png", grey_png(64, 32, hills));
    work.succeeds(&["globe", "grey.png", "-o", "globe.boz", "--levels", "4", "--relief", "0.5"]);
    let outcome = work.run(&["render", "globe.boz", "-o", "probe.png", "--size", "16x16"]);
    if outcome.status != 0 && outcome.stderr.contains("adapter") {
        skipped(test, &outcome.stderr);
        return None;
    }
    Some(work)
}

/// The picture that `render` makes with these options, 320 by 240.
fn picture(work: &Workplace, options: &[&str]) -> RgbaImage {
    let arguments = [&["render", "globe.boz", "-o", "out.png", "--size", "320x240"], options].concat();
    assert_eq!(work.succeeds(&arguments), "");
    let picture = image::load_from_memory(&work.read("out.png")).expect("a PNG").into_rgba8();
    assert_eq!(picture.dimensions(), (320, 240));
    picture
}

/// Pixels that differ by more than rounding.
fn changed(a: &RgbaImage, b: &RgbaImage) -> usize {
    let differs =
        |(a, b): &(&image::Rgba<u8>, &image::Rgba<u8>)| a.0.iter().zip(b.0).any(|(&a, b)| a.abs_diff(b) > 8);
    a.pixels().zip(b.pixels()).filter(differs).count()
}

#[test]
fn a_globe_in_the_middle_of_its_background() {
    let Some(work) = globe("a_globe_in_the_middle_of_its_background") else { return };
    let picture = picture(&work, &[]);
    let pixel = |x, y| *picture.get_pixel(x, y);
    let corners = [pixel(0, 0), pixel(319, 0), pixel(0, 239), pixel(319, 239)];
    let lightness = |p: image::Rgba<u8>| p.0[..3].iter().map(|&x| i32::from(x)).sum::<i32>();
    for corner in corners {
        assert!((lightness(pixel(160, 120)) - lightness(corner)).abs() > 60, "middle and corner differ");
        assert_eq!(corner.0[3], 255, "the background is opaque");
    }
    let colours: std::collections::BTreeSet<[u8; 4]> = picture.pixels().map(|p| p.0).collect();
    assert!(colours.len() > 100, "shaded, not flat: {} colours", colours.len());
    for size in ["33x77", "1x1", "640x8"] {
        work.succeeds(&["render", "globe.boz", "-o", "small.png", "--size", size]);
        let small = image::load_from_memory(&work.read("small.png")).expect("a PNG");
        assert_eq!(format!("{}x{}", small.width(), small.height()), size);
    }
}

#[test]
fn the_same_picture_every_time() {
    let Some(work) = globe("the_same_picture_every_time") else { return };
    assert!(picture(&work, &[]) == picture(&work, &[]));
    assert!(
        picture(&work, &[]) == picture(&work, &["--level", "4", "--view", "30,18,1", "--shading", "clay"])
    );
}

#[test]
fn levels_views_and_shadings_differ() {
    let Some(work) = globe("levels_views_and_shadings_differ") else { return };
    let kinds: [&[&str]; 12] = [
        &["--level", "0"],
        &["--level", "1"],
        &["--level", "2"],
        &["--level", "4"],
        &["--view", "front"],
        &["--view", "right"],
        &["--view", "top"],
        &["--view", "30,18,2"],
        &["--light"],
        &["--shading", "porcelain"],
        &["--shading", "normals"],
        &["--shading", "flat"],
    ];
    let pictures: Vec<RgbaImage> = kinds.iter().map(|options| picture(&work, options)).collect();
    for (a, first) in pictures.iter().enumerate() {
        for (b, second) in pictures.iter().enumerate().skip(a + 1) {
            assert!(changed(first, second) >= 200, "{:?} and {:?} look the same", kinds[a], kinds[b]);
        }
    }
}

#[test]
fn every_overlay_is_seen() {
    let Some(work) = globe("every_overlay_is_seen") else { return };
    let bare = picture(&work, &[]);
    let overlays =
        ["edges", "edges=1", "handles=1", "control=0", "scaling=0/4", "wavelet=0/9", "scaling=2/40"];
    for overlay in overlays {
        let seen = changed(&bare, &picture(&work, &["--overlay", overlay]));
        assert!(seen >= 200, "{overlay} changes {seen} pixels only");
    }
    // Several at once, and those of a coarser level shown.
    let both = picture(&work, &["--overlay", "edges=1", "--overlay", "handles=1"]);
    assert!(changed(&both, &picture(&work, &["--overlay", "edges=1"])) >= 200);
    let coarse = picture(&work, &["--level", "2"]);
    assert!(changed(&coarse, &picture(&work, &["--level", "2", "--overlay", "edges=2"])) >= 200);
}

#[test]
fn meshes_can_be_drawn_too() {
    let Some(work) = globe("meshes_can_be_drawn_too") else { return };
    work.succeeds(&["export", "globe.boz", "-o", "globe.ply"]);
    let of_file = picture(&work, &[]);
    work.succeeds(&["render", "globe.ply", "-o", "mesh.png", "--size", "320x240"]);
    let of_mesh = image::load_from_memory(&work.read("mesh.png")).expect("a PNG").into_rgba8();
    assert!(changed(&of_file, &of_mesh) < 50, "{} pixels differ", changed(&of_file, &of_mesh));
}

/// With Vulkan asked for and no driver of it to be found, whatever this machine has.
#[test]
fn without_an_adapter_the_program_says_what_to_install() {
    let work = Workplace::new();
    work.write("grey.png", grey_png(4, 2, |x, y| (x + y) as u16));
    work.succeeds(&["globe", "grey.png", "-o", "globe.boz", "--levels", "2"]);
    let nothing = [
        ("WGPU_BACKEND", "vulkan"),
        ("VK_DRIVER_FILES", "/nowhere/none.json"),
        ("VK_ICD_FILENAMES", "/nowhere/none.json"),
    ];
    let outcome = work.run_with(&["render", "globe.boz", "-o", "out.png"], &nothing);
    assert_eq!((outcome.status, outcome.stdout.as_str()), (1, ""), "{outcome:?}");
    assert!(outcome.stderr.starts_with("error: no graphics adapter"), "{outcome:?}");
    assert!(outcome.stderr.contains("mesa-vulkan-drivers"), "{outcome:?}");
    assert_eq!(outcome.stderr.matches('\n').count(), 1, "{outcome:?}");
    assert!(!work.path("out.png").exists());
}
