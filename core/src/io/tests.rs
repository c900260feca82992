use std::path::PathBuf;

use super::*;

mod hostile;

/// The formats that hold `f64` and every vertex.
pub(super) const EXACT: [MeshFormat; 3] = [MeshFormat::Obj, MeshFormat::Ply, MeshFormat::Off];

/// A mesh with numbers that are hard to write down, an unreferenced vertex, a repeated position and a
/// degenerate face.
pub(super) fn awkward() -> TriangleMesh {
    let positions = vec![
        [0.1, 1.0 / 3.0, -1e-300],
        [123_456_789.123_456_78, -0.0, 2f64.powi(60)],
        [f64::from(f32::MIN_POSITIVE), 1.0, -1.0 - f64::EPSILON],
        [7.0, 7.0, 7.0],
        [0.1, 1.0 / 3.0, -1e-300],
        [1e30, -1e30, 5e-324],
    ];
    TriangleMesh::new(positions, vec![[5, 1, 0], [0, 1, 2], [2, 2, 4], [4, 2, 1]])
}

pub(super) fn written(mesh: &TriangleMesh, format: MeshFormat) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_mesh(mesh, format, &mut bytes).unwrap();
    bytes
}

pub(super) fn bits(mesh: &TriangleMesh) -> Vec<[u64; 3]> {
    mesh.positions.iter().map(|position| position.map(f64::to_bits)).collect()
}

/// The message of the error that these contents give, checked to be one sentence.
pub(super) fn refusal(format: MeshFormat, bytes: &[u8]) -> String {
    let error = read_mesh_bytes(format, bytes, "model").expect_err("this ought to be refused");
    sentence(&error, "model")
}

/// The error's text, which must name the file, offer a mend and be one short line.
pub(super) fn sentence(error: &MeshFileError, name: &str) -> String {
    let text = error.to_string();
    assert!(text.starts_with(name), "{text}");
    assert!(text.contains("; "), "no mend: {text}");
    // What is quoted from the file may hold anything, on one line.
    let own: String = text.replace("\\'", "").split('\'').step_by(2).collect();
    assert!(!text.contains(['\n', '\r']) && !own.contains(". ") && !own.ends_with('.'), "{text}");
    assert!(text.len() < 300 + name.len(), "{text}");
    text
}

#[test]
fn obj_ply_and_off_read_back_bit_for_bit() {
    let mesh = awkward();
    for format in EXACT {
        let read = read_mesh_bytes(format, &written(&mesh, format), "model").unwrap();
        assert_eq!(bits(&read), bits(&mesh), "{format:?}");
        assert_eq!(read.faces, mesh.faces, "{format:?}");
    }
}

#[test]
fn glb_and_stl_read_back_in_single_precision() {
    let mut mesh = awkward();
    mesh.positions[5] = [1e29, -1e29, 5e-324];
    let rounded = TriangleMesh::new(
        mesh.positions.iter().map(|p| p.map(|x| f64::from(x as f32))).collect(),
        mesh.faces.clone(),
    );
    let read = read_mesh_bytes(MeshFormat::Glb, &written(&mesh, MeshFormat::Glb), "model").unwrap();
    assert_eq!(bits(&read), bits(&rounded));
    assert_eq!(read.faces, mesh.faces);
    let read = read_mesh_bytes(MeshFormat::Stl, &written(&mesh, MeshFormat::Stl), "model").unwrap();
    let corners =
        |mesh: &TriangleMesh| (0..4).map(|f| mesh.corners(crate::mesh::FaceIndex(f))).collect::<Vec<_>>();
    assert_eq!(corners(&read), corners(&rounded));
    assert_eq!(read.positions.len(), 4, "the unreferenced and the repeated one are gone");
}

#[test]
fn the_extension_names_the_format_in_any_case() {
    let format = |name: &str| MeshFormat::from_path(Path::new(name));
    assert_eq!(format("a/b.OBJ"), Some(MeshFormat::Obj));
    assert_eq!(format("b.tar.Ply"), Some(MeshFormat::Ply));
    assert_eq!([format("b.off"), format("b.STL")], [Some(MeshFormat::Off), Some(MeshFormat::Stl)]);
    assert_eq!([format("obj"), format(".obj"), format("b.objx")], [None; 3]);
}

#[test]
fn a_file_is_read_by_its_extension() {
    let folder = tempfile::tempdir().unwrap();
    for format in EXACT {
        let path = folder.path().join(format!("model.{}", format.extension().to_uppercase()));
        std::fs::write(&path, written(&awkward(), format)).unwrap();
        assert_eq!(read_mesh(&path).unwrap(), awkward());
    }
}

/// Longer than what is read at a time.
#[test]
fn a_file_is_shown_whole_and_in_order_while_it_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = crate::mesh::shapes::subdivide(&crate::mesh::shapes::octahedron(), 7);
    for format in MeshFormat::READABLE {
        let mut bytes = written(&mesh, format);
        if format == MeshFormat::Ply {
            bytes.extend(b"\nwhat the header does not declare");
        }
        let path = folder.path().join(format!("model.{}", format.extension()));
        std::fs::write(&path, &bytes).unwrap();
        let (mut seen, mut shares) = (Vec::new(), Vec::new());
        let mut observed = |part: &[u8], share| {
            seen.extend_from_slice(part);
            shares.push(share);
        };
        let read = read_mesh_file(&path, &mut observed, &mut || true).unwrap();
        assert!(read == read_mesh_bytes(format, &bytes, "model").unwrap(), "{format:?}");
        assert!(seen == bytes, "{format:?}");
        assert!(shares.len() > 1 && shares.is_sorted() && shares.iter().all(|s| (0.0..=1.0).contains(s)));
        let refused = read_mesh_file(&path, &mut |_, _| {}, &mut || false);
        assert!(matches!(refused, Err(MeshFileError::Cancelled { .. })), "{format:?}");
    }
}

#[test]
fn what_is_no_mesh_file_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let directory = folder.path().join("folder.obj");
    std::fs::create_dir(&directory).unwrap();
    let expect = |path: PathBuf, part: &str| {
        let text = sentence(&read_mesh(&path).unwrap_err(), &path.display().to_string().replace('\n', "\\n"));
        assert!(text.contains(part), "{text}");
    };
    expect(directory, "not a regular file");
    expect(folder.path().to_owned(), "not a regular file");
    expect(folder.path().join("missing.obj"), "cannot be read (");
    expect(folder.path().join("two\nlines.obj"), "cannot be read (");
    expect(
        folder.path().join("model.fbx"),
        "a .fbx file cannot be read as a mesh; convert it to .obj, .ply, .stl, .glb or .off",
    );
    expect(folder.path().join("model"), "a file without an extension cannot");
    for format in MeshFormat::READABLE {
        let empty = folder.path().join(format!("empty.{}", format.extension()));
        std::fs::write(&empty, b" \n").unwrap();
        expect(empty, "the file is empty");
    }
}

#[test]
fn a_mesh_that_no_file_can_hold_is_not_written() {
    let refused =
        |mesh: &TriangleMesh, format| write_mesh(mesh, format, &mut Vec::new()).unwrap_err().to_string();
    let mut mesh = awkward();
    mesh.positions[3][1] = 1e39;
    assert!(refused(&mesh, MeshFormat::Stl).starts_with("vertex 3 has a coordinate"));
    assert!(write_mesh(&mesh, MeshFormat::Obj, &mut Vec::new()).is_ok());
    mesh.positions[3][1] = f64::NAN;
    assert!(refused(&mesh, MeshFormat::Obj).starts_with("vertex 3 has a coordinate"));
    let mut mesh = awkward();
    mesh.faces[2][0] = 6;
    assert_eq!(
        refused(&mesh, MeshFormat::Glb),
        "face 2 refers beyond the 6 vertices there are; repair the mesh first"
    );
    mesh.faces.clear();
    assert!(refused(&mesh, MeshFormat::Glb).starts_with("a mesh without faces"));
}

#[test]
fn a_writer_that_fails_is_reported() {
    struct Full;
    impl Write for Full {
        fn write(&mut self, _: &[u8]) -> std::io::Result<usize> {
            Err(std::io::ErrorKind::StorageFull.into())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    for format in MeshFormat::WRITABLE {
        assert!(
            matches!(write_mesh(&awkward(), format, &mut Full), Err(MeshWriteError::Io(_))),
            "{format:?}"
        );
    }
}
