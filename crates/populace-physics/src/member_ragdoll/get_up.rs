//! Placement of a member that gets up.

use populace::model::{JointIndex, Role};
use populace::{Crowd, Placement};

use super::MemberRagdoll;
use crate::Error;
use crate::math::{Rotation, Vector};
use crate::motion::LyingPose;
use crate::world::World;

/// Depth below the hips in which a floor is searched, in metres for a member of scale 1.
const FLOOR_WITHIN_M: f32 = 4.0;
/// Least horizontal part of the direction from hips to head in which it tells how a body lies.
const LEAST_FLAT: f32 = 0.3;

/// How the trunk of a ragdoll lies, in world space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Posture {
    /// Unit vector out of the front of hips and chest.
    pub(crate) front: Vector,
    /// Unit vector out of the left of hips and chest.
    pub(crate) left: Vector,
    /// Horizontal unit vector from the hips to the head.
    axis: Vector,
}

impl MemberRagdoll {
    /// Returns the placement whose rest pose has the hips above or below their current position and
    /// the heading of the body after the shortest rotation to upright. So a member that lies on its
    /// back gets up towards its feet.
    pub(crate) fn placement_to_get_up(&self, placement: Placement, world: &World) -> Placement {
        let (rest_rotation, rest_position) = self.plan.rest();
        let world_from_rest = self.root_pose(world).rotation * rest_rotation.inverse();
        let upright =
            Rotation::from_rotation_arc((world_from_rest * Vector::Y).normalize(), Vector::Y);
        let front = upright * (world_from_rest * Vector::Z);
        let hips = rest_position * Vector::new(1.0, 0.0, 1.0);
        self.placement_at(hips, front.x.atan2(front.z), placement, world)
    }

    /// Returns the placement at which the hips and the body's axis of a lying pose are above or
    /// below those of the ragdoll.
    pub(crate) fn placement_for(
        &self,
        lying: &LyingPose,
        posture: &Posture,
        placement: Placement,
        world: &World,
    ) -> Placement {
        let heading = |axis: Vector| axis.x.atan2(axis.z);
        let yaw_rad = heading(posture.axis) - heading(lying.axis);
        self.placement_at(lying.hips, yaw_rad, placement, world)
    }

    /// Returns the placement with a heading on the floor below the hips, where `hips` in model
    /// space is above or below them.
    fn placement_at(
        &self,
        hips: Vector,
        yaw_rad: f32,
        placement: Placement,
        world: &World,
    ) -> Placement {
        let at = self.root_pose(world).translation;
        let aside = Rotation::from_rotation_y(yaw_rad) * hips * placement.scale();
        let [_, height, _] = placement.position();
        let above = at + Vector::Y * 0.1 * placement.scale();
        let floor =
            world.floor_height_below(above, FLOOR_WITHIN_M * placement.scale()).unwrap_or(height);
        let origin = at - aside;
        let placed = Placement::at([origin.x, floor, origin.z]).facing(yaw_rad);
        placed.scaled(placement.scale())
    }

    /// Returns how the trunk lies. Of a body without roles only the hips are known.
    pub(crate) fn posture(&self, crowd: &Crowd, world: &World) -> Result<Posture, Error> {
        let member = crowd.member(self.member)?;
        let (rest_rotation, _) = self.plan.rest();
        let hips = self.root_pose(world);
        let turn = hips.rotation * rest_rotation.inverse();
        let chest = [Role::UpperChest, Role::Chest, Role::Spine].into_iter();
        let chest = chest.filter_map(|role| member.joint(role)).next();
        let chest_turn = chest.and_then(|joint| self.turn(joint, world)).unwrap_or(turn);
        let mean = |axis: Vector| {
            let own = turn * axis;
            (own + chest_turn * axis).try_normalize().unwrap_or(own)
        };
        let front = mean(Vector::Z);
        let head =
            [Role::Head, Role::Neck].into_iter().filter_map(|role| member.joint(role)).next();
        let head = head.and_then(|joint| self.plan.body_of(joint)).filter(|body| *body > 0);
        let up =
            head.map_or(turn * Vector::Y, |b| self.pose(world, b).translation - hips.translation);
        let flat = Vector::new(1.0, 0.0, 1.0);
        // A body that sits upright counts as lying on its back.
        let lies = (up * flat).length() > LEAST_FLAT * up.length();
        let axis = if lies { up * flat } else { -front * flat };
        let axis = axis.try_normalize().unwrap_or(Vector::Z);
        Ok(Posture { front, left: mean(Vector::X), axis })
    }

    /// Returns the rotation of a carried joint from rest, in world space.
    fn turn(&self, joint: JointIndex, world: &World) -> Option<Rotation> {
        let at = self.carried.binary_search_by_key(&joint.index(), |c| c.joint).ok()?;
        let carried = &self.carried[at];
        let rotation = self.pose(world, carried.body).rotation * carried.body_from_joint;
        Some(rotation * self.plan.rest_rotation(joint).inverse())
    }
}
