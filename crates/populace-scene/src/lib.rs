//! Scenes of crowds: people who follow recorded trajectories.

mod error;
mod gaze;
mod heading;
mod motion;
mod replay;
mod smoothing;

pub use error::Error;
pub use motion::{Moment, Motion, Motions};
pub use replay::{Person, PositionError, Replay};
