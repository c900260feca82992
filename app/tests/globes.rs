//! Globes from pictures: spheres from constant ones, and land where the map has it, east to the right.

mod models;
mod program;

use models::{grey_png, read_obj};
use program::Workplace;

/// A cell of the grid, 5 degrees wide and high.
const CELL: f64 = 5.0;
const WIDTH: u32 = 72;
const HEIGHT: u32 = 36;

/// Vertices and faces of a globe made of `grey.png` with these options, its finest level.
fn globe(work: &Workplace, levels: &str, options: &[&str]) -> bozzetto_core::mesh::TriangleMesh {
    let report =
        work.json(&[&["globe", "grey.png", "-o", "globe.boz", "--levels", levels], options].concat());
    assert_eq!(report["levels"].to_string(), levels);
    assert_eq!((&report["base_faces"], &report["genus"]), (&8.into(), &0.into()));
    work.succeeds(&["verify", "globe.boz"]);
    work.succeeds(&["export", "globe.boz", "-o", "globe.obj"]);
    read_obj(&work.text("globe.obj"))
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[track_caller]
fn is_sphere(positions: &[[f64; 3]], radius: f64) {
    for &p in positions {
        let found = dot(p, p).sqrt();
        assert!((found - radius).abs() < 1e-6, "{found} instead of {radius} at {p:?}");
    }
}

#[test]
fn constant_grids_give_spheres() {
    let work = Workplace::new();
    let grey = 30_000.0 / 65_535.0;
    work.write("grey.png", grey_png(WIDTH, HEIGHT, |_, _| 30_000));
    is_sphere(&globe(&work, "4", &["--relief", "0.5"]).positions, 1.0 + 0.5 * grey);
    is_sphere(
        &globe(&work, "4", &["--relief", "0.5", "--zero", "0.25"]).positions,
        1.0 + 0.5 * (grey - 0.25),
    );
    is_sphere(&globe(&work, "4", &["--relief", "-0.5"]).positions, 1.0 - 0.5 * grey);
    is_sphere(&globe(&work, "4", &["--radius-grid"]).positions, grey);
    // The smallest grid there is, and levels as asked for.
    work.write("grey.png", grey_png(2, 1, |_, _| 65_535));
    let mesh = globe(&work, "2", &["--radius-grid"]);
    is_sphere(&mesh.positions, 1.0);
    assert_eq!(mesh.positions.len(), 66);
}

/// Where on the globe a single high cell of the map comes out: latitude and longitude in degrees, and the point.
fn peak(work: &Workplace, column: u32, row: u32, options: &[&str]) -> (f64, f64, [f64; 3]) {
    work.write(
        "grey.png",
        grey_png(WIDTH, HEIGHT, |x, y| if (x, y) == (column, row) { 60_000 } else { 20_000 }),
    );
    let mesh = globe(work, "6", options);
    let length = |p: &[f64; 3]| dot(*p, *p).sqrt();
    let highest = *mesh.positions.iter().max_by(|a, b| length(a).total_cmp(&length(b))).expect("a vertex");
    let [x, y, z] = highest.map(|c| c / length(&highest));
    (y.asin().to_degrees(), x.atan2(z).to_degrees(), highest)
}

#[test]
fn a_mountain_stands_where_the_map_has_it() {
    let work = Workplace::new();
    for options in [&["--relief", "0.3"][..], &["--radius-grid"]] {
        // Either side of longitude 0 and of the date line, north and south.
        for (column, row) in [(36, 17), (35, 18), (0, 10), (71, 25), (42, 9), (12, 30)] {
            let latitude = 90.0 - CELL * (f64::from(row) + 0.5);
            let longitude = CELL * (f64::from(column) + 0.5) - 180.0;
            let (found_latitude, found_longitude, _) = peak(&work, column, row, options);
            let off = (found_latitude - latitude).abs().max((found_longitude - longitude).abs());
            // Within half a cell, for there is a vertex every 1.4 degrees.
            assert!(
                off < CELL / 2.0,
                "{options:?}: cell {column},{row} at {latitude},{longitude} came out at \
                 {found_latitude},{found_longitude}"
            );
        }
    }
}

/// From outside and with north up, east is to the right: east × north points out of the globe, and faces are
/// counter-clockwise from there.
#[test]
fn the_map_is_not_mirrored() {
    let work = Workplace::new();
    let options = ["--relief", "0.1"];
    for (column, row) in [(36, 17), (54, 12), (3, 24)] {
        let (.., here) = peak(&work, column, row, &options);
        let (.., further_east) = peak(&work, column + 3, row, &options);
        let (.., further_north) = peak(&work, column, row - 3, &options);
        let outwards = cross(minus(further_east, here), minus(further_north, here));
        assert!(dot(outwards, here) > 0.0, "cell {column},{row}");
    }
    // Longitude 0 looks at the viewer who looks from +z; the north pole is +y.
    let (.., greenwich) = peak(&work, 36, 17, &options);
    assert!(greenwich[2] > 0.99, "{greenwich:?}");
    let (.., india) = peak(&work, 54, 17, &options);
    assert!(india[0] > 0.99, "{india:?}");
    let (.., arctic) = peak(&work, 36, 0, &options);
    assert!(arctic[1] > 0.99, "{arctic:?}");

    let mesh = read_obj(&work.text("globe.obj"));
    for face in &mesh.faces {
        let [a, b, c] = face.map(|v| mesh.positions[v as usize]);
        assert!(dot(cross(minus(b, a), minus(c, a)), a) > 0.0, "{face:?} faces outwards");
    }
}

/// The elevations of the Earth that come with the program.
#[test]
fn the_earth() {
    let work = Workplace::new();
    let picture = concat!(env!("CARGO_MANIFEST_DIR"), "/../assets/earth-elevation.png");
    work.write("grey.png", std::fs::read(picture).expect("the sample's elevations"));
    let mesh = globe(&work, "6", &["--zero", "0.16785"]);
    let height = |latitude: f64, longitude: f64| {
        let (latitude, longitude) = (latitude.to_radians(), longitude.to_radians());
        let direction = [latitude.cos() * longitude.sin(), latitude.sin(), latitude.cos() * longitude.cos()];
        let nearest =
            mesh.positions.iter().max_by(|a, b| dot(**a, direction).total_cmp(&dot(**b, direction)));
        let p = nearest.expect("a vertex");
        dot(*p, *p).sqrt()
    };
    let (tibet, andes, pacific) = (height(33.0, 88.0), height(-20.0, -67.0), height(0.0, -150.0));
    assert!(tibet > pacific + 0.01, "Tibet {tibet}, Pacific {pacific}");
    assert!(andes > pacific + 0.005, "Andes {andes}, Pacific {pacific}");
}
