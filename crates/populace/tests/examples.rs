//! Tests of the examples: they run without a window, print results and draw a picture with people.

use std::process::Command;

#[track_caller]
fn runs_and_draws(name: &str, words: &[&str]) {
    // `cargo test` builds the examples. `cargo test --test examples` alone needs
    // `cargo build --examples` first.
    let test = std::env::current_exe().expect("a path");
    let built = test.ancestors().nth(2).expect("tests lie in a folder of their own");
    let example = built.join("examples").join(name);
    let example = example.with_extension(std::env::consts::EXE_EXTENSION);
    let folder = tempfile::TempDir::new().expect("a temporary folder");
    let picture = folder.path().join("picture.png");
    let output = Command::new(&example).arg(&picture).current_dir(folder.path()).output();
    let output = output.unwrap_or_else(|error| panic!("{}: {error}", example.display()));
    let (stdout, stderr) =
        (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{stderr}");
    for word in words {
        assert!(stdout.contains(word), "no {word:?} in: {stdout}");
    }
    let picture = image::open(&picture).expect("a PNG").to_rgb8();
    assert_eq!(picture.dimensions(), (960, 400));
    // The colours of shirts differ from the grey ground and the blue sky.
    let strong = |p: &&image::Rgb<u8>| {
        i16::from(p.0[0]) > i16::from(p.0[1]) + 40 || p.0.iter().all(|c| *c < 60)
    };
    let people = picture.pixels().filter(strong).count();
    assert!(people > 2000, "only {people} pixels show people");
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn layers() {
    runs_and_draws("layers", &["3: walks, waves by 0.5, bows by 0.5", "drawn to"]);
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn inertialize() {
    runs_and_draws(
        "inertialize",
        &["cut: the hand", "inertialized: the hand changes its speed by up to 0.", "drawn to"],
    );
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn wind() {
    runs_and_draws(
        "wind",
        &["10000 stalks in the wind on native", "both pictures are the same: true"],
    );
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn blend_space() {
    runs_and_draws(
        "blend_space",
        &["Walk: sample at 1.", "0.0 m/s: Idle 100 %\n", "3.0 m/s: Run 100 %"],
    );
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn root_motion() {
    runs_and_draws("root_motion", &["was placed once, and has moved 7.", "drawn to"]);
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn gaze() {
    runs_and_draws("gaze", &["0: the head is turned by", "drawn to"]);
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn reach() {
    runs_and_draws("reach", &["and 0 mm from the hand", "drawn to"]);
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn attach() {
    runs_and_draws("attach", &["6: the torch is 0.000 m from the fist", "drawn to"]);
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn retarget() {
    runs_and_draws("retarget", &["hips 0.", "drawn to"]);
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn live_clip() {
    runs_and_draws(
        "live_clip",
        &["0: shows 4.90 s of the stream, 0.10 s ago", "4: shows 4.30 s", "150 poses in 5.0 s"],
    );
}

#[cfg_attr(skip_gl, ignore = "POPULACE_SKIP names gl")]
#[test]
fn machine() {
    runs_and_draws(
        "machine",
        &["0: idle at 0.0 m/s, 0.0 m away", ": walk at", ": run at", "6: turn at", "drawn to"],
    );
}
