//! Holds the arrows between the crates: data flows down, and nothing else.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

/// Each crate and the crates of ours that it may use outside tests.
const ALLOWED: &[(&str, &[&str])] = &[
    ("populace-model", &[]),
    ("populace-clip", &["populace-model"]),
    ("populace-character", &["populace-clip", "populace-model"]),
    ("populace-retarget", &["populace-clip", "populace-model"]),
    (
        "populace-device",
        &["populace-character", "populace-clip", "populace-model", "populace-retarget"],
    ),
    ("populace-native", &["populace-clip", "populace-device", "populace-model"]),
    ("populace-opencl", &["populace-device", "populace-model"]),
    (
        "populace-backends",
        &[
            "populace-character",
            "populace-clip",
            "populace-device",
            "populace-model",
            "populace-native",
            "populace-opencl",
        ],
    ),
    (
        "populace-settings",
        &[
            "populace-backends",
            "populace-character",
            "populace-clip",
            "populace-device",
            "populace-model",
            "populace-retarget",
        ],
    ),
    (
        "populace",
        &[
            "populace-backends",
            "populace-character",
            "populace-clip",
            "populace-device",
            "populace-model",
            "populace-retarget",
            "populace-settings",
        ],
    ),
    ("populace-physics", &["populace"]),
    ("populace-locomotion", &["populace"]),
    ("populace-assets", &["populace-character", "populace-clip", "populace-model"]),
    ("populace-bodies", &["populace-character", "populace-model", "populace-random"]),
    ("populace-film", &[]),
    ("populace-lod", &["populace-character", "populace-model"]),
    ("populace-overlay", &[]),
    ("populace-random", &[]),
    ("populace-trajectory", &[]),
    (
        "populace-scene",
        &[
            "populace",
            "populace-cast",
            "populace-locomotion",
            "populace-physics",
            "populace-props",
            "populace-random",
            "populace-trajectory",
        ],
    ),
    ("populace-variety", &["populace-character", "populace-device", "populace-model"]),
    ("populace-render", &["populace-character", "populace-device", "populace-model"]),
    (
        "populace-testkit",
        &[
            "populace-character",
            "populace-clip",
            "populace-device",
            "populace-model",
            "populace-random",
            "populace-retarget",
        ],
    ),
    ("populace-cast", &["populace-character", "populace-clip", "populace-model"]),
    (
        "populace-props",
        &["populace-character", "populace-clip", "populace-model", "populace-random"],
    ),
    // The panels are written in the font of the overlays.
    (
        "populace-viewer",
        &[
            "populace",
            "populace-film",
            "populace-locomotion",
            "populace-overlay",
            "populace-physics",
            "populace-render",
        ],
    ),
    // The benchmark counts bytes of device tables, and holds its results against the oracle of the
    // testkit.
    (
        "populace-bench",
        &[
            "populace",
            "populace-device",
            "populace-locomotion",
            "populace-model",
            "populace-testkit",
        ],
    ),
    (
        "populace-cli",
        &[
            "populace",
            "populace-assets",
            "populace-bench",
            "populace-bodies",
            "populace-cast",
            "populace-film",
            "populace-locomotion",
            "populace-lod",
            "populace-overlay",
            "populace-random",
            "populace-render",
            "populace-scene",
            "populace-trajectory",
            "populace-variety",
            "populace-viewer",
        ],
    ),
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .and_then(Path::parent)
        .expect("crates/populace-testkit lies two down")
}

#[test]
fn crates_use_only_what_lies_below_them() {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--no-deps", "--offline", "--format-version", "1"])
        .current_dir(root())
        .output()
        .expect("cargo runs");
    let metadata: serde_json::Value =
        serde_json::from_slice(&output.stdout).expect("cargo prints JSON");
    let mut found = BTreeMap::new();
    for package in metadata["packages"].as_array().expect("packages") {
        let ours = package["dependencies"]
            .as_array()
            .expect("dependencies")
            .iter()
            .filter(|d| d["kind"].is_null());
        let names = ours.filter_map(|d| d["name"].as_str()).filter(|n| n.starts_with("populace"));
        found.insert(package["name"].as_str().expect("a name"), names.collect::<BTreeSet<_>>());
    }
    let allowed: BTreeMap<_, BTreeSet<_>> =
        ALLOWED.iter().map(|(name, uses)| (*name, uses.iter().copied().collect())).collect();
    assert_eq!(found, allowed);
}

/// Crates of others that only one of ours may use outside tests and examples.
const SOLE_USERS: &[(&str, &str)] = &[
    ("egui", "populace-viewer"),
    ("gif", "populace-film"),
    ("gilrs", "populace-viewer"),
    ("glow", "populace-render"),
    ("khronos-egl", "populace-render"),
    ("opencl3", "populace-opencl"),
    ("openh264", "populace-film"),
    ("rapier3d", "populace-physics"),
    ("winit", "populace-viewer"),
];

#[test]
fn drivers_encoders_and_physics_have_one_user_each() {
    for folder in std::fs::read_dir(root().join("crates")).expect("crates") {
        let folder = folder.expect("a crate").path();
        let manifest = std::fs::read_to_string(folder.join("Cargo.toml")).expect("Cargo.toml");
        for (theirs, ours) in SOLE_USERS {
            let names = |line: &str| line.split(['.', ' ', '=']).next() == Some(theirs);
            let uses = manifest.split("[dev-dependencies]").take(1).any(|m| m.lines().any(names));
            assert_eq!(uses, folder.ends_with(ours), "{theirs} in {}", folder.display());
        }
    }
}

#[test]
fn every_path_that_the_architecture_page_names_exists() {
    let page = std::fs::read_to_string(root().join("ARCHITECTURE.md")).expect("ARCHITECTURE.md");
    let quoted: Vec<_> =
        page.split('`').skip(1).step_by(2).filter(|word| word.contains('/')).collect();
    assert!(quoted.len() > 5, "the page names too few paths: {quoted:?}");
    for path in quoted {
        assert!(root().join(path).exists(), "ARCHITECTURE.md names {path}, which does not exist");
    }
}
