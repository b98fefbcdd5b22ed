//! Small files that would need much memory or time: memory is estimated before allocation, work is
//! limited in proportion to the file size, and numbers are bounded.

use std::fmt::Write;

use populace_assets::{LoadOptions, load_from_slice_with};
use serde_json::json;

use super::builder::{F32, File, rigid, skinned};
use super::{assert_note, assert_problem, loaded, problems};

/// Returns the problems of a file under a memory limit in bytes.
fn problems_within(file: &[u8], memory_limit_bytes: u64) -> Vec<String> {
    let options = LoadOptions { memory_limit_bytes, ..LoadOptions::default() };
    match load_from_slice_with(file, None, &options) {
        Ok(_) => Vec::new(),
        Err(populace_assets::Error::Rejected { problems, .. }) => {
            problems.iter().map(ToString::to_string).collect()
        }
        Err(other) => panic!("{other}"),
    }
}

/// Writes a chain of `count` nodes that are all joints, followed by the JSON text `more`.
fn chain(count: usize, more: &str) -> Vec<u8> {
    let mut text = String::from(r#"{"asset":{"version":"2.0"},"nodes":["#);
    for child in 1..count {
        write!(text, r#"{{"children":[{child}]}},"#).expect("writing to a string succeeds");
    }
    write!(text, r#"{{}}],"skins":[{{"joints":[{}]}}]{more}}}"#, count - 1)
        .expect("writing to a string succeeds");
    text.into_bytes()
}

#[test]
fn every_kind_of_memory_counts_towards_the_limit() {
    let file = skinned();
    assert!(problems_within(&file.gltf(), 1 << 20).is_empty());
    let refused = |file: &[u8], limit: u64, place: &str, what: &str| {
        let found = problems_within(file, limit);
        let named =
            |p: &String| p.starts_with(place) && p.contains(what) && p.contains("--memory-limit");
        assert!(found.iter().any(named), "not `{place}` `{what}`: {found:#?}");
    };
    refused(&file.gltf(), 100, "file: needs", "for its JSON");
    let mut long = rigid();
    long.bin.resize(4 << 20, 0);
    refused(&long.gltf(), 2 << 20, "buffers[0].uri: needs 5 MiB", "for the data of its URI");
    let mut many = rigid();
    many.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    many.json["accessors"][0]["count"] = (1 << 20).into();
    refused(&many.glb(), 8 << 20, "accessors[0]: needs 12 MiB", "for its data");
    refused(&chain(10_000, ""), 8 << 20, "nodes: needs", "for 10000 nodes");
    let mut keys = File::new();
    let times: Vec<f32> = (0..2000).map(|t| t as f32).collect();
    let (input, output) = (keys.floats("SCALAR", &times), keys.floats("VEC3", &times.repeat(3)));
    for _ in 0..100 {
        keys.add("nodes", json!({}));
    }
    keys.add("skins", json!({"joints": (0..100).collect::<Vec<_>>()}));
    let channel = json!({"sampler": 0, "target": {"node": 0, "path": "translation"}});
    keys.add(
        "animations",
        json!({"samplers": [{"input": input, "output": output}], "channels": [channel]}),
    );
    refused(
        &keys.glb(),
        8 << 20,
        "animations[0]: needs",
        "for rows of 100 joints at 2000 key times",
    );
}

#[test]
fn huge_image_is_refused_by_its_header() {
    // The header of a PNG of 16,384 x 16,384 pixels of one bit with its checksum, and the start of
    // the data.
    let start = b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR\0\0\x40\0\0\0\x40\0\x01\0\0\0\0\
                  \x81\xb3\x2d\x29\0\0\0\x04IDAT";
    let mut file = rigid();
    let view = file.view(start);
    for image in 0..2 {
        file.add("images", json!({"bufferView": view, "mimeType": "image/png"}));
        file.add("textures", json!({"source": image}));
        file.add(
            "materials",
            json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": image}}}),
        );
    }
    let found = problems(&file.glb());
    assert_eq!(found.len(), 2, "{found:?}");
    for (image, problem) in found.iter().enumerate() {
        let words = format!("images[{image}]: needs 1281 MiB for an image of 16384 x 16384 pixels");
        assert!(
            problem.starts_with(&words) && problem.contains("the memory limit is 1024 MiB"),
            "{problem}"
        );
    }
}

#[test]
fn chain_of_100_000_nodes_loads_and_too_many_nodes_are_refused() {
    let skeleton = &loaded(&chain(100_000, "")).character.skeleton;
    assert_eq!((skeleton.joint_count(), skeleton.levels().len()), (100_000, 100_000));
    assert_problem(
        &chain((1 << 17) + 1, ""),
        "nodes: has 131073 nodes; at most 131072 are supported",
    );
}

/// Each of these files is small, but the product of two of its counts would take minutes and
/// gigabytes.
#[test]
fn large_products_of_counts_are_refused() {
    let animations =
        format!(r#","animations":[{}{{}}]"#, r#"{"channels":[],"samplers":[]},"#.repeat(20_000));
    let found = problems(&chain(20_000, &animations));
    assert!(found.len() == 1 && found[0].contains("out of proportion to the size"), "{found:?}");

    let mut named = rigid();
    named.json["nodes"][0]["name"] = "x".repeat(60_000).into();
    let primitive = named.primitive().clone();
    named.json["meshes"][0]["primitives"] = vec![primitive; 20_000].into();
    let found = problems(&named.glb());
    assert!(found.len() == 1 && found[0].contains("out of proportion"), "{found:?}");
}

#[test]
fn row_count_of_incompressible_curves_is_limited_by_file_size() {
    let (joints, keys) = (300, 700);
    let mut file = File::new();
    let times: Vec<f32> = (0..keys).map(|t| t as f32).collect();
    let wild = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0].repeat(keys);
    let (input, output) = (file.floats("SCALAR", &times), file.floats("VEC3", &wild));
    let channel =
        |node: usize| json!({"sampler": 0, "target": {"node": node, "path": "translation"}});
    for _ in 0..joints {
        file.add("nodes", json!({}));
    }
    let sampler = json!({"input": input, "output": output, "interpolation": "CUBICSPLINE"});
    let channels: Vec<_> = (0..joints).map(channel).collect();
    file.add("animations", json!({"samplers": [sampler], "channels": channels}));
    let bytes = file.glb();
    let clip = loaded(&bytes).character.clips[0].stats();
    // The pose limit for this file size, and 16 rows of a gap that is being subdivided.
    let most = ((1 << 18) + 2 * bytes.len()) / joints + 16;
    assert!(clip.row_count >= keys && clip.row_count < most, "{} rows of {most}", clip.row_count);
}

#[test]
fn number_magnitudes_are_limited() {
    for (key, value) in [
        ("translation", json!([0, 1.1e9, 0])),
        ("scale", json!([1e38, 1, 1])),
        ("matrix", json!([1e38, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])),
    ] {
        let mut file = rigid();
        file.json["nodes"][0][key] = value;
        assert_problem(&file.glb(), &format!("nodes[0].{key}["));
        assert!(problems(&file.glb())[0].contains("must be at most 1e9"), "{key}");
    }
    // Positions, bind matrices, key times and values.
    for (accessor, what) in [(0, "POSITION"), (6, "bind"), (7, "times"), (8, "values")] {
        let mut file = skinned();
        let view = file.json["accessors"][accessor]["bufferView"].as_u64().unwrap();
        let view = &file.json["bufferViews"][usize::try_from(view).unwrap()];
        let at = usize::try_from(view["byteOffset"].as_u64().unwrap()).unwrap();
        assert_eq!(file.json["accessors"][accessor]["componentType"], F32);
        file.bin[at..at + 4].copy_from_slice(&(-1e38_f32).to_le_bytes());
        assert_problem(&file.glb(), &format!("accessors[{accessor}]: holds -1e38 in element 0"));
        assert!(problems(&file.glb())[0].contains("magnitude of at most 1e9"), "{what}");
    }
}

#[test]
fn products_along_node_chains_are_limited() {
    let chain = |links: usize, key: &str, value: [f32; 3]| {
        let mut file = skinned();
        for child in 3..links + 3 {
            file.add("nodes", json!({key: value, "children": [child + 1]}));
        }
        file.add("nodes", json!({}));
        file.json["nodes"][2]["children"] = json!([3]);
        file
    };
    assert_eq!(loaded(&chain(2, "scale", [1e9; 3]).glb()).character.skeleton.joint_count(), 5);
    let words = "nodes[5]: can be scaled by 1.0e27 and be";
    assert_problem(&chain(4, "scale", [1e9, 1.0, 1.0]).glb(), words);
    let mut far = chain(2, "scale", [1e9; 3]);
    far.json["nodes"][5] = json!({"translation": [0, 2, 0]});
    assert_problem(&far.glb(), "nodes[5]: can be scaled by 1.0e18 and be 2.0e18 m away");
    // Keys count too, as does the overshoot of tangents between them.
    let mut keyed = chain(2, "scale", [1e9; 3]);
    let input = keyed.floats("SCALAR", &[0.0, 1000.0]);
    let output = keyed
        .floats("VEC3", &[[0.0; 3], [1.0; 3], [1.0; 3], [-1.0; 3], [1.0; 3], [0.0; 3]].concat());
    let sampler = json!({"input": input, "output": output, "interpolation": "CUBICSPLINE"});
    let target = json!({"node": 5, "path": "scale"});
    keyed.add(
        "animations",
        json!({"samplers": [sampler], "channels": [{"sampler": 0, "target": target}]}),
    );
    assert_problem(&keyed.glb(), "nodes[5]: can be scaled by 3.0e20");
    // Each chain is reported once.
    let long = chain(7, "scale", [1e9; 3]);
    assert_eq!(problems(&long.glb()).len(), 1);
}

#[test]
fn one_vertex_far_away_makes_no_rows_and_is_noted() {
    let with_vertex_at = |x: f32| {
        let mut file = skinned();
        let positions = file.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, x, 1.0, 0.0]);
        file.primitive()["attributes"]["POSITION"] = positions.into();
        file.glb()
    };
    let rows = |x: f32| loaded(&with_vertex_at(x)).character.clips[0].row_count();
    assert!(loaded(&with_vertex_at(2.0)).notes.is_empty());
    assert_eq!([rows(1e6), rows(1e9)], [rows(100.0); 2]);
    let begins =
        "nodes[0].mesh: reaches 750000.0 m from joint \"head\" with vertex 2 of primitive 0;";
    assert_note(&with_vertex_at(1e6), begins);
}
