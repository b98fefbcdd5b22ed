//! A small generated character file.

use std::path::PathBuf;

use base64::Engine;
use serde_json::{Value, json};
use tempfile::TempDir;

/// A temporary folder with "post.gltf": a post of two joints, 2 m high, whose upper half bends
/// towards +X within one second.
pub(crate) struct Folder(TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        let folder = Self(TempDir::new().expect("a temporary folder"));
        std::fs::write(folder.path("post.gltf"), post().to_string()).expect("written");
        folder
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn text(&self, name: &str) -> String {
        self.path(name).to_string_lossy().into_owned()
    }
}

/// Returns the post as glTF: a quad for each half, skinned to two joints, and a clip "Bend" with
/// two keys.
pub(crate) fn post() -> Value {
    let (bytes, views) = post_data();
    let data = base64::engine::general_purpose::STANDARD.encode(&bytes);
    let uri = format!("data:application/octet-stream;base64,{data}");
    let accessor = |view: usize, kind: u32, count: usize, shape: &str| {
        json!({"bufferView": view,
        "componentType": kind, "count": count, "type": shape})
    };
    let mut accessors = vec![
        accessor(0, 5126, 8, "VEC3"),
        accessor(1, 5121, 8, "VEC4"),
        accessor(2, 5126, 8, "VEC4"),
        accessor(3, 5121, 12, "SCALAR"),
        accessor(4, 5126, 2, "MAT4"),
        accessor(5, 5126, 2, "SCALAR"),
        accessor(6, 5126, 2, "VEC4"),
    ];
    (accessors[0]["min"], accessors[0]["max"]) = (json!([-0.2, 0.0, 0.0]), json!([0.2, 2.0, 0.0]));
    (accessors[5]["min"], accessors[5]["max"]) = (json!([0.5]), json!([1.5]));
    json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"name": "mesh", "mesh": 0, "skin": 0}, {"name": "foot", "children": [2]},
            {"name": "head", "translation": [0.0, 1.0, 0.0]}],
        "meshes": [{"primitives": [{
            "attributes": {"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2},
            "indices": 3,
            "material": 0,
        }]}],
        "materials": [{
            "doubleSided": true,
            "pbrMetallicRoughness": {"baseColorFactor": [0.9, 0.1, 0.1, 1.0]},
        }],
        "skins": [{"joints": [1, 2], "inverseBindMatrices": 4}],
        "animations": [{"name": "Bend", "samplers": [{"input": 5, "output": 6}],
            "channels": [{"sampler": 0, "target": {"node": 2, "path": "rotation"}}]}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": bytes.len(), "uri": uri}],
    })
}

/// Returns positions, joints, weights, indices, inverse bind matrices, key times and rotations,
/// with a buffer view for each.
fn post_data() -> (Vec<u8>, Vec<Value>) {
    let floats = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let level = |y: f32| [[-0.2, y, 0.0], [0.2, y, 0.0]];
    let positions: Vec<f32> = [0.0, 1.0, 1.0, 2.0].into_iter().flat_map(level).flatten().collect();
    let bind =
        |y: f32| [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -y, 0.0, 1.0];
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let pieces = [
        floats(&positions),
        [[0; 16], [1, 0, 0, 0].repeat(4).try_into().expect("16 bytes")].concat(),
        floats(&[1.0, 0.0, 0.0, 0.0].repeat(8)),
        vec![0, 1, 3, 0, 3, 2, 4, 5, 7, 4, 7, 6],
        floats(&[bind(0.0), bind(1.0)].concat()),
        floats(&[0.5, 1.5]),
        floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -half, half]),
    ];
    let views = pieces.iter().scan(0, |end, piece| {
        let first = std::mem::replace(end, *end + piece.len());
        Some(json!({"buffer": 0, "byteOffset": first, "byteLength": piece.len()}))
    });
    let views = views.collect();
    (pieces.concat(), views)
}
