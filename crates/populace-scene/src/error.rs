//! Errors of scenes.

use populace::ErrorKind;

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
    /// Another number of people than of agents.
    #[error("{people} people were given for {agents} agents; give one for each")]
    UnequalLengths {
        /// The number of people.
        people: usize,
        /// The number of agents.
        agents: usize,
    },
}

impl Error {
    /// The kind of error.
    #[must_use]
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::Crowd(error) => error.kind(),
            Self::Locomotion(error) => error.kind(),
            Self::UnequalLengths { .. } => ErrorKind::InvalidInput,
        }
    }
}
