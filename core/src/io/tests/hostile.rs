//! Files that were cut, scrambled or made up: a mesh that keeps the readers' promises, or one sentence.

use proptest::prelude::*;

use super::*;

/// Small valid files of every readable format, with the features that parsers trip over.
fn seeds() -> Vec<(MeshFormat, Vec<u8>)> {
    let obj = b"mtllib m.mtl\no one\nv 0 0 0 1 0 0\nv 1 0 0\nv 1 1 0 1.0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n\
        usemtl red\nf 1/1/1 2/1/1 3/1/1 4//1\ng two\nf -1 -2 \\\n -3 # end\nf 1 2 3 4 1\n";
    let off =
        b"COFF\n# a comment\n4 2 0\n0 0 0 255 0 0 255\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n3 0 1 2 0.5 0.5 0.5\n";
    let ply = b"ply\nformat ascii 1.0\ncomment made up\nelement vertex 4\nproperty float x\nproperty double y\n\
        property short z\nproperty uchar red\nelement face 2\nproperty list uchar int vertex_indices\n\
        element edge 1\nproperty int a\nend_header\n0 0 0 9\n1 .5 0 9\n1 1. 0 9\n0 1 0 9\n4 0 1 2 3\n3 0 1 2\n7\n";
    let big = ply_big_endian();
    let stl =
        b"solid one\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n\
        endfacet\nendsolid one\nsolid two\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 .5\n\
        vertex 0 1 -1e-3\nendloop\nendfacet\nendsolid\n";
    let mut seeds = vec![
        (MeshFormat::Obj, obj.to_vec()),
        (MeshFormat::Off, off.to_vec()),
        (MeshFormat::Ply, ply.to_vec()),
        (MeshFormat::Ply, big),
        (MeshFormat::Stl, stl.to_vec()),
        (MeshFormat::Glb, crate::io::glb::tests::scenery()),
    ];
    seeds.extend(EXACT.map(|format| (format, written(&awkward(), format))));
    let small = crate::mesh::shapes::octahedron();
    seeds.extend([MeshFormat::Stl, MeshFormat::Glb].map(|format| (format, written(&small, format))));
    seeds
}

/// A triangle and a pentagon, with lists of shorts and a list to skip.
fn ply_big_endian() -> Vec<u8> {
    let mut bytes = b"ply\r\nformat binary_big_endian 1.0\r\nelement vertex 5\r\nproperty float x\r\nproperty float y\r\n\
        property float z\r\nelement face 2\r\nproperty list uint double weights\r\n\
        property list ushort ushort vertex_index\r\nend_header\r\n"
        .to_vec();
    for (x, y) in [(0.0f32, 0.0f32), (2.0, 0.0), (3.0, 1.0), (1.0, 2.0), (-1.0, 1.0)] {
        [x, y, 0.0].iter().for_each(|x| bytes.extend(x.to_be_bytes()));
    }
    for face in [&[0u16, 1, 2][..], &[0, 1, 2, 3, 4]] {
        bytes.extend(1u32.to_be_bytes());
        bytes.extend(0.5f64.to_be_bytes());
        bytes.extend((face.len() as u16).to_be_bytes());
        face.iter().for_each(|vertex| bytes.extend(vertex.to_be_bytes()));
    }
    bytes
}

/// Reads, and checks what the readers promise of any file.
fn holds_its_promises(format: MeshFormat, bytes: &[u8]) {
    match read_mesh_bytes(format, bytes, "model") {
        Ok(mesh) => {
            assert!(!mesh.positions.is_empty() && !mesh.faces.is_empty());
            assert!(mesh.positions.iter().flatten().all(|x| x.abs() <= LARGEST_COORDINATE));
            assert!(mesh.faces.iter().flatten().all(|&vertex| (vertex as usize) < mesh.positions.len()));
        }
        Err(error) => drop(sentence(&error, "model")),
    }
}

#[derive(Clone, Debug)]
enum Damage {
    Cut(usize),
    Set(usize, u8),
    Insert(usize, Vec<u8>),
    Remove(usize, usize),
    Repeat(usize, usize),
}

fn damage() -> impl Strategy<Value = Damage> {
    let words = prop::sample::select(vec![
        "\n",
        " ",
        "-1",
        "0",
        "999999999999999999999",
        "-9223372036854775808",
        "4294967296",
        "nan",
        "inf",
        "1e309",
        "1e31",
        "-",
        "/",
        "#",
        "\\\n",
        "\r",
        "f ",
        "v ",
        "f 1 2 3\n",
        "element face 1000000000\n",
        "element x 18446744073709551615\n",
        "property list int int q\n",
        "end_header\n",
        "vertex 1 1 1\n",
        "endloop\n",
        "4294967295",
        "-1e308",
        ",",
        "{}",
        "[]",
        "\u{feff}",
        "\0",
    ]);
    prop_oneof![
        any::<usize>().prop_map(Damage::Cut),
        (any::<usize>(), any::<u8>()).prop_map(|(at, byte)| Damage::Set(at, byte)),
        (any::<usize>(), words).prop_map(|(at, word)| Damage::Insert(at, word.as_bytes().to_vec())),
        (any::<usize>(), prop::collection::vec(any::<u8>(), 1..9))
            .prop_map(|(at, bytes)| Damage::Insert(at, bytes)),
        (any::<usize>(), 1usize..40).prop_map(|(at, length)| Damage::Remove(at, length)),
        (any::<usize>(), 1usize..40).prop_map(|(at, length)| Damage::Repeat(at, length)),
    ]
}

fn apply(bytes: &mut Vec<u8>, damage: &Damage) {
    let place = |at: usize| at % (bytes.len() + 1);
    match damage {
        Damage::Cut(at) => bytes.truncate(place(*at)),
        Damage::Set(at, byte) => {
            let at = place(*at);
            bytes[at..].iter_mut().take(1).for_each(|old| *old = *byte);
        }
        Damage::Insert(at, inserted) => {
            let at = place(*at);
            bytes.splice(at..at, inserted.iter().copied());
        }
        Damage::Remove(at, length) => {
            let at = place(*at);
            bytes.drain(at..(at + length).min(bytes.len()));
        }
        Damage::Repeat(at, length) => {
            let at = place(*at);
            bytes.extend_from_within(at..(at + length).min(bytes.len()));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, ..ProptestConfig::default() })]

    #[test]
    fn damaged_files_never_break_a_promise(
        seed in any::<prop::sample::Index>(),
        damages in prop::collection::vec(damage(), 1..6),
    ) {
        let seeds = seeds();
        let (format, mut bytes) = seed.get(&seeds).clone();
        damages.iter().for_each(|damage| apply(&mut bytes, damage));
        holds_its_promises(format, &bytes);
    }

    #[test]
    fn made_up_files_never_break_a_promise(
        format in prop::sample::select(MeshFormat::READABLE.to_vec()),
        bytes in prop::collection::vec(any::<u8>(), 0..300),
    ) {
        holds_its_promises(format, &bytes);
    }

    #[test]
    fn any_mesh_reads_back_bit_for_bit(
        positions in prop::collection::vec(prop::array::uniform3(-1e30..1e30), 1..20),
        corners in prop::collection::vec(prop::array::uniform3(any::<prop::sample::Index>()), 1..20),
    ) {
        let faces = corners.iter().map(|face| face.map(|corner| corner.index(positions.len()) as u32)).collect();
        let mesh = TriangleMesh::new(positions, faces);
        for format in EXACT {
            let read = read_mesh_bytes(format, &written(&mesh, format), "model").unwrap();
            prop_assert_eq!(bits(&read), bits(&mesh));
            prop_assert_eq!(&read.faces, &mesh.faces);
        }
    }
}

#[test]
fn the_undamaged_files_are_read() {
    for (format, bytes) in seeds() {
        let mesh = read_mesh_bytes(format, &bytes, "model");
        assert!(mesh.is_ok(), "{}: {:?}", String::from_utf8_lossy(&bytes), mesh);
    }
}

#[test]
fn every_truncation_is_a_mesh_or_a_sentence() {
    for (format, bytes) in seeds() {
        (0..bytes.len()).for_each(|length| holds_its_promises(format, &bytes[..length]));
    }
}

#[test]
fn binary_junk_is_refused_in_every_format() {
    let junk: Vec<u8> = (0..10_000u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    for format in MeshFormat::READABLE {
        refusal(format, &junk);
        refusal(format, &[0; 100]);
    }
}
