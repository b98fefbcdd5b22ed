//! Look-at constraints: the joints of a chain share a rotation, and the last joint faces the
//! targets. Twin of `kernels/gaze.cl`.
//!
//! Reads constraints, links and targets, and the chain's transforms. Writes the first joint's model
//! transform, and rotations for the others.
//!
//! The rotation is a yaw about the up direction and a pitch about the left direction of the frame
//! that carries the chain, so that heads do not tilt. Both come straight from the directions before
//! and after. Angles are needed only beyond the limits and between several targets.

use populace_device::layout::{Constraint, GAZE_STEEP, GAZE_UPRIGHT, NONE, Step};
use populace_model::Affine;
use populace_model::math::{Real, angle, quat, vec3};

use super::targets::{Chain, Solver, WeightedPoint};
use crate::hierarchy::Hierarchy;

/// Front, left and up of the parent that carries a chain, in model space.
struct Frame {
    front: [f32; 3],
    left: [f32; 3],
    up: [f32; 3],
}

/// A unit direction in a frame.
#[derive(Clone, Copy, Default)]
struct Sight {
    left: f32,
    up: f32,
    front: f32,
    /// Length of the level part, that is of `left` and `front`.
    level: f32,
}

/// Sine and cosine of half a yaw, both scaled by the same factor.
#[derive(Clone, Copy)]
struct HalfYaw {
    side: f32,
    ahead: f32,
}

/// A rotation in model space, and its weight from 0 to 1.
struct WeightedRotation {
    rotation: [f32; 4],
    weight: f32,
}

impl Frame {
    #[inline(always)]
    fn of(constraint: &Constraint, parent: Option<Affine>) -> Self {
        let (front, up) = (constraint.front.xyz(), constraint.up.xyz());
        let [ahead, up] =
            parent.map_or([front, up], |model| [front, up].map(|v| model.transform_vector(v)));
        let front = vec3::unit_or(ahead, [0.0, 0.0, 1.0]);
        let left = vec3::unit_or(vec3::cross(up, ahead), vec3::any_across(front));
        Self { front, left, up: vec3::cross(front, left) }
    }

    /// Returns a direction in the frame; `None` if it has no length.
    #[inline(always)]
    fn seen_in(&self, v: [f32; 3]) -> Option<Sight> {
        let (x, y, z) = (vec3::dot(v, self.left), vec3::dot(v, self.up), vec3::dot(v, self.front));
        let level = x * x + z * z;
        let squared = level + y * y;
        let k = if squared > 1e-20 { squared.inverse_sqrt() } else { return None };
        Some(Sight { left: x * k, up: y * k, front: z * k, level: vec3::root(level) * k })
    }

    /// Returns the direction that the end of a chain faces. Straight up and down count as front.
    #[inline(always)]
    fn start(&self, facing: [f32; 3]) -> Sight {
        let start = self.seen_in(facing).unwrap_or_default();
        if start.level < GAZE_UPRIGHT {
            return Sight { left: 0.0, up: start.up, front: GAZE_UPRIGHT, level: GAZE_UPRIGHT };
        }
        start
    }

    /// Returns the rotation of `start` by a yaw, and to the pitch of cosine `level` and sine
    /// `height`.
    #[inline(always)]
    fn gaze_rotation(&self, start: Sight, yaw: HalfYaw, level: f32, height: f32) -> [f32; 4] {
        let HalfYaw { side, ahead } = yaw;
        let rise = start.level * height - start.up * level;
        let on = 1.0 + (start.level * level + start.up * height);
        let (right, back, whole) = (-start.front * rise, start.left * rise, start.level * on);
        let (x, y, z) = (ahead * right + side * back, side * whole, ahead * back - side * right);
        let axis = vec3::add_scaled(
            vec3::add_scaled(vec3::scale(self.left, x), self.up, y),
            self.front,
            z,
        );
        quat::normalize_or([axis[0], axis[1], axis[2], ahead * whole], quat::identity())
    }
}

/// Limits a yaw. Beyond the limit the gaze stays at it. A target that passes behind lets the gaze
/// return to the front, so that it never snaps from one side to the other.
fn held(yaw: f32, limit: f32) -> f32 {
    let size = yaw.abs();
    if size <= limit {
        return yaw;
    }
    let behind = 0.5 * (limit + angle::HALF_TURN);
    let size = if size <= behind {
        limit
    } else {
        limit * (angle::HALF_TURN - size) / (angle::HALF_TURN - behind)
    };
    if yaw < 0.0 { -size } else { size }
}

impl Solver<'_> {
    /// Returns the rotation towards the weighted mean of all targets, within the limits.
    #[inline(never)]
    fn aim_by_angles(
        &self,
        constraint: &Constraint,
        frame: &Frame,
        start: Sight,
        from: [f32; 3],
    ) -> [f32; 4] {
        let [side, up, down, _] = constraint.limits.0;
        let (mut yaw, mut pitch, mut total) = (0.0, 0.0, 0.0);
        for target in self.targets(constraint) {
            let WeightedPoint { position, weight } = self.sight(target, from);
            let Some(seen) = frame.seen_in(vec3::sub(position, from)).filter(|_| weight > 0.0)
            else {
                continue;
            };
            let steep = if seen.level < GAZE_STEEP { seen.level * (1.0 / GAZE_STEEP) } else { 1.0 };
            let upwards = angle::of(seen.up, seen.level);
            let raised = if upwards > up { up } else { upwards };
            yaw += held(angle::of(seen.left, seen.front), side) * steep * weight;
            pitch += (if raised < -down { -down } else { raised }) * weight;
            total += weight;
        }
        let k = 1.0 / total;
        let (side, ahead) = angle::sin_cos(0.5 * (yaw * k - angle::of(start.left, start.front)));
        let (height, level) = angle::sin_cos(pitch * k);
        frame.gaze_rotation(start, HalfYaw { side, ahead }, level, height)
    }

    /// Returns the rotation from facing `start` to facing the targets as seen from a point, and the
    /// sum of their weights, at most 1.
    #[inline(never)]
    fn aim(
        &self,
        constraint: &Constraint,
        frame: &Frame,
        start: Sight,
        from: [f32; 3],
    ) -> WeightedRotation {
        let (mut to, mut total, mut count) = (Sight::default(), 0.0, 0);
        for target in self.targets(constraint) {
            let WeightedPoint { position, weight } = self.sight(target, from);
            let Some(seen) = frame.seen_in(vec3::sub(position, from)).filter(|_| weight > 0.0)
            else {
                continue;
            };
            to = seen;
            total += weight;
            count += 1;
        }
        let weight = if total < 1.0 { total } else { 1.0 };
        if count == 0 {
            return WeightedRotation { rotation: quat::identity(), weight };
        }
        // Tangents of the limits. If start and target are both in front, the shortest rotation
        // passes the front.
        let [side, up, down] = [constraint.axis, constraint.front, constraint.up].map(|v| v.0[3]);
        let within = to.level >= GAZE_STEEP
            && to.left.abs() <= side * to.front
            && to.up <= up * to.level
            && -to.up <= down * to.level;
        if count > 1 || !within || start.front <= 0.0 {
            let rotation = self.aim_by_angles(constraint, frame, start, from);
            return WeightedRotation { rotation, weight };
        }
        let side = start.front * to.left - start.left * to.front;
        let ahead = start.level * to.level + (start.left * to.left + start.front * to.front);
        let rotation = frame.gaze_rotation(start, HalfYaw { side, ahead }, to.level, to.up);
        WeightedRotation { rotation, weight }
    }

    /// Turns a chain towards its targets.
    #[inline(never)]
    pub(super) fn gaze(
        &mut self,
        joints: &mut impl Hierarchy,
        joint: usize,
        parent: u32,
        step: &Step,
    ) {
        let constraint = self.constraint(step);
        let links = self.links(constraint);
        let own = joints.model_of(joint);
        let frame =
            Frame::of(constraint, (parent != NONE).then(|| joints.model_of(parent as usize)));
        let Chain { positions, end } = Self::walk(joints, links, own);
        let start = frame.start(end.transform_vector(constraint.axis.xyz()));
        let last = links.len() - 1;
        let whole = self.aim(constraint, &frame, start, positions[last]);
        let (mut so_far, mut position, mut shared) = (quat::identity(), positions[0], 0.0);
        for (at, link) in links.iter().enumerate().take(last) {
            let share = link.share * whole.weight;
            let mut rotation = quat::identity();
            if share > 0.0 {
                shared += share;
                let now = vec3::part_as_told(whole.rotation, shared);
                rotation = quat::mul(now, quat::conjugate(so_far));
                so_far = now;
            }
            if at > 0 {
                self.step_rotations[step.operand as usize + at - 1] = rotation;
            } else {
                joints.keep_model(joint, own.rotated(rotation));
            }
            let bone = vec3::sub(positions[at + 1], positions[at]);
            position = vec3::add(position, vec3::rotated(so_far, bone));
        }
        // The other joints have moved the last one. It looks from its new position, and rotates by
        // the remainder.
        let WeightedRotation { rotation, weight } = self.aim(constraint, &frame, start, position);
        let there = if weight < 1.0 { vec3::part_as_told(rotation, weight) } else { rotation };
        let left = quat::mul(there, quat::conjugate(so_far));
        if last == 0 {
            joints.keep_model(joint, own.rotated(left));
        } else {
            self.step_rotations[step.operand as usize + last - 1] = left;
        }
    }
}
