//! Constraints and overrides, on every device and schedule.

#![expect(clippy::expect_used, reason = "a test that cannot go on fails")]

mod body;
mod feet;
mod gaze;
mod overrides;
mod reach;
mod same;
