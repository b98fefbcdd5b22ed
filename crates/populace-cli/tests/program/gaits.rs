//! Gaits of clips in `populace inspect`.

use base64::Engine;
use serde_json::{Value, json};

use crate::post::Folder;
use crate::{json_of, numbers, populace};

/// Times of keys, and the height and place along Z of the left foot: it stands for 0.6 s, while it
/// moves back by 0.6 m, and swings for 0.4 s.
const LEFT: [(f32, [f32; 2]); 5] = [
    (0.0, [0.0, 0.3]),
    (0.6, [0.0, -0.3]),
    (0.61, [0.2, -0.3]),
    (0.99, [0.2, 0.3]),
    (1.0, [0.0, 0.3]),
];
/// The same of the right foot, half a second later.
const RIGHT: [(f32, [f32; 2]); 7] = [
    (0.0, [0.0, -0.2]),
    (0.1, [0.0, -0.3]),
    (0.11, [0.2, -0.3]),
    (0.49, [0.2, 0.3]),
    (0.5, [0.0, 0.3]),
    (0.75, [0.0, 0.05]),
    (1.0, [0.0, -0.2]),
];

/// Writes a pole with two feet, rigid triangles all, and a clip "Walk" in which the body walks at
/// 1 m/s: towards +Z, or the other way if `reversed`.
fn walker(folder: &Folder, name: &str, reversed: bool) -> String {
    let (mut bytes, mut views, mut accessors) = (Vec::new(), Vec::new(), Vec::new());
    let mut add = |values: &[f32], width: usize| {
        let (offset, length) = (bytes.len(), 4 * values.len());
        bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        views.push(json!({"buffer": 0, "byteOffset": offset, "byteLength": length}));
        let limit = |of: fn(f32, f32) -> f32| {
            let columns = (0..width).map(|column| values.iter().skip(column).step_by(width));
            columns.map(|column| column.copied().reduce(of)).collect::<Vec<_>>()
        };
        accessors.push(json!({
            "bufferView": views.len() - 1,
            "componentType": 5126,
            "count": values.len() / width,
            "type": if width == 1 { "SCALAR" } else { "VEC3" },
            "min": limit(f32::min),
            "max": limit(f32::max),
        }));
        accessors.len() - 1
    };
    let foot = add(&[0.0, 0.0, -0.1, -0.05, 0.0, 0.2, 0.05, 0.0, 0.2], 3);
    let pole = add(&[0.0, 0.5, 0.0, -0.1, 1.7, 0.0, 0.1, 1.7, 0.0], 3);
    let (mut samplers, mut channels) = (Vec::new(), Vec::new());
    for (node, x, keys) in [(1, 0.1, &LEFT[..]), (2, -0.1, &RIGHT[..])] {
        let input = add(&keys.iter().map(|(secs, _)| *secs).collect::<Vec<_>>(), 1);
        let place = |(_, [y, z]): &(f32, [f32; 2])| [x, *y, if reversed { -z } else { *z }];
        let places: Vec<f32> = keys.iter().flat_map(place).collect();
        let output = add(&places, 3);
        samplers.push(json!({"input": input, "output": output}));
        let target = json!({"node": node, "path": "translation"});
        channels.push(json!({"sampler": samplers.len() - 1, "target": target}));
    }
    let data = base64::engine::general_purpose::STANDARD.encode(&bytes);
    let uri = format!("data:application/octet-stream;base64,{data}");
    let mesh = |positions: usize| json!({"primitives": [{"attributes": {"POSITION": positions}}]});
    let file: Value = json!({
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [
            {"name": "pole", "mesh": 1, "children": [1, 2]},
            {"name": "one", "mesh": 0, "translation": [0.1, 0.0, 0.0]},
            {"name": "other", "mesh": 0, "translation": [-0.1, 0.0, 0.0]},
        ],
        "meshes": [mesh(foot), mesh(pole)],
        "animations": [{"name": "Walk", "samplers": samplers, "channels": channels}],
        "buffers": [{"byteLength": bytes.len(), "uri": uri}],
        "bufferViews": views,
        "accessors": accessors,
    });
    std::fs::write(folder.path(name), file.to_string()).expect("written");
    folder.text(name)
}

#[test]
fn inspect_tells_the_gait_of_a_clip() {
    let folder = Folder::new();
    let file = walker(&folder, "walker.gltf", false);
    let gait = &json_of(&["inspect", &file, "--json"])["clips"][0]["gait"];
    let near = |name: &str, wanted: f64| {
        let found = gait[name].as_f64().expect(name);
        assert!((found - wanted).abs() < 0.02, "{name}: {found} is not {wanted}");
    };
    near("speed_m_per_sec", 1.0);
    near("stride_m", 1.0);
    near("steps_per_min", 120.0);
    near("contact_share", 0.6);
    near("skate_m_per_sec", 0.0);
    assert!((numbers(&gait["velocity_m_per_sec"])[1] - 1.0).abs() < 0.02, "{gait}");
    let contacts = gait["contacts"].as_array().expect("contacts");
    let wanted = [("left", 0.0, 0.6), ("right", 0.5, 1.1)];
    assert_eq!(contacts.len(), wanted.len(), "{gait}");
    for (contact, (foot, from, until)) in contacts.iter().zip(wanted) {
        let secs = |name: &str| contact[name].as_f64().expect(name);
        let near = |found: f64, wanted: f64| (found - wanted).abs() < 0.02;
        assert!(
            contact["foot"] == foot
                && near(secs("from_secs"), from)
                && near(secs("until_secs"), until),
            "{contact} is not {foot} from {from} until {until}"
        );
    }
    let text = |file: &str| String::from_utf8(populace(&["inspect", file]).stdout).expect("text");
    let line = "gait: 1.00 m/s, stride 1.00 m, 120 steps/min, contact 60 %, skate 0.0";
    assert!(text(&file).contains(line), "{}", text(&file));
    let backwards = text(&walker(&folder, "backwards.gltf", true));
    assert!(backwards.contains("gait: 1.00 m/s backwards, stride"), "{backwards}");
}

#[test]
fn inspect_tells_no_gait_of_a_body_without_feet() {
    let folder = Folder::new();
    let file = folder.text("post.gltf");
    assert!(json_of(&["inspect", &file, "--json"])["clips"][0]["gait"].is_null());
    let text = String::from_utf8(populace(&["inspect", &file]).stdout).expect("text");
    assert!(!text.contains("gait"), "{text}");
}
