//! Importing in the window: choices, preview, cancelling, remeshing, driven through the widgets.

mod window;

use bozzetto::editor::{PreviewView, Start};
use bozzetto_core::conversion::{Axis, ConversionOptions, convert};
use bozzetto_core::disk::Disk;
use bozzetto_core::edit::{Edit, Gain};
use bozzetto_core::file::{Metadata, Model};
use bozzetto_core::hierarchy::Slot;
use bozzetto_core::io::{MeshFormat, read_mesh, write_mesh};
use bozzetto_core::mesh::{TriangleMesh, shapes};
use bozzetto_core::session::Session;
use bozzetto_core::surface::{FormOptions, Surface, SurfaceHash, UpAxis};
use eframe::egui::{self, Key, Modifiers};
use egui_kittest::kittest::Queryable;
use egui_kittest::{Harness, SnapshotOptions};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use window::{can_draw, editor, hash, settle};

type Window = Harness<'static, bozzetto::editor::Editor>;

/// A lumpy ball, three times as tall along z as it is wide.
fn lumpy(times: u32) -> TriangleMesh {
    let mut mesh = shapes::subdivide(&shapes::octahedron(), times);
    for p in &mut mesh.positions {
        let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
        let radius = 1.0 + 0.12 * (4.0 * p[0]).sin() * (3.0 * p[2]).cos();
        *p = p.map(|x| x / length * radius);
        p[2] *= 3.0;
    }
    mesh
}

/// The same without subdivision connectivity: one face is split at its middle.
fn irregular(times: u32) -> TriangleMesh {
    let mut mesh = lumpy(times);
    let [a, b, c] = mesh.faces.pop().expect("faces");
    let at = |v: u32| mesh.positions[v as usize];
    let middle = std::array::from_fn(|k| (at(a)[k] + at(b)[k] + at(c)[k]) / 3.0);
    let m = mesh.positions.len() as u32;
    mesh.positions.push(middle);
    mesh.faces.extend([[a, b, m], [b, c, m], [c, a, m]]);
    mesh
}

fn write(mesh: &TriangleMesh, path: &Path) {
    let mut bytes = Vec::new();
    write_mesh(mesh, MeshFormat::Obj, &mut bytes).expect("written");
    std::fs::write(path, bytes).expect("written");
}

/// A lumpy ball with its own connectivity, saved as a pair of files, with one edit.
fn saved(folder: &Path) -> PathBuf {
    let converted = convert(&lumpy(3), &ConversionOptions::default()).expect("subdivided");
    let surface = Surface::from_positions(converted.hierarchy, &converted.positions, &FormOptions::default())
        .expect("small");
    let mut session = Session::new(Arc::new(Disk), Model::new(surface, None, Metadata::default()));
    session.edit(Edit::Gain(Gain { level: 1, factor: 0.5, v: 1 })).expect("an edit");
    let path = folder.join("open.boz");
    session.save_as(&path).expect("saved");
    session.close().expect("on disk");
    path
}

fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry"));
    entries
        .filter(|entry| !entry.file_name().to_string_lossy().ends_with(".lock"))
        .map(|e| (e.file_name().to_string_lossy().into_owned(), std::fs::read(e.path()).expect("a file")))
        .collect()
}

fn click(window: &mut Window, label: &str) {
    window.get_by_label(label).click();
    window.run();
}

/// Chooses by hand what is automatic.
fn choose(window: &mut Window, name: &str, value: &str) {
    click(window, &format!("{name} automatic"));
    window.get_by_label(&format!("chosen {name}")).click();
    window.run();
    window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.event(egui::Event::Text(value.to_owned()));
    window.key_press(Key::Enter);
    window.run();
}

/// Chooses small sizes, so that a conversion is quick.
fn choose_small_sizes(window: &mut Window) {
    choose(window, "levels", "2");
    choose(window, "base faces", "40");
}

/// Opens a mesh by the path field.
fn open(window: &mut Window, path: &Path) {
    window.key_press_modifiers(Modifiers::COMMAND, Key::O);
    window.run();
    window.get_by_label("Path").focus();
    window.run();
    window.get_by_label("Path").type_text(path.to_str().expect("a plain path"));
    window.run();
    window.get_by_label("Open file").click();
    settle(window);
}

fn preview(window: &mut Window) {
    window.get_by_label("Preview").click();
    settle(window);
    let message = window.state().message().map(|(text, _)| text.to_owned());
    assert!(window.state().preview().is_some(), "{message:?}");
}

/// The surface that the same import gives without a window.
fn imported(path: &Path, up: UpAxis) -> SurfaceHash {
    imported_with(path, up, ConversionOptions::default())
}

fn imported_with(path: &Path, up: UpAxis, options: ConversionOptions) -> SurfaceHash {
    let mesh = read_mesh(path).expect("a mesh");
    let options = ConversionOptions { levels: Some(2), base_faces: Some(40), ..options };
    let made = convert(&mesh, &options).expect("converted");
    let form = FormOptions { up, ..FormOptions::default() };
    Surface::from_positions(made.hierarchy, &made.positions, &form).expect("small").hash()
}

#[test]
fn a_mesh_is_looked_at_before_it_is_opened() {
    if !can_draw() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let document = saved(folder.path());
    let mesh = folder.path().join("scan.obj");
    write(&irregular(3), &mesh);
    let before = contents(folder.path());
    let mut window = editor(Start::File(document.clone()));
    let original = hash(&window);

    open(&mut window, &mesh);
    assert!(
        window.query_by_label_contains("no subdivision connectivity").is_some(),
        "the dialog says why it asks"
    );
    choose_small_sizes(&mut window);
    preview(&mut window);
    let camera = *window.state().camera();
    let shown = window.state().preview().expect("a preview");
    assert_eq!(shown.document().session.hash(), imported(&mesh, UpAxis::Y), "as without a window");
    let row = |name: &str| {
        let facts = window.state().preview().expect("a preview").facts();
        facts.rows.iter().find(|(n, _)| *n == name).map(|(_, figure)| figure.clone()).expect("a row")
    };
    assert!(row("topology").contains("genus 0, 0 boundary loops"), "{}", row("topology"));
    assert!(row("mesh").contains("259 vertices, 514 faces"), "{}", row("mesh"));
    assert!(row("rms error").contains('%') && row("greatest error").contains('%'));
    assert_eq!(hash(&window), original, "the open surface stays while another is looked at");

    for (label, view, level) in [
        ("Base mesh", PreviewView::Base, 0),
        ("Error", PreviewView::Error, 2),
        ("Converted surface", PreviewView::Surface, 2),
    ] {
        click(&mut window, label);
        let shown = window.state().preview().expect("a preview");
        assert_eq!((shown.view(), shown.document().vertices().level().0), (view, level));
    }
    assert!(
        window.state().camera().distance == camera.distance,
        "looking at something else keeps the camera"
    );

    click(&mut window, "Change");
    assert!(window.state().preview().is_none());
    assert_eq!(hash(&window), original);
    preview(&mut window);
    let session = &window.state().preview().expect("a preview").document().session;
    assert_eq!(session.hash(), imported(&mesh, UpAxis::Y), "the choices are still there");
    click(&mut window, "Import");
    assert_eq!(hash(&window), imported(&mesh, UpAxis::Y));
    assert!(
        window.state().document().expect("open").session.path().is_none(),
        "a new project without a file"
    );
    assert!(contents(folder.path()) == before, "no file is touched");
    drop(window);
    assert_eq!(hash(&editor(Start::File(document))), original, "the surface that was open opens as it was");
}

#[test]
fn giving_a_preview_up_leaves_the_open_surface_to_the_bit() {
    if !can_draw() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let document = saved(folder.path());
    let mesh = folder.path().join("scan.obj");
    write(&irregular(3), &mesh);
    let before = contents(folder.path());
    let mut window = editor(Start::File(document));
    let (original, camera) = (hash(&window), *window.state().camera());
    let settings = window.state().settings().clone();
    open(&mut window, &mesh);
    choose_small_sizes(&mut window);
    preview(&mut window);
    // Keys and drags that would edit do nothing here.
    window.key_press(Key::W);
    window.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    window.run();
    click(&mut window, "Cancel");
    assert!(window.state().preview().is_none());
    assert_eq!(hash(&window), original);
    assert_eq!(window.state().document().expect("open").session.steps(), 1);
    assert_eq!(*window.state().camera(), camera, "seen from where it was");
    assert_eq!(*window.state().settings(), settings);
    assert!(contents(folder.path()) == before, "no file is touched");
}

#[test]
fn a_conversion_cancelled_goes_back_to_its_choices() {
    if !can_draw() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let document = saved(folder.path());
    let mesh = folder.path().join("scan.obj");
    // Large enough that its conversion outlasts a few frames by far.
    write(&irregular(6), &mesh);
    let mut window = editor(Start::File(document));
    let original = hash(&window);
    open(&mut window, &mesh);
    window.get_by_label("Preview").click();
    window.run_steps(8);
    assert!(window.state().is_working());
    assert!(window.query_by_label("Fit the surface").is_some(), "the stages are shown");
    window.get_by_label("Cancel").click();
    window.run_steps(8);
    assert!(!window.state().is_working(), "cancelled at once");
    assert!(window.state().preview().is_none());
    assert!(window.query_by_label("Preview").is_some(), "the choices are there again");
    assert_eq!(hash(&window), original);
}

#[test]
fn a_mesh_with_subdivision_connectivity_opens_and_says_so() {
    if !can_draw() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let mesh = folder.path().join("ball.obj");
    write(&lumpy(3), &mesh);
    let window = editor(Start::File(mesh));
    let (text, failed) = window.state().message().expect("a message");
    assert!(!failed && text.contains("has subdivision connectivity: 3 levels over 8 base faces"), "{text}");
    assert!(window.state().document().expect("open").session.model().source.is_some());
}

#[test]
fn a_mesh_dropped_on_the_window_is_opened() {
    #[derive(Debug)]
    struct Dropped(PathBuf);
    impl egui::DroppedFile for Dropped {
        fn path(&self) -> &Path {
            &self.0
        }

        fn bytes(&self) -> Result<Vec<u8>, String> {
            std::fs::read(&self.0).map_err(|e| e.to_string())
        }
    }
    if !can_draw() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let mesh = folder.path().join("ball.obj");
    write(&lumpy(3), &mesh);
    let mut window = editor(Start::Empty);
    window.input_mut().dropped_files.push(Arc::new(Dropped(mesh)));
    window.run_steps(1);
    settle(&mut window);
    assert!(window.state().document().is_some());
}

#[test]
fn remeshing_makes_a_new_surface_and_leaves_the_old_files() {
    if !can_draw() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let document = saved(folder.path());
    let before = contents(folder.path());
    let mut window = editor(Start::File(document));
    let original = hash(&window);
    click(&mut window, "Remesh");
    assert!(window.query_by_label("Path").is_none(), "there is no file to choose");
    choose_small_sizes(&mut window);
    preview(&mut window);
    click(&mut window, "Import");
    assert_ne!(hash(&window), original);
    let session = &window.state().document().expect("open").session;
    assert!(session.path().is_none() && session.history_len() == 0);
    assert!(session.model().source.is_none(), "converted, although the surface has subdivision connectivity");
    assert_eq!(session.metadata().source.as_deref(), Some("open.boz, remeshed"));
    assert!(contents(folder.path()) == before, "the old pair is as it was");
}

#[test]
fn a_model_with_z_up_stands_upright() {
    if !can_draw() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let mesh = folder.path().join("part.obj");
    write(&irregular(3), &mesh);
    let mut window = editor(Start::File(mesh.clone()));
    choose_small_sizes(&mut window);
    click(&mut window, "Up z");
    click(&mut window, "Unit mm");
    preview(&mut window);
    let shown = window.state().preview().expect("a preview").document();
    let tall = |axis: usize| {
        let along = shown.vertices().positions().iter().map(|p| p[axis]);
        along.clone().fold(f32::MIN, f32::max) - along.fold(f32::MAX, f32::min)
    };
    assert!(tall(1) > 2.0 * tall(0) && tall(1) > 2.0 * tall(2), "drawn upright");
    click(&mut window, "Import");
    assert_eq!(hash(&window), {
        let mesh = read_mesh(&mesh).expect("a mesh");
        let options =
            ConversionOptions { levels: Some(2), base_faces: Some(40), ..ConversionOptions::default() };
        let made = convert(&mesh, &options).expect("converted");
        let form = FormOptions { up: UpAxis::Z, unit: "mm".into(), ..FormOptions::default() };
        Surface::from_positions(made.hierarchy, &made.positions, &form).expect("small").hash()
    });
    let surface = window.state().document().expect("open").surface();
    let finest = surface.finest();
    let heights = (0..surface.scaling(finest).len() as u32).map(|s| surface.position(finest, Slot(s))[2]);
    assert!(heights.fold(f64::MIN, f64::max) > 2.5, "the model's own coordinates stay");
}

#[test]
fn edits_without_a_file_are_not_lost_unasked() {
    if !can_draw() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let mesh = folder.path().join("scan.obj");
    write(&irregular(3), &mesh);
    let mut window = editor(Start::Session(Box::new({
        let converted = convert(&lumpy(2), &ConversionOptions::default()).expect("subdivided");
        let surface =
            Surface::from_positions(converted.hierarchy, &converted.positions, &FormOptions::default())
                .expect("small");
        let mut session = Session::new(Arc::new(Disk), Model::new(surface, None, Metadata::default()));
        session.edit(Edit::Gain(Gain { level: 1, factor: 0.5, v: 1 })).expect("an edit");
        session
    })));
    let original = hash(&window);
    open(&mut window, &mesh);
    click(&mut window, "Discard edits");
    settle(&mut window);
    choose_small_sizes(&mut window);
    preview(&mut window);
    assert_eq!(hash(&window), original, "given up only when another surface takes its place");
    click(&mut window, "Import");
    assert_eq!(hash(&window), original);
    click(&mut window, "Discard edits");
    assert_eq!(hash(&window), imported(&mesh, UpAxis::Y));
}

#[test]
fn edges_are_kept_sharp_above_a_chosen_angle() {
    if !can_draw() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let mesh = folder.path().join("ball.obj");
    write(&irregular(3), &mesh);
    let mut window = editor(Start::Empty);
    open(&mut window, &mesh);
    choose_small_sizes(&mut window);
    choose(&mut window, "sharp edges", "12");
    preview(&mut window);
    let session = &window.state().preview().expect("a preview").document().session;
    assert!(!session.surface().hierarchy().base().sharp_edges().is_empty());
    let options = ConversionOptions { sharp_angle: Some(12.0), ..ConversionOptions::default() };
    assert_eq!(session.hash(), imported_with(&mesh, UpAxis::Y, options), "as without a window");
    assert_ne!(session.hash(), imported(&mesh, UpAxis::Y));
}

#[test]
fn a_base_mesh_is_mirrored_along_the_chosen_axis() {
    if !can_draw() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let mesh = folder.path().join("ball.obj");
    write(&irregular(3), &mesh);
    let mut window = editor(Start::Empty);
    open(&mut window, &mesh);
    choose_small_sizes(&mut window);
    click(&mut window, "Symmetry x");
    // Its sides along x are not alike.
    window.get_by_label("Preview").click();
    settle(&mut window);
    let (text, failed) = window.state().message().expect("a message");
    assert!(failed && text.contains("mirrored along x the mesh is"), "{text}");
    assert!(window.state().preview().is_none());
    click(&mut window, "Symmetry y");
    preview(&mut window);
    let session = &window.state().preview().expect("a preview").document().session;
    let options = ConversionOptions { symmetric: Some(Axis::Y), ..ConversionOptions::default() };
    assert_eq!(session.hash(), imported_with(&mesh, UpAxis::Y, options), "as without a window");
    assert_ne!(session.hash(), imported(&mesh, UpAxis::Y));
}

#[test]
fn pictures_of_an_import() {
    if !can_draw() {
        return;
    }
    let options = SnapshotOptions::new().threshold(2.0).max_failed_pixels(6000);
    let folder = tempfile::tempdir().expect("a folder");
    let mesh = folder.path().join("scan.obj");
    write(&irregular(3), &mesh);
    // By the path field of an empty window: the temporary folder's name is not to be seen.
    let mut window = editor(Start::Empty);
    click(&mut window, "Import mesh");
    window.snapshot_options("import_choices", &options);
    window.get_by_label("Path").focus();
    window.run();
    window.get_by_label("Path").type_text(mesh.to_str().expect("a plain path"));
    window.run();
    choose_small_sizes(&mut window);
    click(&mut window, "tolerance none");
    preview(&mut window);
    click(&mut window, "Error");
    window.remove_cursor();
    window.run();
    window.snapshot_options("import_error", &options);
}
