//! The data that devices evaluate and the contracts they keep: struct layouts shared with kernels
//! ([`layout`]), [`Tables`] of members, slots, layers and controls, the trait of every device
//! ([`Backend`]), buffer interop of palettes with OpenGL ([`PaletteSource`], [`SharedPage`]),
//! and what is drawn with them ([`DrawSource`]).
//!
//! Slots are closed-form: what a member plays at any tick of the clock follows from its
//! [`Slot`](layout::Slot)s alone, on the host and on every device.

pub mod backend;
mod backend_error;
mod control;
mod error;
mod fault;
mod instance;
mod interop;
mod lanes;
pub mod layout;
mod look;
mod place;
mod playback;
mod stage;
mod stage_buffer;
mod tables;
mod view;

pub use backend::{Backend, Frame, Schedule};
pub use backend_error::BackendError;
pub use control::{
    Chain, Constraint, Controls, Feet, Foot, Gaze, GazeLimits, JointOverride, Limb, Space,
};
pub use error::Error;
pub use fault::{ConstraintFault, ConstraintPart, StageFault};
pub use instance::{DrawSource, Instance};
pub use interop::{
    EglHandles, GlContext, MappedPage, PAGE_SETS, PaletteSource, PaletteTarget, PaletteTransport,
    ReleasedPalettes, SharedPage, TargetMark, driver_start,
};
pub use lanes::lanes_allowed;
pub use look::MemberLook;
pub use place::Place;
pub use playback::{
    LayerMode, LayerSettings, MAX_LAYERS, MAX_SLOTS, SampledState, far_row, row_before,
};
pub use stage::{After, StageFn, StageJoint, StageUse, UserStage};
pub use stage_buffer::{Stage, StageBuffer};
pub use tables::{
    BodyIndex, Condition, Epochs, Ground, LiveNewest, MachineState, Table, Tables, Transition,
};
pub use view::{Culling, VIEW_PLANES, View, Visibility};
