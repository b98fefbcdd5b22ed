//! Comparison of pictures with references drawn by Mesa's software driver. `POPULACE_UPDATE=name`
//! rewrites a reference.

use std::path::Path;

use populace_testkit::image::{Folders, Limits, assert_picture};

use crate::post::Folder;
use crate::{json_of, populace};

/// Runs the program and compares the picture with `tests/program/references/name.png`.
fn assert_unchanged(name: &str, limits: Limits, args: &[&str]) {
    let folder = Folder::new();
    let (file, out) = (folder.text("post.gltf"), folder.text("out.png"));
    let args: Vec<&str> =
        args.iter().map(|a| if *a == "POST" { file.as_str() } else { a }).collect();
    let output = populace(&[&args[..], &["--out", &out, "--device", "native"]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let picture = image::open(&out).expect("a PNG").to_rgba8();
    let references = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/program/references");
    let folders =
        Folders { references: &references, failures: Path::new(env!("CARGO_TARGET_TMPDIR")) };
    assert_picture(name, picture.width(), picture.height(), picture.as_raw(), limits, folders);
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn many_posts() {
    let args = ["render", "POST", "--members", "60", "--size", "240x135"];
    assert_unchanged("posts", Limits::surfaces(), &args);
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn skies() {
    for sky in ["evening", "overcast", "studio"] {
        let size = ["--size", "160x90", "--camera", "0,1.6,4,0,0.9,0"];
        let args = [&["render", "@people", "--members", "4", "--sky", sky], &size[..]].concat();
        assert_unchanged(&format!("sky_{sky}"), Limits::surfaces(), &args);
    }
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn close_camera() {
    let args = ["render", "POST", "--members", "3", "--size", "160x160", "--camera", "close"];
    assert_unchanged("post_close", Limits::surfaces(), &args);
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn demo() {
    assert_unchanged("demo", Limits::surfaces(), &["demo", "--members", "40", "--size", "240x135"]);
}

/// A scene of the repository with fewer people, at the time and in the light that it says.
fn assert_scene_unchanged(name: &str, text: &str, fewer: &[(&str, &str)], camera: &str) {
    let folder = Folder::new();
    let scene = folder.text("scene.toml");
    let mut text = text.to_owned();
    for (many, few) in fewer {
        assert!(text.contains(many), "{name} has no {many}");
        text = text.replace(many, few);
    }
    std::fs::write(&scene, text).expect("a file");
    let camera = format!("--camera={camera}");
    let args = ["render", &scene, "--size", "192x108", &camera];
    assert_unchanged(name, Limits::surfaces(), &args);
}

/// The wave has reached the first seats: some cheer, some rise, some sit.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn stand() {
    let text = include_str!("../../../../scenes/stand.toml");
    let fewer = [("count = 10000", "count = 300"), ("lead_in_s = 22", "lead_in_s = 21")];
    assert_scene_unchanged("stand", text, &fewer, "-59,5,2.5,-65,2.2,-4");
}

/// Two lines fight: shields are up, and spears thrust beside them.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn battle() {
    let text = include_str!("../../../../scenes/battle.toml");
    let fewer = [("count = 5000", "count = 48"), ("rank = 250", "rank = 12")];
    assert_scene_unchanged("battle", text, &fewer, "-5.5,2.4,-0.3,3,0.9,0");
}

/// The camera is in the car, before the face of who drives.
#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn eyes_of_a_driver() {
    let text = r#"schema = 1
cast = [{ name = "people", from = ["@man"], varied = false }]
crowd = [{ cast = "people", count = 1, does.stroll.drive = 120 }]
footway = [{ name = "walk", points = [[-20, 6], [60, 6]], width_m = 2 }]
lane = [{ name = "lane", ends = [[-20, 1.6], [60, 1.6]], vehicles = 1, speed = 0.1 }]
"#;
    assert_scene_unchanged("driver", text, &[], "eye:0");
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn built_in_people() {
    let args = [
        "render",
        "@people",
        "--members",
        "8",
        "--size",
        "240x135",
        "--clip",
        "Walk",
        "--seed",
        "3",
    ];
    assert_unchanged("people", Limits::surfaces(), &args);
}

/// A crowd around the camera: some stand at the edges of the picture, and most behind it.
const AMONG: [&str; 10] = [
    "render",
    "@people",
    "--members",
    "120",
    "--size",
    "240x135",
    "--seed",
    "5",
    "--camera",
    "0,1.7,-6,0,1.0,-12",
];

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn members_at_the_edges_of_the_view() {
    assert_unchanged("edges", Limits::surfaces(), &[&AMONG[..], &["--detail", "0"]].concat());
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn nobody_misses_those_who_are_hidden() {
    let folder = Folder::new();
    let picture = |name: &str, detail: &[&str]| {
        let out = folder.text(name);
        // Shadows of the sun are thrown by the levels that characters have.
        let more = ["--sky", "overcast", "--json", "--device", "native", "--out", &out];
        let document = json_of(&[&AMONG[..], detail, &more].concat());
        (image::open(&out).expect("a PNG").to_rgba8(), document)
    };
    let (culled, document) = picture("culled.png", &["--detail", "0"]);
    let (whole, _) = picture("whole.png", &["--full-detail"]);
    assert!(document["hidden"].as_u64() > Some(20), "{document}");
    assert!(culled == whole, "hidden members are missing in the picture");
}

/// Errors in pixels that show a man of 180 pixels at each of his levels.
const MAN_PX: [&str; 11] =
    ["0", "0.45", "0.8", "1.4", "2.4", "3.6", "5.6", "7.5", "10", "13", "18"];
/// The same for the coarser levels, from level 4 on, of a girl of 140 pixels in mid-stride. Her legs
/// must not show through her skirt.
const GIRL_PX: [&str; 9] = ["1.3", "1.9", "2.5", "3.3", "4.2", "5.6", "7.5", "10", "17"];

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn levels_of_detail() {
    let man =
        MAN_PX.into_iter().enumerate().map(|(level, px)| ("@man", &[][..], "level", level, px));
    let girl = GIRL_PX.into_iter().enumerate();
    let girl =
        girl.map(|(above, px)| ("@girl", &["--at", "0.25"][..], "skirt_level", 4 + above, px));
    for (person, at, name, level, error_px) in man.chain(girl) {
        let own = [
            "render",
            person,
            "--members",
            "1",
            "--size",
            "120x200",
            "--clip",
            "Walk",
            "--camera",
            "0.8,1.3,3.6,0,0.9,0",
            "--plain",
            "--detail",
            error_px,
        ];
        let args = [&own[..], at].concat();
        let folder = Folder::new();
        let out = folder.text("level.png");
        let document = json_of(&[&args[..], &["--json", "--out", &out]].concat());
        let levels = document["levels"].as_array().expect("numbers");
        assert_eq!(levels.len(), level + 1, "{person} {error_px}: {document}");
        assert_unchanged(&format!("{name}_{level}"), Limits::surfaces(), &args);
    }
}
