//! Where a member stands that gets up from where it lies.

use populace::Placement;

use super::MemberRagdoll;
use crate::math::{Rotation, Vector};
use crate::world::World;

/// How far below the hips a floor is looked for, in metres, for a member of scale 1.
const FLOOR_WITHIN_M: f32 = 4.0;

impl MemberRagdoll {
    /// The placement whose rest pose has its hips over or under where they are now, and faces where
    /// the body does once it is set upright by the shortest turn: one that lies on its back gets up
    /// towards its feet.
    pub(crate) fn placement_to_get_up(&self, placement: Placement, world: &World) -> Placement {
        let hips = self.root_pose(world);
        let (rest_rotation, rest_position) = self.plan.rest();
        let world_from_rest = hips.rotation * rest_rotation.inverse();
        let upright =
            Rotation::from_rotation_arc((world_from_rest * Vector::Y).normalize(), Vector::Y);
        let front = upright * (world_from_rest * Vector::Z);
        let yaw_rad = front.x.atan2(front.z);
        let aside = Rotation::from_rotation_y(yaw_rad)
            * (rest_position * Vector::new(1.0, 0.0, 1.0))
            * placement.scale();
        let [_, height, _] = placement.position();
        let above = hips.translation + Vector::Y * 0.1 * placement.scale();
        let floor =
            world.floor_height_below(above, FLOOR_WITHIN_M * placement.scale()).unwrap_or(height);
        let at = hips.translation - aside;
        let placed = Placement::at([at.x, floor, at.z]).facing(yaw_rad);
        placed.scaled(placement.scale())
    }
}
