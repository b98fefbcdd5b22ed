//! Where a foot stands.

use glam::{DQuat, DVec3};
use populace_model::JointIndex;
use populace_model::humanoid::Side;

pub(super) const SIDES: [Side; 2] = [Side::Left, Side::Right];

/// What of the target touches the ground: a foot, or its toes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stands {
    pub(super) joint: JointIndex,
    /// In model space.
    pub(super) position: DVec3,
    /// From rest, in model space.
    pub(super) rotation: DQuat,
}
