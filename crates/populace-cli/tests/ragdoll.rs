//! Test of the example `ragdoll`: it draws people who fall.
#![cfg(not(skip_gl))]

use std::path::Path;
use std::process::{Command, Output};

/// Builds and runs the example.
fn run(file: &Path, frames: &str) -> Output {
    let cargo = [
        "run",
        "--quiet",
        "--offline",
        "--package",
        "populace-physics",
        "--example",
        "ragdoll",
        "--",
    ];
    Command::new(env!("CARGO")).args(cargo).arg(file).arg(frames).output().expect("cargo runs")
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
        let run = run(&file, frames);
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
        image::open(&file).unwrap().to_rgba8()
    };
    let lying = picture("a.png", "150");
    let again = picture("b.png", "150");
    let before = picture("c.png", "6");
    assert_eq!(differing(&lying, &again), 0, "two runs must draw the same picture");
    assert!(differing(&lying, &before) > 10_000, "the people must have moved");
}
