//! Animated bodies as plain data: [`Skeleton`], [`Track`], [`Mask`] and humanoid [`Role`]s, and the
//! arithmetic of transforms.
//!
//! Spaces and units follow glTF 2.0: right-handed, Y up, +Z front, metres, seconds, radians,
//! quaternions as `x y z w`. A transform is named `to_from`, so that inner names cancel:
//! `model_from_bind = model_from_joint * joint_from_bind`. *Local* space is relative to the parent
//! joint, *model* space to the character's root, *world* space to the scene.
//!
//! ```
//! use populace_model::{JointSource, Skeleton, Trs};
//!
//! let joint = |name: &str, parent| JointSource { name: name.into(), parent, rest: Trs::IDENTITY };
//! let skeleton = Skeleton::new(&[joint("head", Some(1)), joint("hips", None)])?;
//! assert_eq!(skeleton.name(skeleton.joint_from_source(0)), "head");
//! assert_eq!(skeleton.parent(skeleton.joint_from_source(0)), Some(skeleton.joint_from_source(1)));
//!
//! let cyclic = Skeleton::new(&[joint("a", Some(1)), joint("b", Some(0))]);
//! assert!(cyclic.unwrap_err().to_string().contains("its own ancestor"));
//! # Ok::<(), populace_model::Error>(())
//! ```
//!
//! Design decision: skeletons are sorted breadth first on import ("level order"). On every device a
//! parent's transform is therefore ready before its children need it, and all joints of one depth
//! form one contiguous range (Lister & Day 2012, section 3.1, fig. 2).

pub mod convert;
mod error;
mod error_kind;
pub mod f64math;
pub mod humanoid;
mod joint;
mod legs;
mod mask;
pub mod math;
mod names;
mod property;
mod role;
mod skeleton;
mod track;

pub use error::{Error, RoleFault, TrackFault};
pub use error_kind::ErrorKind;
pub use humanoid::RoleMap;
pub use joint::JointIndex;
pub use mask::Mask;
pub use math::{Affine, LARGEST, LARGEST_SCALE, Trs};
pub use names::{UnknownName, did_you_mean, nearest_names};
pub use property::Property;
pub use role::{Finger, Phalanx, Role, Side};
pub use skeleton::{JointSource, Skeleton};
pub use track::{ClipSource, Interpolation, Track};
