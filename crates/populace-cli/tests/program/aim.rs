//! Tests of `populace pose --look-at ... --reach ...` on real characters, and of refused arguments.

use std::collections::HashMap;
use std::path::Path;

use glam::{DMat4, DVec3};

use crate::post::Folder;
use crate::{json_of, numbers, refused};

/// Devices with schedules.
const CONFIGURATIONS: [&str; 5] =
    ["native staged", "native fused", "opencl staged", "opencl fused-wide", "opencl fused-grouped"];

/// Returns model transforms by joint.
fn models(file: &str, configuration: &str, args: &[&str]) -> HashMap<String, DMat4> {
    let (device, schedule) = configuration.split_once(' ').expect("device and schedule");
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

fn position(models: &HashMap<String, DMat4>, joint: &str) -> DVec3 {
    models[joint].w_axis.truncate()
}

/// Returns the current direction of a joint that faces +Z at rest.
fn facing(rest: &DMat4, now: &DMat4) -> DVec3 {
    now.transform_vector3(rest.inverse().transform_vector3(DVec3::Z)).normalize()
}

/// File, clip, joints (head, shoulder, elbow, hand) and height.
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
fn real_characters_look_and_reach_at_their_targets() {
    let data = std::env::var("POPULACE_TEST_DATA").expect("the folder of test data");
    for (name, clip, [head, upper, lower, hand], height) in BODIES {
        let file = Path::new(&data).join(format!("characters/{name}.glb"));
        let file = file.to_str().expect("a path of letters");
        let rest = models(file, "native fused", &[]);
        let playing = ["--clip", clip, "--time", "0.4"];
        let free = models(file, "native fused", &playing);
        let bones = position(&free, upper).distance(position(&free, lower))
            + position(&free, lower).distance(position(&free, hand));
        for (n, configuration) in (0..).zip(CONFIGURATIONS) {
            let angle = 0.3 * f64::from(n) - 0.6;
            let target =
                position(&free, head) + DVec3::new(angle.sin(), 0.2 * angle, angle.cos()) * height;
            let reach = position(&free, upper)
                + DVec3::new(0.3, 0.2 * angle, 0.9).normalize()
                    * (0.45 + 0.08 * f64::from(n))
                    * bones;
            let [look, reach_arg] = [target, reach].map(|p| format!("{},{},{}", p.x, p.y, p.z));
            let reach_arg = format!("{hand}={reach_arg}");
            let args = [&playing[..], &["--look-at", &look, "--reach", &reach_arg]].concat();
            let now = models(file, configuration, &args);
            let wanted = (target - position(&now, head)).normalize();
            let off = facing(&rest[head], &now[head]).angle_between(wanted).to_degrees();
            assert!(off < 0.1, "{name}, {configuration}: {off} degrees off the target");
            // The rotation of the trunk has moved the shoulder. The hand reaches from there.
            let missed = position(&now, hand).distance(reach) / height * 1800.0;
            assert!(
                missed < 1.0,
                "{name}, {configuration}: the hand misses by {missed} mm of a body of 1.8 m"
            );
        }
    }
}

#[test]
fn invalid_targets_are_refused() {
    let folder = Folder::new();
    let file = folder.text("post.gltf");
    refused(&["pose", &file, "--look-at", "1,2"], 2, &["write X,Y,Z in metres"]);
    refused(&["pose", &file, "--look-at", "1,2,NaN"], 2, &["write X,Y,Z in metres"]);
    refused(&["pose", &file, "--reach", "head"], 2, &["JOINT=X,Y,Z"]);
    refused(
        &["pose", &file, "--reach", "hed=1,2,3"],
        2,
        &["no joint \"hed\"", "did you mean \"head\""],
    );
    refused(&["pose", &file, "--reach", "head=1,2,3"], 2, &["limb of two bones"]);
}
