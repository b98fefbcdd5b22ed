//! The stages of a frame, and what each leaves for the next.

/// A stage of a frame. Pose, Transform and Write-Back are the three kernels of Lister & Day 2012,
/// section 3, fig. 1. Evaluate is added because slots are closed-form.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stage {
    /// Finds the rows and the weight of each slot from the clock.
    Evaluate,
    /// Mixes each member's slots, layer by layer, into local transforms.
    Pose,
    /// Multiplies local transforms down the hierarchy.
    Transform,
    /// Multiplies by `joint_from_bind`, which gives the matrix palettes.
    WriteBack,
}

impl Stage {
    /// All stages in the order they run.
    pub const ALL: [Self; 4] = [Self::Evaluate, Self::Pose, Self::Transform, Self::WriteBack];

    /// The stage's name in code, kernels and tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Evaluate => "evaluate",
            Self::Pose => "pose",
            Self::Transform => "transform",
            Self::WriteBack => "write_back",
        }
    }
}

/// Buffers that stages write for later stages. Each element is 16 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StageBuffer {
    /// [`SlotSample`](crate::layout::SlotSample)s, `members x slots`, slots fastest.
    Samples,
    /// The joint buffer's local translations, `x y z 0`, joints fastest.
    Translations,
    /// The joint buffer's local rotations, `x y z w`.
    Rotations,
    /// The joint buffer's local scales, `x y z 0`.
    Scales,
    /// First rows of `model_from_joint`. Rows are kept in separate arrays. Matrices are needed
    /// because a rotated child under non-uniform scale shears, which translation, rotation and
    /// scale cannot express.
    ModelRow0,
    /// Second rows.
    ModelRow1,
    /// Third rows.
    ModelRow2,
    /// The matrix palettes: three elements for each palette entry.
    Palette,
    /// History of members with constraint programs, kept from frame to frame:
    /// [`STATES_PER_CONTROL`](crate::layout::STATES_PER_CONTROL) elements per control.
    States,
    /// Watched joints: three rows of `world_from_joint` each, or of `model_from_joint` for joints
    /// that members are attached to.
    Watched,
    /// State of state machines: a [`Running`](crate::layout::Running) in three elements per machine
    /// instance.
    Running,
}

impl StageBuffer {
    /// All buffers.
    pub const ALL: [Self; 11] = [
        Self::Samples,
        Self::Translations,
        Self::Rotations,
        Self::Scales,
        Self::ModelRow0,
        Self::ModelRow1,
        Self::ModelRow2,
        Self::Palette,
        Self::States,
        Self::Watched,
        Self::Running,
    ];
}
