//! State machines, on every device and schedule, on devices that share a crowd, and across a move.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]
#![expect(
    clippy::cast_possible_truncation,
    dead_code,
    reason = "scenes may be rounded as they come: each is made once for the device and for what \
              judges it; arms are shared"
)]

#[path = "../playback/rig.rs"]
mod arm;
mod fades;
mod moves;
mod reference;
mod refusals;
mod rig;
