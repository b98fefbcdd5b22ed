//! Small mutations of the seeds of the fuzz target. None of them may panic or hang.

use populace_assets::load_from_slice;

use super::builder::{File, rigid, skinned};
use super::loaded;

#[path = "../../../../fuzz/seeds.rs"]
mod fuzz_seeds;

fn seeds() -> [File; 2] {
    let mut sparse = skinned();
    let indices = sparse.view(&[0, 2]);
    let values = sparse.view(&[0; 24]);
    sparse.json["accessors"][0]["sparse"] = serde_json::json!({
        "count": 2,
        "indices": {"bufferView": indices, "componentType": 5121},
        "values": {"bufferView": values}
    });
    [rigid(), sparse]
}

#[test]
fn seeds_load_and_can_be_written() {
    for (index, file) in seeds().into_iter().enumerate() {
        for (kind, bytes) in [("glb", file.glb()), ("gltf", file.gltf())] {
            assert!(!loaded(&bytes).character.parts.is_empty());
            fuzz_seeds::write("gltf", &format!("{index}.{kind}"), &bytes);
        }
    }
}

/// Loads a file. If it is refused, the error must have a problem with a location.
fn survives(file: &[u8]) {
    if let Err(error) = load_from_slice(file, None) {
        assert!(error.to_string().contains(": "), "{error}");
    }
}

#[test]
fn every_truncation_is_refused() {
    for file in seeds() {
        for bytes in [file.glb(), file.gltf()] {
            for length in 0..bytes.len() {
                assert!(
                    load_from_slice(&bytes[..length], None).is_err(),
                    "{length} of {} bytes load",
                    bytes.len()
                );
            }
        }
    }
}

#[test]
fn changing_any_byte_does_not_panic() {
    for file in seeds() {
        let bytes = file.glb();
        for at in 0..bytes.len() {
            let old = bytes[at];
            for new in [old ^ 1, old ^ 0x80, 0, 0xFF, b'9', old.wrapping_add(1)] {
                let mut changed = bytes.clone();
                changed[at] = new;
                survives(&changed);
            }
        }
    }
}

#[test]
fn replacing_any_digit_in_the_json_does_not_panic() {
    for file in seeds() {
        let text = file.json.to_string();
        let digits: Vec<_> =
            text.match_indices(|c: char| c.is_ascii_digit()).map(|(at, _)| at).collect();
        for at in digits {
            for new in [
                "-1",
                "1e300",
                "18446744073709551615",
                "4294967296",
                "0.5",
                "\"x\"",
                "null",
                "[]",
                "{}",
            ] {
                let changed = format!("{}{new}{}", &text[..at], &text[at + 1..]);
                let Ok(json) = serde_json::from_str(&changed) else {
                    continue;
                };
                survives(&File { json, bin: file.bin.clone() }.glb());
            }
        }
    }
}

#[test]
fn removing_any_property_does_not_panic() {
    for file in seeds() {
        let mut paths = Vec::new();
        collect(&file.json, &mut Vec::new(), &mut paths);
        assert!(paths.len() > 50);
        for path in paths {
            let mut changed = file.clone();
            let (last, parents) = path.split_last().unwrap();
            let parent =
                parents.iter().fold(&mut changed.json, |value, key| match key.parse::<usize>() {
                    Ok(index) if value.is_array() => &mut value[index],
                    _ => &mut value[key],
                });
            if let Some(object) = parent.as_object_mut() {
                object.remove(last);
            } else if let (Some(array), Ok(index)) = (parent.as_array_mut(), last.parse::<usize>())
            {
                array.remove(index);
            }
            survives(&changed.glb());
        }
    }
}

fn collect(value: &serde_json::Value, path: &mut Vec<String>, paths: &mut Vec<Vec<String>>) {
    let children: Vec<(String, &serde_json::Value)> = match value {
        serde_json::Value::Object(map) => map.iter().map(|(k, v)| (k.clone(), v)).collect(),
        serde_json::Value::Array(items) => {
            items.iter().enumerate().map(|(i, v)| (i.to_string(), v)).collect()
        }
        _ => return,
    };
    for (key, child) in children {
        path.push(key);
        paths.push(path.clone());
        collect(child, path, paths);
        path.pop();
    }
}
