//! The judges of Populace: a double-precision [`oracle`], the [`conformance`] suite that every
//! device and schedule runs against it, and the comparison of [`image`]s.
//!
//! The oracle is written from the glTF 2.0 equations and the rules of blending, one character at a
//! time and recursively. It shares no sampling, blending or hierarchy code with what it judges. How
//! far a device may stray from it is stated in [`tolerance`], each bound with its derivation.
//! [`scenes`] makes the skeletons and clips.
//!
//! A crate that implements a backend runs the whole suite by one line:
//!
//! ```text
//! mod conformance {
//!     populace_testkit::backend_conformance!(super::NativeBackend::new(3));
//! }
//! ```

#![expect(
    clippy::print_stdout,
    reason = "the numbers compared are for those who run tests with --nocapture"
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
mod rng;
pub mod scenes;
pub mod tolerance;

pub use broken::{Broken, Corruption};
pub use crowd::TestCrowd;
pub use plan::{Inertialization, LayerPlan, MemberPlan, Play};
pub use reading::MemberReading;
pub use rng::Rng;

pub(crate) use populace_model::convert::single;
