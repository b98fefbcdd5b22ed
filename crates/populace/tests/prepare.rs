//! Prepared devices: a crowd that moves to one builds no kernels.
#![expect(
    clippy::disallowed_methods,
    reason = "tests need not give the same bits on every machine"
)]
#![cfg(feature = "opencl")]
#![expect(
    clippy::expect_used,
    dead_code,
    reason = "a failed call fails the test; not every test uses the whole fixture"
)]

#[path = "controls/fixture.rs"]
mod fixture;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use fixture::scene;
use populace::{ClipPlayback, Device, Placement, Schedule};

/// Environment variable that names PoCL's kernel folder. The test runs itself again in a process
/// for which this folder is empty.
const KERNELS: &str = "POCL_CACHE_DIR";
/// Environment variable that marks that process.
const INNER: &str = "POPULACE_TEST_PREPARE";

/// Lists the kernels that PoCL has compiled.
fn compiled(folder: &Path) -> BTreeSet<PathBuf> {
    let mut found = BTreeSet::new();
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            found.extend(compiled(&path));
        } else if path.extension().is_some_and(|e| e == "so") {
            found.insert(path);
        }
    }
    found
}

/// Moves a crowd to a prepared device and compares the compiled kernels before and after.
fn assert_move_builds_nothing(kernels: &Path) {
    Device::opencl(0).prepare(Schedule::Fused).expect("a device");
    let before = compiled(kernels);
    let mut scene = scene(Device::native(), Schedule::Fused);
    let members: Vec<_> =
        (0..40).map(|n| scene.member(Placement::at([n as f32, 0.0, 0.0]))).collect();
    let walk = scene.clip("walk");
    scene.update(0.0);
    scene.crowd.move_to(Device::opencl(0)).expect("a device");
    for &member in &members {
        scene.edit(member).play(walk, ClipPlayback::looping()).expect("a slot");
        scene.update(0.1);
    }
    scene.edit(members[0]).local_pose().expect("a pose");
    assert!(!before.is_empty());
    assert_eq!(compiled(kernels), before);
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn move_to_prepared_device_builds_no_kernels() {
    if std::env::var_os(INNER).is_some() {
        return assert_move_builds_nothing(Path::new(
            &std::env::var_os(KERNELS).expect("a folder"),
        ));
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let this_test = "move_to_prepared_device_builds_no_kernels";
    let mut process = Command::new(std::env::current_exe().expect("this program"));
    process.args(["--exact", this_test]).env(INNER, "1").env(KERNELS, folder.path());
    assert!(process.status().expect("the program starts").success());
}
