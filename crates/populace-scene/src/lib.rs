//! Scenes of crowds: people who follow recorded trajectories, and people who live in a street.

mod behaviour;
mod error;
mod footsteps;
mod gaze;
mod heading;
mod motion;
mod neighbours;
mod place;
pub mod plan;
mod prop_sizes;
mod replay;
mod scene_file;
mod smoothing;
mod stage;
mod street;

pub use behaviour::{Behaviours, Counts};
pub use error::Error;
pub use gaze::EYES;
pub use motion::{Moment, Motion, Motions};
pub use neighbours::Neighbours;
pub use place::{PlaceModel, PlacePart, PlaceSettings, PlaceWarning};
pub use replay::{Person, PositionError, Replay};
pub use scene_file::SceneFileError;
pub use stage::{Lights, PROP_KINDS, Prepare, Stage, THING_KINDS};
pub use street::{StreetSettings, street};
