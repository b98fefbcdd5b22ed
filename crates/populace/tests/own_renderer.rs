//! The example `own_renderer` runs without a window and draws the picture that it drew before.
//! `POPULACE_UPDATE=own_renderer` rewrites the reference, which Mesa's software driver drew.

use std::path::Path;
use std::process::Command;

use image::imageops::{FilterType, resize};
use populace_testkit::image::{Folders, Limits, assert_picture};

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn draws_its_reference() {
    // `cargo test` builds the examples beside the folder of the tests. `cargo test --test
    // own_renderer` alone needs `cargo build --examples` first.
    let test = std::env::current_exe().expect("a path");
    let build = test.parent().and_then(Path::parent).expect("a folder");
    let example =
        build.join("examples/own_renderer").with_extension(std::env::consts::EXE_EXTENSION);
    let folder = tempfile::TempDir::new().expect("a temporary folder");
    let file = folder.path().join("picture.png");
    let output = Command::new(&example).arg(&file).output();
    let output = output.unwrap_or_else(|error| panic!("{}: {error}", example.display()));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(said.starts_with("40 members, drawn to "), "{said}");
    let picture = resize(&image::open(&file).expect("a PNG"), 480, 200, FilterType::Triangle);
    let references = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/references");
    let folders =
        Folders { references: &references, failures: Path::new(env!("CARGO_TARGET_TMPDIR")) };
    assert_picture("own_renderer", 480, 200, picture.as_raw(), Limits::surfaces(), folders);
}
