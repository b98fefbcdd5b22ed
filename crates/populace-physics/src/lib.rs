//! Ragdolls for crowds. A member goes limp with its current pose and velocity, is simulated by
//! `rapier3d`, and gets up again with a motion, or by blending back to its clips. A part of a
//! member, such as an arm, can go limp alone.
//!
//! Axes and units are those of [`populace`]: right-handed, Y up, metres, seconds, radians. Masses
//! are in kg, impulses in newton-seconds. Bodies are simulated in world space, so placements must
//! be in world space too.
//!
//! ```
//! use std::sync::Arc;
//!
//! use populace::{ClipPlayback, Crowd, Device, Placement};
//! use populace_physics::{GetUp, RagdollPlan, Ragdolls, State};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mut crowd = Crowd::builder().device(Device::native()).capacity(10).build()?;
//! let man = crowd.add_character(populace_cast::person(&populace_cast::Look::man())?)?;
//! let walk = crowd.clip(man, "Walk")?;
//! let member = crowd.spawn(man, Placement::at([0.0; 3]))?;
//! crowd.member_mut(member)?.play(walk, ClipPlayback::looping())?;
//! crowd.update(0.1)?;
//!
//! let plan = Arc::new(RagdollPlan::from_skeleton(&crowd.character(man)?.asset().skeleton));
//! let chest = crowd.character(man)?.asset().skeleton.find("Spine4").unwrap();
//! let mut ragdolls = Ragdolls::new([0.0, -9.81, 0.0])?;
//! ragdolls.go_limp(&crowd, member, &plan)?;
//! ragdolls.push(member, chest, [0.0, 0.0, -60.0], None)?;
//! for _ in 0..90 {
//!     ragdolls.step(&mut crowd, 1.0 / 60.0)?; // writes overrides for the update that follows
//!     crowd.update(1.0 / 60.0)?;
//! }
//! let hips = crowd.member_mut(member)?.model_from_joints()?[0];
//! assert!(hips.rows[1][3] < 0.4, "he lies on the ground");
//!
//! let motions = GetUp::find(&crowd, man); // those of the built-in people
//! ragdolls.get_up_with(&mut crowd, member, &motions)?;
//! for _ in 0..330 {
//!     ragdolls.step(&mut crowd, 1.0 / 60.0)?;
//!     crowd.update(1.0 / 60.0)?;
//! }
//! assert_eq!(ragdolls.state(member), State::Animated);
//! # Ok(())
//! # }
//! ```
//!
//! # Design
//!
//! A limp member is moved by joint overrides only. The joints rotate against their parents like the
//! simulated bodies and keep their lengths and scales; only the first joint gets a position in
//! model space. So a limp member keeps its buffers, handle and rendering path, its joints never
//! come apart, and it can blend back joint by joint. A motion for getting up plays on a layer above
//! what the member plays, which goes on beneath.

mod error;
mod math;
mod member_ragdoll;
mod motion;
mod plan;
mod ragdolls;
mod snapshot;
mod world;

pub use error::Error;
pub use member_ragdoll::JointAngles;
pub use plan::{Limits, PlannedBody, RagdollPlan};
pub use ragdolls::{GetUp, Ragdolls, State};

/// The page on ragdolls, its program compiled as a test.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/ragdolls.md")]
pub struct RagdollsPage;
