//! The oracle: evaluates one character at one time in double precision, from its source curves and
//! the equations of glTF 2.0.
//!
//! Each stage has a file of its name: `evaluate.rs`, `pose.rs`, `transform.rs` and
//! `write_back.rs`. `pose.rs` relies on `sample.rs` for curves, `inertialize.rs` for transitions
//! and `retarget.rs` for clips of other bodies. Joints are in source order, not in level order, and
//! no data is flattened or packed.

mod contacts;
mod controls;
mod evaluate;
mod ground;
mod inertialize;
mod local;
mod machine;
mod motion;
mod noise;
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

pub use contacts::OracleSteps;
pub use controls::{
    OracleFrame, OracleGait, OracleMember, OraclePlace, OracleStage, OracleStageInputs,
    OracleStance,
};
pub use evaluate::{Timing, Weighting};
pub use ground::OracleGround;
pub use inertialize::{OracleInertialization, OracleSampledState};
pub use local::{Gain, Local};
pub use machine::{OracleCourse, OracleEntry};
pub use motion::{OracleChange, OracleMover, OracleTravel};
pub use noise::{Bounded, Noise, bounded};
pub use retarget::OracleRetarget;
pub use sample::{slerp, track_value};
pub use transform::model_from_joints;
pub use write_back::{palettes, palettes_with};

/// A skeleton and its palette entries in source order.
#[derive(Clone, Debug)]
pub struct OracleBody {
    /// Joints in source order; a parent may come after its children.
    pub joints: Vec<JointSource>,
    /// The source index of each entry's joint, and `joint_from_bind` as 3x4, row-major.
    pub palette: Vec<(usize, [f64; 12])>,
}

impl OracleBody {
    /// Copies a skeleton and its palette entries.
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

    /// Copies the skeleton and the palette entries of a character.
    #[must_use]
    pub fn from_character(character: &Character) -> Self {
        Self::from_skeleton(&character.skeleton, &character.palette)
    }

    /// Returns the rest transform of a joint.
    ///
    /// # Panics
    ///
    /// If `joint` is out of range.
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

/// A slot: a playing clip at one instant.
#[derive(Clone, Copy, Debug)]
pub struct OracleSlot<'a> {
    /// The motion as its file states it.
    pub clip: &'a ClipSource,
    /// Time on the clip's own axis.
    pub time_secs: f64,
    /// Weight; a slot of weight 0 or below has no effect.
    pub weight: f64,
    /// Index of the slot's layer.
    pub layer: usize,
    /// Retargeting of the clip to this body. Without it, the clip moves the joints that it names.
    pub retarget: Option<&'a OracleRetarget>,
}

/// A layer at one instant.
#[derive(Clone, Debug, PartialEq)]
pub struct OracleLayer {
    /// The combination with the layers below; ignored in layer 0.
    pub mode: LayerMode,
    /// From 0 to 1; ignored in layer 0.
    pub weight: f64,
    /// A weight per joint, in source order; ignored in layer 0.
    pub mask: Option<Vec<f64>>,
}

impl Default for OracleLayer {
    fn default() -> Self {
        Self { mode: LayerMode::Override, weight: 1.0, mask: None }
    }
}

/// A character's pose at one instant; joints in source order.
#[derive(Clone, Debug)]
pub struct OraclePose {
    /// Local transforms.
    pub locals: Vec<Local>,
    /// Error gains of the local transforms.
    pub gains: Vec<Gain>,
    /// `model_from_joint` of each joint.
    pub model_from_joint: Vec<DAffine3>,
    /// `model_from_bind` of each palette entry, 3x4, row-major.
    pub palette: Vec<[f64; 12]>,
}

/// Evaluates a pose. `layers` are all layers in use, in order; if empty, the slots of layer 0 are
/// mixed.
///
/// # Panics
///
/// If the joints have a cycle, or a mask is not one weight per joint.
#[must_use]
pub fn evaluate(body: &OracleBody, slots: &[OracleSlot<'_>], layers: &[OracleLayer]) -> OraclePose {
    evaluate_inertialization(body, slots, &[], layers)
}

/// Evaluates a pose with transitions that are still inertializing.
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
