use super::*;
use bozzetto_core::conversion::Remesh;
use bozzetto_core::mesh::shapes;
use std::cell::RefCell;

/// A file with a mesh that has no subdivision connectivity: a ball whose last face is split at its middle.
pub(super) fn irregular(folder: &Path) -> std::path::PathBuf {
    let mut mesh = shapes::subdivide(&shapes::octahedron(), 3);
    for p in &mut mesh.positions {
        let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
        *p = p.map(|x| x / length * (1.0 + 0.1 * (5.0 * x).sin()));
    }
    let [a, b, c] = mesh.faces.pop().expect("faces");
    let at = |v: u32| mesh.positions[v as usize];
    let middle = std::array::from_fn(|k| (at(a)[k] + at(b)[k] + at(c)[k]) / 3.0);
    let m = mesh.positions.len() as u32;
    mesh.positions.push(middle);
    mesh.faces.extend([[a, b, m], [b, c, m], [c, a, m]]);
    let path = folder.join("irregular.off");
    let mut bytes = Vec::new();
    bozzetto_core::io::write_mesh(&mesh, bozzetto_core::io::MeshFormat::Off, &mut bytes).expect("written");
    std::fs::write(&path, bytes).expect("written");
    path
}

/// Imports and maps the error, noting what was asked; from the `last`-th question on the answer is no.
fn asked(path: &Path, options: &ImportOptions, last: usize) -> (Result<()>, Vec<Stage>) {
    let stages = RefCell::new(Vec::new());
    let progress = |stage, _| {
        stages.borrow_mut().push(stage);
        stages.borrow().len() < last
    };
    let done = import_file(path, options, &progress)
        .and_then(|(source, imported)| error_map(&imported.model.surface, &source.mesh, &progress).map(drop));
    (done, stages.into_inner())
}

#[test]
fn a_refusal_is_the_last_question_in_every_stage() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = irregular(folder.path());
    let conversion =
        ConversionOptions { levels: Some(2), base_faces: Some(30), ..ConversionOptions::default() };
    let options = ImportOptions { conversion, form: FormOptions::default() };
    let (done, all) = asked(&path, &options, usize::MAX);
    done.expect("an import");
    let mut stages = all.clone();
    stages.dedup();
    assert_eq!(stages, Stage::ALL, "every stage asks, in its order");
    for last in 1..=all.len() {
        let (done, seen) = asked(&path, &options, last);
        assert!(done.is_err(), "refused at question {last} of {}, {:?}", all.len(), all[last - 1]);
        assert_eq!(seen, all[..last], "nothing goes on after the refusal");
    }
}

#[test]
fn the_error_map_is_over_the_diagonal_and_by_slot() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = irregular(folder.path());
    let conversion = ConversionOptions { remesh: Remesh::Never, ..ConversionOptions::default() };
    let options = ImportOptions { conversion, form: FormOptions::default() };
    let (source, imported) = import_file(&path, &options, &|_, _| true).expect("an import");
    assert!(imported.kept && imported.measured.is_none());
    let mut moved = source.mesh.clone();
    moved.positions.iter_mut().for_each(|p| p[1] += 0.25);
    let map = error_map(&imported.model.surface, &source.mesh, &|_, _| true).expect("a map");
    assert!(map.iter().all(|&d| d < 1e-7));
    let map = error_map(&imported.model.surface, &moved, &|_, _| true).expect("a map");
    let surface = &imported.model.surface;
    let top = (0..map.len()).max_by(|&a, &b| {
        let height = |s: usize| surface.position(surface.finest(), Slot(s as u32))[1];
        height(b).total_cmp(&height(a))
    });
    let expected = 0.25 / source.mesh.diagonal();
    assert!((map[top.expect("vertices")] - expected).abs() < 0.1 * expected, "the lowest vertex is 0.25 off");
}
