//! Pictures against references, drawn by Mesa's software driver. `POPULACE_UPDATE=name` writes one
//! anew.

use std::path::Path;

use populace_testkit::image::{Folders, Limits, assert_picture};

use crate::populace;
use crate::post::Folder;

/// Draws by the program and compares with `tests/program/references/name.png`.
fn drawn_as_ever(name: &str, limits: Limits, args: &[&str]) {
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
fn a_field_of_posts() {
    let args = ["render", "POST", "--members", "60", "--size", "240x135"];
    drawn_as_ever("posts", Limits::surfaces(), &args);
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn a_post_from_close_by() {
    let args = ["render", "POST", "--members", "3", "--size", "160x160", "--camera", "close"];
    drawn_as_ever("post_close", Limits::surfaces(), &args);
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn the_demo() {
    drawn_as_ever("demo", Limits::surfaces(), &["demo", "--members", "40", "--size", "240x135"]);
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn all_built_in_people_from_mid_range() {
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
    drawn_as_ever("people", Limits::surfaces(), &args);
}
