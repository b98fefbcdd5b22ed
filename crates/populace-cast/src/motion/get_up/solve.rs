//! Solving a key pose of one body: limbs reach their contacts, and the trunk rests on the ground.

use glam::{DMat3, DQuat, DVec3};

use super::key::{Foot, Hand, Key};
use crate::anatomy::{HEAD, Limb, NECK, PELVIS, SEGMENTS, SPINE, Side};
use crate::motion::Pose;
use crate::motion::figure::Figure;
use crate::motion::limb::bend;
use crate::motion::stance::{rotation_between, solve_fingers};

/// Most steps in which the trunk is laid onto the ground. Each moves it by the gap that is left.
const STEPS: usize = 8;
/// Gap in metres that may be left.
const CLOSE_M: f64 = 2e-4;
/// Distance in metres within which the trunk's height changes over from the key pose's to that of
/// the ground.
const SOFT_M: f64 = 0.012;

impl Figure<'_> {
    /// Returns the pose that a key describes. `end` is the pose in which the motion ends.
    pub(super) fn solve(&self, key: &Key, end: &Pose) -> Pose {
        let mut pose = Pose { rotations: trunk(key), pelvis_offset: DVec3::ZERO };
        let height = self.body.height;
        let rest_y = self.body.joints[PELVIS].y;
        let end_y = rest_y + end.pelvis_offset.y;
        let [x, y, z] = key.pelvis;
        let wanted = y * end_y - rest_y;
        pose.pelvis_offset = end.pelvis_offset + DVec3::new(x * height, 0.0, z * height);
        pose.pelvis_offset.y = wanted;
        let end_at = self.positions(end);
        let ankles = Side::BOTH.map(|side| self.ankle(key, side, (end, &end_at), &mut pose));
        let wrists = Side::BOTH.map(|side| self.wrist(key, side, &mut pose.rotations));
        for _ in 0..STEPS {
            // Hips and shoulders do not depend on the limbs.
            let at = self.positions(&pose);
            for side in Side::BOTH {
                let (foot, hand) = (&key.feet[side.index()], &key.hands[side.index()]);
                let hip = self.joint(&at, Limb::Thigh, side);
                let shoulder = self.joint(&at, Limb::UpperArm, side);
                self.bend_leg(&mut pose, side, foot, [hip, ankles[side.index()]]);
                let elbow = side.mirror_point(DVec3::from_array(hand.elbow));
                self.bend_arm(&mut pose, side, elbow, [shoulder, wrists[side.index()]]);
            }
            let before = pose.pelvis_offset.y;
            pose.pelvis_offset.y = soft_max(wanted, before - self.trunk_low(&pose));
            if (pose.pelvis_offset.y - before).abs() < CLOSE_M {
                // The limbs reach as before.
                pose.pelvis_offset.y = before;
                break;
            }
        }
        for side in Side::BOTH {
            self.hang(&mut pose, side, &key.hands[side.index()], end);
        }
        pose
    }

    /// Sets the rotations of a foot, and returns where its ankle is in model space.
    fn ankle(
        &self,
        key: &Key,
        side: Side,
        (end, end_at): (&Pose, &[DVec3]),
        pose: &mut Pose,
    ) -> DVec3 {
        let rotations = &mut pose.rotations;
        let Foot { at, turn, .. } = key.feet[side.index()];
        let [yaw, pitch, toes] = turn.map(f64::to_radians);
        let home = end.rotations[Limb::Foot.of(side)];
        let flat = DQuat::from_rotation_y(side.sign() * yaw) * home;
        let foot = flat * DQuat::from_rotation_x(-pitch);
        rotations[Limb::Foot.of(side)] = foot;
        rotations[Limb::Toes.of(side)] = foot * DQuat::from_rotation_x(-toes);
        let [ankle, ball] = [Limb::Foot, Limb::Toes].map(|limb| self.body.joint(limb, side));
        let mut to = self.joint(end_at, Limb::Foot, side) + home * (ball - ankle);
        to += side.mirror_point(DVec3::from_array(at) * self.body.height);
        let mut from = to - foot * (ball - ankle);
        from.y = at[1] * self.body.height - self.foot_low(side, rotations);
        from
    }

    /// Sets the rotations of a hand, and returns where its wrist is in model space.
    fn wrist(&self, key: &Key, side: Side, rotations: &mut [DQuat; SEGMENTS]) -> DVec3 {
        let Hand { at, turn, curl, .. } = key.hands[side.index()];
        let [yaw, pitch, roll] = turn.map(f64::to_radians);
        // From rest to the fingers forward and the palm down.
        let (along, outward) = (self.body.along, self.body.outward);
        let rest = DMat3::from_cols(outward.cross(along), outward, along);
        let palm_down = DQuat::from_mat3(&rest.transpose());
        let turned = DQuat::from_rotation_y(yaw)
            * DQuat::from_rotation_x(-pitch)
            * DQuat::from_rotation_z(roll)
            * palm_down;
        rotations[Limb::Hand.of(side)] = side.mirror_rotation(turned);
        solve_fingers(self.body, side, curl, rotations);
        let mut wrist = side.mirror_point(DVec3::from_array(at) * self.body.height);
        wrist.y -= self.hand_low(side, rotations);
        wrist
    }

    fn bend_leg(&self, pose: &mut Pose, side: Side, foot: &Foot, span: [DVec3; 2]) {
        let rest = [Limb::Thigh, Limb::Shin, Limb::Foot].map(|limb| self.body.joint(limb, side));
        let front = side.mirror_point(DVec3::from_array(foot.knee));
        let bones = bend(rest, span, front, self.knee);
        let [hip, knee, end] = rest;
        pose.rotations[Limb::Thigh.of(side)] =
            rotation_between([knee - hip, DVec3::X], [bones.upper, bones.hinge]);
        pose.rotations[Limb::Shin.of(side)] =
            rotation_between([end - knee, DVec3::X], [bones.lower, bones.hinge]);
    }

    /// Mixes in an arm that hangs from the chest as it does at the end.
    fn hang(&self, pose: &mut Pose, side: Side, hand: &Hand, end: &Pose) {
        let weight = hand.hang.clamp(0.0, 1.0);
        if weight <= 0.0 {
            return;
        }
        let fingers = (0..5).flat_map(|f| (0..3).map(move |j| Limb::Finger(f, j).of(side)));
        let arm = [Limb::UpperArm, Limb::Forearm, Limb::Hand].map(|limb| limb.of(side));
        let before = pose.rotations;
        for segment in arm.into_iter().chain(fingers) {
            let parent = crate::anatomy::parent(segment).unwrap_or(PELVIS);
            let own = before[parent].inverse() * before[segment];
            let hanging = end.rotations[parent].inverse() * end.rotations[segment];
            pose.rotations[segment] = pose.rotations[parent] * own.slerp(hanging, weight);
        }
    }
}

/// Returns the rotations of trunk and head, with all limbs at rest against them.
fn trunk(key: &Key) -> [DQuat; SEGMENTS] {
    let turn = |[x, z, y]: [f64; 3]| {
        let [x, z, y] = [x, z, y].map(f64::to_radians);
        DQuat::from_rotation_y(y) * DQuat::from_rotation_z(z) * DQuat::from_rotation_x(x)
    };
    let pelvis = turn(key.turn);
    let chest = pelvis * turn(key.chest);
    let head = chest * turn(key.head);
    let mut rotations = [pelvis; SEGMENTS];
    for (at, &segment) in SPINE.iter().enumerate() {
        rotations[segment] = pelvis.slerp(chest, (at + 1) as f64 / 4.0);
    }
    rotations[NECK[0]] = chest.slerp(head, 0.4);
    rotations[NECK[1]] = chest.slerp(head, 0.75);
    rotations[HEAD] = head;
    for side in Side::BOTH {
        rotations[Limb::Clavicle.of(side)] = chest;
    }
    rotations
}

/// Returns a smooth maximum, at least both values.
fn soft_max(a: f64, b: f64) -> f64 {
    let over = b - a;
    if over > 4.0 * SOFT_M {
        return b;
    }
    if over < -4.0 * SOFT_M {
        return a;
    }
    // The parabola meets both lines with their values and slopes.
    let t = (over / (4.0 * SOFT_M) + 1.0) / 2.0;
    a + 4.0 * SOFT_M * t * t
}
