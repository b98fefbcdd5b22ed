//! What the crowd is told of a ragdoll.

use populace::{Affine, Crowd, JointIndex, JointOverride, Placement, Space, Trs};

use super::{Carried, Doll};
use crate::Error;
use crate::math::{Rotation, heading, joint_index, point_before, trs};
use crate::world::World;

impl Carried {
    fn space(&self) -> Space {
        if self.parent.is_some() { Space::Local } else { Space::Model }
    }
}

impl Doll {
    /// Writes where the joints are now, with what is left of the ragdoll's weight.
    pub(crate) fn write(&mut self, crowd: &mut Crowd, world: &World) -> Result<(), Error> {
        let place = crowd.placement(self.member)?;
        let is_settled = self.fade.is_none() && self.is_whole() && self.is_asleep(world);
        if is_settled && self.settled_at == Some(place) {
            return Ok(());
        }
        let weight = self.weight();
        let mut told: Vec<JointOverride> =
            self.carried.iter().map(|carried| self.told(world, &place, carried, weight)).collect();
        if self.is_whole() {
            let last_words = self.last_words(&told);
            told.extend(last_words);
        }
        crowd.override_joints(self.member, &told)?;
        self.settled_at = is_settled.then_some(place);
        Ok(())
    }

    /// Gives the joints back to the clips.
    pub(crate) fn release(&self, crowd: &mut Crowd) -> Result<(), Error> {
        let joints: Vec<JointIndex> = self.carried.iter().map(|c| joint_index(c.joint)).collect();
        crowd.release_joints(self.member, Space::Local, &joints)?;
        crowd.release_joints(self.member, Space::Model, &joints)?;
        Ok(())
    }

    /// Joints turn against their parents, keep the place and the scale that they had there, and so
    /// never come apart. Only where no body carries the parent is a joint told in model space.
    fn told(
        &self,
        world: &World,
        place: &Placement,
        carried: &Carried,
        weight: f32,
    ) -> JointOverride {
        let pose = self.pose(world, carried.body);
        let turn = pose.rotation * carried.body_from_joint;
        let joint = joint_index(carried.joint);
        let Some(parent) = carried.parent else {
            let world_from_model = place.world_from_model();
            let at = point_before(&world_from_model, pose.transform_point(carried.place_in_body));
            let rotation = (heading(place).inverse() * turn * carried.turn_to_model).normalize();
            let transform = Trs {
                translation: at.to_array(),
                rotation: rotation.to_array(),
                scale: carried.start.scale,
            };
            return JointOverride { joint, space: carried.space(), transform, weight };
        };
        let mut transform = carried.start;
        if self.plan.bodies()[carried.body].head == carried.joint {
            let rotation = (self.turn_of(world, parent).inverse() * turn).normalize();
            transform.rotation = rotation.to_array();
        }
        JointOverride { joint, space: carried.space(), transform, weight }
    }

    /// The same joints once more, in model space: that is the last word, so that no constraint
    /// plants a limp foot. It gives way soon when the member gets up, since joints blend well in
    /// local space alone. Sheared ones cannot be told so.
    fn last_words(&self, told: &[JointOverride]) -> Vec<JointOverride> {
        let weight = self.fade.map_or(1.0, |fade| fade.grip());
        let mut models: Vec<Affine> = Vec::with_capacity(told.len());
        let mut words = Vec::with_capacity(told.len());
        for (carried, given) in self.carried.iter().zip(told) {
            let own = Affine::from_trs(&given.transform);
            let parent = carried
                .parent
                .and_then(|p| self.carried.binary_search_by_key(&p, |c| c.joint).ok());
            let model = parent.map_or(own, |at| models[at].mul(&own));
            models.push(model);
            let transform = trs(&model);
            if parent.is_some() && is_near(&Affine::from_trs(&transform), &model) {
                words.push(JointOverride { space: Space::Model, transform, weight, ..*given });
            }
        }
        words
    }

    /// The turn in the world of a joint that some body carries.
    fn turn_of(&self, world: &World, joint: usize) -> Rotation {
        let Some(body) = self.plan.body_of(joint_index(joint)) else { return Rotation::IDENTITY };
        let turn = self.pose(world, body).rotation;
        if self.limp[body] {
            let at = self.carried.binary_search_by_key(&joint, |c| c.joint);
            return at.map_or(turn, |at| turn * self.carried[at].body_from_joint);
        }
        let head = self.plan.bodies()[body].head;
        turn * self.last.model_turn(head).inverse() * self.last.model_turn(joint)
    }
}

/// Whether two transforms turn and scale alike, as far as can be seen.
fn is_near(a: &Affine, b: &Affine) -> bool {
    let both = a.rows.iter().flatten().zip(b.rows.iter().flatten());
    let largest = a.rows.iter().flat_map(|row| &row[..3]).fold(0.0f32, |most, v| most.max(v.abs()));
    both.enumerate()
        .filter(|(at, _)| at % 4 != 3)
        .all(|(_, (a, b))| (a - b).abs() <= 1e-3 * largest)
}
