//! The faults that errors of the library carry: what is wrong, with ids, counts and ranges.

use std::fmt;

use populace_device::layout::MACHINE_PARAMETERS;
use populace_model::did_you_mean;

/// The kind of thing that an id names.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum IdKind {
    /// A character.
    Character,
    /// A clip.
    Clip,
    /// A mask of a character.
    Mask,
    /// A blend space.
    BlendSpace,
    /// A state machine.
    Machine,
    /// A user stage.
    Stage,
    /// A member.
    Member,
    /// A playback of a member.
    Playback,
    /// A watch of a joint.
    Watch,
}

impl fmt::Display for IdKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Character => "character",
            Self::Clip => "clip",
            Self::Mask => "mask",
            Self::BlendSpace => "blend space",
            Self::Machine => "state machine",
            Self::Stage => "stage",
            Self::Member => "member",
            Self::Playback => "playback",
            Self::Watch => "watch",
        })
    }
}

impl IdKind {
    /// The thing that returns ids of this kind.
    pub(crate) const fn owner(self) -> &'static str {
        match self {
            Self::Mask => "character",
            _ => "crowd",
        }
    }
}

/// The user of an asset that cannot be removed.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
pub enum User {
    /// A member of the character.
    #[error("a member; despawn its members first")]
    Member,
    /// A member that plays it, or is scheduled to.
    #[error(
        "a member that plays it or is scheduled to; stop it there first, and wait until it has \
         faded out"
    )]
    Playback,
    /// A layer of a member.
    #[error("a layer of a member; set that layer without it first")]
    Layer,
    /// A blend space.
    #[error("a blend space; remove that first")]
    BlendSpace,
    /// A state machine.
    #[error("a state machine; remove that first")]
    Machine,
}

/// The values that a number may have.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Allowed {
    /// A range, both ends included.
    #[error("from {least} to {most}")]
    Range {
        /// The least.
        least: f64,
        /// The most.
        most: f64,
    },
    /// A finite number of at most this size.
    #[error("a finite number of at most {most:e} in size")]
    Size {
        /// The largest.
        most: f32,
    },
    /// Any finite number.
    #[error("a finite number")]
    Finite,
    /// A count up to this one.
    #[error("at most {0}")]
    AtMost(usize),
    /// A count: this one.
    #[error("{0}")]
    Exactly(usize),
    /// A number above zero and at most this large.
    #[error("above zero and at most {most:e}")]
    AboveZero {
        /// The largest.
        most: f32,
    },
    /// A direction of some length.
    #[error("of some length")]
    SomeLength,
}

/// The defect of a blend space, or of a call to it.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BlendSpaceFault {
    /// No samples, or more than 1,000.
    #[error("needs 1 to 1,000 samples")]
    SampleCount(usize),
    /// Two samples on a line at one value.
    #[error("has two samples at one value; put each at its own")]
    SameValue(f32),
    /// Two samples in a plane at one point.
    #[error("has two samples at one point; put each at its own")]
    SamePoint([f32; 2]),
    /// An offset for a clip that is not among the samples.
    #[error("does not have the clip that an offset is given for")]
    NoSuchClip,
    /// A live clip.
    #[error("has the live clip \"{0}\", which has no cycle to share; leave it out")]
    LiveClip(String),
    /// More slots than members have.
    #[error("takes {needed} slots, but members have {slots}; see CrowdBuilder::slots_per_member")]
    Slots {
        /// Slots that the blend space takes.
        needed: usize,
        /// Slots of each member.
        slots: usize,
    },
    /// A member that plays none.
    #[error("parameter cannot be set: the member plays no blend space")]
    NotPlaying,
}

/// The part of a state machine that a name names.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MachinePart {
    /// A state.
    State,
    /// A parameter.
    Parameter,
}

impl fmt::Display for MachinePart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::State => "state",
            Self::Parameter => "parameter",
        })
    }
}

/// The defect of a state machine, or of a call to it.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MachineFault {
    /// No states.
    #[error("has no states; add one by StateMachine::state")]
    NoStates,
    /// More parameters than fit.
    #[error("has {0} parameters; {MACHINE_PARAMETERS} are the most")]
    TooManyParameters(usize),
    /// A name that occurs twice.
    #[error("has two {part}s \"{name}\"; give each a name of its own")]
    Duplicate {
        /// The part.
        part: MachinePart,
        /// The name.
        name: String,
    },
    /// A name that does not exist.
    #[error("has no {part} \"{name}\"{}", did_you_mean(nearest))]
    Unknown {
        /// The part.
        part: MachinePart,
        /// The name.
        name: String,
        /// Similar names, nearest first.
        nearest: Vec<String>,
    },
    /// A transition that waits for the end of a clip that has none.
    #[error(
        "waits in \"{state}\" for the end of a clip that has none; play it by StatePlayback::once()"
    )]
    NoEnd {
        /// The state.
        state: String,
    },
    /// Members with one slot.
    #[error("takes 2 slots, but members have 1; see CrowdBuilder::slots_per_member")]
    Slots,
    /// A parameter of a machine that the member does not run.
    #[error("of this parameter is not run by the member; start it with play_machine")]
    OtherMachine,
    /// A member that runs none.
    #[error(
        "parameter cannot be set: the member runs no state machine; start one with play_machine"
    )]
    NotRunning,
    /// A layer whose machine starts later.
    #[error(
        "of layer {layer} has not started yet; ask for its state after the update in which it \
         starts"
    )]
    NotStarted {
        /// The layer.
        layer: usize,
    },
    /// A layer that runs none.
    #[error("of layer {layer} has no state: the layer runs no state machine")]
    NoMachine {
        /// The layer.
        layer: usize,
    },
}

/// The reason why an attachment is not possible.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AttachmentFault {
    /// A placement for an attached member.
    #[error(
        "an attached member has the placement of its parent; place the parent, or detach the \
         member first"
    )]
    Placed,
    /// A parent without a mesh.
    #[error(
        "nothing can be attached to a member of \"{character}\": it has no mesh, so devices do not \
         evaluate it"
    )]
    NoMesh {
        /// The character's name.
        character: String,
    },
    /// A member attached to itself, or to its own attachments.
    #[error("a member cannot be attached to itself or to its own attachments; detach those first")]
    Circle,
    /// A chain of attachments that is too long.
    #[error(
        "attachments would be {levels} levels deep; at most {most} are possible, so attach this \
         member nearer to the first of the chain"
    )]
    TooDeep {
        /// Levels of attachments.
        levels: u32,
        /// The most that are possible.
        most: u32,
    },
}
