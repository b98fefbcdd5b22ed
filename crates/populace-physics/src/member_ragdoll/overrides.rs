//! Joint overrides of a ragdoll.

use populace::{Affine, Crowd, JointIndex, JointOverride, Placement, Space, Trs};

use super::{CarriedJoint, MemberRagdoll};
use crate::Error;
use crate::math::{Rotation, inverse_transform_point, joint_index, trs, yaw_rotation};
use crate::world::World;

impl CarriedJoint {
    fn space(&self) -> Space {
        if self.parent.is_some() { Space::Local } else { Space::Model }
    }
}

impl MemberRagdoll {
    /// Writes the current joint overrides with the remaining weight of the ragdoll.
    pub(crate) fn write(&mut self, crowd: &mut Crowd, world: &World) -> Result<(), Error> {
        let place = crowd.member(self.member)?.placement();
        let is_resting = self.fade.is_none() && self.is_fully_limp() && self.is_asleep(world);
        if is_resting && self.resting_placement == Some(place) {
            return Ok(());
        }
        let weight = self.weight();
        let mut overrides: Vec<JointOverride> = self
            .carried
            .iter()
            .map(|carried| self.joint_override(world, &place, carried, weight))
            .collect();
        if self.is_fully_limp() {
            let index = |joint: usize| self.carried.binary_search_by_key(&joint, |c| c.joint).ok();
            let parents: Vec<_> = self.carried.iter().map(|c| c.parent.and_then(index)).collect();
            let weight = self.fade.map_or(1.0, |fade| fade.model_override_weight());
            overrides.extend(model_overrides(&parents, &overrides, weight));
        }
        crowd.member_mut(self.member)?.override_joints(&overrides)?;
        self.resting_placement = is_resting.then_some(place);
        Ok(())
    }

    /// Releases all overrides, so that the clips move the joints again.
    pub(crate) fn release(&self, crowd: &mut Crowd) -> Result<(), Error> {
        let joints: Vec<JointIndex> = self.carried.iter().map(|c| joint_index(c.joint)).collect();
        crowd.member_mut(self.member)?.release_joints(Space::Local, &joints)?;
        crowd.member_mut(self.member)?.release_joints(Space::Model, &joints)?;
        Ok(())
    }

    /// Returns the local override of a joint: its rotation against the parent, with unchanged
    /// translation and scale, so that joints never come apart. If no body moves the parent, returns
    /// an override in model space.
    pub(super) fn joint_override(
        &self,
        world: &World,
        place: &Placement,
        carried: &CarriedJoint,
        weight: f32,
    ) -> JointOverride {
        let pose = self.pose(world, carried.body);
        let joint_rotation = pose.rotation * carried.body_from_joint;
        let joint = joint_index(carried.joint);
        let Some(parent) = carried.parent else {
            let world_from_model = place.world_from_model();
            let at = inverse_transform_point(
                &world_from_model,
                pose.transform_point(carried.position_in_body),
            );
            let rotation =
                (yaw_rotation(place).inverse() * joint_rotation * carried.rotation_to_model)
                    .normalize();
            let transform = Trs {
                translation: at.to_array(),
                rotation: rotation.to_array(),
                scale: carried.start.scale,
            };
            return JointOverride { joint, space: carried.space(), transform, weight };
        };
        let mut transform = carried.start;
        if self.plan.bodies()[carried.body].head == carried.joint {
            let rotation =
                (self.world_rotation(world, parent).inverse() * joint_rotation).normalize();
            transform.rotation = rotation.to_array();
        }
        JointOverride { joint, space: carried.space(), transform, weight }
    }

    /// Returns the rotation in world space of a joint that some body moves.
    fn world_rotation(&self, world: &World, joint: usize) -> Rotation {
        let Some(body) = self.plan.body_of(joint_index(joint)) else { return Rotation::IDENTITY };
        let body_rotation = self.pose(world, body).rotation;
        if self.limp[body] {
            let at = self.carried.binary_search_by_key(&joint, |c| c.joint);
            return at.map_or(body_rotation, |at| body_rotation * self.carried[at].body_from_joint);
        }
        let head = self.plan.bodies()[body].head;
        body_rotation * self.last.model_rotation(head).inverse() * self.last.model_rotation(joint)
    }
}

/// Returns the joint transforms `local` as overrides in model space. These are applied last, so
/// that no constraint such as a planted foot moves a limp joint. They fade out early when the
/// member gets up, because only local overrides blend well. Joints whose model transform has shear
/// are left out. `parents` are indices in `local`.
pub(super) fn model_overrides(
    parents: &[Option<usize>],
    local: &[JointOverride],
    weight: f32,
) -> Vec<JointOverride> {
    let mut models: Vec<Affine> = Vec::with_capacity(local.len());
    let mut overrides = Vec::with_capacity(local.len());
    for (parent, given) in parents.iter().zip(local) {
        let own = Affine::from_trs(&given.transform);
        let model = parent.map_or(own, |at| models[at].mul(&own));
        models.push(model);
        let transform = trs(&model);
        let is_child = given.space == Space::Local;
        if is_child && is_same_linear_part(&Affine::from_trs(&transform), &model) {
            overrides.push(JointOverride { space: Space::Model, transform, weight, ..*given });
        }
    }
    overrides
}

/// Returns whether the 3x3 parts of two transforms agree within a relative tolerance of 0.001.
fn is_same_linear_part(a: &Affine, b: &Affine) -> bool {
    let both = a.rows.iter().flatten().zip(b.rows.iter().flatten());
    let largest = a.rows.iter().flat_map(|row| &row[..3]).fold(0.0f32, |most, v| most.max(v.abs()));
    both.enumerate()
        .filter(|(at, _)| at % 4 != 3)
        .all(|(_, (a, b))| (a - b).abs() <= 1e-3 * largest)
}
