//! Builds small glTF files.

use base64::Engine;
use serde_json::{Value, json};

pub(crate) const U8: u32 = 5121;
pub(crate) const U16: u32 = 5123;
pub(crate) const U32: u32 = 5125;
pub(crate) const F32: u32 = 5126;

/// JSON and binary data of a file under construction.
#[derive(Clone, Debug)]
pub(crate) struct File {
    pub(crate) json: Value,
    pub(crate) bin: Vec<u8>,
}

impl File {
    pub(crate) fn new() -> Self {
        Self { json: json!({"asset": {"version": "2.0"}}), bin: Vec::new() }
    }

    /// Appends `item` to a list of the file and returns its index.
    pub(crate) fn add(&mut self, list: &str, item: Value) -> usize {
        if self.json[list].is_null() {
            self.json[list] = json!([]);
        }
        let items = self.json[list].as_array_mut().expect("the value is an array");
        items.push(item);
        items.len() - 1
    }

    /// Adds a buffer view of `bytes`, aligned to 4 bytes, and returns its index.
    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let offset = self.bin.len();
        self.bin.extend_from_slice(bytes);
        self.add(
            "bufferViews",
            json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}),
        )
    }

    /// Adds a buffer view of `bytes` with an accessor for all of it, and returns the accessor's
    /// index.
    pub(crate) fn accessor(
        &mut self,
        bytes: &[u8],
        component: u32,
        count: usize,
        kind: &str,
    ) -> usize {
        let view = self.view(bytes);
        let bounds = [0.0];
        self.add(
            "accessors",
            json!({
                "bufferView": view, "componentType": component, "count": count, "type": kind,
                "min": bounds, "max": bounds
            }),
        )
    }

    pub(crate) fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(&bytes, F32, values.len() / width(kind), kind)
    }

    pub(crate) fn bytes(&mut self, kind: &str, values: &[u8]) -> usize {
        self.accessor(values, U8, values.len() / width(kind), kind)
    }

    pub(crate) fn shorts(&mut self, kind: &str, values: &[u16]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(&bytes, U16, values.len() / width(kind), kind)
    }

    /// Returns the first primitive of the first mesh.
    pub(crate) fn primitive(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]
    }

    /// Returns the JSON with its buffer declared.
    fn finished(&self, uri: Option<String>) -> Value {
        let mut json = self.json.clone();
        if json["buffers"].is_null() && !self.bin.is_empty() {
            json["buffers"] = json!([{"byteLength": self.bin.len()}]);
            if let Some(uri) = uri {
                json["buffers"][0]["uri"] = uri.into();
            }
        }
        json
    }

    /// Returns a text file with the buffer in a data URI.
    pub(crate) fn gltf(&self) -> Vec<u8> {
        let base64 = base64::engine::general_purpose::STANDARD.encode(&self.bin);
        let uri = format!("data:application/octet-stream;base64,{base64}");
        self.finished(Some(uri)).to_string().into_bytes()
    }

    /// Returns a text file with the buffer in an external file.
    pub(crate) fn gltf_with_buffer_uri(&self, uri: &str) -> Vec<u8> {
        self.finished(Some(uri.into())).to_string().into_bytes()
    }

    /// Returns a binary file.
    pub(crate) fn glb(&self) -> Vec<u8> {
        let json = self.finished(None).to_string().into_bytes();
        let mut chunks = vec![(*b"JSON", padded(json, b' '))];
        if !self.bin.is_empty() {
            chunks.push((*b"BIN\0", padded(self.bin.clone(), 0)));
        }
        container(&chunks)
    }
}

/// Returns a binary file of `chunks`.
pub(crate) fn container(chunks: &[([u8; 4], Vec<u8>)]) -> Vec<u8> {
    let length = 12 + chunks.iter().map(|(_, data)| 8 + data.len()).sum::<usize>();
    let number = |n: usize| u32::try_from(n).expect("test files are small").to_le_bytes();
    let mut file = [*b"glTF", number(2), number(length)].concat();
    for (kind, data) in chunks {
        file.extend_from_slice(&number(data.len()));
        file.extend_from_slice(kind);
        file.extend_from_slice(data);
    }
    file
}

pub(crate) fn padded(mut data: Vec<u8>, with: u8) -> Vec<u8> {
    data.resize(data.len().next_multiple_of(4), with);
    data
}

fn width(kind: &str) -> usize {
    match kind {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        _ => 16,
    }
}

pub(crate) const TRIANGLE: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];

/// A node with one triangle: positions, normals, texture coordinates and indices.
pub(crate) fn rigid() -> File {
    let mut file = File::new();
    let positions = file.floats("VEC3", &TRIANGLE);
    let normals = file.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    let uvs = file.floats("VEC2", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    let indices = file.bytes("SCALAR", &[0, 1, 2]);
    let attributes = json!({"POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs});
    file.add("meshes", json!({"primitives": [{"attributes": attributes, "indices": indices}]}));
    file.add("nodes", json!({"name": "body", "mesh": 0}));
    file
}

/// A column-major matrix that translates by `y` along Y.
pub(crate) fn moved_up(y: f32) -> [f32; 16] {
    [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, y, 0.0, 1.0]
}

/// Hips, a head one metre above them, a triangle skinned to both, and a clip that rotates the head.
pub(crate) fn skinned() -> File {
    let mut file = rigid();
    let joints = file.bytes("VEC4", &[0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0]);
    let weights = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.25, 0.75, 0.0, 0.0];
    let weights = file.floats("VEC4", &weights);
    file.primitive()["attributes"]["JOINTS_0"] = joints.into();
    file.primitive()["attributes"]["WEIGHTS_0"] = weights.into();
    let binds = file.floats("MAT4", &[moved_up(0.0), moved_up(-1.0)].concat());
    file.json["nodes"][0]["skin"] = 0.into();
    file.add("nodes", json!({"name": "hips", "children": [2]}));
    file.add("nodes", json!({"name": "head", "translation": [0, 1, 0]}));
    file.add("skins", json!({"name": "skin", "joints": [1, 2], "inverseBindMatrices": binds}));
    let times = file.floats("SCALAR", &[0.5, 1.5]);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let turns = file.floats("VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, half, 0.0, half]);
    file.add(
        "animations",
        json!({
            "name": "turn",
            "samplers": [{"input": times, "output": turns}],
            "channels": [{"sampler": 0, "target": {"node": 2, "path": "rotation"}}]
        }),
    );
    file
}
