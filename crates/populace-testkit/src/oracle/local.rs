//! Local transforms in double precision, and how errors grow in them.

use glam::{DQuat, DVec3, DVec4};

/// Single precision may flip a quaternion whose dot product with its reference is below this.
pub(super) const HEMISPHERE_MARGIN: f64 = 1e-4;

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

/// Error gains: the factors by which an error in a clip's value grows on its way into a joint's
/// local transform.
///
/// Infinite where single precision may flip a rotation to the other hemisphere. No device can be
/// held to a value there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gain {
    /// Gain of translations.
    pub translation: f64,
    /// Gain of rotations, taken as four-component vectors.
    pub rotation: f64,
    /// Gain of scales.
    pub scale: f64,
}

impl Gain {
    pub(super) const ONE: Self = Self { translation: 1.0, rotation: 1.0, scale: 1.0 };
}

/// A joint's local transform with its error gains.
pub(super) type LocalWithGain = (Local, Gain);

/// Divides component by component; 1 where the reference is 0.
pub(super) fn ratio(value: DVec3, reference: DVec3) -> DVec3 {
    let one = |v: f64, r: f64| if r == 0.0 { 1.0 } else { v / r };
    DVec3::new(one(value.x, reference.x), one(value.y, reference.y), one(value.z, reference.z))
}

pub(super) fn vec4_from_quat(q: DQuat) -> DVec4 {
    DVec4::from_array(q.to_array())
}

pub(super) fn quat_from_vec4(v: DVec4) -> DQuat {
    DQuat::from_array(v.normalize().to_array())
}
