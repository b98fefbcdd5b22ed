use serde_json::json;

use super::builder::{F32, File, TRIANGLE, U8, U16, rigid};
use super::{assert_problem, loaded, problems};

fn positions(file: &File) -> Vec<[f32; 3]> {
    loaded(&file.glb()).character.parts[0].mesh.positions.clone()
}

#[test]
fn interleaved_vertices_use_byte_stride() {
    let mut file = rigid();
    let mut mixed = Vec::new();
    for corner in TRIANGLE.chunks(3) {
        for value in corner.iter().chain(&[9.0, 9.0]) {
            mixed.extend_from_slice(&value.to_le_bytes());
        }
    }
    mixed.truncate(mixed.len() - 8); // no padding after the last element
    let view = file.view(&mixed);
    file.json["bufferViews"][view]["byteStride"] = 20.into();
    file.json["accessors"][0]["bufferView"] = view.into();
    assert_eq!(positions(&file).concat(), TRIANGLE);
    file.json["bufferViews"][view]["byteStride"] = 8.into();
    assert_problem(
        &file.glb(),
        "accessors[0]: has elements of 12 bytes, but bufferViews[4] has a byteStride of 8",
    );
    for stride in [2, 6, 256] {
        file.json["bufferViews"][view]["byteStride"] = stride.into();
        let problem = format!(
            "bufferViews[{view}]: has a byteStride of {stride}; it must be a multiple of 4"
        );
        assert_problem(&file.glb(), &problem);
    }
}

#[test]
fn sparse_values_replace_elements() {
    let mut file = rigid();
    let indices = file.view(&[1, 2]);
    let values: Vec<u8> =
        [5.0f32, 6.0, 7.0, 8.0, 9.0, 10.0].iter().flat_map(|v| v.to_le_bytes()).collect();
    let values = file.view(&values);
    file.json["accessors"][0]["sparse"] = json!({
        "count": 2,
        "indices": {"bufferView": indices, "componentType": U8},
        "values": {"bufferView": values}
    });
    assert_eq!(positions(&file), [[0.0; 3], [5.0, 6.0, 7.0], [8.0, 9.0, 10.0]]);
    // Without a buffer view, the other elements are zero.
    file.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert_eq!(positions(&file)[1], [5.0, 6.0, 7.0]);
    let at =
        usize::try_from(file.json["bufferViews"][indices]["byteOffset"].as_u64().unwrap()).unwrap();
    for wrong in [[1, 1], [2, 1], [1, 3]] {
        file.bin[at..at + 2].copy_from_slice(&wrong);
        assert_problem(&file.glb(), "accessors[0].sparse.indices: holds");
    }
    file.json["accessors"][0]["sparse"]["count"] = 4.into();
    assert!(problems(&file.glb())[0].starts_with("accessors[0].sparse.count: is 4"));
    file.json["accessors"][0]["sparse"]["count"] = 1.into();
    file.json["accessors"][0]["sparse"]["indices"]["componentType"] = F32.into();
    assert_problem(&file.glb(), "accessors[0].sparse.indices.componentType: must be an unsigned");
    file.json["accessors"][0]["sparse"]["indices"]["componentType"] = U16.into();
    file.json["accessors"][0]["sparse"]["indices"]["byteOffset"] = 1.into();
    assert!(problems(&file.glb())[0].starts_with("accessors[0].sparse.indices: starts at byte 1"));
}

#[test]
fn ranges_past_the_end_are_refused() {
    let mut file = rigid();
    file.json["accessors"][0]["count"] = 4.into();
    assert_problem(
        &file.glb(),
        "accessors[0]: has 4 elements of 12 bytes from byte 0 on, which do not fit into the 36",
    );
    file.json["accessors"][0]["count"] = 3.into();
    file.json["accessors"][0]["byteOffset"] = 4.into();
    assert_problem(&file.glb(), "accessors[0]: has 3 elements of 12 bytes from byte 4 on");
    file.json["accessors"][0]["byteOffset"] = u64::MAX.into();
    assert!(
        problems(&file.glb())[0].starts_with("accessors[0]: starts at byte 18446744073709551615")
    );
    let mut file = rigid();
    file.json["bufferViews"][0]["byteOffset"] = 100_000.into();
    assert_problem(
        &file.glb(),
        "bufferViews[0]: covers 36 bytes from byte 100000 on, but buffer 0 has",
    );
    file.json["bufferViews"][0]["byteOffset"] = u64::MAX.into();
    assert_problem(&file.glb(), "bufferViews[0]: covers 36 bytes from byte 18446744073709551615");
    let mut file = rigid();
    file.json["buffers"] = json!([{"byteLength": file.bin.len() + 4}]);
    assert_problem(&file.glb(), "buffers[0]: has");
    file.json["buffers"] = json!([{"byteLength": 0}]);
    assert_problem(&file.glb(), "buffers[0].byteLength: is 0");
}

#[test]
fn misaligned_and_unknown_formats_are_refused() {
    let mut file = rigid();
    file.json["accessors"][0]["byteOffset"] = 2.into();
    file.json["accessors"][0]["count"] = 2.into();
    assert!(problems(&file.glb())[0].starts_with("accessors[0]: starts at byte 2"));
    let mut file = rigid();
    file.json["accessors"][0]["componentType"] = 5124.into();
    assert_problem(&file.glb(), "accessors[0].componentType: is 5124");
    file.json["accessors"][0]["componentType"] = F32.into();
    file.json["accessors"][0]["type"] = "VEC5".into();
    assert_problem(&file.glb(), "accessors[0].type: is \"VEC5\"");
    file.json["accessors"][0]["type"] = "VEC3".into();
    file.json["accessors"][0]["normalized"] = true.into();
    assert_problem(&file.glb(), "accessors[0]: is normalised");
    file.json["accessors"][0]["normalized"] = "yes".into();
    assert_problem(&file.glb(), "accessors[0].normalized: must be true or false");
}

#[test]
fn small_components_need_only_their_own_alignment() {
    for (component, size) in [(U8, 1), (U16, 2)] {
        for offset in [size, 3 * size] {
            let mut file = rigid();
            let mut bytes = vec![0xFF; offset];
            for index in [2_u8, 0, 1] {
                bytes.extend_from_slice(&[index, 0][..size]);
            }
            let view = file.view(&bytes);
            let (starts, length) =
                (file.json["bufferViews"][view]["byteOffset"].clone(), bytes.len());
            let indices = &mut file.json["accessors"][3];
            *indices = json!({
                "bufferView": view, "componentType": component, "count": 3, "type": "SCALAR"
            });
            indices["byteOffset"] = offset.into();
            assert_eq!(loaded(&file.glb()).character.parts[0].mesh.indices, [2, 0, 1]);
            // The same with the offset moved to the view.
            file.json["accessors"][3]["byteOffset"] = 0.into();
            file.json["bufferViews"][view]["byteOffset"] =
                (starts.as_u64().unwrap() + offset as u64).into();
            file.json["bufferViews"][view]["byteLength"] = (length - offset).into();
            assert_eq!(loaded(&file.glb()).character.parts[0].mesh.indices, [2, 0, 1]);
        }
    }
}

#[test]
fn non_finite_numbers_are_refused() {
    for bad in [f32::NAN, f32::INFINITY] {
        let mut file = rigid();
        file.bin[16..20].copy_from_slice(&bad.to_le_bytes());
        assert_problem(&file.glb(), &format!("accessors[0]: holds {bad} in element 1"));
    }
}

#[test]
fn small_file_cannot_allocate_much_memory() {
    let mut file = rigid();
    file.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    for count in [1_u64 << 33, u64::MAX >> 4] {
        file.json["accessors"][0]["count"] = count.into();
        let listed = problems(&file.glb());
        assert!(listed.iter().any(|p| p.contains("the memory limit is 1024 MiB")), "{listed:?}");
    }
    // Using one array many times is refused too.
    let mut file = rigid();
    let big = file.floats("VEC3", &vec![0.0; 3 * 40_000]);
    file.json["meshes"] = json!([{"primitives": [{"attributes": {"POSITION": big}}]}]);
    for _ in 0..500 {
        file.add("nodes", json!({"mesh": 0}));
    }
    let listed = problems(&file.glb());
    assert!(listed.len() == 1 && listed[0].contains("out of proportion to the size"), "{listed:?}");
}

#[test]
fn integers_convert_plain_and_normalised() {
    let mut file = rigid();
    file.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let shorts: Vec<u8> = [0i16, 0, 0, 0, 32767, 0, 0, 0, -32768, 16384, 0, 0]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let view = file.view(&shorts);
    file.json["bufferViews"][view]["byteStride"] = 8.into();
    let accessor = &mut file.json["accessors"][0];
    accessor["bufferView"] = view.into();
    accessor["componentType"] = 5122.into();
    assert_eq!(positions(&file), [[0.0; 3], [32767.0, 0.0, 0.0], [-32768.0, 16384.0, 0.0]]);
    file.json["accessors"][0]["normalized"] = true.into();
    assert_eq!(positions(&file), [[0.0; 3], [1.0, 0.0, 0.0], [-1.0, 16384.0 / 32767.0, 0.0]]);
    file.json.as_object_mut().unwrap().remove("extensionsRequired");
    assert_problem(
        &file.glb(),
        "accessors[0]: is VEC3 of normalised 16-bit signed; POSITION must be VEC3 of float",
    );
}
