//! Facts about a file that its reader is told.

use std::path::PathBuf;

use crate::{Format, HeadingSource, Unit};

/// Facts that overrule those of a file, or stand in where it has none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadSettings {
    /// The format; `None` recognises it by the content.
    pub format: Option<Format>,
    /// The unit of positions, and of the place in the file; `None` takes that of the file, or the
    /// format's. Positions in columns with pixels in their names need one.
    pub unit: Option<Unit>,
    /// Frames per second by which the file counts; `None` takes that of the file. Without effect
    /// on files that store seconds, with a warning.
    pub fps: Option<f64>,
    /// The source of headings; `None` takes the file's headings where it has some. A file that has
    /// none is warned of if they are asked for.
    pub heading: Option<HeadingSource>,
    /// A file with the walkable area in metres, as WKT or a scenario of Vadere; `None` takes that
    /// in the file or beside it.
    pub geometry: Option<PathBuf>,
    /// Refuses files with warnings.
    pub strict: bool,
}
