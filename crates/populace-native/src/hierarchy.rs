//! Transforms of a member's joints on the way down its hierarchy. Twin of `kernels/hierarchy.cl`.

use populace_device::layout::NONE;
use populace_model::Affine;

/// Storage of a member's transforms. A joint is local until its model transform is stored.
pub(crate) trait Hierarchy {
    /// Returns `model_from_joint` of a joint that is stored.
    fn model_of(&self, joint: usize) -> Affine;

    /// Returns `parent_from_joint` of a joint that is not stored yet.
    fn local_of(&self, joint: usize) -> Affine;

    /// Stores `model_from_joint`.
    fn keep_model(&mut self, joint: usize, model: Affine);

    /// Computes a joint's model transform. Its parent must be stored.
    #[inline(always)]
    fn descend_to(&mut self, parents: &[u32], joint: usize) {
        let local = self.local_of(joint);
        let model = if parents[joint] == NONE {
            local
        } else {
            self.model_of(parents[joint] as usize).mul(&local)
        };
        self.keep_model(joint, model);
    }
}

impl<H: Hierarchy + ?Sized> Hierarchy for &mut H {
    #[inline(always)]
    fn model_of(&self, joint: usize) -> Affine {
        (**self).model_of(joint)
    }

    #[inline(always)]
    fn local_of(&self, joint: usize) -> Affine {
        (**self).local_of(joint)
    }

    #[inline(always)]
    fn keep_model(&mut self, joint: usize, model: Affine) {
        (**self).keep_model(joint, model);
    }

    #[inline(always)]
    fn descend_to(&mut self, parents: &[u32], joint: usize) {
        (**self).descend_to(parents, joint);
    }
}
