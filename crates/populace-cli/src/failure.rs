//! Failures that end the program, and their exit codes.

use std::fmt::Display;
use std::process::ExitCode;

use populace::BackendError;

/// The refusal of a character that cannot walk.
pub(crate) const UNKNOWN_LEGS: &str = "its joints have no names that are known as hips, legs and \
    feet, so it cannot walk; leave it out, or rename its joints as VRM, Mixamo, Unreal, KayKit, \
    Rigify, Quaternius or CMU do";

/// A failure that ends the program.
#[derive(Debug)]
pub(crate) enum Failure {
    /// A file or value that was rejected.
    Input(anyhow::Error),
    /// Wrong usage, or a name that does not exist.
    Usage(anyhow::Error),
    /// No usable device or GL.
    NoDevice(anyhow::Error),
    /// An output or the run failed.
    Run(anyhow::Error),
    /// The reader of stdout is gone. The program ends without a message.
    ClosedPipe,
}

impl Failure {
    pub(crate) fn usage(message: impl Display) -> Self {
        Self::Usage(anyhow::anyhow!("{message}"))
    }

    /// Returns the error to report, if any.
    pub(crate) fn error(&self) -> Option<&anyhow::Error> {
        match self {
            Self::Input(error) | Self::Usage(error) | Self::NoDevice(error) | Self::Run(error) => {
                Some(error)
            }
            Self::ClosedPipe => None,
        }
    }

    /// Returns the exit code of the program.
    pub(crate) fn exit_code(&self) -> ExitCode {
        match self {
            Self::Input(_) => ExitCode::from(1),
            Self::Usage(_) => ExitCode::from(2),
            Self::NoDevice(_) => ExitCode::from(3),
            Self::Run(_) => ExitCode::from(4),
            Self::ClosedPipe => ExitCode::SUCCESS,
        }
    }
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.error() {
            Some(error) => write!(f, "{error:#}"),
            None => write!(f, "the reader of the output is gone"),
        }
    }
}

impl std::error::Error for Failure {}

impl From<populace_assets::Error> for Failure {
    fn from(error: populace_assets::Error) -> Self {
        Self::Input(error.into())
    }
}

impl From<populace_bodies::Error> for Failure {
    fn from(error: populace_bodies::Error) -> Self {
        Self::Input(error.into())
    }
}

impl From<populace_trajectory::Error> for Failure {
    fn from(error: populace_trajectory::Error) -> Self {
        Self::Input(error.into())
    }
}

impl From<populace_locomotion::Error> for Failure {
    fn from(error: populace_locomotion::Error) -> Self {
        match error {
            populace_locomotion::Error::Crowd(error) => error.into(),
            _ => Self::Input(error.into()),
        }
    }
}

impl From<populace_scene::Error> for Failure {
    fn from(error: populace_scene::Error) -> Self {
        match error {
            populace_scene::Error::Crowd(error) => error.into(),
            populace_scene::Error::Locomotion(error) => error.into(),
            _ => Self::Input(error.into()),
        }
    }
}

impl From<populace::Error> for Failure {
    fn from(error: populace::Error) -> Self {
        use populace::{ConstraintFault, DevicesError, Error, TablesError};
        match error {
            Error::Tables(TablesError::BadConstraint(ConstraintFault::UnknownRoles {
                character,
                part: "legs",
            })) => Self::Input(anyhow::anyhow!("\"{character}\": {UNKNOWN_LEGS}")),
            Error::Backend(BackendError::NoRuntime { .. } | BackendError::Unusable { .. })
            | Error::Devices(DevicesError::WithoutOpenCl) => Self::NoDevice(error.into()),
            Error::Backend(BackendError::NoDevice { .. } | BackendError::NoPart { .. })
            | Error::Model(populace::model::Error::UnknownJoints { .. })
            | Error::UnknownClip { .. }
            | Error::Devices(_)
            | Error::BadValue { .. } => Self::Usage(error.into()),
            Error::Backend(_) | Error::Full { .. } => Self::Run(error.into()),
            _ => Self::Input(error.into()),
        }
    }
}

impl From<populace_render::Error> for Failure {
    fn from(error: populace_render::Error) -> Self {
        match error {
            populace_render::Error::NoGl { .. } => Self::NoDevice(error.into()),
            populace_render::Error::BadCamera { .. } => Self::Usage(error.into()),
            _ => Self::Run(error.into()),
        }
    }
}

#[cfg(feature = "viewer")]
impl From<populace_viewer::Error> for Failure {
    fn from(error: populace_viewer::Error) -> Self {
        use populace_viewer::Error;
        match error {
            Error::NoDisplay { .. } => Self::NoDevice(error.into()),
            Error::Script { .. } => Self::Usage(error.into()),
            Error::Render(error) => error.into(),
            Error::Film(error) => error.into(),
            Error::Crowd(error) => error.into(),
            Error::Show(error) => match error.downcast::<Self>() {
                Ok(failure) => *failure,
                Err(error) => Self::Run(anyhow::anyhow!("{error}")),
            },
            _ => Self::Run(error.into()),
        }
    }
}

impl From<populace_film::Error> for Failure {
    fn from(error: populace_film::Error) -> Self {
        use populace_film::Error;
        match error {
            Error::BadValue { .. }
            | Error::UnknownFormat { .. }
            | Error::WithoutOpenH264
            | Error::NoFfmpeg { .. } => Self::Usage(error.into()),
            _ => Self::Run(error.into()),
        }
    }
}

impl From<std::io::Error> for Failure {
    fn from(error: std::io::Error) -> Self {
        if error.kind() == std::io::ErrorKind::BrokenPipe {
            Self::ClosedPipe
        } else {
            Self::Run(error.into())
        }
    }
}
