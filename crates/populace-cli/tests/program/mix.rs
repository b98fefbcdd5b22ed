//! `populace pose --slot ... --layer ...` against the oracle, on files of our own and on real ones.

use std::path::Path;

use populace::LayerMode;
use populace::character::Character;
use populace_testkit::oracle::{OracleBody, OracleLayer, OraclePose, OracleSlot, evaluate};
use serde_json::{Value, json};

use crate::post::{Folder, post};
use crate::{json_of, numbers, populace, refused};

/// How far a joint may be off, as part of the character's height: what stored rows may, for each of
/// the clips that add up.
const OFF: f64 = 2e-5;

/// A slot as it is typed, and for the oracle: clip, time, weight, layer.
type Slot<'a> = (&'a str, f32, f32, usize);
/// A layer as it is typed, and for the oracle: layer, mask, additive, weight.
type Layer<'a> = (usize, Option<&'a str>, bool, f32);

struct Mix<'a> {
    slots: Vec<Slot<'a>>,
    layers: Vec<Layer<'a>>,
}

fn quoted(name: &str) -> String {
    name.replace('\\', r"\\").replace(',', r"\,").replace('=', r"\=")
}

impl Mix<'_> {
    fn arguments(&self) -> Vec<String> {
        let mut all = Vec::new();
        for (clip, secs, weight, layer) in &self.slots {
            let slot = format!("clip={},time={secs},weight={weight},layer={layer}", quoted(clip));
            all.extend(["--slot".into(), slot]);
        }
        for (layer, mask, additive, weight) in &self.layers {
            let mask = mask.map_or(String::new(), |joint| format!(",mask={}", quoted(joint)));
            let additive = if *additive { ",additive" } else { "" };
            all.extend(["--layer".into(), format!("{layer}{mask}{additive},weight={weight}")]);
        }
        all
    }

    /// The document of the program on a device with a schedule, as in "opencl staged".
    fn run(&self, file: &str, way: &str) -> Value {
        let (device, schedule) = way.split_once(' ').expect("device and schedule");
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

/// 1 for each joint that a chain of parents leads from to the one named.
fn subtree(body: &OracleBody, root: &str) -> Vec<f64> {
    let hangs = |mut joint: usize| loop {
        if body.joints[joint].name == root {
            return 1.0;
        }
        match body.joints[joint].parent {
            Some(parent) => joint = parent,
            None => return 0.0,
        }
    };
    (0..body.joints.len()).map(hangs).collect()
}

fn load(file: &str) -> Character {
    populace_assets::load(file).expect("the file can be read").character
}

/// Holds each joint's matrix against the oracle.
fn assert_as_the_oracle_says(file: &str, mix: &Mix, way: &str) {
    let character = load(file);
    let body = OracleBody::from_character(&character);
    let wanted = mix.oracle(&character, &body);
    let document = mix.run(file, way);
    let joints = document["joints"].as_array().expect("joints");
    assert_eq!(joints.len(), body.joints.len());
    let height = f64::from(character.height_m());
    let allowed = OFF * mix.slots.len() as f64;
    for joint in joints {
        let name = joint["name"].as_str().expect("a name");
        let at = body.joints.iter().position(|j| j.name == name).expect("a joint of that name");
        let found = numbers(&joint["model_from_joint"]);
        let matrix = glam::DMat4::from(wanted.model_from_joint[at]).to_cols_array();
        for (element, (found, wanted)) in found.iter().zip(matrix).enumerate() {
            // Columns of directions have no unit: a point as far from the joint as a tenth of the
            // height is meant.
            let allowed = if element >= 12 {
                allowed * height
            } else {
                allowed * 10.0 * wanted.abs().max(1.0)
            };
            let off = (found - wanted).abs();
            assert!(
                off <= allowed,
                "{file} on {way}: {name}[{element}] is off by {off}, {allowed} allowed"
            );
        }
    }
}

const NATIVE: [&str; 2] = ["native staged", "native fused"];
const OPENCL: [&str; 3] = ["opencl staged", "opencl fused-wide", "opencl fused-grouped"];

/// A post whose second clip has a name full of what separates, and bends the lower joint; it moves
/// and scales the upper.
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
        // No slot at all: layers lie over the rest pose.
        Mix { slots: vec![], layers: vec![(1, Some("foot"), true, 0.5)] },
    ]
}

fn a_made_file_is_mixed_as_the_oracle_says(ways: &[&str]) {
    let folder = Folder::new();
    let file = awkward_post(&folder);
    for way in ways {
        mixes_of_the_post().iter().for_each(|mix| assert_as_the_oracle_says(&file, mix, way));
    }
}

#[test]
fn a_made_file_is_mixed_as_the_oracle_says_on_native() {
    a_made_file_is_mixed_as_the_oracle_says(&NATIVE);
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn a_made_file_is_mixed_as_the_oracle_says_on_opencl() {
    a_made_file_is_mixed_as_the_oracle_says(&OPENCL);
}

/// Eight slots in four layers of three characters.
fn real_files_are_mixed_as_the_oracle_says(ways: &[&str]) {
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
        ways.iter().for_each(|way| assert_as_the_oracle_says(&file, &mix, way));
    }
}

#[cfg_attr(no_test_data, ignore = "POPULACE_TEST_DATA does not name a folder of test data")]
#[test]
fn real_files_are_mixed_as_the_oracle_says_on_native() {
    real_files_are_mixed_as_the_oracle_says(&NATIVE);
}

#[cfg_attr(any(skip_opencl, no_test_data), ignore = "no test data, or POPULACE_SKIP names opencl")]
#[test]
fn real_files_are_mixed_as_the_oracle_says_on_opencl() {
    real_files_are_mixed_as_the_oracle_says(&OPENCL);
}

fn slots_change_nothing_by_their_order_nor_by_a_weight_of_0(ways: &[&str]) {
    let folder = Folder::new();
    let file = awkward_post(&folder);
    for way in ways {
        for mix in mixes_of_the_post() {
            let joints = |mix: &Mix| mix.run(&file, way)["joints"].clone();
            let plain = joints(&mix);
            let mut with_nothing = Mix { slots: mix.slots.clone(), layers: mix.layers.clone() };
            with_nothing.slots.insert(0, ("Bend", 1.5, 0.0, 0));
            with_nothing.slots.push(("Bend", 1.1, 0.0, 1));
            assert_eq!(joints(&with_nothing), plain, "{way}: bit for bit");
            let backwards =
                Mix { slots: mix.slots.iter().rev().copied().collect(), layers: mix.layers };
            let turned = joints(&backwards);
            for (a, b) in
                plain.as_array().expect("joints").iter().zip(turned.as_array().expect("joints"))
            {
                let (a, b) = (numbers(&a["model_from_joint"]), numbers(&b["model_from_joint"]));
                assert!(
                    a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-6),
                    "{way}: {a:?} is not {b:?}"
                );
            }
        }
    }
}

#[test]
fn slots_change_nothing_by_their_order_nor_by_a_weight_of_0_on_native() {
    slots_change_nothing_by_their_order_nor_by_a_weight_of_0(&NATIVE);
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn slots_change_nothing_by_their_order_nor_by_a_weight_of_0_on_opencl() {
    slots_change_nothing_by_their_order_nor_by_a_weight_of_0(&OPENCL);
}

#[test]
fn the_document_tells_what_is_mixed() {
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
    // --clip and --time are a slot of weight 1.
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
    assert!(text.starts_with("\"Bend\" at 0.7 s by 0.5 in layer 1 on native"), "{text}");
}

/// A file whose clip "Bow" bends the joint "head" and so many others.
fn lender(folder: &Folder, others: usize) -> String {
    let mut file = post();
    let names = (0..others).map(|nth| format!("tail {nth}"));
    for (node, name) in (3..).zip(names) {
        file["nodes"].as_array_mut().expect("nodes").push(json!({"name": name}));
        file["scenes"][0]["nodes"].as_array_mut().expect("nodes").push(json!(node));
        file["skins"][0]["joints"].as_array_mut().expect("joints").push(json!(node));
        let channel = json!({"sampler": 0, "target": {"node": node, "path": "rotation"}});
        file["animations"][0]["channels"].as_array_mut().expect("channels").push(channel);
    }
    // Which would need a matrix for each joint.
    file["skins"][0].as_object_mut().expect("a skin").remove("inverseBindMatrices");
    file["animations"][0]["name"] = json!("Bow");
    let name = format!("lender {others}.gltf");
    std::fs::write(folder.path(&name), file.to_string()).expect("written");
    folder.text(&name)
}

#[test]
fn clips_that_share_few_names_are_refused_and_fewer_than_most_warned_of() {
    let folder = Folder::new();
    let file = folder.text("post.gltf");
    let pose = |lender: &str, slot: &str| {
        let args =
            ["pose", &file, "--clips", lender, "--slot", slot, "--json", "--device", "native"];
        let output = populace(&args);
        let document: Value = serde_json::from_slice(&output.stdout).unwrap_or_default();
        let talk = String::from_utf8(output.stderr).expect("text");
        (output.status.code(), document["slots"][0]["binding"]["share"].clone(), talk)
    };
    let stray = lender(&folder, 3);
    let (code, _, talk) = pose(&stray, "clip=Bow,time=1");
    assert!(code == Some(1) && talk.contains("the names of 1 of the 4 joints"), "{code:?} {talk}");
    let (code, share, talk) = pose(&stray, "clip=Bow,time=1,partial");
    assert!(
        code == Some(0) && share == 0.25 && talk.contains("1 of the 4 joints"),
        "{code:?} {share} {talk}"
    );
    let (code, share, talk) = pose(&lender(&folder, 1), "clip=Bow,time=1");
    assert!(
        code == Some(0) && share == 0.5 && talk.contains("fits \"post\" badly"),
        "{code:?} {share} {talk}"
    );
    let (code, share, talk) = pose(&lender(&folder, 0), "clip=Bow,time=1");
    assert!(
        code == Some(0) && share == 1.0 && !talk.contains("warning"),
        "{code:?} {share} {talk}"
    );
}

#[test]
fn mixes_that_make_no_sense_are_exit_code_2() {
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
    bad(&["--layer", "0,mask=head"], &["layer 0 lies over the rest pose"]);
    bad(&["--layer", "2", "--layer", "2,mask=head"], &["layer 2 is set twice"]);
    bad(&["--slot", "clip=Bend"].repeat(9), &["there are 9 slots; a member has at most 8"]);
}
