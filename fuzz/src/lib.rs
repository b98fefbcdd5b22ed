//! Checks that fuzz targets and the ordinary test `sequences` of `populace-cli` have in common.
#![allow(dead_code, reason = "only fuzz targets' part of the test is used")]

#[path = "../../crates/populace-cli/tests/sequences/assets.rs"]
mod assets;
#[path = "../../crates/populace-assets/tests/gltf/builder.rs"]
mod builder;
#[path = "../../crates/populace-cli/tests/sequences/builders.rs"]
mod builders;
#[path = "../../crates/populace-cli/tests/sequences/calls.rs"]
mod calls;
#[path = "../../crates/populace-cli/tests/sequences/controls.rs"]
mod controls;
#[path = "../../crates/populace-cli/tests/sequences/draw.rs"]
mod draw;
#[path = "../../crates/populace-cli/tests/sequences/fixture.rs"]
mod fixture;
#[path = "../../crates/populace-cli/tests/sequences/imported.rs"]
mod imported;
#[path = "../../crates/populace-cli/tests/sequences/reads.rs"]
mod reads;
#[path = "../../crates/populace-cli/tests/sequences/sequence.rs"]
mod sequence;
#[path = "../../crates/populace-cli/tests/sequences/world.rs"]
mod world;

/// Panics with the fault of a state machine or blend space.
pub fn builders(bytes: &[u8]) {
    fails(builders::survives(bytes));
}

/// Panics with the fault of a character read from glTF and evaluated.
pub fn imported(bytes: &[u8]) {
    fails(imported::survives(bytes));
}

/// Makes calls on two native crowds, and panics if they differ or if a palette is not finite.
pub fn calls(bytes: &[u8]) {
    let setup = &fixture::setups()[0];
    let sequence = sequence::Sequence::from_bytes(bytes);
    if let Err(fault) = sequence.run(setup) {
        panic!("{}", sequence.report(setup, &fault));
    }
}

fn fails(result: Result<(), String>) {
    if let Err(fault) = result {
        panic!("{fault}");
    }
}
