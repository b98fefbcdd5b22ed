//! Data model of an animated crowd: [`Skeleton`], [`Clip`], [`AnimationSet`], [`Character`], slots,
//! layers and masks, the struct layouts shared by host and devices ([`layout`]), the tables that a
//! device evaluates ([`Tables`]) and the trait that every device implements ([`Backend`]).
//!
//! Spaces and units follow glTF 2.0: right-handed, Y up, +Z front, metres, seconds, radians,
//! quaternions as `x y z w`. A transform is named `to_from`, so that inner names cancel:
//! `model_from_bind = model_from_joint * joint_from_bind`. *Local* space is relative to the parent
//! joint, *model* space to the character's root, *world* space to the scene.
//!
//! ```
//! use populace_core::{JointSource, Skeleton, Trs};
//!
//! let joint = |name: &str, parent| JointSource { name: name.into(), parent, rest: Trs::IDENTITY };
//! let skeleton = Skeleton::new(&[joint("head", Some(1)), joint("hips", None)])?;
//! assert_eq!(skeleton.name(skeleton.joint_from_source(0)), "head");
//! assert_eq!(skeleton.parent(skeleton.joint_from_source(0)), Some(skeleton.joint_from_source(1)));
//!
//! let cyclic = Skeleton::new(&[joint("a", Some(1)), joint("b", Some(0))]);
//! assert!(cyclic.unwrap_err().to_string().contains("its own ancestor"));
//! # Ok::<(), populace_core::Error>(())
//! ```
//!
//! Design decision: skeletons are sorted breadth first on import ("level order"). On every device a
//! parent's transform is therefore ready before its children need it, and all joints of one depth
//! form one contiguous range (Lister & Day 2012, section 3.1, fig. 2).

mod animation_set;
pub mod backend;
mod character;
mod clip;
mod control;
mod error;
mod f64math;
mod hand_over;
mod humanoid;
pub mod layout;
pub mod math;
mod names;
mod playback;
mod rehang;
mod retarget;
mod skeleton;
mod soles;
mod stage;
mod tables;
mod track;

pub use animation_set::{AnimationSet, ClipIndex};
pub use backend::{Backend, BackendError, Frame, Schedule, Stage, StageBuffer};
pub use character::{
    AlphaMode, Bounds, Character, CharacterSource, Image, Influences, Material, Mesh, PaletteEntry,
    Part, SkinInstance, Texture, TextureFilter, Wrap, vertex_reach_m,
};
pub use clip::{
    Binding, BindingMethod, BindingReport, Clip, ClipStats, Footstep, LiveRing, LiveSettings,
    MotionOrigin, MotionSettings, MotionSource, RootMotion, Streamed,
};
pub use control::{
    Chain, Constraint, Controls, Feet, Foot, Gaze, GazeLimits, JointOverride, Limb, Place, Space,
};
pub use error::Error;
pub use hand_over::{
    EglHandles, GlContext, HandedOver, MappedPage, PAGE_SETS, PaletteSource, PaletteTarget,
    PaletteTransport, SharedPage, TargetMark,
};
pub use humanoid::{Finger, Phalanx, Role, RoleMap, Side};
pub use math::{Affine, LARGEST, LARGEST_SCALE, Trs};
pub use names::{UnknownName, did_you_mean, nearest_names};
pub use playback::{
    FIRST_TICK, LayerMode, LayerSettings, MAX_LAYERS, MAX_SLOTS, Mask, SampledState, TICKS_PER_SEC,
    far_row, row_before, ticks_from_secs,
};
pub use skeleton::{JointIndex, JointSource, Skeleton};
pub use soles::sole_points;
pub use stage::{After, StageFn, StageJoint, StageUse, UserStage};
pub use tables::{
    BodyIndex, Condition, Ground, LiveNewest, MachineState, Table, Tables, Transition,
};
pub use track::{ClipSource, Interpolation, Property, Track};
