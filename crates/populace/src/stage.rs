//! How a member uses a user's stage.

use populace_model::JointIndex;

/// For which joints of a member a stage runs, and the member's own four numbers for it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StageUse {
    /// `None` for all.
    pub(crate) joints: Option<Vec<JointIndex>>,
    pub(crate) values: [f32; 4],
}

impl StageUse {
    /// For all joints.
    #[must_use]
    pub fn on_all() -> Self {
        Self::default()
    }

    /// For these joints.
    #[must_use]
    pub fn on(joints: impl IntoIterator<Item = JointIndex>) -> Self {
        Self { joints: Some(joints.into_iter().collect()), ..Self::default() }
    }

    /// With numbers of the member's own, which the stage finds in `values`; 0 unless given.
    #[must_use]
    pub fn with_values(mut self, values: [f32; 4]) -> Self {
        self.values = values;
        self
    }
}
