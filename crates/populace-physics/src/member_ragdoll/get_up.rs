//! Placement of a member that gets up.

use populace::Placement;

use super::MemberRagdoll;
use crate::math::{Rotation, Vector};
use crate::world::World;

/// Depth below the hips in which a floor is searched, in metres for a member of scale 1.
const FLOOR_WITHIN_M: f32 = 4.0;

impl MemberRagdoll {
    /// Returns the placement whose rest pose has the hips above or below their current position and
    /// the heading of the body after the shortest rotation to upright. So a member that lies on its
    /// back gets up towards its feet.
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
