//! The error type of this crate.

use crate::ShowError;

/// Errors of windows and of scripts.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// There is no display to open a window on.
    #[error(
        "there is no display to open a window on ({cause}); set DISPLAY or WAYLAND_DISPLAY, start \
         an X server (for example `Xvfb :1` and DISPLAY=:1), or draw without a window: `populace \
         render INPUT... --out FILE.png`"
    )]
    NoDisplay {
        /// Message of the system.
        cause: String,
    },
    /// The window could not be opened, or failed.
    #[error("the window failed: {cause}")]
    Window {
        /// Message of the system.
        cause: String,
    },
    /// A line of a script cannot be read.
    #[error("line {line} of the script: {fault}")]
    Script {
        /// Number of the line, from 1.
        line: usize,
        /// What is wrong, and what would be right.
        fault: String,
    },
    /// A line of a layout cannot be read.
    #[error("line {line}: {fault}")]
    Layout {
        /// Number of the line, from 1.
        line: usize,
        /// The fault.
        fault: String,
    },
    /// A line of a script expected something else.
    #[error("line {line} of the script expected {expected}, but found {found}")]
    Expected {
        /// Number of the line, from 1.
        line: usize,
        /// What was expected.
        expected: String,
        /// What was there.
        found: String,
    },
    /// Drawing failed.
    #[error(transparent)]
    Render(#[from] populace_render::Error),
    /// A picture or a film could not be written.
    #[error(transparent)]
    Film(#[from] populace_film::Error),
    /// The crowd failed.
    #[error(transparent)]
    Crowd(#[from] populace::Error),
    /// The show failed.
    #[error("{0}")]
    Show(ShowError),
}
