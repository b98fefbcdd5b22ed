//! The ids, settings and errors of a crowd's calls.
//!
//! Users get these types from `populace`. To them an id is opaque, and a setting can be set but not
//! read. The module [`parts`] is for the crowd, which makes ids and carries settings out.

mod blend_space;
mod check;
mod control;
mod error;
mod fault;
mod feet;
mod ids;
mod machine;
pub mod parts;
mod placement;
mod playback;
mod stage;

pub use blend_space::{BlendSpace, SpacePoint};
pub use control::{Gaze, Reach, Target, Weight};
pub use error::Error;
pub use fault::{
    Allowed, AttachmentFault, BlendSpaceFault, IdKind, MachineFault, MachinePart, User,
};
pub use feet::{Contact, Stride};
pub use ids::{
    BlendSpaceId, CharacterId, ClipId, MachineId, MaskId, MemberId, Parameter, ParameterId,
    PlaybackId,
};
pub use machine::{Condition, StateMachine};
pub use placement::Placement;
pub use playback::{ActiveClip, BlendSpacePlayback, ClipPlayback, MachinePlayback, StatePlayback};
pub use stage::StageUse;
