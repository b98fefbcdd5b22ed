//! Scenes of crowds: people who follow recorded trajectories.

mod error;
mod footsteps;
mod gaze;
mod heading;
mod motion;
mod place;
mod replay;
mod smoothing;

pub use error::Error;
pub use motion::{Moment, Motion, Motions};
pub use place::{PlaceModel, PlacePart, PlaceSettings, PlaceWarning};
pub use replay::{Person, PositionError, Replay};
