//! Inputs that all members of a frame share.

use populace_device::{Frame, Tables};

use crate::history::History;
use crate::user_stages::UserStages;

/// Inputs of a frame.
#[derive(Clone, Copy)]
pub(crate) struct FrameInputs<'a> {
    pub(crate) tables: &'a Tables,
    /// The clock, and the members and phases to evaluate.
    pub(crate) frame: Frame,
    pub(crate) stages: &'a UserStages,
    pub(crate) history: &'a History,
}
