//! Constraints and overrides, on every device and schedule.

#![expect(clippy::expect_used, reason = "a test that cannot go on fails")]
#![expect(
    clippy::disallowed_methods,
    reason = "tests have no need of the same bits on every machine"
)]
#![expect(
    clippy::print_stdout,
    reason = "what is measured is for those who run tests with --nocapture"
)]

mod attach;
mod body;
mod feet;
mod gaze;
mod moves;
mod overrides;
mod reach;
mod repeats;
mod same;
