//! Constraints and overrides, on every device and schedule.

#![expect(clippy::expect_used, reason = "a failed call fails the test")]
#![expect(
    clippy::disallowed_methods,
    reason = "tests need not give the same bits on every machine"
)]
#![expect(clippy::print_stdout, reason = "measured values are shown with --nocapture")]

mod attach;
mod determinism;
mod feet;
mod fixture;
mod gaze;
mod history;
mod moves;
mod overrides;
mod reach;
mod refusals;
mod repeats;
mod small;
