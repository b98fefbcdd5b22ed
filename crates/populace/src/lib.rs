//! Crowds in which every member has the full character pipeline: its own clips, blends and layers,
//! evaluated afresh each frame on the CPU or on an OpenCL device, with palettes ready to be drawn
//! from.
//!
//! Spaces and units: right-handed, Y up, +Z front, metres, seconds, radians. A member's *model*
//! space is placed in the *world* by its [`Placement`].
//!
//! ```
//! use populace::{Crowd, Device, Placement, Play};
//! # use populace::core::{CharacterSource, Character, Clip, ClipSource, Interpolation, JointSource, PaletteEntry,
//! #     JointIndex, Affine, Property, Skeleton, Track, Trs};
//! # let joint = JointSource { name: "hips".into(), parent: None, rest: Trs::IDENTITY };
//! # let skeleton = Skeleton::new(&[joint])?;
//! # let track = Track { joint: "hips".into(), property: Property::Translation, interpolation: Interpolation::Linear,
//! #     times: vec![0.0, 1.0], values: vec![0.0, 0.0, 0.0, 0.0, 2.0, 0.0] };
//! # let clip = Clip::new(ClipSource { name: "Rise".into(), tracks: vec![track] }, &skeleton)?;
//! # let knight = Character::new(CharacterSource { name: "knight".into(),
//! #     palette: vec![PaletteEntry { joint: JointIndex(0), joint_from_bind: Affine::IDENTITY }],
//! #     skeleton, parts: vec![], materials: vec![], images: vec![], skins: vec![], clips: vec![clip.into()] })?;
//! let mut crowd = Crowd::builder().device(Device::native()).capacity(100).build()?;
//! let knight = crowd.add_character(knight)?;
//! let rise = crowd.clip(knight, "Rise")?;
//! let member = crowd.spawn(knight, Placement::at([3.0, 0.0, 5.0]).facing(0.5))?;
//! crowd.play(member, rise, Play::once())?;
//! crowd.update(0.5)?;
//! let hips = crowd.model_from_joints(member)?[0];
//! assert!((hips.rows[1][3] - 1.0).abs() < 1e-3, "half way up");
//!
//! let error = crowd.clip(knight, "Raise").unwrap_err();
//! assert_eq!(error.to_string(), "\"knight\" has no clip \"Raise\"; did you mean \"Rise\"?");
//! # Ok::<(), populace::Error>(())
//! ```
//!
//! The main decision: the host keeps the truth in plain tables and devices take over what changed,
//! so a crowd can move to another device, and everything a device computes can be computed by every
//! other.

mod blend_space;
mod control;
mod crowd;
mod device;
mod error;
mod machine;
mod play;
mod split;
mod stage;

pub use populace_core as core;
pub use populace_core::{
    Affine, After, BackendError, BindingMethod, BindingReport, Feet, Foot, Gaze, GazeLimits,
    Ground, JointIndex, JointOverride, LayerMode, LayerSettings, LiveSettings, Mask, MotionOrigin,
    MotionSettings, MotionSource, Schedule, Space, StageJoint, Streamed, Trs, UserStage,
    nearest_names,
};

pub use blend_space::{BlendSpace, SpacePoint};
pub use control::{Reach, Target, Weight};
pub use crowd::{
    CharacterId, ClipId, Crowd, CrowdBuilder, Event, EventKind, Instance, MachineId, MaskId,
    Member, PlayId, Sighting, SpaceId, StageId, Watch,
};
pub use device::{Device, DeviceReport, Devices, Split, devices};
pub use error::Error;
pub use machine::{Condition, StateMachine};
pub use play::{Placement, Play, Playing};
pub use stage::StageUse;

/// The library as the README shows it, compiled as a test.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
pub struct Readme;

/// The page on animation, its programs compiled as tests.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/animation.md")]
pub struct AnimationPage;
