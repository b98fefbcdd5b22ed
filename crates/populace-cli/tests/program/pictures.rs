//! Comparison of pictures with references drawn by Mesa's software driver. `POPULACE_UPDATE=name`
//! rewrites a reference.

use std::path::Path;

use populace_testkit::image::{Folders, Limits, assert_picture};

use crate::populace;
use crate::post::Folder;

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
