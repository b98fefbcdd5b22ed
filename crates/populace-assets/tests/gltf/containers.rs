use populace_assets::{Error, load, load_from_slice};
use serde_json::json;

use super::builder::{File, container, padded, rigid, skinned};
use super::{assert_note, assert_problem, loaded, problems};

#[test]
fn text_and_binary_files_load_equally() {
    let file = skinned();
    let (text, binary) = (loaded(&file.gltf()), loaded(&file.glb()));
    assert_eq!(text.character.parts, binary.character.parts);
    assert_eq!(text.character.skeleton, binary.character.skeleton);
    assert_eq!(text.character.parts[0].mesh.positions[1], [1.0, 0.0, 0.0]);
}

#[test]
fn format_is_detected_from_content_and_buffer_files_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let file = rigid();
    let path = folder.path().join("binary.gltf");
    std::fs::write(&path, file.glb()).unwrap();
    assert_eq!(load(&path).unwrap().character.name, "binary");
    // The name is percent-encoded in the file, and a buffer file may be longer than declared.
    std::fs::create_dir(folder.path().join("data")).unwrap();
    std::fs::write(folder.path().join("data/a b.bin"), [&file.bin[..], b"more"].concat()).unwrap();
    let path = folder.path().join("text.glb");
    std::fs::write(&path, file.gltf_with_buffer_uri("data/a%20b.bin")).unwrap();
    assert_eq!(load(&path).unwrap().character.parts.len(), 1);
    std::fs::write(folder.path().join("data/a b.bin"), &file.bin[..8]).unwrap();
    let error = load(&path).unwrap_err().to_string();
    assert!(
        error.contains("buffers[0].uri: refers to \"data/a b.bin\", which has 8 bytes, but"),
        "{error}"
    );
}

#[test]
fn missing_files_and_folders_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    assert!(matches!(load(folder.path().join("none.glb")), Err(Error::Io { .. })));
    std::fs::create_dir(folder.path().join("folder")).unwrap();
    let file = rigid().gltf_with_buffer_uri("folder");
    let error = load_from_slice(&file, Some(folder.path())).unwrap_err().to_string();
    assert!(
        error.contains(
            "buffers[0].uri: refers to \"folder\", which cannot be read: it is not a regular file"
        ),
        "{error}"
    );
    assert_problem(&file, "buffers[0].uri: refers to the file \"folder\", but this input has no");
}

#[test]
fn other_schemes_and_absolute_paths_are_refused() {
    for uri in [
        "http://example.com/a.bin",
        "/etc/passwd",
        "file:///etc/passwd",
        "%2Fetc/passwd",
        "C:%5Ca.bin",
    ] {
        assert_problem(&rigid().gltf_with_buffer_uri(uri), "buffers[0].uri: ");
    }
}

#[test]
fn unused_buffer_file_need_not_exist() {
    let mut file = rigid();
    file.json["buffers"] =
        json!([{"byteLength": file.bin.len()}, {"byteLength": 9, "uri": "gone.bin"}]);
    assert_note(&file.glb(), "buffers[1]: is not opened");
}

#[test]
fn buffer_without_data_is_refused_only_on_use() {
    let mut file = File::new();
    file.json["buffers"] = json!([{"byteLength": 48}]);
    file.add("bufferViews", json!({"buffer": 0, "byteLength": 48}));
    file.add(
        "accessors",
        json!({"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}),
    );
    for bytes in [file.glb(), file.json.to_string().into_bytes()] {
        assert_note(&bytes, "buffers[0]: has no uri; nothing that is drawn or animated uses it");
    }
    file.add("meshes", json!({"primitives": [{"attributes": {"POSITION": 0}}]}));
    file.add("nodes", json!({"mesh": 0}));
    assert_problem(&file.glb(), "buffers[0]: has no uri, and the file has no BIN chunk for it");
    assert_problem(
        file.json.to_string().as_bytes(),
        "buffers[0]: has no uri; only the first buffer",
    );
}

#[test]
fn invalid_chunks_are_refused() {
    let json = padded(br#"{"asset":{"version":"2.0"}}"#.to_vec(), b' ');
    let bin = vec![0; 4];
    let (json, bin) = ((*b"JSON", json), (*b"BIN\0", bin));
    let other = (*b"WHAT", vec![1, 2, 3, 4]);
    loaded(&container(std::slice::from_ref(&json)));
    assert_note(&container(&[json.clone(), bin.clone()]), "chunk 1: holds data");
    assert_note(
        &container(&[json.clone(), bin.clone(), other.clone()]),
        "chunk 2: is of the unknown kind",
    );
    assert_problem(&container(std::slice::from_ref(&bin)), "chunk 0: is of kind");
    assert_problem(&container(&[json.clone(), json.clone()]), "chunk 1: is a second JSON");
    assert_problem(
        &container(&[json.clone(), bin.clone(), bin.clone()]),
        "chunk 2: is a second BIN",
    );
    assert_problem(&container(&[json.clone(), other, bin]), "chunk 2: is BIN");
    assert_problem(&container(&[(*b"JSON", b"{}   ".to_vec())]), "chunk 0: has 5 bytes");
    assert_problem(&container(&[(*b"JSON", vec![])]), "chunk 0: is empty");
    let good = container(&[json]);
    assert_problem(&good[..good.len() - 1], "header: says the file has");
    assert_note(&[&good[..], b"x"].concat(), "header: says the file has");
    let mut wrong = good.clone();
    wrong[4] = 1;
    assert_problem(&wrong, "header: says container version 1");
    wrong = good;
    wrong[12] = 0xFF;
    assert_problem(&wrong, "chunk 0: says it has 255 bytes");
}

#[test]
fn input_other_than_gltf_2_is_refused() {
    assert_problem(b"", "file: is empty");
    assert_problem(b"; FBX 7.4.0", "file: is not a glTF file");
    assert_problem(b"\xEF\xBB\xBF{}", "file: begins with a byte order mark");
    assert_problem(b"{", "file: is not valid JSON");
    assert_problem(b"{}", "asset: is missing");
    assert_problem(&b"{\"a\":".repeat(100_000), "file: is not valid JSON: recursion limit");
    let mut file = File::new();
    file.json["asset"]["version"] = "1.0".into();
    assert_problem(&file.gltf(), "asset.version: is \"1.0\"");
    file.json["asset"] = json!({"version": "2.1", "minVersion": "2.0"});
    loaded(&file.gltf());
    file.json["asset"]["minVersion"] = "3.0".into();
    assert_problem(&file.gltf(), "asset.minVersion: is \"3.0\"");
}

#[test]
fn all_problems_are_listed() {
    let mut file = skinned();
    file.json["nodes"][0]["mesh"] = 9.into();
    file.json["skins"][0]["joints"] = json!([1, 77]);
    file.json["animations"][0]["channels"][0]["target"]["node"] = "x".into();
    file.json["materials"] = json!([{"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1]}}]);
    assert_eq!(
        problems(&file.gltf()),
        [
            "materials[0].pbrMetallicRoughness.baseColorFactor: has 3 numbers; it must have 4",
            "nodes[0].mesh: refers to mesh 9, but the last one is mesh 0",
            "skins[0].joints[1]: refers to node 77, but the last one is node 2",
            "animations[0].channels[0].target.node: must be a whole number, but is a string",
        ]
    );
}

#[test]
fn empty_file_gives_a_single_joint_without_parts() {
    let imported = loaded(&File::new().gltf());
    assert_eq!(imported.character.skeleton.joint_count(), 1);
    assert!(imported.character.parts.is_empty());
    assert!(imported.notes[0].what.contains("nothing to animate or draw"));
}
