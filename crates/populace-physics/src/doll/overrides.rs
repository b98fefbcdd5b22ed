//! What the crowd is told of a ragdoll.

use populace::{Crowd, JointIndex, JointOverride, Placement, Space, Trs};

use super::{Carried, Doll};
use crate::Error;
use crate::math::{Rotation, heading, joint_index, point_before};
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
        let told: Vec<JointOverride> =
            self.carried.iter().map(|carried| self.told(world, &place, carried, weight)).collect();
        crowd.override_joints(self.member, &told)?;
        self.settled_at = is_settled.then_some(place);
        Ok(())
    }

    /// Gives the joints back to the clips.
    pub(crate) fn release(&self, crowd: &mut Crowd) -> Result<(), Error> {
        for space in [Space::Local, Space::Model] {
            let ours = self.carried.iter().filter(|c| c.space() == space);
            let joints: Vec<JointIndex> = ours.map(|c| joint_index(c.joint)).collect();
            crowd.release_joints(self.member, space, &joints)?;
        }
        Ok(())
    }

    /// Joints turn against their parents, keep the place and the scale that they had there, and so never come apart. Only
    /// where no body carries the parent is a joint told in model space.
    fn told(&self, world: &World, place: &Placement, carried: &Carried, weight: f32) -> JointOverride {
        let pose = self.pose(world, carried.body);
        let turn = pose.rotation * carried.body_from_joint;
        let joint = joint_index(carried.joint);
        let Some(parent) = carried.parent else {
            let world_from_model = place.world_from_model();
            let at = point_before(&world_from_model, pose.transform_point(carried.place_in_body));
            let rotation = (heading(place).inverse() * turn * carried.turn_to_model).normalize();
            let transform =
                Trs { translation: at.to_array(), rotation: rotation.to_array(), scale: carried.start.scale };
            return JointOverride { joint, space: carried.space(), transform, weight };
        };
        let mut transform = carried.start;
        if self.plan.bodies()[carried.body].head == carried.joint {
            let rotation = (self.turn_of(world, parent).inverse() * turn).normalize();
            transform.rotation = rotation.to_array();
        }
        JointOverride { joint, space: carried.space(), transform, weight }
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
