//! `populace pose --look-at ... --reach ...` on real characters, and what it refuses.

use std::collections::HashMap;
use std::path::Path;

use glam::{DMat4, DVec3};

use crate::post::Folder;
use crate::{json_of, numbers, refused};

const WAYS: [&str; 5] =
    ["native staged", "native fused", "opencl staged", "opencl fused-wide", "opencl fused-grouped"];

/// Model transforms by joint.
fn models(file: &str, way: &str, args: &[&str]) -> HashMap<String, DMat4> {
    let (device, schedule) = way.split_once(' ').expect("device and schedule");
    let d = json_of(
        &[&["pose", file, "--json", "--device", device, "--schedule", schedule], args].concat(),
    );
    let joints = d["joints"].as_array().expect("joints");
    let matrix = |m: &serde_json::Value| DMat4::from_cols_slice(&numbers(m));
    let named = joints
        .iter()
        .map(|j| (j["name"].as_str().expect("a name").into(), matrix(&j["model_from_joint"])));
    named.collect()
}

fn place(models: &HashMap<String, DMat4>, joint: &str) -> DVec3 {
    models[joint].w_axis.truncate()
}

/// Where a joint that faces +Z at rest faces now.
fn facing(rest: &DMat4, now: &DMat4) -> DVec3 {
    now.transform_vector3(rest.inverse().transform_vector3(DVec3::Z)).normalize()
}

/// A file, its clip, its head, its hand with elbow and shoulder, and its height.
const BODIES: [(&str, &str, [&str; 4], f64); 3] = [
    ("kaykit_knight", "Walking_A", ["head", "upperarm.r", "lowerarm.r", "hand.r"], 2.4),
    ("m2m_human_base", "0", ["DEF-head", "DEF-upper_arm.L", "DEF-forearm.L", "DEF-hand.L"], 1.8),
    ("quaternius_robot", "0", ["Head", "UpperArm.R", "LowerArm.R", "Palm1.R"], 4.6),
];

#[cfg_attr(
    any(no_test_data, skip_opencl),
    ignore = "no POPULACE_TEST_DATA, or POPULACE_SKIP names opencl"
)]
#[test]
fn real_characters_look_and_reach_where_they_are_told() {
    let data = std::env::var("POPULACE_TEST_DATA").expect("the folder of test data");
    for (name, clip, [head, upper, lower, hand], height) in BODIES {
        let file = Path::new(&data).join(format!("characters/{name}.glb"));
        let file = file.to_str().expect("a path of letters");
        let rest = models(file, "native fused", &[]);
        let playing = ["--clip", clip, "--time", "0.4"];
        let free = models(file, "native fused", &playing);
        let bones = place(&free, upper).distance(place(&free, lower))
            + place(&free, lower).distance(place(&free, hand));
        for (n, way) in (0..).zip(WAYS) {
            let turn = 0.3 * f64::from(n) - 0.6;
            let target =
                place(&free, head) + DVec3::new(turn.sin(), 0.2 * turn, turn.cos()) * height;
            let reach = place(&free, upper)
                + DVec3::new(0.3, 0.2 * turn, 0.9).normalize()
                    * (0.45 + 0.08 * f64::from(n))
                    * bones;
            let [look, reach_arg] = [target, reach].map(|p| format!("{},{},{}", p.x, p.y, p.z));
            let reach_arg = format!("{hand}={reach_arg}");
            let args = [&playing[..], &["--look-at", &look, "--reach", &reach_arg]].concat();
            let now = models(file, way, &args);
            let wanted = (target - place(&now, head)).normalize();
            let off = facing(&rest[head], &now[head]).angle_between(wanted).to_degrees();
            assert!(off < 0.1, "{name}, {way}: {off} degrees beside the target");
            // The trunk's turn has moved the shoulder, and the hand reaches from where it is now.
            let missed = place(&now, hand).distance(reach) / height * 1800.0;
            assert!(
                missed < 1.0,
                "{name}, {way}: the hand misses by {missed} mm of a body of 1.8 m"
            );
        }
    }
}

#[test]
fn what_cannot_be_looked_at_or_reached_for_is_refused() {
    let folder = Folder::new();
    let file = folder.text("post.gltf");
    refused(&["pose", &file, "--look-at", "1,2"], 2, &["three numbers of metres"]);
    refused(&["pose", &file, "--look-at", "1,2,NaN"], 2, &["three numbers of metres"]);
    refused(&["pose", &file, "--reach", "head"], 2, &["JOINT=X,Y,Z"]);
    refused(
        &["pose", &file, "--reach", "hed=1,2,3"],
        2,
        &["no joint \"hed\"", "did you mean \"head\""],
    );
    refused(&["pose", &file, "--reach", "head=1,2,3"], 2, &["limb of two bones"]);
}
