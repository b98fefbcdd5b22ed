//! Errors of scenes.

use populace::ErrorKind;
use populace::model::{did_you_mean, nearest_names};

/// The reason why a call was refused.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// An error of the crowd.
    #[error(transparent)]
    Crowd(#[from] populace::Error),
    /// An error of walkers.
    #[error(transparent)]
    Locomotion(#[from] populace_locomotion::Error),
    /// An error of ragdolls.
    #[error(transparent)]
    Physics(populace_physics::Error),
    /// A name that nothing in the plan of a scene has.
    #[error("there is no {what} \"{name}\"{}", did_you_mean(nearest))]
    UnknownName {
        /// The kind of thing.
        what: &'static str,
        /// The name.
        name: String,
        /// Names like it.
        nearest: Vec<String>,
    },
    /// Another number of people than a crowd of a plan counts.
    #[error("{people} people were given for a crowd of {count}; give one for each")]
    UnequalCrowd {
        /// The number of people.
        people: usize,
        /// The number that the plan says.
        count: usize,
    },
    /// A footway whose points are fewer than two, all equal, or not finite.
    #[error("the footway \"{name}\" has no length; give it two different, finite points or more")]
    FootwayWithoutLength {
        /// The name of the footway.
        name: String,
    },
    /// A bay so near to an end of its lane, or beyond it, that a vehicle cannot park and set off.
    #[error(
        "a bay of the lane \"{lane}\" at [{}, {}] is beyond its ends or within {least_m} m of one; \
         move the bay, or lengthen the lane", at[0], at[1]
    )]
    BayAtLaneEnd {
        /// The name of the lane.
        lane: String,
        /// The middle of the bay: `[x, z]` in metres.
        at: [f32; 2],
        /// The least length of the lane before and after the middle of a bay, in metres.
        least_m: f32,
    },
    /// Fewer free seats than people who sit.
    #[error("{people} people watch from {seats} seats; add stands or take fewer people")]
    TooFewSeats {
        /// The number of people.
        people: usize,
        /// The number of free seats.
        seats: usize,
    },
    /// More layers of a crowd of a plan than its behaviour leaves free.
    #[error("a [[crowd]] has {layers} `layers`; with this behaviour give at most {most}")]
    TooManyLayers {
        /// The number of layers that the plan gives.
        layers: usize,
        /// The number that there may be.
        most: usize,
    },
    /// A layer of a crowd of a plan that moves a part of the body which a character has not.
    #[error(
        "a [[crowd]] has `layers` with `mask = \"{part}\"`, and in the character \"{character}\" \
         no joints are known for that part; write `mask = \"whole_body\"`, or name the joints as \
         in a rig that is known"
    )]
    NoSuchPart {
        /// The character.
        character: String,
        /// The part of the body, as a scene file names it.
        part: &'static str,
    },
    /// Roads so far apart that the heights of the ground around them would fill the memory.
    #[error(
        "the roads lie within {} by {} m, and heights of the ground are kept for a square \
         kilometre; bring the roads closer together",
        size_m[0].ceil(), size_m[1].ceil()
    )]
    RoadsTooFarApart {
        /// The sides of the box around all roads, in metres along X and Z.
        size_m: [f32; 2],
    },
    /// Another number of people than of agents.
    #[error("{people} people were given for {agents} agents; give one for each")]
    UnequalLengths {
        /// The number of people.
        people: usize,
        /// The number of agents.
        agents: usize,
    },
}

impl From<populace_physics::Error> for Error {
    fn from(error: populace_physics::Error) -> Self {
        match error {
            populace_physics::Error::Crowd(error) => Self::Crowd(error),
            error => Self::Physics(error),
        }
    }
}

impl Error {
    /// The kind of error.
    #[must_use]
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::Crowd(error) => error.kind(),
            Self::Locomotion(error) => error.kind(),
            Self::Physics(error) => error.kind(),
            Self::UnequalLengths { .. }
            | Self::UnknownName { .. }
            | Self::UnequalCrowd { .. }
            | Self::FootwayWithoutLength { .. }
            | Self::BayAtLaneEnd { .. }
            | Self::TooFewSeats { .. }
            | Self::NoSuchPart { .. }
            | Self::RoadsTooFarApart { .. }
            | Self::TooManyLayers { .. } => ErrorKind::InvalidInput,
        }
    }

    /// A name that none of some things has.
    pub(crate) fn unknown<'a>(
        what: &'static str,
        name: &str,
        known: impl Iterator<Item = &'a String>,
    ) -> Self {
        let nearest = nearest_names(name, known.map(String::as_str));
        Self::UnknownName { what, name: name.to_owned(), nearest }
    }
}
