//! Limbs of two bones that reach from one point to another.

use glam::{DQuat, DVec3};

use super::Pose;
use super::figure::Figure;
use super::stance::rotation_between;
use crate::anatomy::{Limb, Side};

/// The bones of a limb: directions of the upper and the lower one, and the axis of the bend.
pub(super) struct Bones {
    pub(super) upper: DVec3,
    pub(super) lower: DVec3,
    pub(super) hinge: DVec3,
}

impl Figure<'_> {
    /// Sets the rotations of upper arm and forearm, which reach from the first point of `span` to
    /// the second. The elbow points towards `elbow`, in model space.
    pub(super) fn bend_arm(&self, pose: &mut Pose, side: Side, elbow: DVec3, span: [DVec3; 2]) {
        let rest = [Limb::UpperArm, Limb::Forearm, Limb::Hand].map(|l| self.body.joint(l, side));
        let bones = bend(rest, span, elbow, self.elbow);
        let along = side.mirror_point(self.body.along);
        let hinge = side.mirror_point(-self.body.outward) * side.sign();
        pose.rotations[Limb::UpperArm.of(side)] =
            rotation_between([along, hinge], [bones.upper, bones.hinge]);
        let forearm = rotation_between([along, hinge], [bones.lower, bones.hinge]);
        // The forearm takes a part of the hand's twist about it. The sine has no jump at half a
        // turn.
        let between = forearm.inverse() * pose.rotations[Limb::Hand.of(side)];
        let sine = DVec3::new(between.x, between.y, between.z).dot(along);
        let twist = 2.0 * (sine * between.w.signum()).atan2(between.w.abs());
        pose.rotations[Limb::Forearm.of(side)] =
            forearm * DQuat::from_axis_angle(along, 0.6 * twist.sin());
    }
}

/// Bends a limb of two bones between two points. The middle joint points towards `side`, but stays
/// above the ground by `radius`.
pub(super) fn bend(rest: [DVec3; 3], [from, to]: [DVec3; 2], side: DVec3, radius: f64) -> Bones {
    let [first, middle, last] = rest;
    let (a, b) = ((middle - first).length(), (last - middle).length());
    let straight = (to - from).normalize_or(-DVec3::Y);
    let reach = (to - from).length().clamp((a - b).abs() + 1e-6, (a + b) * (1.0 - 1e-4));
    // By the law of cosines.
    let cos = ((a * a + reach * reach - b * b) / (2.0 * a * reach)).clamp(-1.0, 1.0);
    let sin = (1.0 - cos * cos).sqrt();
    let away =
        (side - straight * side.dot(straight)).normalize_or(straight.any_orthonormal_vector());
    let centre = from + straight * (a * cos);
    let away = above_ground(away, straight, (radius - centre.y) / (a * sin).max(1e-9));
    let joint = centre + away * (a * sin);
    Bones {
        upper: (joint - from).normalize(),
        lower: (from + straight * reach - joint).normalize(),
        hinge: away.cross(straight).normalize(),
    }
}

/// Turns the unit vector `away` about `axis` as little as needed for its height to be `least`.
fn above_ground(away: DVec3, axis: DVec3, least: f64) -> DVec3 {
    if away.y >= least {
        return away;
    }
    let up = DVec3::Y - axis * axis.y;
    let most = up.length();
    if most < 1e-6 {
        return away;
    }
    let up = up / most;
    let aside = up.cross(axis);
    let cos = (least / most).min(1.0);
    let sin = (1.0 - cos * cos).sqrt() * if away.dot(aside) < 0.0 { -1.0 } else { 1.0 };
    up * cos + aside * sin
}
