//! The binary data of a file: buffer views and accessors.

use populace_character::Bounds;
use serde_json::{Value, json};

const FLOAT: u32 = 5126;
const BYTE: u32 = 5121;
const SHORT: u32 = 5123;
const INT: u32 = 5125;
/// Targets of buffer views: vertex attributes and indices.
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// One buffer, its views and accessors.
#[derive(Default)]
pub(super) struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    /// Appends data that starts at a multiple of four bytes.
    pub(super) fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        let offset = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut view = json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.views.push(view);
        self.views.len() - 1
    }

    fn accessor(&mut self, view: usize, component: u32, shape: &str, count: usize) -> usize {
        self.accessors.push(json!({
            "bufferView": view,
            "componentType": component,
            "type": shape,
            "count": count,
        }));
        self.accessors.len() - 1
    }

    pub(super) fn floats(&mut self, values: &[f32], shape: &str, target: Option<u32>) -> usize {
        let view = self.view(bytemuck::cast_slice(values), target);
        let width = match shape {
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        self.accessor(view, FLOAT, shape, values.len() / width)
    }

    pub(super) fn vertices(&mut self, values: &[f32], shape: &str) -> usize {
        self.floats(values, shape, Some(VERTICES))
    }

    pub(super) fn positions(&mut self, positions: &[[f32; 3]]) -> usize {
        let flat: Vec<f32> = positions.iter().flatten().copied().collect();
        let accessor = self.vertices(&flat, "VEC3");
        if let Some(bounds) = Bounds::around(positions.iter().copied()) {
            self.accessors[accessor]["min"] = json!(bounds.low);
            self.accessors[accessor]["max"] = json!(bounds.high);
        }
        accessor
    }

    /// Appends four joints per vertex, as bytes if they fit.
    pub(super) fn joints(&mut self, joints: &[u16]) -> usize {
        let bytes: Result<Vec<u8>, _> = joints.iter().map(|j| u8::try_from(*j)).collect();
        let (view, component) = match &bytes {
            Ok(bytes) => (self.view(bytes, Some(VERTICES)), BYTE),
            Err(_) => (self.view(bytemuck::cast_slice(joints), Some(VERTICES)), SHORT),
        };
        self.accessor(view, component, "VEC4", joints.len() / 4)
    }

    /// Appends indices, as 16-bit numbers if they fit.
    pub(super) fn indices(&mut self, indices: &[u32], vertex_count: usize) -> usize {
        let (view, component) = if vertex_count < usize::from(u16::MAX) {
            let short = |index: &u32| u16::try_from(*index).unwrap_or(0);
            let short: Vec<u16> = indices.iter().map(short).collect();
            (self.view(bytemuck::cast_slice(&short), Some(INDICES)), SHORT)
        } else {
            (self.view(bytemuck::cast_slice(indices), Some(INDICES)), INT)
        };
        self.accessor(view, component, "SCALAR", indices.len())
    }

    /// Adds the lists of buffers, views and accessors to a document.
    pub(super) fn describe(&mut self, document: &mut Value) {
        if !self.bytes.is_empty() {
            document["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
            document["bufferViews"] = std::mem::take(&mut self.views).into();
        }
        if !self.accessors.is_empty() {
            document["accessors"] = std::mem::take(&mut self.accessors).into();
        }
    }

    /// Returns the file (glTF 2.0, section 4); `None` if it would be too large for its header.
    pub(super) fn glb(&self, document: &Value) -> Option<Vec<u8>> {
        let mut json = document.to_string().into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let chunks: &[(&[u8], &[u8; 4])] = &[(&json, b"JSON"), (&self.bytes, b"BIN\0")];
        let chunks: Vec<_> = chunks.iter().filter(|(bytes, _)| !bytes.is_empty()).collect();
        let length = 12 + chunks.iter().map(|(bytes, _)| 8 + bytes.len()).sum::<usize>();
        let mut file = Vec::with_capacity(length);
        file.extend_from_slice(b"glTF");
        file.extend_from_slice(&2_u32.to_le_bytes());
        file.extend_from_slice(&u32::try_from(length).ok()?.to_le_bytes());
        for (bytes, kind) in chunks {
            file.extend_from_slice(&u32::try_from(bytes.len()).ok()?.to_le_bytes());
            file.extend_from_slice(*kind);
            file.extend_from_slice(bytes);
        }
        Some(file)
    }
}
