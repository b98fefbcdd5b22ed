//! Transforms of a member's joints on the way down its hierarchy. Twin of `kernels/hierarchy.cl`.

use populace_core::Affine;
use populace_core::layout::NONE;

/// Storage of a member's transforms. A joint is local until its model transform is set.
pub(crate) trait Hierarchy {
    /// Returns `model_from_joint` of a joint that has been set.
    fn model(&self, joint: usize) -> Affine;

    /// Returns `parent_from_joint` of a joint that has not been set.
    fn local(&self, joint: usize) -> Affine;

    /// Sets `model_from_joint`.
    fn set_model(&mut self, joint: usize, model: Affine);
}

/// Computes a joint's model transform. Its parent must have been set.
#[inline(always)]
pub(crate) fn descend_to(joints: &mut impl Hierarchy, parents: &[u32], joint: usize) {
    let local = joints.local(joint);
    let model = if parents[joint] == NONE {
        local
    } else {
        joints.model(parents[joint] as usize).mul(&local)
    };
    joints.set_model(joint, model);
}

/// Computes the model transforms of all joints, parents first.
#[inline(always)]
pub(crate) fn descend(joints: &mut impl Hierarchy, parents: &[u32]) {
    (0..parents.len()).for_each(|joint| descend_to(joints, parents, joint));
}
