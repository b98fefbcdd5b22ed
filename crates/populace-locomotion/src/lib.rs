//! People who walk where and how fast they are told: gaits of clips on any body, walkers, and local
//! avoidance.

pub mod avoidance;
mod contacts;
mod error;
mod feet;
mod footing;
mod gait;
mod gait_clips;
mod gait_space;
mod mix;
mod path;
mod skate;
mod soles;
mod step;
mod steps;
mod strides;
mod treads;
mod walker;
mod walkers;

pub use contacts::Contact;
pub use error::Error;
pub use footing::LedStep;
pub use gait::Gait;
pub use gait_clips::GaitClips;
pub use gait_space::GaitSpace;
pub use mix::MixedClip;
pub use path::Path;
pub use skate::{FootSkate, Skate, SkateMeter};
pub use step::Step;
pub use walker::{Lead, WalkerSettings};
pub use walkers::{Goal, UpdateTimes, Walkers};

/// The page on locomotion, its program compiled as a test.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/locomotion.md")]
pub struct LocomotionPage;
