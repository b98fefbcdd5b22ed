//! Tests of the program's interface: exit codes, JSON documents, pictures and error messages.

mod aim;
mod bench;
mod casts;
mod clipless;
mod documents;
mod drivers;
mod films;
mod gaits;
mod input;
mod levels;
mod mix;
mod outputs;
mod pictures;
mod plan;
mod post;
mod recordings;
mod scenes;
#[cfg(unix)]
mod signals;
mod skate;
mod trajectories;
mod usage;

use std::process::{Command, Output};

use serde_json::{Value, json};

use post::Folder;

fn populace(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_populace")).args(args).output().expect("the program starts")
}

fn json_of(args: &[&str]) -> Value {
    let output = populace(args);
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("stdout is one JSON document")
}

#[track_caller]
fn refused(args: &[&str], code: i32, words: &[&str]) {
    let output = populace(args);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{args:?}: {stderr}");
    assert!(output.stdout.is_empty(), "a failing run must not print results");
    for word in words {
        assert!(stderr.contains(word), "{args:?}: no {word:?} in: {stderr}");
    }
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("an array").iter().map(|v| v.as_f64().expect("a number")).collect()
}

#[track_caller]
fn assert_near(found: &[f64], wanted: &[f64]) {
    let near =
        found.len() == wanted.len() && found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-4);
    assert!(near, "{found:?} differs from {wanted:?}");
}

fn check_pose(device: &str) {
    let folder = Folder::new();
    let file = folder.text("post.gltf");
    let args = [
        "pose",
        &file,
        "--clip",
        "Bend",
        "--time",
        "1.5",
        "--vertices",
        "--vertex",
        "0,0,7",
        "--json",
    ];
    let d = json_of(&[&args[..], &["--device", device]].concat());
    assert_eq!(
        (&d["schema"], &d["clip"], &d["schedule"]),
        (&json!(1), &json!("Bend"), &json!("fused"))
    );
    assert_eq!(d["joints"][0]["name"], "foot");
    assert_eq!((&d["joints"][0]["node"], &d["joints"][0]["parent"]), (&json!(1), &Value::Null));
    assert_eq!((&d["joints"][1]["node"], &d["joints"][1]["parent"]), (&json!(2), &json!(0)));
    // The head joint is 1 m high and rotated by 90 degrees about -Z. Matrices are column-major.
    let head = numbers(&d["joints"][1]["model_from_joint"]);
    assert_near(
        &head,
        &[0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 1.0],
    );
    assert_eq!((&d["skins"][0]["skin"], &d["skins"][0]["node"]), (&json!(0), &json!(0)));
    let palette = numbers(&d["skins"][0]["palette"][1]);
    assert_near(&palette, &[0.0, 1.0, 0.0, -1.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
    // At rest, vertex 7 is at (0.2, 2, 0): 1 m above the joint and 0.2 m beside it.
    assert_near(&numbers(&d["vertices"][0]), &[0.0, 0.0, 7.0, 1.0, 0.8, 0.0]);

    let at = |time: &str, clip: &[&str]| {
        let common = [
            "pose",
            &file,
            "--time",
            time,
            "--vertices",
            "--vertex",
            "0,0,6",
            "--json",
            "--device",
            device,
        ];
        numbers(&json_of(&[&common[..], clip].concat())["vertices"][0])[3..].to_vec()
    };
    assert_eq!(
        json_of(&["pose", &file, "--time", "0.3", "--json", "--device", device])["time"],
        0.3
    );
    assert_near(&at("-7", &["--clip", "Bend"]), &[-0.2, 2.0, 0.0]); // before the first key
    assert_near(&at("99", &["--clip", "0"]), &[1.0, 1.2, 0.0]); // after the last key, clip by index
    assert_near(&at("1.5", &[]), &[-0.2, 2.0, 0.0]); // no clip: rest pose
    let half = std::f64::consts::FRAC_1_SQRT_2;
    // Half way of a slerp.
    assert_near(&at("1.0", &["--clip", "Bend"]), &[half * 0.8, 1.0 + half * 1.2, 0.0]);
}

#[test]
fn pose_is_correct_on_native() {
    check_pose("native");
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn pose_is_correct_on_opencl() {
    check_pose("opencl");
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn pose_is_correct_on_several_devices() {
    check_pose("native:1+opencl:0");
    check_pose("opencl:0:1/2+opencl:0:2/2");
    let folder = Folder::new();
    let args = [
        "pose",
        &folder.text("post.gltf"),
        "--json",
        "--device",
        "opencl+native",
        "--split",
        "0,1",
    ];
    assert_eq!(json_of(&args)["device"], "opencl:0+native");
}

#[test]
fn inspect_describes_a_file() {
    let folder = Folder::new();
    let file = folder.text("post.gltf");
    let d = json_of(&["inspect", &file, "--json"]);
    assert_eq!(
        (&d["joints"], &d["depth"], &d["palette_entries"]),
        (&json!(2), &json!(2), &json!(2))
    );
    assert_eq!(d["parts"][0]["triangles"], 4);
    let clip = &d["clips"][0];
    assert_eq!(
        (&clip["name"], &clip["start_secs"], &clip["duration_secs"]),
        (&json!("Bend"), &json!(0.5), &json!(1.0))
    );
    assert!(
        clip["rows"].as_u64() > Some(2),
        "a rotation by 90 degrees between two keys needs rows between them"
    );
    assert!(clip["worst_error_m"].as_f64() <= clip["tolerance_m"].as_f64());
    let text = String::from_utf8(populace(&["inspect", &file]).stdout).expect("text");
    assert!(text.contains("clip 0 \"Bend\": 1.000 s from 0.500 s"), "{text}");
}

#[test]
fn built_in_people_stand_for_files() {
    let d = json_of(&["inspect", "@man", "--json"]);
    assert!(d["joints"].as_u64() > Some(40), "{d}");
    json_of(&["pose", "@woman", "--json", "--device", "native"]);
    let clips: Vec<_> =
        d["clips"].as_array().expect("clips").iter().map(|clip| &clip["name"]).collect();
    assert!(["Idle", "Idle_Look", "Walk", "Run"].iter().all(|name| clips.contains(&&json!(name))));
    let walking = ["--clip", "Walk", "--time", "0.3", "--json", "--device", "native"];
    let [own, added] = [&[][..], &["--clips", "@man"]]
        .map(|more| json_of(&[&["pose", "@man"], &walking[..], more].concat()));
    assert_eq!(own["joints"], added["joints"]);
    refused(&["inspect", "@people"], 2, &["@people are several", "@man"]);
    refused(&["pose", "@nobody"], 2, &["no built-in \"@nobody\"", "@woman"]);
}

#[test]
fn inspect_rows_sums_clip_sizes() {
    let folder = Folder::new();
    let file = folder.text("post.gltf");
    let d = json_of(&["inspect", &file, "--json"]);
    let both = json_of(&["inspect", "--rows", &file, &file, "--json"]);
    for field in ["rows", "row_bytes", "key_bytes"] {
        assert_eq!(
            (&both["files"][1][field], both["files"][0]["clips"].as_u64()),
            (&d["clips"][0][field], Some(1))
        );
    }
    let (rows, bytes) = (d["clips"][0]["rows"].as_u64(), d["clips"][0]["row_bytes"].as_u64());
    let (rows, bytes) = (rows.expect("rows"), bytes.expect("bytes"));
    let text =
        String::from_utf8(populace(&["inspect", "--rows", &file, &file]).stdout).expect("text");
    assert!(text.contains(&format!("| post.gltf | 2 | 1 | {rows} | {bytes} |")), "{text}");
    assert!(text.contains(&format!("| all |  | 2 | {} | {} |", 2 * rows, 2 * bytes)), "{text}");
    refused(&["inspect", &file, &file, "--json"], 2, &["one file", "--rows"]);
}

#[test]
fn devices_lists_native_and_opengl() {
    let d = json_of(&["devices", "--json"]);
    assert_eq!(d["devices"][0]["device"], "native");
    assert!(d["drawing"].is_object());
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn devices_reports_the_palette_transport_with_reasons() {
    let d = json_of(&["devices", "--json"]);
    let palettes = &d["devices"][0]["palettes"];
    assert_eq!(
        (&palettes["way"], &palettes["refused"][0]["way"]),
        (&json!("mapped"), &json!("shared"))
    );
    assert_eq!(palettes["refused"][0]["reason"], "it needs an OpenCL device");
    let text = String::from_utf8(populace(&["devices"]).stdout).expect("text");
    let words =
        "palettes written straight into OpenGL's memory (not shared between OpenCL and OpenGL: ";
    assert!(text.contains(words), "{text}");
}

#[cfg_attr(any(skip_gl, skip_opencl), ignore = "POPULACE_SKIP names gl or opencl")]
#[test]
fn render_is_identical_on_every_device_and_on_repeat() {
    let folder = Folder::new();
    let file = folder.text("post.gltf");
    let draw = |name: &str, device: &str, seed: &str| {
        let out = folder.text(name);
        let args =
            ["render", &file, "--members", "30", "--size", "160x90", "--out", &out, "--seed", seed];
        let args = [&args[..], &["--device"], &device.split(' ').collect::<Vec<_>>()].concat();
        let output = populace(&args);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{stderr}");
        if device.contains("60,40") {
            assert!(
                stderr.contains("30 members on opencl:0 (60 %) + native (40 %), fused\n"),
                "{stderr}"
            );
        }
        assert_eq!(
            String::from_utf8_lossy(&output.stdout),
            format!("{out}\n"),
            "only the path goes to stdout"
        );
        std::fs::read(out).expect("a picture")
    };
    let native = draw("native.png", "native", "1");
    assert!(native == draw("again.png", "native", "1"), "the same seed gives the same bytes");
    assert!(
        native == draw("opencl.png", "opencl", "1"),
        "PoCL gives the same bytes as the native device"
    );
    assert!(
        native == draw("both.png", "opencl:0+native --split 60,40", "1"),
        "two devices that share the crowd give the same bytes"
    );
    assert!(
        native == draw("halves.png", "opencl:0:1/2+opencl:0:2/2", "1"),
        "two parts of a device give the same bytes"
    );
    assert!(native != draw("other.png", "native", "2"), "another seed gives another crowd");
    let picture = image::load_from_memory(&native).expect("a PNG").to_rgb8();
    assert_eq!(picture.dimensions(), (160, 90));
    let red = picture.pixels().filter(|p| p.0[0] > 100 && p.0[1] < 70 && p.0[2] < 70).count();
    assert!(red > 100, "only {red} pixels are as red as the posts");
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn demo_draws_people_without_files() {
    let folder = Folder::new();
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_populace"))
        .args(["demo", "--members", "12", "--size", "64x36", "--device", "native"])
        // A display would open a window.
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .current_dir(folder.path(""))
        .output()
        .expect("the program starts");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    let lines = [
        "12 people on native, fused",
        "drawn by ",
        "palettes written straight into OpenGL's memory",
    ];
    lines
        .iter()
        .for_each(|line| assert!(stderr.contains(&format!("populace: {line}")), "{stderr}"));
    assert!(stderr.contains("1 frame: ") && stderr.contains(" to animate, "), "{stderr}");
    assert!(stderr.lines().all(|line| line.len() <= 100), "{stderr}");
    assert_eq!(output.stdout, b"populace-demo.png\n");
    let picture = image::open(folder.path("populace-demo.png")).expect("a PNG");
    assert_eq!((picture.width(), picture.height()), (64, 36));
}

/// Before the picture, members of each character are posed one by one, so palette pages were longer
/// before than they are in the picture.
#[cfg_attr(any(skip_gl, skip_opencl), ignore = "POPULACE_SKIP names gl or opencl")]
#[test]
fn render_draws_all_people_on_opencl() {
    let folder = Folder::new();
    let out = folder.text("people.png");
    let size = ["--members", "12", "--size", "64x36", "--device", "opencl:0"];
    let output = populace(&[&["render", "@people", "--out", &out][..], &size].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn frames_are_numbered_and_differ() {
    let folder = Folder::new();
    let out = folder.text("film.png");
    let args = [
        "render",
        "@child",
        "--members",
        "2",
        "--clip",
        "Walk",
        "--frames",
        "3",
        "--size",
        "64x64",
        "--out",
        &out,
    ];
    let output = populace(&[&args[..], &["--device", "native"]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let frames: Vec<_> = (0..3)
        .map(|i| std::fs::read(folder.path(&format!("film_000{i}.png"))).expect("a frame"))
        .collect();
    assert!(frames[0] != frames[1] && frames[1] != frames[2]);
    assert!(!folder.path("film_0003.png").exists());
}

#[test]
fn bench_measures_shared_devices_as_one() {
    let both = ["--device", "native", "--device", "native:1+native:2", "--split", "1,3", "--json"];
    let output = populace(&[&["bench", "--members", "40", "--frames", "2"], &both[..]].concat());
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    assert!(stderr.contains("final shares: native:1 (25 %) + native:2 (75 %) (fused)"), "{stderr}");
    let d: Value = serde_json::from_slice(&output.stdout).expect("stdout is one JSON document");
    for device in ["native", "native:1+native:2"] {
        for (schedule, stage) in
            [("staged", "all"), ("fused", "all"), ("floor", "all"), ("staged", "pose")]
        {
            let wanted = |r: &&Value| {
                r["device"] == device && r["schedule"] == schedule && r["stage"] == stage
            };
            let run = d["runs"].as_array().expect("runs").iter().find(wanted);
            assert!(run.is_some(), "{device} {schedule} {stage}");
        }
    }
}
