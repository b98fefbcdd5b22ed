//! Errors of the library. A call that returns one leaves the crowd as it was.

use populace_device::BackendError;
use populace_model::{ErrorKind, did_you_mean};

use crate::fault::{Allowed, AttachmentFault, BlendSpaceFault, IdKind, MachineFault, User};

/// The reason why a call was refused. The crowd is as it was before the call.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// Data that does not describe a skeleton, or a joint's name that it does not have.
    #[error(transparent)]
    Model(#[from] populace_model::Error),
    /// Data that does not describe a character.
    #[error(transparent)]
    Character(populace_character::Error),
    /// Data that does not describe a clip.
    #[error(transparent)]
    Clip(populace_clip::Error),
    /// A clip that does not fit a skeleton.
    #[error(transparent)]
    Retarget(#[from] populace_retarget::Error),
    /// A constraint, override or stage that no device could evaluate.
    #[error(transparent)]
    Tables(#[from] populace_device::Error),
    /// A device that failed, or is not there.
    #[error(transparent)]
    Backend(#[from] BackendError),
    /// The character has no clip of this name.
    #[error("\"{character}\" has no clip \"{name}\"{}", did_you_mean(nearest))]
    UnknownClip {
        /// The character's name.
        character: String,
        /// The name asked for.
        name: String,
        /// Similar names, nearest first.
        nearest: Vec<String>,
    },
    /// Devices that cannot be opened or share a crowd.
    #[error(transparent)]
    Devices(populace_backends::Error),
    /// The crowd already has the number of members that it was built for.
    #[error("the crowd is full: it was built for {capacity} members")]
    Full {
        /// The capacity.
        capacity: usize,
    },
    /// A handle to a member that was despawned.
    #[error("the member handle is stale: its member was despawned")]
    StaleMember,
    /// A handle to a playback that has ended, or that something else replaced.
    #[error("the playback handle is stale: its clip has ended or was replaced")]
    StalePlayback,
    /// A blend space that is invalid, or cannot be played as requested.
    #[error("the blend space {0}")]
    BadBlendSpace(BlendSpaceFault),
    /// A state machine that is invalid, or cannot be run as requested.
    #[error("the state machine {0}")]
    BadStateMachine(MachineFault),
    /// An attachment that is not possible, or a call that an attached member does not allow.
    #[error("{0}")]
    BadAttachment(AttachmentFault),
    /// An id of another crowd, or of something that does not exist.
    #[error(
        "there is no {what} {index} in this {owner}; ids are valid in the {owner} that returned \
         them, until it is removed",
        owner = .what.owner()
    )]
    UnknownId {
        /// The kind of id.
        what: IdKind,
        /// Its number.
        index: u32,
    },
    /// A snapshot of another crowd.
    #[error("the snapshot was taken from another crowd; restore it there")]
    OtherCrowd,
    /// Something to remove that is still needed.
    #[error("the {what} cannot be removed: it is in use by {by}")]
    InUse {
        /// The kind of the asset.
        what: IdKind,
        /// Its user.
        by: User,
    },
    /// A number out of its range.
    #[error("{what} is {value}; it must be {allowed}")]
    BadValue {
        /// The quantity.
        what: &'static str,
        /// The value.
        value: f32,
        /// The allowed values.
        allowed: Allowed,
    },
}

impl Error {
    /// Returns the kind of the error.
    #[must_use]
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::Model(error) => error.kind(),
            Self::Character(error) => error.kind(),
            Self::Clip(error) => error.kind(),
            Self::Retarget(error) => error.kind(),
            Self::Tables(error) => error.kind(),
            Self::Backend(error) => error.kind(),
            Self::Devices(error) => error.kind(),
            Self::UnknownClip { .. }
            | Self::UnknownId { .. }
            | Self::BadStateMachine(MachineFault::Unknown { .. }) => ErrorKind::NotFound,
            Self::StaleMember
            | Self::StalePlayback
            | Self::BadStateMachine(MachineFault::NotStarted { .. }) => ErrorKind::Stale,
            Self::Full { .. } => ErrorKind::TooLarge,
            Self::BadBlendSpace(_)
            | Self::BadStateMachine(_)
            | Self::BadAttachment(_)
            | Self::OtherCrowd
            | Self::InUse { .. }
            | Self::BadValue { .. } => ErrorKind::InvalidInput,
        }
    }
}

impl From<populace_clip::Error> for Error {
    fn from(error: populace_clip::Error) -> Self {
        match error {
            populace_clip::Error::Model(error) => Self::Model(error),
            error => Self::Clip(error),
        }
    }
}

impl From<populace_character::Error> for Error {
    fn from(error: populace_character::Error) -> Self {
        match error {
            populace_character::Error::Model(error) => Self::Model(error),
            populace_character::Error::Clip(error) => error.into(),
            error => Self::Character(error),
        }
    }
}

impl From<populace_backends::Error> for Error {
    fn from(error: populace_backends::Error) -> Self {
        match error {
            populace_backends::Error::Backend(error) => Self::Backend(error),
            populace_backends::Error::Model(error) => Self::Model(error),
            populace_backends::Error::Tables(error) => Self::Tables(error),
            error => Self::Devices(error),
        }
    }
}
