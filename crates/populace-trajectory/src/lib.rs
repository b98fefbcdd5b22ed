//! Trajectories of pedestrians from the files of simulations and experiments.
//!
//! Positions are on a plan, `[x, y]` in metres, x to the right and y up, with elevations apart.
//! Angles are in radians, counter-clockwise from +x. Times are in seconds, as the file counts them.

mod area;
#[cfg(any(feature = "hdf5", feature = "sqlite"))]
mod areas;
mod comment;
mod error;
mod extra;
mod fields;
#[cfg(feature = "hdf5")]
mod hdf5;
#[cfg(any(feature = "hdf5", feature = "sqlite"))]
mod ids;
mod input;
mod jpscore;
#[cfg(feature = "sqlite")]
mod jupedsim;
mod layout;
mod location;
mod menge;
mod named;
mod names;
mod obsmat;
mod pathfinder_json;
mod petrack;
mod place;
mod presence;
mod read;
mod recognise;
mod recording;
mod rows;
mod scenario;
mod settings;
mod source;
mod steps;
mod summary;
mod sumo;
mod table;
mod trajnet;
mod trajnet_plus_plus;
mod vadere;
mod warnings;
mod wkt;

pub use error::Error;
pub use location::Location;
pub use place::{Place, PlaceChange, Polygon};
pub use presence::{counts_present, most_present};
pub use read::{load, parse};
pub use recording::{Agent, Column, Footstep, Kind, Recording, Track, Values};
pub use settings::ReadSettings;
pub use source::{Fact, Format, HeadingSource, Origin, Source, Unit};
pub use summary::{Gaps, Summary};
pub use warnings::Warning;
