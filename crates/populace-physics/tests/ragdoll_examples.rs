//! Tests of the examples `ragdoll` and `get_up`: they draw people who fall and get up.
#![cfg(not(skip_gl))]

use std::path::Path;
use std::process::{Command, Output};

/// Runs an example. `cargo test` builds it, but `cargo test --test ragdoll_examples` does not.
fn run(example: &str, file: &Path, frames: &str) -> Output {
    let test = std::env::current_exe().expect("a path");
    let built = test.ancestors().nth(2).expect("tests lie in a folder of their own");
    let example = built.join("examples").join(example);
    let example = example.with_extension(std::env::consts::EXE_EXTENSION);
    let output = Command::new(&example).arg(file).arg(frames).output();
    output.unwrap_or_else(|error| panic!("{}: {error}", example.display()))
}

/// Counts the pixels that differ clearly between two pictures.
fn differing(a: &image::RgbaImage, b: &image::RgbaImage) -> usize {
    let far = |(a, b): &(&image::Rgba<u8>, &image::Rgba<u8>)| {
        a.0.iter().zip(b.0).map(|(a, b)| u32::from(a.abs_diff(b))).sum::<u32>() > 60
    };
    a.pixels().zip(b.pixels()).filter(far).count()
}

#[test]
fn ragdoll_example_draws_falling_people() {
    let folder = tempfile::tempdir().unwrap();
    let picture = |name: &str, frames: &str| {
        let file = folder.path().join(name);
        let run = run("ragdoll", &file, frames);
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
        image::open(&file).unwrap().to_rgba8()
    };
    let lying = picture("a.png", "150");
    let again = picture("b.png", "150");
    let before = picture("c.png", "6");
    assert_eq!(differing(&lying, &again), 0, "two runs must draw the same picture");
    assert!(differing(&lying, &before) > 10_000, "the people must have moved");
}

#[test]
fn get_up_example_draws_people_who_lie_and_then_stand() {
    let folder = tempfile::tempdir().unwrap();
    let picture = |name: &str, frames: &str| {
        let file = folder.path().join(name);
        let run = run("get_up", &file, frames);
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
        image::open(&file).unwrap().to_rgba8()
    };
    let lying = picture("a.png", "180");
    let up = picture("b.png", "480");
    assert!(differing(&lying, &up) > 3_000, "the people must have got up");
}
