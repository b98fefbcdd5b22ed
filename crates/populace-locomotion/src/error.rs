//! Errors of locomotion.

use populace::ErrorKind;

/// The reason why a call was refused. Nothing has changed after an error.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// An error of the crowd.
    #[error(transparent)]
    Crowd(#[from] populace::Error),
    /// An error of avoidance.
    #[error(transparent)]
    Avoidance(#[from] crate::avoidance::Error),
    /// A clip that does not walk on a body.
    #[error(
        "the clip \"{clip}\" does not walk forwards on this body; give a clip whose feet touch the \
         ground and pass it backwards, and a body with two feet"
    )]
    NoGait {
        /// The clip's name.
        clip: String,
    },
    /// Two clips of nearly the same speed.
    #[error("two clips move at speeds that differ by less than 5 %; give one of them")]
    SameSpeed,
    /// No moving clip.
    #[error("no clip that moves is given; give a walk at least")]
    NoClips,
    /// No clips to walk with among those of a character.
    #[error(
        "\"{character}\" has no clips to walk with: one in which both feet stand, and one that \
         walks or runs forwards; add some with CharacterMut::add_clip"
    )]
    NoGaitClips {
        /// The character's name.
        character: String,
    },
    /// A clip that the character does not have.
    #[error("a clip is not among those of the character; add it with CharacterMut::add_clip")]
    NotItsClip,
    /// A member of a character that no gaits were given for.
    #[error("there are no gaits of the member's character; give them with Walkers::add_gaits")]
    NoGaits,
    /// A member that is no walker.
    #[error("member {member} is no walker; make it one with Walkers::add")]
    NotAWalker {
        /// The member's number.
        member: u32,
    },
    /// A walker whose member was despawned.
    #[error("walker {member} was despawned; forget it with Walkers::remove")]
    Despawned {
        /// The member's number.
        member: u32,
    },
    /// A number out of its range.
    #[error("{what} is {value}; it must be {rule}")]
    BadValue {
        /// The quantity.
        what: &'static str,
        /// The value.
        value: f32,
        /// The values that are allowed.
        rule: &'static str,
    },
    /// A slice of another length than the number of walkers.
    #[error("{found} velocities are given for {walkers} walkers; give one for each")]
    UnequalLengths {
        /// The length of the slice.
        found: usize,
        /// The number of walkers.
        walkers: usize,
    },
    /// A path of fewer than two points.
    #[error("the path has {points} points; it needs at least 2")]
    ShortPath {
        /// The number of points.
        points: usize,
    },
}

impl Error {
    /// Returns the kind of the error.
    #[must_use]
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::Crowd(error) => error.kind(),
            Self::Avoidance(error) => error.kind(),
            Self::NotItsClip
            | Self::NoGaitClips { .. }
            | Self::NoGaits
            | Self::NotAWalker { .. }
            | Self::Despawned { .. } => ErrorKind::NotFound,
            Self::NoGait { .. }
            | Self::SameSpeed
            | Self::NoClips
            | Self::BadValue { .. }
            | Self::UnequalLengths { .. }
            | Self::ShortPath { .. } => ErrorKind::InvalidInput,
        }
    }
}

/// Refuses a number outside of a range.
pub(crate) fn within(
    what: &'static str,
    value: f32,
    range: std::ops::RangeInclusive<f32>,
    rule: &'static str,
) -> Result<(), Error> {
    if range.contains(&value) { Ok(()) } else { Err(Error::BadValue { what, value, rule }) }
}
