//! The oracle: what a character looks like at a time, in double precision, from source curves and
//! equations.
//!
//! One file per stage, named after it: `evaluate.rs`, `pose.rs` (with `sample.rs`, the curves),
//! `transform.rs` and `write_back.rs`. Joints are in the order of the source list, not in level
//! order; nothing is flattened or packed.

mod evaluate;
mod inertialize;
mod pose;
mod retarget;
mod sample;
#[cfg(test)]
mod tests;
mod transform;
mod write_back;

use glam::{DAffine3, DQuat, DVec3};
use populace_character::{Character, PaletteEntry};
use populace_device::LayerMode;
use populace_model::{ClipSource, JointSource, Skeleton};

pub use evaluate::{Timing, Weighting};
pub use inertialize::{OracleInertialization, OracleStand};
pub use pose::Gain;
pub use retarget::OracleRetarget;
pub use sample::{slerp, track_value};
pub use transform::model_from_joints;
pub use write_back::palettes;

/// A local transform in double precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Local {
    /// Metres.
    pub translation: DVec3,
    /// Unit quaternion.
    pub rotation: DQuat,
    /// Factors along the joint's own axes.
    pub scale: DVec3,
}

/// A skeleton and its palette entries, as the source lists them.
#[derive(Clone, Debug)]
pub struct OracleBody {
    /// Joints in the order of the source, parents anywhere.
    pub joints: Vec<JointSource>,
    /// Source index of the joint, and `joint_from_bind` as 3x4, row-major.
    pub palette: Vec<(usize, [f64; 12])>,
}

impl OracleBody {
    /// From a skeleton and the palette entries on it.
    #[must_use]
    pub fn from_skeleton(skeleton: &Skeleton, palette: &[PaletteEntry]) -> Self {
        let joints = (0..skeleton.joint_count())
            .map(|source| {
                let joint = skeleton.joint_from_source(source);
                JointSource {
                    name: skeleton.name(joint).to_owned(),
                    parent: skeleton.parent(joint).map(|p| skeleton.source_from_joint(p)),
                    rest: *skeleton.rest(joint),
                }
            })
            .collect();
        let palette = palette
            .iter()
            .map(|entry| {
                let flat = entry.joint_from_bind.rows.as_flattened();
                let wide = std::array::from_fn(|element| f64::from(flat[element]));
                (skeleton.source_from_joint(entry.joint), wide)
            })
            .collect();
        Self { joints, palette }
    }

    /// From a character.
    #[must_use]
    pub fn from_character(character: &Character) -> Self {
        Self::from_skeleton(&character.skeleton, &character.palette)
    }

    /// The rest pose of a joint.
    ///
    /// # Panics
    ///
    /// If there is no such joint.
    #[must_use]
    pub fn rest(&self, joint: usize) -> Local {
        let rest = &self.joints[joint].rest;
        Local {
            translation: DVec3::from_array(rest.translation.map(f64::from)),
            rotation: DQuat::from_array(rest.rotation.map(f64::from)).normalize(),
            scale: DVec3::from_array(rest.scale.map(f64::from)),
        }
    }
}

/// A playing clip at one instant.
#[derive(Clone, Copy, Debug)]
pub struct OracleSlot<'a> {
    /// The motion as its file states it.
    pub clip: &'a ClipSource,
    /// Time on the clip's own axis.
    pub time_secs: f64,
    /// Weight; nothing happens at 0 and below.
    pub weight: f64,
    /// The layer that the slot is mixed in.
    pub layer: usize,
    /// How the clip moves a body that it was not made for; else it moves the joints whose names it
    /// knows.
    pub retarget: Option<&'a OracleRetarget>,
}

/// A layer at one instant.
#[derive(Clone, Debug, PartialEq)]
pub struct OracleLayer {
    /// How it meets what lies beneath; not looked at in layer 0.
    pub mode: LayerMode,
    /// From 0 to 1; not looked at in layer 0.
    pub weight: f64,
    /// A weight per joint, in the order of the source; not looked at in layer 0.
    pub mask: Option<Vec<f64>>,
}

impl Default for OracleLayer {
    fn default() -> Self {
        Self { mode: LayerMode::Override, weight: 1.0, mask: None }
    }
}

/// A character at one instant; joints in the order of the source.
#[derive(Clone, Debug)]
pub struct OraclePose {
    /// Local transforms.
    pub locals: Vec<Local>,
    /// How much an error in a clip's value grows on its way into each local transform.
    pub gains: Vec<Gain>,
    /// Model space.
    pub model_from_joint: Vec<DAffine3>,
    /// `model_from_bind` of each palette entry, 3x4, row-major.
    pub palette: Vec<[f64; 12]>,
}

/// A character's pose. `layers` are all layers in use, in order; without any, slots of layer 0 are
/// mixed.
///
/// # Panics
///
/// If the joints have a cycle, or a mask is not one weight per joint.
#[must_use]
pub fn evaluate(body: &OracleBody, slots: &[OracleSlot<'_>], layers: &[OracleLayer]) -> OraclePose {
    evaluate_inertialization(body, slots, &[], layers)
}

/// The same where clips that were left still inertialize.
///
/// # Panics
///
/// As [`evaluate`].
#[must_use]
pub fn evaluate_inertialization(
    body: &OracleBody,
    slots: &[OracleSlot<'_>],
    inertialization: &[OracleInertialization<'_>],
    layers: &[OracleLayer],
) -> OraclePose {
    let (locals, gains) = pose::pose(body, slots, inertialization, layers);
    let model_from_joint = model_from_joints(body, &locals);
    let palette = palettes(body, &model_from_joint);
    OraclePose { locals, gains, model_from_joint, palette }
}
