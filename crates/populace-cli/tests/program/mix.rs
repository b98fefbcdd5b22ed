//! Tests of `populace pose --slot ... --layer ...` against the oracle, on generated and real files.

use std::path::Path;

use populace::LayerMode;
use populace::character::Character;
use populace_testkit::oracle::{OracleBody, OracleLayer, OraclePose, OracleSlot, evaluate};
use serde_json::{Value, json};

use crate::post::{Folder, post};
use crate::{json_of, numbers, populace, refused};

/// The allowed error of stored rows per slot, in units of the character's height.
const TOLERANCE: f64 = 2e-5;

/// A slot: clip, time in seconds, weight, layer.
type Slot<'a> = (&'a str, f32, f32, usize);
/// A layer: index, mask, additive, weight.
type Layer<'a> = (usize, Option<&'a str>, bool, f32);

struct Mix<'a> {
    slots: Vec<Slot<'a>>,
    layers: Vec<Layer<'a>>,
}

fn escaped(name: &str) -> String {
    name.replace('\\', r"\\").replace(',', r"\,").replace('=', r"\=")
}

impl Mix<'_> {
    fn arguments(&self) -> Vec<String> {
        let mut all = Vec::new();
        for (clip, secs, weight, layer) in &self.slots {
            let slot = format!("clip={},time={secs},weight={weight},layer={layer}", escaped(clip));
            all.extend(["--slot".into(), slot]);
        }
        for (layer, mask, additive, weight) in &self.layers {
            let mask = mask.map_or(String::new(), |joint| format!(",mask={}", escaped(joint)));
            let additive = if *additive { ",additive" } else { "" };
            all.extend(["--layer".into(), format!("{layer}{mask}{additive},weight={weight}")]);
        }
        all
    }

    /// Returns the program's document for a device and schedule, such as "opencl staged".
    fn run(&self, file: &str, configuration: &str) -> Value {
        let (device, schedule) = configuration.split_once(' ').expect("device and schedule");
        let mut args = vec!["pose", file, "--json", "--device", device, "--schedule", schedule];
        let mixed = self.arguments();
        args.extend(mixed.iter().map(String::as_str));
        json_of(&args)
    }

    fn oracle(&self, character: &Character, body: &OracleBody) -> OraclePose {
        let clip = |name: &str| {
            let found = character.clips.iter().find(|clip| clip.name() == name);
            found.unwrap_or_else(|| panic!("no clip {name}")).source()
        };
        let slot = |(name, secs, weight, layer): &Slot| OracleSlot {
            retarget: None,
            clip: clip(name),
            time_secs: f64::from(*secs),
            weight: f64::from(*weight),
            layer: *layer,
        };
        let slots: Vec<_> = self.slots.iter().map(slot).collect();
        let mut layers = vec![OracleLayer::default(); 4];
        for (layer, mask, additive, weight) in &self.layers {
            let mode = if *additive { LayerMode::Additive } else { LayerMode::Override };
            let mask = mask.map(|root| subtree(body, root));
            layers[*layer] = OracleLayer { mode, weight: f64::from(*weight), mask };
        }
        evaluate(body, &slots, &layers)
    }
}

/// Returns 1 for the named joint and its descendants, 0 for other joints.
fn subtree(body: &OracleBody, root: &str) -> Vec<f64> {
    let weight = |mut joint: usize| loop {
        if body.joints[joint].name == root {
            return 1.0;
        }
        match body.joints[joint].parent {
            Some(parent) => joint = parent,
            None => return 0.0,
        }
    };
    (0..body.joints.len()).map(weight).collect()
}

fn load(file: &str) -> Character {
    populace_assets::load(file).expect("the file can be read").character
}

/// Compares each joint's matrix with the oracle's.
fn assert_matches_oracle(file: &str, mix: &Mix, configuration: &str) {
    let character = load(file);
    let body = OracleBody::from_character(&character);
    let wanted = mix.oracle(&character, &body);
    let document = mix.run(file, configuration);
    let joints = document["joints"].as_array().expect("joints");
    assert_eq!(joints.len(), body.joints.len());
    let height = f64::from(character.height_m());
    let allowed = TOLERANCE * mix.slots.len() as f64;
    for joint in joints {
        let name = joint["name"].as_str().expect("a name");
        let at = body.joints.iter().position(|j| j.name == name).expect("a joint of that name");
        let found = numbers(&joint["model_from_joint"]);
        let matrix = glam::DMat4::from(wanted.model_from_joint[at]).to_cols_array();
        for (element, (found, wanted)) in found.iter().zip(matrix).enumerate() {
            // For direction columns, the error of a point at a tenth of the height counts.
            let allowed = if element >= 12 {
                allowed * height
            } else {
                allowed * 10.0 * wanted.abs().max(1.0)
            };
            let off = (found - wanted).abs();
            assert!(
                off <= allowed,
                "{file} on {configuration}: {name}[{element}] is off by {off}, {allowed} is allowed"
            );
        }
    }
}

const NATIVE: [&str; 2] = ["native staged", "native fused"];
const OPENCL: [&str; 3] = ["opencl staged", "opencl fused-wide", "opencl fused-grouped"];

/// Adds a clip whose name contains separators to the post. It rotates the lower joint and
/// translates the upper.
fn awkward_post(folder: &Folder) -> String {
    let mut post = post();
    let rotation = json!({"input": 5, "output": 6});
    post["nodes"][2]["name"] = json!("he,ad=");
    post["accessors"].as_array_mut().expect("an array").push(json!({
        "bufferView": 0, "componentType": 5126, "count": 2, "type": "VEC3"
    }));
    let animations = post["animations"].as_array_mut().expect("an array");
    animations.push(json!({
        "name": r"a,b=c\d",
        "samplers": [rotation, {"input": 5, "output": 7}],
        "channels": [{"sampler": 0, "target": {"node": 1, "path": "rotation"}},
            {"sampler": 1, "target": {"node": 2, "path": "translation"}}]
    }));
    std::fs::write(folder.path("awkward.gltf"), post.to_string()).expect("written");
    folder.text("awkward.gltf")
}

fn mixes_of_the_post() -> [Mix<'static>; 4] {
    let odd = r"a,b=c\d";
    [
        Mix { slots: vec![("Bend", 1.0, 0.25, 0), (odd, 1.25, 0.5, 0)], layers: vec![] },
        Mix {
            slots: vec![(odd, 0.75, 1.0, 0), ("Bend", 1.5, 0.6, 1)],
            layers: vec![(1, Some("he,ad="), false, 0.7)],
        },
        Mix {
            slots: vec![("Bend", 0.8, 1.0, 0), (odd, 1.4, 0.9, 2), ("Bend", 1.2, 0.3, 2)],
            layers: vec![(2, None, true, 0.8), (3, Some("foot"), false, 1.0)],
        },
        // Without slots, layers are blended over the rest pose.
        Mix { slots: vec![], layers: vec![(1, Some("foot"), true, 0.5)] },
    ]
}

fn check_generated_file(configurations: &[&str]) {
    let folder = Folder::new();
    let file = awkward_post(&folder);
    for configuration in configurations {
        mixes_of_the_post().iter().for_each(|mix| assert_matches_oracle(&file, mix, configuration));
    }
}

#[test]
fn generated_file_matches_the_oracle_on_native() {
    check_generated_file(&NATIVE);
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn generated_file_matches_the_oracle_on_opencl() {
    check_generated_file(&OPENCL);
}

/// Checks eight slots in four layers on three characters.
fn check_real_files(configurations: &[&str]) {
    let folder = std::env::var("POPULACE_TEST_DATA").expect("ignored without it");
    let eight = |clips: [&'static str; 4], mask: &'static str, other: &'static str| Mix {
        slots: vec![
            (clips[0], 0.3, 0.7, 0),
            (clips[1], 0.21, 0.4, 0),
            (clips[2], 0.05, 1.0, 0),
            (clips[3], 0.4, 0.5, 1),
            (clips[0], 0.1, 0.25, 1),
            (clips[1], 0.33, 0.8, 2),
            (clips[2], 0.2, 0.3, 2),
            (clips[3], 0.15, 0.9, 3),
        ],
        layers: vec![
            (1, Some(mask), false, 0.9),
            (2, None, true, 0.35),
            (3, Some(other), false, 0.5),
        ],
    };
    let human = ["Walk_Loop", "Jog_Fwd_Loop", "Idle_Loop", "Punch_Jab"];
    let files = [
        ("characters/m2m_human_base.glb", eight(human, "DEF-spine.002", "DEF-upper_arm.L")),
        (
            "characters/kenney_platformer/character.glb",
            eight(["walk", "idle", "jump", "static"], "torso", "arm-left"),
        ),
        ("animals/fox.glb", eight(["Walk", "Run", "Survey", "Walk"], "b_Neck_04", "b_Tail01_012")),
    ];
    for (file, mix) in files {
        let file = Path::new(&folder).join(file).to_string_lossy().into_owned();
        configurations
            .iter()
            .for_each(|configuration| assert_matches_oracle(&file, &mix, configuration));
    }
}

#[cfg_attr(no_test_data, ignore = "POPULACE_TEST_DATA does not name a folder of test data")]
#[test]
fn real_files_match_the_oracle_on_native() {
    check_real_files(&NATIVE);
}

#[cfg_attr(any(skip_opencl, no_test_data), ignore = "no test data, or POPULACE_SKIP names opencl")]
#[test]
fn real_files_match_the_oracle_on_opencl() {
    check_real_files(&OPENCL);
}

fn check_order_and_zero_weights(configurations: &[&str]) {
    let folder = Folder::new();
    let file = awkward_post(&folder);
    for configuration in configurations {
        for mix in mixes_of_the_post() {
            let joints = |mix: &Mix| mix.run(&file, configuration)["joints"].clone();
            let plain = joints(&mix);
            let mut with_weightless = Mix { slots: mix.slots.clone(), layers: mix.layers.clone() };
            with_weightless.slots.insert(0, ("Bend", 1.5, 0.0, 0));
            with_weightless.slots.push(("Bend", 1.1, 0.0, 1));
            assert_eq!(
                joints(&with_weightless),
                plain,
                "{configuration}: must be equal bit for bit"
            );
            let backwards =
                Mix { slots: mix.slots.iter().rev().copied().collect(), layers: mix.layers };
            let reversed = joints(&backwards);
            for (a, b) in
                plain.as_array().expect("joints").iter().zip(reversed.as_array().expect("joints"))
            {
                let (a, b) = (numbers(&a["model_from_joint"]), numbers(&b["model_from_joint"]));
                assert!(
                    a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-6),
                    "{configuration}: {a:?} differs from {b:?}"
                );
            }
        }
    }
}

#[test]
fn slot_order_and_zero_weights_have_no_effect_on_native() {
    check_order_and_zero_weights(&NATIVE);
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn slot_order_and_zero_weights_have_no_effect_on_opencl() {
    check_order_and_zero_weights(&OPENCL);
}

#[test]
fn document_describes_slots_and_layers() {
    let folder = Folder::new();
    let file = folder.text("post.gltf");
    let pose =
        |args: &[&str]| json_of(&[&["pose", &file, "--json", "--device", "native"], args].concat());
    let mixed = pose(&[
        "--slot",
        "clip=0,time=0.7",
        "--slot",
        "clip=Bend,weight=0.3,layer=2",
        "--layer",
        "2,mask=head",
    ]);
    assert_eq!((&mixed["clip"], &mixed["time"]), (&Value::Null, &Value::Null));
    let binding = json!({"way": "same rest", "share": 1.0, "rest_turn_deg": 0.0});
    let slots = json!([{"clip": "Bend", "time": 0.7, "weight": 1.0, "layer": 0, "binding": binding},
        {"clip": "Bend", "time": 0.0, "weight": 0.3, "layer": 2, "binding": binding}]);
    assert_eq!(mixed["slots"], slots);
    assert_eq!(
        mixed["layers"],
        json!([{"layer": 2, "mask": "head", "additive": false, "weight": 1.0}])
    );
    // --clip and --time describe a slot of weight 1.
    let (alone, slot) =
        (pose(&["--clip", "Bend", "--time", "1.2"]), pose(&["--slot", "clip=Bend,time=1.2"]));
    assert_eq!((&alone["clip"], &alone["time"]), (&json!("Bend"), &json!(1.2)));
    assert_eq!((&alone["joints"], &alone["slots"]), (&slot["joints"], &slot["slots"]));
    let output = populace(&[
        "pose",
        &file,
        "--slot",
        "clip=0,time=0.7,weight=0.5,layer=1",
        "--device",
        "native",
    ]);
    let text = String::from_utf8(output.stdout).expect("text");
    assert!(text.starts_with("\"Bend\" at 0.7 s with weight 0.5 in layer 1 on native"), "{text}");
}

/// Writes a file whose clip "Bow" bends the joint "head" and `others` more joints.
fn clip_file(folder: &Folder, others: usize) -> String {
    let mut file = post();
    let names = (0..others).map(|nth| format!("tail {nth}"));
    for (node, name) in (3..).zip(names) {
        file["nodes"].as_array_mut().expect("nodes").push(json!({"name": name}));
        file["scenes"][0]["nodes"].as_array_mut().expect("nodes").push(json!(node));
        file["skins"][0]["joints"].as_array_mut().expect("joints").push(json!(node));
        let channel = json!({"sampler": 0, "target": {"node": node, "path": "rotation"}});
        file["animations"][0]["channels"].as_array_mut().expect("channels").push(channel);
    }
    // Inverse bind matrices would be needed for all joints.
    file["skins"][0].as_object_mut().expect("a skin").remove("inverseBindMatrices");
    file["animations"][0]["name"] = json!("Bow");
    let name = format!("clips {others}.gltf");
    std::fs::write(folder.path(&name), file.to_string()).expect("written");
    folder.text(&name)
}

#[test]
fn clips_with_few_common_names_are_refused_or_warned_about() {
    let folder = Folder::new();
    let file = folder.text("post.gltf");
    let pose = |clip_file: &str, slot: &str| {
        let args =
            ["pose", &file, "--clips", clip_file, "--slot", slot, "--json", "--device", "native"];
        let output = populace(&args);
        let document: Value = serde_json::from_slice(&output.stdout).unwrap_or_default();
        let stderr = String::from_utf8(output.stderr).expect("text");
        (output.status.code(), document["slots"][0]["binding"]["share"].clone(), stderr)
    };
    let foreign = clip_file(&folder, 3);
    let (code, _, stderr) = pose(&foreign, "clip=Bow,time=1");
    assert!(code == Some(1) && stderr.contains("only 1 of the 4 joints"), "{code:?} {stderr}");
    let (code, share, stderr) = pose(&foreign, "clip=Bow,time=1,partial");
    assert!(
        code == Some(0) && share == 0.25 && stderr.contains("1 of its 4 joints"),
        "{code:?} {share} {stderr}"
    );
    let (code, share, stderr) = pose(&clip_file(&folder, 1), "clip=Bow,time=1");
    assert!(
        code == Some(0) && share == 0.5 && stderr.contains("fits \"post\" badly"),
        "{code:?} {share} {stderr}"
    );
    let (code, share, stderr) = pose(&clip_file(&folder, 0), "clip=Bow,time=1");
    assert!(
        code == Some(0) && share == 1.0 && !stderr.contains("warning"),
        "{code:?} {share} {stderr}"
    );
}

#[test]
fn invalid_mixes_exit_with_2() {
    let folder = Folder::new();
    let file = folder.text("post.gltf");
    let bad = |args: &[&str], words: &[&str]| {
        refused(&[&["pose", &file, "--device", "native"], args].concat(), 2, words);
    };
    bad(&["--slot", "clip=Bned"], &["no clip \"Bned\"", "did you mean \"Bend\"?"]);
    bad(&["--slot", "clip=9"], &["there is no clip 9"]);
    bad(&["--slot", "clip=Bend,time=NaN"], &["time=NaN is not a number of seconds"]);
    bad(&["--slot", "clip=Bend,weight=7"], &["weight=7 is not a number from 0 to 1"]);
    bad(&["--slot", "clip=Bend", "--clip", "Bend"], &["cannot be used with"]);
    bad(&["--slot", "clip=Bend", "--time", "1"], &["cannot be used with"]);
    bad(&["--layer", "1,mask=haed"], &["there is no joint \"haed\"", "did you mean \"head\"?"]);
    bad(&["--layer", "0,mask=head"], &["layer 0 is mixed by its slots"]);
    bad(&["--layer", "2", "--layer", "2,mask=head"], &["layer 2 is set twice"]);
    bad(&["--slot", "clip=Bend"].repeat(9), &["9 slots are given; a member has at most 8"]);
}
