//! What is in a picture. Small ones, one sample a pixel unless smoothing itself is the matter.

use glam::{DVec2, DVec3};
use image::{Rgba, RgbaImage};

use super::shapes::{self, Shape};
use crate::render::{
    Background, BoundingSphere, Camera, GhostMesh, Gpu, GpuError, Handle, HandleState, Line, LineStyle,
    Samples, Scene, Shading, Style, SurfaceRenderer, View, grid, render_png,
};

const SIZE: [u32; 2] = [256, 256];
const PICTURE: DVec2 = DVec2::new(256.0, 256.0);
const UNIT: BoundingSphere = BoundingSphere { center: DVec3::ZERO, radius: 1.0 };

/// An adapter, or nothing and a loud word about it.
fn adapter() -> Option<Gpu> {
    match Gpu::headless() {
        Ok(gpu) => Some(gpu),
        Err(GpuError::NoAdapter(why)) => {
            eprintln!(
                "\n*** NOT TESTED: no graphics adapter ({why}); apt-get install mesa-vulkan-drivers ***\n"
            );
            None
        }
        Err(other) => panic!("{other}"),
    }
}

fn front() -> Camera {
    View::FRONT.camera(UNIT, 1.0)
}

fn scene(shape: &Shape) -> Scene<'_> {
    Scene {
        positions: &shape.positions,
        normals: &shape.normals,
        triangles: &shape.triangles,
        ..Scene::default()
    }
}

fn picture(gpu: &Gpu, scene: &Scene<'_>) -> RgbaImage {
    render_png(gpu, scene, &front(), SIZE, Samples::One).expect("a small picture can be drawn")
}

/// The pixels that differ, by more than dithering could make them.
fn differing(a: &RgbaImage, b: &RgbaImage) -> Vec<(u32, u32)> {
    let far = |p: &Rgba<u8>, q: &Rgba<u8>| p.0.iter().zip(q.0).any(|(p, q)| p.abs_diff(q) > 1);
    a.enumerate_pixels().filter(|(x, y, p)| far(p, b.get_pixel(*x, *y))).map(|(x, y, _)| (x, y)).collect()
}

fn pixel_of(point: [f32; 3]) -> DVec2 {
    front().project(DVec3::from(point.map(f64::from)), PICTURE).expect("in front of the eye")
}

fn color_at(image: &RgbaImage, place: DVec2) -> [u8; 4] {
    image.get_pixel(place.x as u32, place.y as u32).0
}

#[test]
fn a_sphere_covers_its_silhouette() {
    let Some(gpu) = adapter() else { return };
    let sphere = shapes::sphere(5);
    let with = picture(&gpu, &scene(&sphere));
    let without = picture(&gpu, &Scene::default());
    let covered = differing(&with, &without).len() as f64;
    let camera = front();
    let cone = (1.0 / camera.distance).asin().tan() / (camera.vertical_fov * 0.5).tan() * 128.0;
    let expected = std::f64::consts::PI * cone * cone;
    assert!((covered / expected - 1.0).abs() < 0.01, "{covered} pixels, not {expected}");
    assert!(with.pixels().all(|p| p.0[3] == 255), "pictures are opaque");
}

#[test]
fn every_way_of_shading_and_backdrop_differs() {
    let Some(gpu) = adapter() else { return };
    let sphere = shapes::sphere(3);
    let mut renderer = SurfaceRenderer::new(&gpu, Samples::One);
    renderer.load(&scene(&sphere)).unwrap();
    let mut seen: Vec<RgbaImage> = Vec::new();
    for background in [Background::Dark, Background::Light] {
        for shading in [Shading::Clay, Shading::Porcelain, Shading::Normals, Shading::Flat] {
            let style = Style { shading, background, ..Style::default() };
            assert!(renderer.draw(&front(), &style, SIZE).unwrap());
            let image = renderer.read().unwrap();
            assert!(
                seen.iter().all(|other| differing(other, &image).len() > 1000),
                "{shading:?}, {background:?}"
            );
            seen.push(image);
        }
    }
}

#[test]
fn closed_surfaces_need_no_inside_and_open_ones_show_it() {
    let Some(gpu) = adapter() else { return };
    let mut sphere = shapes::sphere(4);
    let outside = Style { two_sided: false, ..Style::default() };
    let closed = picture(&gpu, &scene(&sphere));
    assert_eq!(closed, picture(&gpu, &Scene { style: outside, ..scene(&sphere) }));

    let front_half = |t: &[u32; 3]| t.iter().all(|v| sphere.positions[*v as usize][2] >= 0.0);
    sphere.triangles = sphere.triangles.iter().copied().filter(|t| !front_half(t)).collect();
    let [r, _, b, _] = color_at(&picture(&gpu, &scene(&sphere)), PICTURE * 0.5);
    assert!(b > r, "the inside is cool");
    let empty = picture(&gpu, &Scene::default());
    let culled = picture(&gpu, &Scene { style: outside, ..scene(&sphere) });
    assert!(differing(&empty, &culled).len() < 600, "no inside but a seam of the half sphere's triangles");
}

#[test]
fn a_tint_colours_where_it_is() {
    let Some(gpu) = adapter() else { return };
    let sphere = shapes::sphere(4);
    let blue: Vec<[u8; 4]> =
        sphere.positions.iter().map(|p| [40, 90, 255, if p[0] > 0.3 { 255 } else { 0 }]).collect();
    let plain = picture(&gpu, &scene(&sphere));
    let tinted = picture(&gpu, &Scene { tints: &blue, ..scene(&sphere) });
    let [r, _, b, _] = color_at(&tinted, pixel_of([0.6, 0.0, 0.8]));
    assert!(i32::from(b) > i32::from(r) + 60, "tinted: {r} red, {b} blue");
    assert!(differing(&plain, &tinted).iter().all(|(x, _)| *x > 128), "the other half stays");

    let mut renderer = SurfaceRenderer::new(&gpu, Samples::One);
    renderer.load(&Scene { tints: &blue, ..scene(&sphere) }).unwrap();
    renderer.clear_tints();
    renderer.draw(&front(), &Style::default(), SIZE).unwrap();
    assert_eq!(renderer.read().unwrap(), plain);
}

#[test]
fn a_local_write_changes_only_its_neighbourhood() {
    let Some(gpu) = adapter() else { return };
    let sphere = shapes::sphere(4);
    let mut renderer = SurfaceRenderer::new(&gpu, Samples::One);
    renderer.load(&scene(&sphere)).unwrap();
    let style = Style::default();
    renderer.draw(&front(), &style, SIZE).unwrap();
    let before = renderer.read().unwrap();

    // Vertex 4 is the one nearest to the eye.
    renderer.write_vertices(4, &[[0.0, 0.0, 1.2]], &[[0.0, 0.6, 0.8]]).unwrap();
    assert!(renderer.draw(&front(), &style, SIZE).unwrap());
    let changed = differing(&before, &renderer.read().unwrap());
    assert!(changed.len() > 40, "{} pixels changed", changed.len());
    let neighbours = sphere.triangles.iter().filter(|t| t.contains(&4)).flatten();
    let reach = neighbours
        .map(|v| pixel_of(sphere.positions[*v as usize]).distance(PICTURE * 0.5))
        .fold(0.0, f64::max);
    for (x, y) in changed {
        let off = DVec2::new(f64::from(x), f64::from(y)).distance(PICTURE * 0.5);
        assert!(off < reach + 1.0, "({x}, {y}) is {off} from the vertex moved");
    }

    renderer.write_vertices(4, &[sphere.positions[4]], &[sphere.normals[4]]).unwrap();
    renderer.draw(&front(), &style, SIZE).unwrap();
    assert_eq!(renderer.read().unwrap(), before);
}

#[test]
fn an_unchanged_frame_draws_nothing() {
    let Some(gpu) = adapter() else { return };
    let sphere = shapes::sphere(2);
    let mut renderer = SurfaceRenderer::new(&gpu, Samples::One);
    renderer.load(&scene(&sphere)).unwrap();
    let (mut camera, style) = (front(), Style::default());
    assert!(renderer.draw(&camera, &style, SIZE).unwrap());
    assert!(!renderer.draw(&camera, &style, SIZE).unwrap());
    assert!(renderer.draw(&camera, &Style { shading: Shading::Flat, ..style }, SIZE).unwrap());
    assert!(renderer.draw(&camera, &Style { two_sided: false, ..style }, SIZE).unwrap());
    camera.orbit(0.1, 0.0);
    assert!(renderer.draw(&camera, &style, SIZE).unwrap());
    assert!(renderer.draw(&camera, &style, [128, 64]).unwrap());
    assert_eq!(renderer.read().unwrap().dimensions(), (128, 64));
    renderer.write_tints(3, &[[1, 2, 3, 4]]).unwrap();
    assert!(renderer.draw(&camera, &style, [128, 64]).unwrap());
}

#[test]
fn arrays_grow_and_shrink() {
    let Some(gpu) = adapter() else { return };
    let fine = shapes::sphere(4);
    let coarse = shapes::sphere(1);
    let mut renderer = SurfaceRenderer::new(&gpu, Samples::One);
    let last = |renderer: &mut SurfaceRenderer| {
        renderer.draw(&front(), &Style::default(), SIZE).unwrap();
        renderer.read().unwrap()
    };
    renderer.set_triangles(&fine.triangles).unwrap();
    assert_eq!(last(&mut renderer), picture(&gpu, &Scene::default()), "no vertices, no picture");
    for (start, (positions, normals)) in fine.positions.chunks(37).zip(fine.normals.chunks(37)).enumerate() {
        renderer.write_vertices(start as u32 * 37, positions, normals).unwrap();
    }
    assert_eq!(last(&mut renderer), picture(&gpu, &scene(&fine)), "written in runs");
    renderer.load(&scene(&coarse)).unwrap();
    assert_eq!(last(&mut renderer), picture(&gpu, &scene(&coarse)), "a smaller surface after a larger one");
}

#[test]
fn edges_lie_on_the_surface() {
    let Some(gpu) = adapter() else { return };
    let sphere = shapes::sphere(4);
    let edges = shapes::edges(&shapes::sphere(4).triangles);
    let style =
        Style { edges: LineStyle { color: [0, 255, 0, 255], width: 1.5, hidden: 0.0 }, ..Style::default() };
    let with = picture(&gpu, &Scene { edges: &edges, style, ..scene(&sphere) });
    let green = |c: [u8; 4]| c[1] > 180 && c[0] < 120;
    let seen = edges.iter().filter(|e| e.iter().all(|v| sphere.positions[*v as usize][2] > 0.5));
    let mut count = 0;
    for edge in seen {
        let [a, b] = edge.map(|v| pixel_of(sphere.positions[v as usize]));
        assert!(green(color_at(&with, (a + b) * 0.5)), "{edge:?} is drawn all along");
        count += 1;
    }
    assert!(count > 200);
    let behind: Vec<[u32; 2]> =
        edges.iter().copied().filter(|e| e.iter().all(|v| sphere.positions[*v as usize][2] < -0.2)).collect();
    let hidden = picture(&gpu, &Scene { edges: &behind, style, ..scene(&sphere) });
    assert_eq!(hidden, picture(&gpu, &scene(&sphere)), "edges on the far side are hidden");
}

#[test]
fn handles_draw_where_they_are_and_fade_behind() {
    let Some(gpu) = adapter() else { return };
    let sphere = shapes::sphere(4);
    let handle = |position, state| Handle {
        position,
        radius: 6.0,
        fill: [255, 0, 0, 255],
        rim: [0, 0, 0, 255],
        state,
    };
    let plain = picture(&gpu, &scene(&sphere));
    let near = [0.3, 0.4, (1.0_f32 - 0.25).sqrt()];
    let mut sizes = Vec::new();
    for state in [HandleState::Idle, HandleState::Hovered, HandleState::Selected] {
        let shown = picture(&gpu, &Scene { handles: &[handle(near, state)], ..scene(&sphere) });
        let [r, g, ..] = color_at(&shown, pixel_of(near));
        assert!(r > 240 && g < 20);
        sizes.push(differing(&plain, &shown).len());
    }
    assert!((90..150).contains(&sizes[0]), "a disc of radius 6 has 113 pixels, this one {}", sizes[0]);
    assert!(sizes[0] < sizes[1] && sizes[1] < sizes[2], "{sizes:?}");

    let far = [handle([0.1, 0.1, -0.99], HandleState::Idle)];
    assert_eq!(picture(&gpu, &Scene { handles: &far, ..scene(&sphere) }), plain);
    let style = Style { handles_hidden: 0.4, ..Style::default() };
    let faded = picture(&gpu, &Scene { handles: &far, style, ..scene(&sphere) });
    let [r, g, ..] = color_at(&faded, pixel_of(far[0].position));
    assert!(r > g, "faint red");
    assert!(differing(&plain, &faded).len() > 60);
}

#[test]
fn lines_are_as_wide_as_asked_even_past_the_eye() {
    let Some(gpu) = adapter() else { return };
    let empty = picture(&gpu, &Scene::default());
    let line = |from, to, width| Line { from, to, color: [255, 255, 255, 255], width };
    let across = [line([-9.0, 0.0, 0.0], [9.0, 0.0, 0.0], 3.0)];
    let drawn = differing(&empty, &picture(&gpu, &Scene { lines: &across, ..Scene::default() }));
    assert!((drawn.len() as f64 / 256.0 - 3.5).abs() < 1.0, "{} pixels in 256 columns", drawn.len());

    let towards = [line([0.2, -0.2, 0.0], [1.0, -1.0, 50.0], 2.0)];
    let drawn = differing(&empty, &picture(&gpu, &Scene { lines: &towards, ..Scene::default() }));
    assert!(drawn.len() > 100 && drawn.iter().all(|(x, y)| *x >= 127 && *y >= 127), "{}", drawn.len());
}

#[test]
fn a_ghost_is_seen_through() {
    let Some(gpu) = adapter() else { return };
    let sphere = shapes::sphere(4);
    let shell = shapes::sphere(0);
    let larger: Vec<[f32; 3]> = shell.positions.iter().map(|p| p.map(|c| c * 1.9)).collect();
    let edges = shapes::edges(&shell.triangles);
    let ghost = GhostMesh { positions: &larger, triangles: &shell.triangles, edges: &[] };
    let plain = picture(&gpu, &scene(&sphere));
    let ghosted = picture(&gpu, &Scene { ghost, ..scene(&sphere) });
    let [before, after] = [&plain, &ghosted].map(|p| color_at(p, DVec2::new(140.0, 110.0)));
    let shift = before[0].abs_diff(after[0]).max(before[2].abs_diff(after[2]));
    assert!((2..90).contains(&shift), "{before:?} through the ghost is {after:?}");
    let lined = picture(&gpu, &Scene { ghost: GhostMesh { edges: &edges, ..ghost }, ..scene(&sphere) });
    assert!(differing(&ghosted, &lined).len() > 200, "its edges draw");

    let mut renderer = SurfaceRenderer::new(&gpu, Samples::One);
    renderer.load(&Scene { ghost, ..scene(&sphere) }).unwrap();
    renderer.set_ghost(GhostMesh::default()).unwrap();
    renderer.draw(&front(), &Style::default(), SIZE).unwrap();
    assert_eq!(renderer.read().unwrap(), plain);
}

#[test]
fn the_same_scene_gives_the_same_bytes() {
    let Some(gpu) = adapter() else { return };
    let sphere = shapes::sphere(4);
    let edges = shapes::edges(&shapes::sphere(2).triangles);
    let scene =
        Scene { edges: &edges, ghost: GhostMesh { edges: &edges, ..ghost_of(&sphere) }, ..scene(&sphere) };
    for samples in [Samples::One, Samples::Four] {
        let draw = || render_png(&gpu, &scene, &front(), [250, 130], samples).unwrap();
        let first = draw();
        // Rows of 250 pixels are padded on their way back; no padding may get into the picture.
        assert_eq!(first.dimensions(), (250, 130));
        assert!(first.pixels().all(|p| p.0[3] == 255));
        assert!((0..4).all(|_| draw() == first));
    }
}

fn ghost_of(shape: &Shape) -> GhostMesh<'_> {
    GhostMesh { positions: &shape.positions, triangles: &shape.triangles, edges: &[] }
}

#[test]
fn four_samples_smooth_the_silhouette() {
    let Some(gpu) = adapter() else { return };
    let sphere = shapes::sphere(5);
    let style = Style { background: Background::Light, ..Style::default() };
    let bright = |samples| {
        let image = render_png(&gpu, &Scene { style, ..scene(&sphere) }, &front(), SIZE, samples).unwrap();
        // Along the middle row, from the border inwards: how many pixels are between backdrop and surface.
        (0..40).filter(|x| (130..228).contains(&image.get_pixel(*x, 128).0[2])).count()
    };
    assert!(bright(Samples::Four) > bright(Samples::One));
}

#[test]
fn impossible_sizes_are_refused_in_a_sentence() {
    let Some(gpu) = adapter() else { return };
    for size in [[0, 10], [10, 0], [1 << 20, 10]] {
        let error = render_png(&gpu, &Scene::default(), &front(), size, Samples::One).expect_err("refused");
        assert!(matches!(error, GpuError::PictureSize { .. }), "{error}");
        assert!(error.to_string().contains(&format!("{}x{}", size[0], size[1])));
    }
}

#[test]
fn a_grid_holds_every_picture() {
    let color = |value| Rgba([value, 0, 0, 255]);
    let pictures: Vec<_> = (1..=3).map(|i| RgbaImage::from_pixel(4 * i, 6, color(i as u8))).collect();
    let sheet = grid(&pictures, 2, 1, [9, 9, 9, 255]);
    assert_eq!(sheet.dimensions(), (2 * 12 + 3, 2 * 6 + 3));
    for i in 1..=3 {
        let count = sheet.pixels().filter(|p| **p == color(i)).count();
        assert_eq!(count, 24 * usize::from(i));
    }
    assert_eq!(*sheet.get_pixel(0, 0), Rgba([9, 9, 9, 255]));
    assert_eq!(grid(&[], 3, 0, [0; 4]).dimensions(), (1, 1));
}
