//! Users' stages, on every device and schedule.

#![expect(clippy::expect_used, reason = "a test that cannot go on fails")]

mod poses;
mod refusals;
mod rig;
mod strays;
