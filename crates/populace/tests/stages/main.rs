//! User stages, on every device and schedule.

#![expect(clippy::expect_used, reason = "a failed call fails the test")]

mod fixture;
mod invalid_output;
mod poses;
mod refusals;
