//! What ends the program early, and its exit code.

use std::fmt::Display;
use std::process::ExitCode;

use populace::BackendError;

/// Why the program stops.
#[derive(Debug)]
pub(crate) enum Failure {
    /// A file or value that was rejected.
    Input(anyhow::Error),
    /// Wrong usage, or a name that does not exist.
    Usage(anyhow::Error),
    /// No usable device or GL.
    NoDevice(anyhow::Error),
    /// Output or run failed.
    Run(anyhow::Error),
    /// Whoever reads stdout has gone: nobody is left to tell.
    ClosedPipe,
}

impl Failure {
    pub(crate) fn usage(message: impl Display) -> Self {
        Self::Usage(anyhow::anyhow!("{message}"))
    }

    /// Says what went wrong on stderr and gives the exit code.
    pub(crate) fn report(self) -> ExitCode {
        let (error, code) = match self {
            Self::Input(error) => (error, 1),
            Self::Usage(error) => (error, 2),
            Self::NoDevice(error) => (error, 3),
            Self::Run(error) => (error, 4),
            Self::ClosedPipe => return ExitCode::SUCCESS,
        };
        crate::report::talk!("{error:#}");
        ExitCode::from(code)
    }
}

impl From<populace_assets::Error> for Failure {
    fn from(error: populace_assets::Error) -> Self {
        Self::Input(error.into())
    }
}

impl From<populace::Error> for Failure {
    fn from(error: populace::Error) -> Self {
        use populace::Error;
        match error {
            Error::Backend(BackendError::NoRuntime { .. } | BackendError::Unusable { .. })
            | Error::WithoutOpenCl => Self::NoDevice(error.into()),
            Error::Backend(BackendError::NoDevice { .. } | BackendError::NoPart { .. })
            | Error::Model(populace::model::Error::UnknownJoints { .. })
            | Error::UnknownClip { .. }
            | Error::UnknownDevice { .. }
            | Error::BadDevices { .. }
            | Error::BadSplit { .. }
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

impl From<std::io::Error> for Failure {
    fn from(error: std::io::Error) -> Self {
        if error.kind() == std::io::ErrorKind::BrokenPipe {
            Self::ClosedPipe
        } else {
            Self::Run(error.into())
        }
    }
}
