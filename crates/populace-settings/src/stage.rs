//! Settings of a user stage for one member.

use populace_model::JointIndex;

/// The joints of a member for which a user stage runs, and the member's four values for it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StageUse(pub(crate) StageUseParts);

/// The parts of a [`StageUse`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StageUseParts {
    /// The joints; `None` for all.
    pub joints: Option<Vec<JointIndex>>,
    /// The member's values.
    pub values: [f32; 4],
}

impl StageUse {
    /// Runs the stage for all joints.
    #[must_use]
    pub fn on_all() -> Self {
        Self::default()
    }

    /// Runs the stage for the given joints.
    #[must_use]
    pub fn on(joints: impl IntoIterator<Item = JointIndex>) -> Self {
        let joints = Some(joints.into_iter().collect());
        Self(StageUseParts { joints, ..StageUseParts::default() })
    }

    /// Sets the member's values, which the stage reads as `values`; 0 unless set.
    #[must_use]
    pub fn with_values(mut self, values: [f32; 4]) -> Self {
        self.0.values = values;
        self
    }
}
