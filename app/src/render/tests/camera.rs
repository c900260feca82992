//! The camera's arithmetic: no adapter needed.

use glam::{DVec2, DVec3};

use crate::render::{BoundingSphere, Camera, View};

const PICTURE: DVec2 = DVec2::new(1280.0, 800.0);
/// Pixels, and model units times the camera's distance: what `f64` leaves after a dozen operations.
const PIXELS_OFF: f64 = 1e-6;
const OFF: f64 = 1e-9;

/// Cameras of many angles, sizes and places, up to 240 radii from the origin, straight up and down among them.
fn cameras() -> impl Iterator<Item = Camera> {
    (0..240).map(|i| {
        let turn = f64::from(i);
        let radius = 10_f64.powi(i % 7 - 3);
        let center = DVec3::new(turn.sin() * 3.0, turn * 0.1, -turn) * radius;
        let sphere = BoundingSphere { center, radius };
        View { yaw: turn * 17.0, pitch: f64::from(i % 13 - 6) * 15.0, distance: 0.5 + f64::from(i % 4) }
            .camera(sphere, PICTURE.x / PICTURE.y)
    })
}

fn pixels() -> impl Iterator<Item = DVec2> {
    (0..25).map(|i| DVec2::new(f64::from(i % 5) * 320.0, f64::from(i / 5) * 200.0))
}

#[test]
fn a_pixel_projects_back_to_itself() {
    for camera in cameras() {
        for pixel in pixels() {
            let place = camera.unproject(pixel, camera.target, PICTURE);
            let back = camera.project(place, PICTURE).expect("the target lies in front of the eye");
            assert!(back.distance(pixel) < PIXELS_OFF, "{pixel} came back as {back} from {camera:?}");

            let ray = camera.ray(pixel, PICTURE);
            assert!((ray.direction.length() - 1.0).abs() < OFF);
            let along = camera.project(ray.origin + ray.direction * camera.distance * 7.0, PICTURE);
            assert!(along.expect("in front").distance(pixel) < PIXELS_OFF);
        }
    }
}

#[test]
fn the_matrix_agrees_with_project() {
    for camera in cameras() {
        for pixel in pixels() {
            let through = camera.target + DVec3::new(0.1, 0.2, -0.1) * camera.distance;
            let place = camera.unproject(pixel, through, PICTURE);
            let clip = camera.view_projection(PICTURE.x / PICTURE.y) * place.extend(1.0);
            let ndc = clip.truncate() / clip.w;
            let matrix_pixel = (DVec2::new(ndc.x, -ndc.y) * 0.5 + 0.5) * PICTURE;
            assert!(matrix_pixel.distance(pixel) < PIXELS_OFF, "{matrix_pixel} is not {pixel}");
            let depth = camera.near() / camera.depth_of(place);
            assert!((ndc.z - depth).abs() < OFF && (0.0..1.0).contains(&ndc.z), "depth is near / distance");
        }
    }
}

#[test]
fn what_lies_behind_the_eye_has_no_pixel() {
    let camera = Camera::default();
    assert_eq!(camera.project(camera.eye() * 2.0, PICTURE), None);
    assert_eq!(camera.project(camera.eye(), PICTURE), None);
    assert_eq!(camera.project(DVec3::NAN, PICTURE), None);
}

#[test]
fn presets_look_along_the_axes() {
    let sphere = BoundingSphere { center: DVec3::ZERO, radius: 2.0 };
    for (view, eye, up) in [
        (View::FRONT, DVec3::Z, DVec3::Y),
        (View::RIGHT, DVec3::X, DVec3::Y),
        (View::TOP, DVec3::Y, DVec3::NEG_Z),
    ] {
        let camera = view.camera(sphere, 1.0);
        assert!(camera.eye().normalize().distance(eye) < OFF);
        assert!(camera.axes()[1].distance(up) < OFF);
    }
}

#[test]
fn a_fitted_sphere_fills_the_shorter_side() {
    let sphere = BoundingSphere { center: DVec3::new(3.0, -1.0, 2.0), radius: 0.25 };
    for picture in [DVec2::new(900.0, 300.0), DVec2::new(300.0, 900.0), DVec2::splat(400.0)] {
        let camera = View::FRONT.camera(sphere, picture.x / picture.y);
        // The silhouette of a ball lies on a cone: its half angle has the sine radius / distance.
        let cone = (sphere.radius / camera.distance).asin().tan();
        let fraction = cone / ((camera.vertical_fov * 0.5).tan() * (picture.x / picture.y).min(1.0));
        assert!((0.90..0.95).contains(&fraction), "fills {fraction} of {picture}");
        let farther = View { distance: 2.0, ..View::FRONT }.camera(sphere, picture.x / picture.y);
        assert!((farther.distance / camera.distance - 2.0).abs() < OFF);
    }
}

#[test]
fn zooming_keeps_what_is_under_the_cursor() {
    for mut camera in cameras() {
        let pixel = DVec2::new(1000.0, 130.0);
        let place = camera.unproject(pixel, camera.target, PICTURE);
        camera.zoom_at(0.6, pixel, PICTURE);
        assert!(camera.project(place, PICTURE).expect("in front").distance(pixel) < PIXELS_OFF);
    }
}

#[test]
fn panning_follows_the_cursor() {
    for mut camera in cameras() {
        let place = camera.target;
        let moved = DVec2::new(40.0, -25.0);
        camera.pan(moved, PICTURE);
        let pixel = camera.project(place, PICTURE).expect("in front");
        assert!(pixel.distance(PICTURE * 0.5 + moved) < PIXELS_OFF);
    }
}

#[test]
fn a_pixel_spans_world_per_pixel() {
    for camera in cameras() {
        let place = camera.target + camera.axes()[2] * (camera.distance * 0.3);
        let step = camera.world_per_pixel_at(place, PICTURE);
        let right = camera.project(place + camera.axes()[0] * step, PICTURE).expect("in front");
        let pixel = camera.project(place, PICTURE).expect("in front");
        assert!((right - pixel).distance(DVec2::X) < PIXELS_OFF);
    }
}

#[test]
fn orbiting_stops_at_the_poles_and_zooming_stays_finite() {
    let mut camera = Camera::default();
    camera.orbit(100.0, 100.0);
    assert!((0.0..std::f64::consts::TAU).contains(&camera.yaw));
    assert!((camera.pitch.to_degrees() - 90.0).abs() < OFF);
    for factor in [0.0, f64::NAN, f64::INFINITY] {
        camera.zoom(factor);
        assert!(camera.distance > 0.0 && camera.distance.is_finite());
        assert!(camera.view_projection(1.0).is_finite());
    }
}

#[test]
fn bounds_leave_out_what_is_not_finite() {
    let sphere = BoundingSphere::of(&[
        [1.0, 0.0, 0.0],
        [3.0, 0.0, 0.0],
        [f32::NAN, 0.0, 0.0],
        [0.0, f32::INFINITY, 0.0],
    ]);
    assert_eq!(sphere, BoundingSphere { center: DVec3::new(2.0, 0.0, 0.0), radius: 1.0 });
    assert_eq!(BoundingSphere::of(&[]).radius, 1.0);
    assert_eq!(BoundingSphere::of(&[[5.0; 3]]), BoundingSphere { center: DVec3::splat(5.0), radius: 1.0 });
}

#[test]
fn views_are_read_from_text() {
    assert_eq!("30, -20,1.5".parse(), Ok(View { yaw: 30.0, pitch: -20.0, distance: 1.5 }));
    assert_eq!("top".parse(), Ok(View::TOP));
    for wrong in ["", "30", "30,20", "30,20,1,1", "a,b,c", "0,91,1", "0,0,0", "0,0,-1", "nan,0,1", "0,0,inf"]
    {
        let error = wrong.parse::<View>().expect_err(wrong).to_string();
        assert!(error.contains("yaw,pitch,distance"), "{error}");
    }
}
