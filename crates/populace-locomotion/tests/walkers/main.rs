//! Walkers of small crowds on the native device.

#![expect(clippy::unwrap_used, reason = "tests panic on errors")]
#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "numbers of frames are small"
)]
#![expect(
    clippy::disallowed_methods,
    reason = "tests need not give the same bits on every machine"
)]

mod fixture;
mod goals;
mod ground;
mod led;
mod limits;
mod refusals;
mod replay;
mod walls;
