use serde_json::Value;

use crate::io::tests::written;
use crate::io::{MeshFormat, write_mesh};
use crate::mesh::TriangleMesh;

mod reading;

pub(in crate::io) use reading::scenery;

/// The JSON and the binary chunk of a file, whose framing is checked.
fn chunks(bytes: &[u8]) -> (Value, &[u8]) {
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&bytes[..4], word(4), word(8)), (&b"glTF"[..], 2, bytes.len()));
    let text = word(12);
    assert_eq!(&bytes[16..20], b"JSON");
    let binary = word(20 + text);
    assert_eq!(&bytes[24 + text..28 + text], b"BIN\0");
    assert_eq!((text % 4, binary % 4, 28 + text + binary), (0, 0, bytes.len()));
    (serde_json::from_slice(&bytes[20..20 + text]).unwrap(), &bytes[28 + text..])
}

/// The numbers of an accessor, as bits.
fn accessor(json: &Value, binary: &[u8], index: usize) -> Vec<u32> {
    let accessor = &json["accessors"][index];
    let width = if accessor["type"] == "VEC3" { 3 } else { 1 };
    let count = accessor["count"].as_u64().unwrap() as usize * width;
    let view = &json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
    let (offset, length) = (view["byteOffset"].as_u64().unwrap(), view["byteLength"].as_u64().unwrap());
    assert_eq!((offset % 4, length), (0, 4 * count as u64));
    let part = &binary[offset as usize..][..length as usize];
    part.as_chunks().0.iter().map(|&bytes| u32::from_le_bytes(bytes)).collect()
}

fn floats(json: &Value, binary: &[u8], index: usize) -> Vec<[f32; 3]> {
    let numbers: Vec<f32> = accessor(json, binary, index).into_iter().map(f32::from_bits).collect();
    numbers.as_chunks().0.to_vec()
}

/// A tetrahedron's corner at 0.1, an unreferenced vertex, and one on a degenerate face alone.
fn corner() -> TriangleMesh {
    let positions =
        vec![[0.1, 0.1, 0.1], [2.0, 0.1, 0.1], [0.1, 3.0, 0.1], [0.1, 0.1, -4.0], [9.0; 3], [5.0; 3]];
    TriangleMesh::new(positions, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [5, 5, 0]])
}

#[test]
fn the_chunks_hold_what_the_accessors_say() {
    let mesh = corner();
    let bytes = written(&mesh, MeshFormat::Glb);
    let (json, binary) = chunks(&bytes);
    assert_eq!(json["asset"]["version"], "2.0");
    assert_eq!(json["buffers"][0]["byteLength"], binary.len());
    let positions = floats(&json, binary, 0);
    assert_eq!(positions, mesh.positions.iter().map(|p| p.map(|x| x as f32)).collect::<Vec<_>>());
    assert_eq!(accessor(&json, binary, 2), mesh.faces.as_flattened());
}

#[test]
fn the_bounds_are_those_of_the_stored_numbers() {
    let bytes = written(&corner(), MeshFormat::Glb);
    let (json, _) = chunks(&bytes);
    let least = f64::from(0.1f32);
    assert_eq!(json["accessors"][0]["min"], serde_json::json!([least, least, -4.0]));
    assert_eq!(json["accessors"][0]["max"], serde_json::json!([9.0, 9.0, 9.0]));
}

#[test]
fn normals_are_weighted_by_area_and_of_unit_length() {
    let bytes = written(&corner(), MeshFormat::Glb);
    let (json, binary) = chunks(&bytes);
    let normals = floats(&json, binary, 1);
    for normal in &normals {
        let length: f32 = normal.iter().map(|x| x * x).sum();
        assert!((length - 1.0).abs() < 1e-6, "{normal:?}");
    }
    // Area vectors of the three faces: (0, 0, -a), (0, b, 0) and (-c, 0, 0), up to sign.
    let areas = [2.9 * 4.1, 1.9 * 4.1, 1.9 * 2.9];
    let length = areas.iter().map(|area| area * area).sum::<f64>().sqrt();
    for (found, area) in normals[0].iter().zip(areas) {
        assert!((f64::from(found.abs()) - area / length).abs() < 1e-6, "{:?}", normals[0]);
    }
    assert_eq!((normals[4], normals[5]), ([0.0, 0.0, 1.0], [0.0, 0.0, 1.0]));
}

#[test]
fn any_length_of_json_is_padded() {
    for extra in 0..12 {
        let mut mesh = corner();
        mesh.positions.resize(6 + 10usize.pow(extra % 4), [0.0; 3]);
        mesh.positions[5][0] = 10f64.powi(extra as i32);
        let mut bytes = Vec::new();
        write_mesh(&mesh, MeshFormat::Glb, &mut bytes).unwrap();
        chunks(&bytes);
    }
}
