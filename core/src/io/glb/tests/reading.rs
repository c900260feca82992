//! Reading: what a scene may hold, and what is refused.

use super::*;
use crate::io::read_mesh_bytes;
use crate::io::tests::refusal;
use serde_json::json;

/// A file of this JSON and this binary chunk.
fn glb(json: &Value, binary: &[u8]) -> Vec<u8> {
    glb_of_text(json.to_string().into_bytes(), binary)
}

fn glb_of_text(mut text: Vec<u8>, binary: &[u8]) -> Vec<u8> {
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF".to_vec();
    let words =
        |bytes: &mut Vec<u8>, words: [u32; 2]| words.iter().for_each(|w| bytes.extend(w.to_le_bytes()));
    words(&mut bytes, [2, (28 + text.len() + binary.len()) as u32]);
    words(&mut bytes, [text.len() as u32, u32::from_le_bytes(*b"JSON")]);
    bytes.extend(text);
    words(&mut bytes, [binary.len() as u32, u32::from_le_bytes(*b"BIN\0")]);
    bytes.extend(binary);
    bytes
}

/// Five points as `f32` with a stride of 16; three of them as normalised shorts, padded to 8 bytes; then indices 0 to 4
/// as bytes, shorts and ints.
fn buffer() -> Vec<u8> {
    let mut bytes = Vec::new();
    for p in [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 2.0, 0.0]] {
        p.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
        bytes.extend([7; 4]);
    }
    for p in [[0i16, 0, 0], [32767, 0, 0], [0, -32768, 0]] {
        p.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
        bytes.extend([7; 2]);
    }
    (0..5u8).for_each(|i| bytes.push(i));
    bytes.extend([7; 3]);
    (0..5u16).for_each(|i| bytes.extend(i.to_le_bytes()));
    bytes.extend([7; 2]);
    (0..5u32).for_each(|i| bytes.extend(i.to_le_bytes()));
    bytes
}

/// A scene over [`buffer`]: the accessors 0 float positions, 1 short ones, 2 to 4 indices; `meshes` and `nodes` as given.
fn scene(meshes: Value, nodes: Value) -> Value {
    json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": nodes,
        "meshes": meshes,
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 5, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5122, "count": 3, "type": "VEC3", "normalized": true },
            { "bufferView": 2, "componentType": 5121, "count": 3, "type": "SCALAR" },
            { "bufferView": 2, "byteOffset": 8, "componentType": 5123, "count": 5, "type": "SCALAR" },
            { "bufferView": 2, "byteOffset": 20, "componentType": 5125, "count": 5, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": 76, "byteStride": 16 },
            { "buffer": 0, "byteOffset": 80, "byteLength": 24, "byteStride": 8 },
            { "buffer": 0, "byteOffset": 104, "byteLength": 40 },
        ],
        "buffers": [{ "byteLength": 144 }],
    })
}

fn primitive(position: u32, indices: Value, mode: u32) -> Value {
    json!({ "attributes": { "POSITION": position, "NORMAL": 99 }, "indices": indices, "mode": mode })
}

fn one_mesh(primitives: Value) -> Value {
    scene(json!([{ "primitives": primitives }]), json!([{ "mesh": 0 }]))
}

fn read(json: &Value) -> TriangleMesh {
    let read = read_mesh_bytes(MeshFormat::Glb, &glb(json, &buffer()), "model");
    read.unwrap_or_else(|error| panic!("{error}"))
}

/// A scene with most of what is read, for damage.
pub(in crate::io) fn scenery() -> Vec<u8> {
    let meshes = json!([
        { "primitives": [primitive(0, json!(2), 4), primitive(0, json!(3), 5), primitive(1, json!(null), 4)] },
        { "primitives": [primitive(0, json!(4), 6), { "attributes": {}, "mode": 1 }] },
    ]);
    let nodes = json!([
        { "children": [1, 2], "mesh": 0, "translation": [1, 2, 3], "rotation": [0, 0, 1, 1], "scale": [1, -1, 2] },
        { "mesh": 1, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 5, 5, 1] },
        { "mesh": 1, "skin": 0 },
    ]);
    glb(&scene(meshes, nodes), &buffer())
}

#[test]
fn triangles_strips_and_fans_with_indices_of_every_type() {
    let mesh = read(&one_mesh(json!([primitive(0, json!(2), 4)])));
    assert_eq!(mesh.positions[1..4], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]]);
    assert_eq!((mesh.positions.len(), mesh.faces), (5, vec![[0, 1, 2]]));
    // Every triangle of a strip faces the same way.
    assert_eq!(read(&one_mesh(json!([primitive(0, json!(3), 5)]))).faces, [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
    assert_eq!(read(&one_mesh(json!([primitive(0, json!(4), 6)]))).faces, [[1, 2, 0], [2, 3, 0], [3, 4, 0]]);
    assert_eq!(read(&one_mesh(json!([primitive(0, json!(null), 6)]))).faces.len(), 3);
}

#[test]
fn quantised_positions_are_scaled() {
    let mesh = read(&one_mesh(json!([primitive(1, json!(null), 4)])));
    assert_eq!(mesh.positions, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]);
}

#[test]
fn primitives_share_positions_and_lines_are_passed_over() {
    let both = json!([primitive(0, json!(2), 4), primitive(0, json!(4), 1), primitive(0, json!(3), 5)]);
    let mesh = read(&one_mesh(both));
    assert_eq!((mesh.positions.len(), mesh.faces.len()), (5, 4));
}

#[test]
fn nodes_place_and_mirror_their_meshes() {
    let meshes = json!([{ "primitives": [primitive(0, json!(2), 4)] }]);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let nodes = json!([
        { "children": [2, 1], "translation": [10, 0, 0] },
        { "mesh": 0, "scale": [-2, 1, 1] },
        { "mesh": 0, "rotation": [0, 0, half, half], "translation": [0, 0, 5] },
        { "mesh": 0 },
    ]);
    let mesh = read(&scene(meshes, nodes));
    assert_eq!(mesh.faces, [[0, 1, 2], [5, 7, 6]], "the node that no scene holds is left out");
    let near = |at: usize, expected: [f64; 3]| {
        let p = mesh.positions[at];
        assert!((0..3).all(|k| (p[k] - expected[k]).abs() < 1e-12), "{p:?}");
    };
    near(1, [10.0, 1.0, 5.0]);
    near(2, [9.0, 0.0, 5.0]);
    near(6, [8.0, 0.0, 0.0]);
}

#[test]
fn without_scenes_and_nodes_all_meshes_count() {
    let mut json = one_mesh(json!([primitive(0, json!(2), 4)]));
    let object = json.as_object_mut().unwrap();
    object.remove("scenes");
    object.remove("scene");
    assert_eq!(read(&json).faces.len(), 1);
    json.as_object_mut().unwrap().remove("nodes");
    assert_eq!(read(&json).faces.len(), 1);
}

#[test]
fn what_cannot_be_read_is_named() {
    let sound = one_mesh(json!([primitive(0, json!(2), 4)]));
    let with = |pointer: &str, value: Value| {
        let mut json = sound.clone();
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        match json.pointer_mut(parent).unwrap() {
            Value::Object(object) => drop(object.insert(key.to_owned(), value)),
            Value::Array(array) => array[key.parse::<usize>().unwrap()] = value,
            _ => unreachable!("a container"),
        }
        json
    };
    let draco = json!({ "KHR_draco_mesh_compression": { "bufferView": 0 } });
    let mut compressed = with("/meshes/0/primitives/0/extensions", draco);
    compressed["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    let cases = [
        (compressed, "accessor 0 (counting from 0): a Draco-compressed mesh cannot be read"),
        (with("/extensionsRequired", json!(["KHR_draco_mesh_compression"])), "a Draco-compressed mesh"),
        (with("/extensionsRequired", json!(["X"])), "the extension 'X' cannot be read"),
        (with("/bufferViews/0/extensions", json!({ "EXT_meshopt_compression": {} })), "meshopt compression"),
        (
            with("/accessors/0/sparse", json!({})),
            "accessor 0 (counting from 0): a sparse accessor cannot be read",
        ),
        (with("/buffers/0/uri", json!("a.bin")), "a buffer outside the file's binary chunk"),
        (with("/accessors/0/count", json!(6)), "its data reaches beyond the end"),
        (with("/accessors/0/count", json!(u64::MAX)), "its mesh"),
        (with("/accessors/2/count", json!(1u64 << 40)), "more than 2147483648 elements"),
        (with("/accessors/2/byteOffset", json!(u64::MAX)), "its data reaches beyond the end"),
        (with("/accessors/2/count", json!(2)), "a primitive has 2 corners, no multiple of three"),
        (
            with("/accessors/2/byteOffset", json!(5)),
            "accessor 2, index 0 (counting from 0): it refers to vertex 7",
        ),
        (with("/accessors/2/componentType", json!(5122)), "indices must be unsigned"),
        (with("/accessors/0/componentType", json!(5130)), "component type is none of glTF's"),
        (with("/accessors/0/type", json!("MAT4")), "positions must be of type VEC3"),
        (with("/accessors/0/bufferView", json!(null)), "it has no buffer view"),
        (with("/bufferViews/0/byteStride", json!(8)), "shorter than an element"),
        (
            with("/meshes/0/primitives/0/indices", json!(17)),
            "accessor 17 (counting from 0): the accessor does not exist",
        ),
        (with("/meshes/0/primitives/0/mode", json!(7)), "mode 7"),
        (with("/meshes/0/primitives/0/mode", json!(0)), "there is no face"),
        (with("/nodes/0/mesh", json!(3)), "mesh 3 (counting from 0): the mesh does not exist"),
        (with("/nodes/0/children", json!([0])), "node 0 (counting from 0): the scene reaches it twice"),
        (with("/nodes/0/children", json!([1])), "a child that does not exist"),
        (
            with("/nodes/0/scale", json!([1e300, 1, 1])),
            "accessor 0, vertex 1 (counting from 0): the coordinate 1e300 is beyond",
        ),
        (with("/scene", json!(2)), "the default scene does not exist"),
        (with("/accessors/0/count", json!(-1)), "its JSON is not that of glTF 2.0 ('invalid value"),
    ];
    for (json, expected) in cases {
        let message = refusal(MeshFormat::Glb, &glb(&json, &buffer()));
        assert!(message.contains(expected), "{message}\nnot: {expected}");
    }
    let mut nan = buffer();
    nan[16..20].copy_from_slice(&f32::NAN.to_le_bytes());
    let message = refusal(MeshFormat::Glb, &glb(&sound, &nan));
    assert!(
        message.contains("accessor 0, vertex 1 (counting from 0): the coordinate 'NaN' is not finite"),
        "{message}"
    );
}

#[test]
fn framing_is_checked() {
    let whole = scenery();
    let with = |at: usize, word: u32| {
        let mut bytes = whole.clone();
        bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
        bytes
    };
    let cases = [
        (b"{\"asset\":{}}".to_vec(), "this is not a binary glTF file"),
        (with(4, 1), "its version is 1"),
        (with(8, 1 << 30), "the file ends before the end that its header states"),
        (with(12, 1 << 30), "the file ends before"),
        (with(16, 7), "the JSON chunk is missing"),
        (whole[..whole.len() - 4].to_vec(), "the file ends before"),
        (glb_of_text(b"{".to_vec(), &[]), "its JSON is not that of glTF 2.0 ('EOF while"),
        (glb_of_text(vec![b'['; 1 << 16], &[]), "its JSON is not that of glTF 2.0"),
    ];
    for (bytes, expected) in cases {
        let message = refusal(MeshFormat::Glb, &bytes);
        assert!(message.contains(expected), "{message}\nnot: {expected}");
    }
}

#[test]
fn a_mesh_placed_without_end_is_refused_before_memory_is() {
    let meshes = json!([{ "primitives": vec![primitive(0, json!(4), 5); 1000] }]);
    let nodes: Vec<Value> = (0..2000).map(|_| json!({ "mesh": 0 })).collect();
    let mut json = scene(meshes, json!(nodes));
    json["scenes"][0]["nodes"] = json!((0..2000).collect::<Vec<_>>());
    let message = refusal(MeshFormat::Glb, &glb(&json, &buffer()));
    assert!(message.contains("it places its meshes so often that they are 64 times"), "{message}");
}
