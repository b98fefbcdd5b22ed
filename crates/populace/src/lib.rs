//! Crowds in which every member has the full character pipeline: its own clips, blends and layers,
//! evaluated afresh each frame on the CPU or on an OpenCL device, with palettes ready to be drawn
//! from.
//!
//! Spaces and units: right-handed, Y up, +Z front, metres, seconds, radians. A member's *model*
//! space is placed in the *world* by its [`Placement`].
//!
//! ```
//! use populace::{ClipPlayback, Crowd, Device, Placement};
//! let mut crowd = Crowd::builder().device(Device::native()).capacity(100).build()?;
//! # let knight = populace::doc_fixture::knight(&mut crowd)?;
//! let rise = crowd.clip(knight, "Rise")?;
//! let member = crowd.spawn(knight, Placement::at([3.0, 0.0, 5.0]).facing(0.5))?;
//! crowd.member_mut(member)?.play(rise, ClipPlayback::once())?;
//! crowd.update(0.5)?;
//! let hips = crowd.member_mut(member)?.model_from_joints()?[0];
//! assert!((hips.rows[1][3] - 1.0).abs() < 1e-3, "half way up");
//!
//! let error = crowd.clip(knight, "Raise").unwrap_err();
//! let wanted = "\"knight\" has no clip \"Raise\"; did you mean \"Rise\" or \"Wave\"?";
//! assert_eq!(error.to_string(), wanted);
//! # Ok::<(), populace::Error>(())
//! ```
//!
//! The main decision: the host keeps the truth in plain tables and devices take over what changed,
//! so a crowd can move to another device, and everything a device computes can be computed by every
//! other.

mod crowd;
#[doc(hidden)]
pub mod doc_fixture;

pub use populace_backends::{
    Device, DeviceReport, Devices, DevicesFault, Error as DevicesError, Split, SplitFault, devices,
};
pub use populace_clip::{LiveSettings, MotionOrigin, MotionSettings, MotionSource, Streamed};
pub use populace_device::{
    After, BackendError, ConstraintFault, ConstraintPart, Error as TablesError, Feet, Foot,
    GazeLimits, Ground, Instance, JointOverride, LayerMode, LayerSettings, MAX_LAYERS, MAX_SLOTS,
    MemberLook, Schedule, Space, Stage, StageFault, StageJoint, UserStage,
};
pub use populace_model::{Affine, ErrorKind, JointIndex, Mask, Trs, nearest_names};
pub use populace_retarget::{BindingMethod, BindingReport};
#[doc(inline)]
pub use populace_settings::{
    ActiveClip, Allowed, AttachmentFault, BlendSpace, BlendSpaceFault, BlendSpaceId,
    BlendSpacePlayback, CharacterId, ClipId, ClipPlayback, Condition, Contact, Error, Gaze, IdKind,
    MachineFault, MachineId, MachinePart, MachinePlayback, MaskId, MemberId, Parameter,
    ParameterId, Placement, PlaybackId, Reach, SpacePoint, StageUse, StateMachine, StatePlayback,
    Stride, Target, User, Weight,
};

pub use crowd::{
    AssetId, CharacterMut, CharacterRef, ClipMut, Crowd, CrowdBuilder, DeviceInfo, Event,
    EventKind, FrameTimes, History, JointReadback, MemberMut, MemberRef, MemberView, SeekReport,
    Snapshot, StageId, ViewStatistics, VisibleMember, Watch,
};

/// Skeletons, tracks, masks and humanoid roles.
pub mod model {
    pub use populace_model::{
        Affine, ClipSource, Error, Finger, Interpolation, JointIndex, JointSource, LARGEST,
        LARGEST_SCALE, Mask, Phalanx, Property, Role, RoleFault, RoleMap, Side, Skeleton, Track,
        TrackFault, Trs, UnknownName, did_you_mean, nearest_names,
    };

    /// Arithmetic of quaternions and vectors, as devices do it.
    pub mod math {
        pub use populace_model::math::{Real, quat, vec3};
    }
}

/// Clips and the clock of playback.
pub mod clip {
    pub use populace_clip::{
        Clip, ClipStats, Error, Footstep, LiveFault, LiveSettings, MotionFault, MotionOrigin,
        MotionSettings, MotionSource, RootMotion, Streamed, TICKS_PER_SEC, ticks_from_secs,
    };
}

/// Characters: skeletons with meshes, materials and clips.
pub mod character {
    pub use populace_character::{
        AlphaMode, Bounds, Character, CharacterSource, Error, Image, Influences, Level,
        MAX_OPTIONS, Material, Mesh, PaletteEntry, Part, PartOption, Region, RegionFinder,
        SkinInstance, Texture, TextureFilter, Wrap, joints_needed, linear_from_srgb, sole_points,
        vertex_reach_m,
    };
}

/// Bindings of clips to skeletons that they were not made for.
pub mod retarget {
    pub use populace_retarget::{Binding, BindingFault, BindingMethod, BindingReport, Error};
}

/// Buffer interop of palettes with renderers.
pub mod interop {
    pub use populace_device::layout::{Float4, PAGE_ENTRIES};
    pub use populace_device::{
        DrawSource, EglHandles, GlContext, MappedPage, PAGE_SETS, PaletteSource, PaletteTarget,
        PaletteTransport, ReleasedPalettes, SharedPage, TargetMark, VIEW_PLANES, View, Visibility,
    };
}

/// The library as the README shows it, compiled as a test.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
pub struct Readme;

/// The page on animation, its programs compiled as tests.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/animation.md")]
pub struct AnimationPage;

/// The page on films, its program compiled as a test.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/films.md")]
pub struct FilmsPage;
