//! Devices made ready ahead: a crowd that moves there finds every kernel built.
#![expect(
    clippy::disallowed_methods,
    reason = "tests have no need of the same bits on every machine"
)]
#![cfg(feature = "opencl")]
#![expect(
    clippy::expect_used,
    dead_code,
    reason = "a test that cannot go on fails; bodies are shared with others"
)]

#[path = "controls/body.rs"]
mod body;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use body::stage;
use populace::{ClipPlayback, Device, Placement, Schedule};

/// Names PoCL's folder of kernels; the test runs once more in a process that begins with an empty
/// one.
const KERNELS: &str = "POCL_CACHE_DIR";
const INNER: &str = "POPULACE_TEST_PREPARE";

/// The kernels that PoCL has compiled.
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

/// Moves a crowd to a device that was prepared, and compares the kernels before and after.
fn moves_to_what_is_built(kernels: &Path) {
    Device::opencl(0).prepare(Schedule::Fused).expect("a device");
    let before = compiled(kernels);
    let mut stage = stage(Device::native(), Schedule::Fused);
    let members: Vec<_> =
        (0..40).map(|n| stage.member(Placement::at([n as f32, 0.0, 0.0]))).collect();
    let walk = stage.clip("walk");
    stage.update(0.0);
    stage.crowd.move_to(Device::opencl(0)).expect("a device");
    for &member in &members {
        stage
            .crowd
            .member_mut(member)
            .expect("a slot")
            .play(walk, ClipPlayback::looping())
            .expect("a slot");
        stage.update(0.1);
    }
    stage.crowd.member_mut(members[0]).expect("a pose").local_pose().expect("a pose");
    assert!(!before.is_empty());
    assert_eq!(compiled(kernels), before);
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn a_crowd_that_moves_to_a_prepared_device_builds_nothing() {
    if std::env::var_os(INNER).is_some() {
        return moves_to_what_is_built(Path::new(&std::env::var_os(KERNELS).expect("a folder")));
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let this_test = "a_crowd_that_moves_to_a_prepared_device_builds_nothing";
    let mut process = Command::new(std::env::current_exe().expect("this program"));
    process.args(["--exact", this_test]).env(INNER, "1").env(KERNELS, folder.path());
    assert!(process.status().expect("the program starts").success());
}
