//! Tests of refused arguments, inputs and outputs, with their messages and exit codes.

use std::path::Path;

use serde_json::json;

use crate::post::{Folder, post};
use crate::refused;

#[test]
fn wrong_usage_exits_with_2() {
    let folder = Folder::new();
    let file = folder.text("post.gltf");
    refused(&["pose", &file, "--clip", "Bned"], 2, &["no clip \"Bned\"", "did you mean \"Bend\"?"]);
    refused(&["pose", &file, "--clip", "7"], 2, &["there is no clip 7"]);
    refused(
        &["pose", &file, "--device", "cuda"],
        2,
        &["there is no device \"cuda\"", "native, opencl"],
    );
    refused(&["pose", &file, "--time", "NaN"], 2, &["finite"]);
    refused(
        &["pose", &file, "--vertices", "--vertex", "0,0,99"],
        2,
        &["no vertex 99 of primitive 0 of node 0"],
    );
    refused(&["pose", &file, "--schedule", "magic"], 2, &["staged"]);
    refused(&["render", &file, "--members", "0", "--out", "x.png"], 2, &["--members"]);
    refused(&["render", &file, "--size", "640", "--out", "x.png"], 2, &["1280x720"]);
    let noon = ["render", &file, "--sky", "noon", "--out", "x.png"];
    refused(&noon, 2, &["--sky", "\"noon\" is none of day, evening, overcast and studio"]);
    let out = folder.text("x.png");
    let hide = |name| ["render", &file, "--hide", name, "--out", &out];
    refused(&hide("mehs"), 2, &["no node \"mehs\"", "did you mean \"mesh\"?"]);
    refused(&hide("xyz"), 2, &["no node \"xyz\"", "known are \"mesh\""]);
    refused(&["render", &file, "--clip", "xyz", "--out", &out], 2, &["known are \"Bend\""]);
    refused(&["pose", &file, "--clip", "xyz"], 2, &["known are \"Bend\""]);
    refused(&["pose", &file, "--reach", "xyz=1,2,3"], 2, &["known are \"foot\", \"head\""]);
    refused(&["pose", &file, "--layer", "1,mask=xyz"], 2, &["known are \"foot\", \"head\""]);
    refused(&[], 2, &["Usage"]);
}

/// Options that change nothing are refused, not ignored.
#[test]
fn options_without_meaning_are_refused() {
    let folder = Folder::new();
    let [rows, scene, out] = ["rows.csv", "scene.toml", "x.png"].map(|name| folder.text(name));
    std::fs::write(&rows, "id,t,x,y\n1,0,0,0\n1,1,1,0\n").expect("a file");
    std::fs::write(&scene, "schema = 1\n").expect("a file");
    for flag in [&["--clip", "Walk"][..], &["--root-motion"]] {
        for (input, words) in [(&rows, "for a recording"), (&scene, "for a scene")] {
            let args = [&["render", input, "--out", &out], flag].concat();
            refused(&args, 2, &["have no meaning", words]);
        }
    }
    refused(&["demo", "--clip", "Walk"], 2, &["have no meaning for a scene"]);
    let walls = ["render", "@man", "--walls", "2", "--out", &out];
    refused(&walls, 2, &["--walls needs a trajectory file"]);
    let both = ["render", &rows, &scene, "--out", &out];
    refused(&both, 2, &["is a scene", "a recording; give one of them"]);
    let twice = ["render", &scene, &scene, "--out", &out];
    refused(&twice, 2, &["are both scene files"]);
    let written = ["demo", "--write-scene", &scene, "--out", &out];
    refused(&written, 2, &["--write-scene", "--out"]);
}

/// A pipe would be waited for.
#[cfg(unix)]
#[test]
fn pipes_are_no_scenes_and_no_cameras() {
    let folder = Folder::new();
    let [pipe, out] = ["pipe.toml", "x.png"].map(|name| folder.text(name));
    let made = std::process::Command::new("mkfifo").arg(&pipe).status().expect("mkfifo");
    assert!(made.success());
    refused(&["render", &pipe, "--out", &out], 1, &["pipe.toml", "not a regular file"]);
    let camera = ["render", "@man", "--camera", &pipe, "--out", &out];
    refused(&camera, 2, &["pipe.toml", "not a regular file"]);
}

/// A value that looks like another flag gets the message of its own flag.
#[test]
fn negative_values_are_refused_by_their_own_flag() {
    let drawn = [
        ("--members", "-3", "1..=10000000"),
        ("--frames", "-3", "1..=1000000"),
        ("--fps", "-3", "from 0.001 to 1000"),
        ("--height", "-1.8", "metres from 0.001"),
        ("--seed", "-1", "invalid digit"),
        ("--size", "-640x360", "1280x720"),
        ("--device", "-1", "no device \"-1\""),
        ("--schedule", "-1", "no schedule \"-1\""),
    ];
    for (flag, value, words) in drawn {
        refused(&["render", "@child", flag, value, "--out", "x.png"], 2, &[flag, value, words]);
        refused(&["demo", flag, value], 2, &[flag, value, words]);
    }
    let folder = Folder::new();
    let file = folder.text("post.gltf");
    let posed = [
        (&["--clip", "-1"][..], "no clip \"-1\""),
        (&["--vertices", "--vertex", "-1,0,0"], "5,0,17"),
        (&["--layer", "-1"], "no layer -1"),
    ];
    for (args, words) in posed {
        refused(&[&["pose", &file], args].concat(), 2, &[words]);
    }
    for (flag, value, words) in [
        ("--members", "-3,5", "1..=10000000"),
        ("--joints", "-3", "1..=10000"),
        ("--slots", "-3", "1..=8"),
        ("--frames", "-3", "1..=10000"),
        ("--changing", "-1", "above 0"),
    ] {
        refused(&["bench", flag, value], 2, &[flag, words]);
    }
}

#[test]
fn invalid_devices_and_splits_exit_with_2() {
    let folder = Folder::new();
    let file = folder.text("post.gltf");
    let several = |names: &str, split: &str, words: &str| {
        refused(&["pose", &file, "--device", names, "--split", split], 2, &[words]);
    };
    several("native+", "measured", "there is no device \"\"");
    several("native+native", "measured", "native is named twice");
    several("opencl:0:3/2", "measured", "there is no device \"opencl:0:3/2\"");
    several("native:0", "measured", "native:2 takes two threads");
    several(
        "native:1+native:2",
        "60",
        "has one share for 2 devices, native:1+native:2; give each device one",
    );
    several("native:1+native:2", "60,-40", "a share of -40");
    several("native:1+native:2", "0,0", "no share above 0");
    several("native:1+native:2", "sixty,forty", "as in 60,40, or measured");
    several("native", "60,40", "has 2 shares for one device, native");
    let bench =
        ["bench", "--members", "9", "--frames", "1", "--device", "native", "--split", "60,40"];
    refused(&bench, 2, &["join them by +"]);
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn unsupported_device_part_is_refused() {
    let folder = Folder::new();
    let file = folder.text("post.gltf");
    refused(
        &["pose", &file, "--device", "opencl:0:1/999"],
        2,
        &["cannot be cut into 999 equal parts"],
    );
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn missing_opencl_device_is_refused() {
    let folder = Folder::new();
    refused(
        &["pose", &folder.text("post.gltf"), "--device", "opencl:99"],
        2,
        &["no OpenCL device 99"],
    );
}

#[test]
fn rejected_input_exits_with_1_and_names_every_problem() {
    let folder = Folder::new();
    refused(&["inspect", &folder.text("nothing.glb")], 1, &["nothing.glb"]);
    std::fs::write(folder.path("junk.glb"), b"junk").expect("written");
    refused(&["inspect", &folder.text("junk.glb")], 1, &["junk.glb"]);
    let mut broken = post();
    broken["skins"][0]["joints"] = json!([1, 99]);
    broken["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(77);
    broken["animations"][0]["channels"][0]["sampler"] = json!(5);
    std::fs::write(folder.path("broken.gltf"), broken.to_string()).expect("written");
    let places = [
        "skins[0].joints[1]",
        "meshes[0].primitives[0].attributes.POSITION",
        "animations[0].channels[0].sampler",
    ];
    for command in ["inspect", "pose"] {
        refused(&[command, &folder.text("broken.gltf")], 1, &places);
    }
    assert!(Path::new(&folder.text("broken.gltf")).exists());
}

#[test]
fn invalid_outputs_are_refused_and_links_are_kept() {
    let folder = Folder::new();
    refused(&["render", "@child", "--out", &folder.text("x.jpg")], 2, &["does not end in .png"]);
    let unnumbered = ["x does not end in .png"];
    refused(&["render", "@child", "--frames", "2", "--out", &folder.text("x")], 2, &unnumbered);
    refused(&["render", "@child", "--out", &folder.text("no/x.png")], 4, &["does not exist"]);
    refused(&["render", "@child", "--fps", "20", "--out", &folder.text("x.png")], 2, &["--frames"]);
    #[cfg(unix)]
    {
        let link = folder.path("link.png");
        std::os::unix::fs::symlink(folder.path("nowhere.png"), &link).expect("a link");
        refused(&["render", "@nobody", "--out", &folder.text("link.png")], 2, &["nobody"]);
        assert!(link.symlink_metadata().expect("the link").is_symlink());
    }
}

#[cfg(target_os = "linux")]
#[test]
fn full_stderr_does_not_change_the_exit_code() {
    let folder = Folder::new();
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").expect("/dev/full");
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_populace"));
    command.args(["pose", &folder.text("post.gltf"), "--clip", "nothing"]).stderr(full);
    assert_eq!(command.status().expect("the program starts").code(), Some(2));
}

#[test]
fn unknown_built_in_person_is_refused_with_the_known_names() {
    let folder = Folder::new();
    refused(
        &["render", "@nobody", "--out", &folder.text("x.png")],
        2,
        &["no built-in \"@nobody\"", "\"@child\""],
    );
}

#[test]
fn unwritable_output_exits_with_4() {
    let folder = Folder::new();
    let out = folder.text("no/such/folder/x.png");
    refused(&["render", &folder.text("post.gltf"), "--out", &out], 4, &["cannot write", "x.png"]);
}
