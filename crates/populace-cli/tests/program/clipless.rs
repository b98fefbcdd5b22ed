//! Tests of characters without clips, and of the clips of built-in people.

use serde_json::{Value, json};

use crate::post::{Folder, post};
use crate::{json_of, numbers, populace};

/// Joints of a humanoid with VRM names, their parents and local translations.
const HUMANOID: [(&str, Option<usize>, [f64; 3]); 19] = [
    ("hips", None, [0.0, 0.9, 0.0]),
    ("spine", Some(0), [0.0, 0.15, 0.0]),
    ("chest", Some(1), [0.0, 0.2, 0.0]),
    ("neck", Some(2), [0.0, 0.2, 0.0]),
    ("head", Some(3), [0.0, 0.1, 0.0]),
    ("leftUpperArm", Some(2), [0.18, 0.12, 0.0]),
    ("leftLowerArm", Some(5), [0.27, 0.0, 0.0]),
    ("leftHand", Some(6), [0.25, 0.0, 0.0]),
    ("rightUpperArm", Some(2), [-0.18, 0.12, 0.0]),
    ("rightLowerArm", Some(8), [-0.27, 0.0, 0.0]),
    ("rightHand", Some(9), [-0.25, 0.0, 0.0]),
    ("leftUpperLeg", Some(0), [0.1, -0.05, 0.0]),
    ("leftLowerLeg", Some(11), [0.0, -0.4, 0.0]),
    ("leftFoot", Some(12), [0.0, -0.4, 0.0]),
    ("leftToes", Some(13), [0.0, -0.04, 0.12]),
    ("rightUpperLeg", Some(0), [-0.1, -0.05, 0.0]),
    ("rightLowerLeg", Some(15), [0.0, -0.4, 0.0]),
    ("rightFoot", Some(16), [0.0, -0.4, 0.0]),
    ("rightToes", Some(17), [0.0, -0.04, 0.12]),
];

/// A humanoid without clips, with the post's mesh on its arms.
pub(crate) fn humanoid() -> Value {
    let mut file = post();
    let children = |of: usize| {
        let children =
            HUMANOID.iter().enumerate().filter(move |(_, (_, parent, _))| *parent == Some(of));
        children.map(|(index, _)| index).collect::<Vec<_>>()
    };
    let node = |(index, (name, _, at)): (usize, &(&str, Option<usize>, [f64; 3]))| {
        let mut node = json!({"name": name, "translation": at});
        if !children(index).is_empty() {
            node["children"] = json!(children(index));
        }
        if name.contains("Arm") {
            node["mesh"] = json!(0);
        }
        node
    };
    file["nodes"] = HUMANOID.iter().enumerate().map(node).collect();
    file["scenes"] = json!([{"nodes": [0]}]);
    file["skins"] = json!([{"joints": (0..HUMANOID.len()).collect::<Vec<_>>()}]);
    let attributes = json!({"POSITION": 0});
    file["meshes"][0]["primitives"][0]["attributes"] = attributes;
    file.as_object_mut().expect("an object").remove("animations");
    file
}

fn write(folder: &Folder, name: &str, file: &Value) -> String {
    std::fs::write(folder.path(name), file.to_string()).expect("written");
    folder.text(name)
}

const SMALL: [&str; 8] =
    ["--members", "2", "--size", "64x64", "--device", "native", "--frames", "2"];

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn humanoid_without_clips_plays_those_of_the_built_in_people() {
    let folder = Folder::new();
    let file = write(&folder, "golem.gltf", &humanoid());
    let out = folder.text("golem.png");
    let output = populace(&[&["render", &file, "--out", &out], &SMALL[..]].concat());
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    let words = "\"golem\" has no clips; it plays Idle and Walk of the built-in people, retargeted";
    assert!(stderr.contains(words), "{stderr}");
    let frame =
        |index: u32| std::fs::read(folder.path(&format!("golem_000{index}.png"))).expect("a frame");
    assert!(frame(0) != frame(1), "the frames must differ");
    // The same clips, added explicitly.
    let added =
        populace(&[&["render", &file, "--clips", "@people", "--out", &out], &SMALL[..]].concat());
    assert!(!String::from_utf8_lossy(&added.stderr).contains("no clips"), "clips were added");
    assert!(added.status.success() && frame(0) != frame(1));
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn non_humanoid_without_clips_gets_a_warning() {
    let folder = Folder::new();
    let mut still = post();
    still.as_object_mut().expect("an object").remove("animations");
    let file = write(&folder, "still.gltf", &still);
    let output =
        populace(&[&["render", &file, "--out", &folder.text("x.png")], &SMALL[..]].concat());
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    assert!(
        stderr.contains("warning: \"still\" has no clips") && stderr.contains("--clips FILE"),
        "{stderr}"
    );
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn added_clips_that_fit_nobody_are_named() {
    let folder = Folder::new();
    let file = write(&folder, "post.gltf", &post());
    let out = folder.text("x.png");
    let stderr = |inputs: &[&str]| {
        let args = [&["render", "--clips", "@people", "--out", &out], inputs, &SMALL[..]].concat();
        let output = populace(&args);
        assert!(output.status.success(), "{output:?}");
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let words = "warning: no clip of @people fits any of the characters: ";
    let alone = stderr(&[&file]);
    assert!(alone.contains(words), "{alone}");
    let among_people = stderr(&[&file, "@man"]);
    assert!(!among_people.contains(words), "{among_people}");
}

#[test]
fn pose_plays_clips_of_built_in_people() {
    let folder = Folder::new();
    let file = write(&folder, "golem.gltf", &humanoid());
    let knee = |args: &[&str]| {
        let d = json_of(&[&["pose", &file, "--json", "--device", "native"], args].concat());
        let knee =
            d["joints"].as_array().expect("joints").iter().find(|j| j["name"] == "leftLowerLeg");
        numbers(&knee.expect("a knee")["model_from_joint"])
    };
    let rest = knee(&[]);
    for source in ["@people", "@child"] {
        let walking = knee(&["--clips", source, "--clip", "Walk", "--time", "0.3"]);
        assert!(walking.iter().zip(&rest).any(|(a, b)| (a - b).abs() > 0.05), "{walking:?}");
    }
}
