//! Feet and toes of the target.

use glam::{DQuat, DVec3};
use populace_model::JointIndex;
use populace_model::humanoid::Side;

pub(super) const SIDES: [Side; 2] = [Side::Left, Side::Right];

/// A foot or toes of the target that touch the ground.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stands {
    pub(super) joint: JointIndex,
    /// Position in model space.
    pub(super) position: DVec3,
    /// Rotation from rest, in model space.
    pub(super) rotation: DQuat,
}
