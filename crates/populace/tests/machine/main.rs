//! State machines, on every device and schedule, on split crowds, and across moves.

#![expect(clippy::unwrap_used, reason = "a failed call fails the test")]
#![expect(
    clippy::cast_possible_truncation,
    dead_code,
    reason = "device and oracle get the same rounded input; not every test uses the whole arm"
)]

#[path = "../playback/fixture.rs"]
mod arm;
mod fades;
mod fixture;
mod moves;
mod reference;
mod refusals;
