//! Views of a member: constraints, overrides, attachments, user stages.

use std::borrow::Borrow;

use populace_device::{Feet, JointOverride, Space};
use populace_model::{JointIndex, Trs};

use super::super::state::State;
use super::super::{MemberId, StageId};
use super::{MemberMut, MemberView};
use crate::{Error, Gaze, Reach, StageUse, Stride, Target, Weight};

impl<C: Borrow<State>> MemberView<C> {
    /// The member and joint that this member is attached to, if any.
    #[must_use]
    pub fn attached_to(&self) -> Option<(MemberId, JointIndex)> {
        self.state().attachments.attached_to(self.id)
    }
}

impl MemberMut<'_> {
    /// Overrides transforms of joints until they are released, in place of earlier overrides of
    /// the same joints in the same space. The joints below follow, and all else plays on.
    ///
    /// # Errors
    ///
    /// A joint that does not exist, a transform that is not finite or whose rotation is not of
    /// length 1, or a weight that is not from 0 to 1. Nothing is changed then.
    pub fn override_joints(&mut self, overrides: &[JointOverride]) -> Result<(), Error> {
        let (constraints, base) = self.crowd.state.constraints();
        constraints.override_joints(base, self.id, overrides)
    }

    /// Removes the overrides of joints in one space.
    ///
    /// # Errors
    ///
    /// More data than devices can address.
    pub fn release_joints(&mut self, space: Space, joints: &[JointIndex]) -> Result<(), Error> {
        let (constraints, base) = self.crowd.state.constraints();
        constraints.release_joints(base, self.id, space, joints)
    }

    /// Removes all overrides.
    ///
    /// # Errors
    ///
    /// More data than devices can address.
    pub fn release_all_joints(&mut self) -> Result<(), Error> {
        let (constraints, base) = self.crowd.state.constraints();
        constraints.release_all(base, self.id)
    }

    /// Makes the member look at a target, in place of its earlier one. Spine, neck, head and eyes
    /// share the rotation, as far as the character has them. The gaze eases over to the new
    /// target, or follows it if calls move it ([`Weight`]). Beyond 85 degrees to either side, 45
    /// up or 50 down the gaze stays at the limit, and it returns to the front while the target
    /// passes behind.
    ///
    /// A character without humanoid roles looks with the joint whose name contains "head".
    ///
    /// # Errors
    ///
    /// A character whose head is unknown
    /// ([`CharacterMut::set_roles`](crate::CharacterMut::set_roles),
    /// [`look_at_with`](Self::look_at_with)), or a target or weight that is out of its range.
    pub fn look_at(&mut self, target: impl Into<Target>, weight: Weight) -> Result<(), Error> {
        let (constraints, base) = self.crowd.state.constraints();
        constraints.look_at(base, self.id, target.into(), weight)
    }

    /// Makes the member look at a target with a chain of joints of the caller's choice, in place of
    /// the earlier target of the same last joint. [`GazeLimits::HEAD`](crate::GazeLimits::HEAD) are
    /// the limits of [`look_at`](Self::look_at).
    ///
    /// # Errors
    ///
    /// Joints that form no chain, a facing direction of no length, or a target or weight that is
    /// out of its range.
    pub fn look_at_with(
        &mut self,
        gaze: &Gaze,
        target: impl Into<Target>,
        weight: Weight,
    ) -> Result<(), Error> {
        let (constraints, base) = self.crowd.state.constraints();
        constraints.look_at_with(base, self.id, gaze.clone(), target.into(), weight)
    }

    /// Fades out all look-at constraints within `over_secs`.
    ///
    /// # Errors
    ///
    /// A time that is out of its range.
    pub fn clear_look_at(&mut self, over_secs: f32) -> Result<(), Error> {
        let (constraints, base) = self.crowd.state.constraints();
        constraints.clear_look_at(base, self.id, over_secs)
    }

    /// Makes a limb reach for a target by two-bone IK, in place of its earlier target. The limb
    /// eases over to the new target, or follows it if calls move it ([`Weight`]).
    ///
    /// # Errors
    ///
    /// Joints that form no limb, or a target, pole or weight that is out of its range.
    pub fn reach(
        &mut self,
        reach: Reach,
        target: impl Into<Target>,
        weight: Weight,
    ) -> Result<(), Error> {
        let (constraints, base) = self.crowd.state.constraints();
        constraints.reach(base, self.id, reach, target.into(), weight)
    }

    /// Makes a chain of joints from `first` to `end` reach for a target by FABRIK, in place of its
    /// earlier target.
    ///
    /// # Errors
    ///
    /// Joints that form no chain, or a target or weight that is out of its range.
    pub fn reach_with_chain(
        &mut self,
        first: JointIndex,
        end: JointIndex,
        target: impl Into<Target>,
        weight: Weight,
    ) -> Result<(), Error> {
        let (constraints, base) = self.crowd.state.constraints();
        constraints.reach_with_chain(base, self.id, [first, end], target.into(), weight)
    }

    /// Fades out the reach of the limb or chain that ends in `end`, within `over_secs`.
    ///
    /// # Errors
    ///
    /// A time that is out of its range.
    pub fn clear_reach(&mut self, end: JointIndex, over_secs: f32) -> Result<(), Error> {
        let (constraints, base) = self.crowd.state.constraints();
        constraints.clear_reach(base, self.id, end, over_secs)
    }

    /// Keeps the feet on the ground ([`Crowd::set_ground`](crate::Crowd::set_ground)) by leg IK.
    /// The humanoid roles name the legs. A weight of 0 ends it.
    ///
    /// # Errors
    ///
    /// A character whose legs are unknown
    /// ([`CharacterMut::set_roles`](crate::CharacterMut::set_roles),
    /// [`plant_feet_with`](Self::plant_feet_with)) or whose feet do not hang on its legs
    /// ([`Character::with_feet_on_legs`](populace_character::Character::with_feet_on_legs)), or a
    /// weight that is not from 0 to 1.
    pub fn plant_feet(&mut self, weight: f32) -> Result<(), Error> {
        let (constraints, base) = self.crowd.state.constraints();
        constraints.plant_feet(base, self.id, weight)
    }

    /// Sets how planted feet step. It holds until feet are planted no longer and does nothing for a
    /// member whose feet are not planted.
    ///
    /// # Errors
    ///
    /// A number that is not finite.
    pub fn set_stride(&mut self, stride: Stride) -> Result<(), Error> {
        self.crowd.set_strides(&[(self.id, stride)])
    }

    /// Keeps feet of the caller's choice on the ground. A weight of 0 ends it.
    ///
    /// # Errors
    ///
    /// Joints that form no legs, or a weight that is not from 0 to 1.
    pub fn plant_feet_with(&mut self, feet: &Feet) -> Result<(), Error> {
        let (constraints, base) = self.crowd.state.constraints();
        constraints.plant_with(base, self.id, feet)
    }

    /// Scales the lengths of joints: one factor for each joint, in level order, on its distance
    /// from its parent. All 1 is the character's own build, and takes earlier factors away.
    ///
    /// # Errors
    ///
    /// Another number of factors than joints, or a factor that is not above 0 and at most 10,000.
    pub fn set_proportions(&mut self, factors: &[f32]) -> Result<(), Error> {
        let (constraints, base) = self.crowd.state.constraints();
        constraints.set_proportions(base, self.id, factors)
    }

    /// Attaches the member to a joint of another, in place of its earlier attachment. Its model
    /// space is then that joint times `offset`, scale included, as of the same frame and after all
    /// constraints; the device computes it, and the host reads nothing. Attached members can carry
    /// members in turn, four levels deep.
    ///
    /// The member takes over the placement of its parent. Its joints in model space, and targets,
    /// overrides and stages in model space, refer to that placement and not to the joint.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`], a joint that does not exist, an offset that is not finite or whose
    /// rotation is not of length 1, or [`Error::BadAttachment`] for a member attached to itself or
    /// to its own attachments, past four levels, or to a member without a mesh. Nothing is changed
    /// then.
    pub fn attach_to(
        &mut self,
        parent: MemberId,
        joint: JointIndex,
        offset: Trs,
    ) -> Result<(), Error> {
        self.crowd.state.attach(self.id, parent, joint, offset)
    }

    /// Detaches the member. It keeps the placement that it has of its parent, wherever root motion
    /// has moved that ([`commit_root_motion`](Self::commit_root_motion) updates placements). A
    /// member that is not attached stays as it is.
    ///
    /// # Errors
    ///
    /// More data than devices can address.
    pub fn detach(&mut self) -> Result<(), Error> {
        self.crowd.state.detach(self.id)
    }

    /// Runs a user stage for joints of the member, in place of the joints for which it ran. Several
    /// stages of one joint run in the order in which they were set.
    ///
    /// # Errors
    ///
    /// A stage or joint that does not exist, or a value that is not finite. Nothing is changed
    /// then.
    pub fn set_stage(&mut self, stage: StageId, usage: StageUse) -> Result<(), Error> {
        self.crowd.state.set_stage(self.id, stage, usage)
    }

    /// Stops running a user stage for the member.
    ///
    /// # Errors
    ///
    /// A stage that does not exist.
    pub fn clear_stage(&mut self, stage: StageId) -> Result<(), Error> {
        self.crowd.state.clear_stage(self.id, stage)
    }
}
