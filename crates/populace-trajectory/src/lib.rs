//! Trajectories of pedestrians from the files of simulations and experiments.
//!
//! Positions are on a plan, `[x, y]` in metres, x to the right and y up, with elevations apart.
//! Angles are in radians, counter-clockwise from +x. Times are in seconds, as the file counts them.

mod area;
mod error;
mod extra;
#[cfg(feature = "hdf5")]
mod hdf5;
mod input;
#[cfg(feature = "sqlite")]
mod jupedsim;
mod petrack;
mod place;
mod read;
mod recognise;
mod recording;
mod rows;
mod scenario;
mod settings;
mod source;
mod vadere;
mod warnings;
mod wkt;

pub use error::{Error, Location};
pub use place::{Place, PlaceChange, Polygon};
pub use read::{load, parse};
pub use recording::{Agent, Column, Footstep, Kind, Recording, Track, Values};
pub use settings::ReadSettings;
pub use source::{Fact, Format, HeadingSource, Origin, Source, Unit};
pub use warnings::Warning;
