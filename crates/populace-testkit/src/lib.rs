//! Test support for Populace: a double-precision [`oracle`], the [`conformance`] suite that
//! compares every device and schedule with it, and [`image`] comparison.
//!
//! The oracle implements the glTF 2.0 equations and the blending rules recursively, one character
//! at a time. It shares no sampling, blending or hierarchy code with the backends. [`tolerance`]
//! states the allowed error of each number, with its derivation. [`scenes`] generates the skeletons
//! and clips.
//!
//! A crate that implements a backend runs the whole suite with one macro call:
//!
//! ```text
//! mod conformance {
//!     populace_testkit::backend_conformance!(super::NativeBackend::new(3));
//! }
//! ```

#![expect(
    clippy::print_stdout,
    reason = "each check prints its statistics for runs with --nocapture"
)]

mod broken;
mod compare;
pub mod conformance;
mod crowd;
mod expected;
pub mod image;
pub mod oracle;
mod plan;
mod reading;
pub mod scenes;
pub mod tolerance;

pub use broken::{Broken, Corruption};
pub use crowd::TestCrowd;
pub use plan::{Inertialization, LayerPlan, MemberPlan, Play};
pub use populace_random::Rng;
pub use reading::MemberReading;
