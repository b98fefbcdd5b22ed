//! Look-at: the joints of a chain share one rotation, and the last faces the targets.
//!
//! The rotation is a yaw about the up direction, a pitch about the left direction, and no roll, in
//! the frame that carries the chain. With the end of the chain facing yaw `y` and pitch `p`, and the
//! targets at yaw `Y` and pitch `P`, it is `yaw(Y) * pitch(P - p) * yaw(-y)`.

use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use populace_device::Gaze;
use populace_device::layout::{GAZE_STEEP, Target};

use super::{Descent, part_of};

/// Front, left and up of what carries a chain, in model space.
struct Carrier {
    front: DVec3,
    left: DVec3,
    up: DVec3,
}

/// A direction as yaw to the left and pitch up, in radians.
#[derive(Clone, Copy)]
struct Angles {
    yaw: f64,
    pitch: f64,
}

impl Carrier {
    fn angles(&self, v: DVec3) -> Angles {
        let (left, up, front) = (v.dot(self.left), v.dot(self.up), v.dot(self.front));
        Angles { yaw: left.atan2(front), pitch: up.atan2(left.hypot(front)) }
    }

    /// Returns the rotation from one direction to another, in model space. Its sign tells the way:
    /// the yaw does not go the shorter way round.
    fn rotation(&self, from: Angles, to: Angles) -> DQuat {
        let yaw = |angle| DQuat::from_axis_angle(self.up, angle);
        let raised = DQuat::from_axis_angle(-self.left, to.pitch - from.pitch);
        yaw(to.yaw) * raised * yaw(-from.yaw)
    }
}

/// Limits a yaw: beyond the limit it stays there. From half-way between the limit and straight
/// behind, it returns to the front, which it reaches straight behind.
fn limited_yaw(yaw: f64, limit: f64) -> f64 {
    let returns = 0.5 * (limit + PI);
    let size = match yaw.abs() {
        size if size <= limit => size,
        size if size <= returns => limit,
        size => limit * (PI - size) / (PI - returns),
    };
    size.copysign(yaw)
}

impl Descent<'_, '_> {
    /// Returns the rotation of each joint of a gaze, in model space, after its parent's.
    pub(super) fn gaze(&mut self, gaze: &Gaze) -> Vec<(usize, DQuat)> {
        let of = self.of;
        let joints = of.path(gaze.chain[0].0, gaze.chain[gaze.chain.len() - 1].0);
        let carrier = self.carrier(of.body.joints[joints[0]].parent);
        let now = self.walk(joints);
        let last = now.joints.len() - 1;
        let own = of.in_joint(Some(now.joints[last]), gaze.facing);
        let facing = now.end.matrix3 * own;
        let start = carrier.angles(self.noise.vector(facing));
        let (whole, weight) = self.aim(gaze, &carrier, start, now.positions[last]);
        let sum: f64 = gaze.chain.iter().map(|(_, share)| f64::from(*share)).sum();
        let (mut rotations, mut so_far, mut shared) = (Vec::new(), DQuat::IDENTITY, 0.0);
        let mut end = now.positions[0];
        for at in 0..last {
            let joint = now.joints[at];
            let share: f64 = gaze
                .chain
                .iter()
                .filter(|(listed, _)| of.source(*listed) == joint)
                .map(|(_, share)| f64::from(*share) / sum)
                .sum();
            if share > 0.0 {
                shared += share * weight;
                let turned = self.noise.rotation(part_of(whole, shared));
                rotations.push((joint, turned * so_far.inverse()));
                so_far = turned;
            }
            end += so_far * (now.positions[at + 1] - now.positions[at]);
            end = self.noise.vector(end);
        }
        // The last joint has been moved by the others, and looks from where it is now.
        let (rest, weight) = self.aim(gaze, &carrier, start, end);
        let there = self.noise.rotation(part_of(rest, weight));
        rotations.push((now.joints[last], there * so_far.inverse()));
        rotations
    }

    /// Returns the frame of the joint above a chain: its own front and up at rest are +Z and +Y of
    /// model space.
    fn carrier(&mut self, parent: Option<usize>) -> Carrier {
        let model = parent.map(|parent| self.model(parent).matrix3);
        let [front, up] = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]].map(|axis| {
            let own = self.of.in_joint(parent, axis);
            self.noise.vector(model.map_or(own, |model| model * own))
        });
        let left = up.cross(front).normalize();
        let front = front.normalize();
        Carrier { front, left, up: front.cross(left) }
    }

    /// Returns the rotation to the mean of all targets, and the sum of their weights, at most 1.
    fn aim(&mut self, gaze: &Gaze, carrier: &Carrier, start: Angles, from: DVec3) -> (DQuat, f64) {
        let targets: &[Target] = &gaze.targets;
        let limits = gaze.limits;
        let (mut mean, mut total) = (Angles { yaw: 0.0, pitch: 0.0 }, 0.0);
        for sight in self.sights(targets, from) {
            let to = self.noise.vector(sight.position - from);
            let Angles { yaw, pitch } = carrier.angles(to);
            // Near straight up and down a yaw means little, so it fades out.
            let steep = (pitch.cos() / f64::from(GAZE_STEEP)).min(1.0);
            mean.yaw += limited_yaw(yaw, f64::from(limits.yaw_rad)) * steep * sight.weight;
            mean.pitch +=
                pitch.clamp(-f64::from(limits.down_rad), f64::from(limits.up_rad)) * sight.weight;
            total += sight.weight;
        }
        if total == 0.0 {
            return (DQuat::IDENTITY, 0.0);
        }
        let to = Angles {
            yaw: self.noise.near(mean.yaw / total, 1.0),
            pitch: self.noise.near(mean.pitch / total, 1.0),
        };
        (self.noise.rotation(carrier.rotation(start, to)), total.min(1.0))
    }
}
