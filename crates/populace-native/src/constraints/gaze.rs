//! Look-at constraints: the joints of a chain share a rotation, and the last joint faces the
//! targets. Twin of `kernels/gaze.cl`.
//!
//! Reads constraints, links and targets, and the chain's transforms. Writes the first joint's model
//! transform, and rotations for the others.
//!
//! The rotation is a yaw about the up direction and a pitch about the left direction of the frame
//! that carries the chain, so that heads do not tilt. Both come straight from the directions before
//! and after. Angles are needed only beyond the limits and between several targets.

use populace_device::layout::{GAZE_STEEP, GAZE_UPRIGHT, MAX_LINKS, NONE};
use populace_model::math::{Real, angle, quat, vec3};

use super::programs::{Company, Programs, Stop};
use super::targets::{Chain, Solver, WeightedPoint};
use crate::hierarchy::Hierarchy;
use crate::lanes::{Simd, lane_of, put};

/// Front, left and up of the parents that carry chains, in model space.
#[derive(Clone, Copy)]
struct Frame<R> {
    front: [R; 3],
    left: [R; 3],
    up: [R; 3],
}

/// Unit directions in a frame; all 0 if a direction has no length.
#[derive(Clone, Copy)]
struct Sight<R> {
    left: R,
    up: R,
    front: R,
    /// Length of the level part, that is of `left` and `front`.
    level: R,
}

/// Sines and cosines of half a yaw, both scaled by the same factor.
#[derive(Clone, Copy)]
struct HalfYaw<R> {
    side: R,
    ahead: R,
}

impl<R: Real> Frame<R> {
    #[inline(always)]
    fn frame_of(front: [R; 3], up: [R; 3]) -> Self {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let ahead = vec3::unit_or(front, [zero, zero, one]);
        let left = vec3::unit_or(vec3::cross(up, front), vec3::any_across(ahead));
        Self { front: ahead, left, up: vec3::cross(ahead, left) }
    }

    /// Returns directions in the frame.
    #[inline(always)]
    fn seen_in(&self, v: [R; 3]) -> Sight<R> {
        let (x, y, z) = (vec3::dot(v, self.left), vec3::dot(v, self.up), vec3::dot(v, self.front));
        let level = x * x + z * z;
        let squared = level + y * y;
        let long = R::splat(1e-20).less(squared);
        let k = R::choose(long, squared.inverse_sqrt(), R::splat(0.0));
        Sight { left: x * k, up: y * k, front: z * k, level: vec3::root(level) * k }
    }

    /// Returns the rotation of `start` by a yaw, and to the pitch of cosine `level` and sine
    /// `height`.
    #[inline(always)]
    fn gaze_rotation(&self, start: &Sight<R>, yaw: HalfYaw<R>, level: R, height: R) -> [R; 4] {
        let HalfYaw { side, ahead } = yaw;
        let rise = start.level * height - start.up * level;
        let on = R::splat(1.0) + (start.level * level + start.up * height);
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

/// Limits yaws. Beyond the limit the gaze stays at it. A target that passes behind lets the gaze
/// return to the front, so that it never snaps from one side to the other.
#[inline(always)]
fn held<R: Real>(yaw: R, limit: R) -> R {
    let (size, half_turn) = (yaw.abs(), R::splat(angle::HALF_TURN));
    let behind = R::splat(0.5) * (limit + half_turn);
    let back = limit * (half_turn - size) / (half_turn - behind);
    let kept = R::choose(behind.less(size), back, limit);
    let kept = R::choose(yaw.less(R::splat(0.0)), -kept, kept);
    R::choose(limit.less(size), kept, yaw)
}

/// Constraints and chains of gazes, one gaze in each lane.
struct Gazes<const COUNT: usize> {
    frame: Frame<Simd<COUNT>>,
    /// Direction that the end of the chain faces.
    start: Sight<Simd<COUNT>>,
    /// Positions of the chain's joints before the constraint. Shorter chains repeat their last
    /// joint.
    positions: [[Simd<COUNT>; 3]; MAX_LINKS as usize],
    /// Share of the whole rotation for each joint; 0 from the last joint on.
    shares: [Simd<COUNT>; MAX_LINKS as usize],
    /// Tangents of the limits: to either side, up, down.
    tangents: [Simd<COUNT>; 3],
    /// The limits in radians.
    limits: [Simd<COUNT>; 3],
    /// Joints of the longest chain.
    links_most: usize,
    /// The largest number of targets.
    targets_most: usize,
}

/// A target of each member.
struct Seen<const COUNT: usize> {
    sight: Sight<Simd<COUNT>>,
    weight: Simd<COUNT>,
    counts: [bool; COUNT],
}

impl<C: Company<COUNT>, const COUNT: usize> Programs<'_, C, COUNT> {
    /// Collects the members' constraints and chains.
    #[inline(always)]
    fn put_gazes(&mut self) -> Gazes<COUNT> {
        let zero = Simd([0.0; COUNT]);
        let none = [zero; 3];
        let nowhere = Sight { left: zero, up: zero, front: zero, level: zero };
        let mut gazes = Gazes {
            frame: Frame { front: none, left: none, up: none },
            start: nowhere,
            positions: [none; MAX_LINKS as usize],
            shares: [zero; MAX_LINKS as usize],
            tangents: none,
            limits: none,
            links_most: 1,
            targets_most: 0,
        };
        for lane in 0..self.members.len() {
            let Some(Stop { solver, step, .. }) = self.stop(lane) else { continue };
            let constraint = solver.constraint(step);
            gazes.links_most = gazes.links_most.max(constraint.link_count as usize);
            gazes.targets_most = gazes.targets_most.max(constraint.target_count as usize);
        }
        let (mut front, mut up, mut facing) = (none, none, none);
        for lane in 0..self.members.len() {
            let Some(Stop { solver, step, joints, parents }) = self.stop(lane) else { continue };
            let constraint = solver.constraint(step);
            let links = solver.links(constraint);
            let own = joints.model_of(step.joint as usize);
            let Chain { positions, end } = Solver::walk(&joints, links, own);
            let (mut ahead, mut above) = (constraint.front.xyz(), constraint.up.xyz());
            let parent = parents[step.joint as usize];
            if parent != NONE {
                let parent = joints.model_of(parent as usize);
                (ahead, above) = (parent.transform_vector(ahead), parent.transform_vector(above));
            }
            put(&mut front, lane, ahead);
            put(&mut up, lane, above);
            put(&mut facing, lane, end.transform_vector(constraint.axis.xyz()));
            let tangents = [constraint.axis.0[3], constraint.front.0[3], constraint.up.0[3]];
            put(&mut gazes.tangents, lane, tangents);
            put(&mut gazes.limits, lane, constraint.limits.xyz());
            let last = links.len() - 1;
            for (at, all) in gazes.positions[..gazes.links_most].iter_mut().enumerate() {
                put(all, lane, positions[at.min(last)]);
            }
            for (share, link) in gazes.shares.iter_mut().zip(&links[..last]) {
                share.0[lane] = link.share;
            }
        }
        gazes.frame = Frame::frame_of(front, up);
        // Straight up or down there is no side to turn from: that counts as front.
        let start = gazes.frame.seen_in(facing);
        let steep = Simd::splat(GAZE_UPRIGHT);
        let upright = start.level.less(steep);
        gazes.start = Sight {
            left: Simd::choose(upright, zero, start.left),
            up: start.up,
            front: Simd::choose(upright, steep, start.front),
            level: Simd::choose(upright, steep, start.level),
        };
        gazes
    }

    /// Returns target `nth` of each member as seen from a point, its weight, and whether it counts.
    #[inline(always)]
    fn see_target(
        &mut self,
        gazes: &Gazes<COUNT>,
        nth: usize,
        from: &[Simd<COUNT>; 3],
    ) -> Seen<COUNT> {
        let (mut place, mut weight) = (*from, Simd([0.0; COUNT]));
        for lane in 0..self.members.len() {
            let Some(Stop { solver, step, .. }) = self.stop(lane) else { continue };
            if let Some(target) = solver.targets(solver.constraint(step)).get(nth) {
                let seen: WeightedPoint = solver.sight(target, lane_of(from, lane));
                put(&mut place, lane, seen.position);
                weight.0[lane] = seen.weight;
            }
        }
        let sight = gazes.frame.seen_in(vec3::sub(place, *from));
        let Sight { left, up, front, .. } = sight;
        let length = left * left + up * up + front * front;
        let mut counts = [false; COUNT];
        for (lane, counts) in counts.iter_mut().enumerate() {
            *counts = weight.0[lane] > 0.0 && length.0[lane] > 0.0;
        }
        Seen { sight, weight, counts }
    }

    /// Returns the rotations towards the weighted mean of all targets, within the limits.
    #[inline(always)]
    fn aim_by_angles(&mut self, gazes: &Gazes<COUNT>, from: &[Simd<COUNT>; 3]) -> [Simd<COUNT>; 4] {
        let (zero, one) = (Simd([0.0; COUNT]), Simd([1.0; COUNT]));
        let [side, most, down] = gazes.limits;
        let least = -down;
        let (mut yaw, mut pitch, mut total) = (zero, zero, zero);
        for nth in 0..gazes.targets_most {
            let Seen { sight: seen, weight, counts } = self.see_target(gazes, nth, from);
            let is_steep = seen.level.less(Simd::splat(GAZE_STEEP));
            let steep = Simd::choose(is_steep, seen.level * Simd::splat(1.0 / GAZE_STEEP), one);
            let upwards = angle::of(seen.up, seen.level);
            let raised = Simd::choose(most.less(upwards), most, upwards);
            let raised = Simd::choose(raised.less(least), least, raised);
            let to_side = held(angle::of(seen.left, seen.front), side) * steep * weight;
            yaw = Simd::choose(counts, yaw + to_side, yaw);
            pitch = Simd::choose(counts, pitch + raised * weight, pitch);
            total = Simd::choose(counts, total + weight, total);
        }
        let (k, half) = (one / total, Simd::splat(0.5));
        let start = angle::of(gazes.start.left, gazes.start.front);
        let (side, ahead) = angle::sin_cos(half * (yaw * k - start));
        let (height, level) = angle::sin_cos(pitch * k);
        gazes.frame.gaze_rotation(&gazes.start, HalfYaw { side, ahead }, level, height)
    }

    /// Returns the rotations from facing `start` to facing the targets as seen from a point, and
    /// the sums of their weights, at most 1.
    #[inline(always)]
    fn aim(
        &mut self,
        gazes: &Gazes<COUNT>,
        from: &[Simd<COUNT>; 3],
    ) -> ([Simd<COUNT>; 4], Simd<COUNT>) {
        let (zero, one) = (Simd([0.0; COUNT]), Simd([1.0; COUNT]));
        let mut to = Sight { left: zero, up: zero, front: zero, level: zero };
        let (mut total, mut count) = (zero, [0; COUNT]);
        for nth in 0..gazes.targets_most {
            let Seen { sight: seen, weight, counts } = self.see_target(gazes, nth, from);
            to = Sight {
                left: Simd::choose(counts, seen.left, to.left),
                up: Simd::choose(counts, seen.up, to.up),
                front: Simd::choose(counts, seen.front, to.front),
                level: Simd::choose(counts, seen.level, to.level),
            };
            total = Simd::choose(counts, total + weight, total);
            for (count, counts) in count.iter_mut().zip(counts) {
                *count += u32::from(counts);
            }
        }
        let weight = Simd::choose(total.less(one), total, one);
        // Tangents of the limits. If start and target are both in front, the shortest rotation
        // passes the front.
        let [side, up, down] = &gazes.tangents;
        let (mut straight, mut by_angles) = ([false; COUNT], [false; COUNT]);
        for lane in 0..COUNT {
            let [left, height] = [to.left.0[lane], to.up.0[lane]];
            let [front, level] = [to.front.0[lane], to.level.0[lane]];
            let within = level >= GAZE_STEEP
                && left.abs() <= side.0[lane] * front
                && height <= up.0[lane] * level
                && -height <= down.0[lane] * level;
            straight[lane] = count[lane] == 1 && within && gazes.start.front.0[lane] > 0.0;
            by_angles[lane] = count[lane] > 0 && !straight[lane];
        }
        let start = &gazes.start;
        let side = start.front * to.left - start.left * to.front;
        let ahead = start.level * to.level + (start.left * to.left + start.front * to.front);
        let rotation = gazes.frame.gaze_rotation(start, HalfYaw { side, ahead }, to.level, to.up);
        let mut rotation = quat::choose::<Simd<COUNT>>(straight, rotation, quat::identity());
        if by_angles.contains(&true) {
            let bent = self.aim_by_angles(gazes, from);
            rotation = quat::choose::<Simd<COUNT>>(by_angles, bent, rotation);
        }
        (rotation, weight)
    }

    /// Turns chains towards their targets.
    #[inline(always)]
    pub(super) fn gaze(&mut self) {
        let gazes = self.put_gazes();
        let (zero, one) = (Simd([0.0; COUNT]), Simd([1.0; COUNT]));
        let (whole, weight) = self.aim(&gazes, &gazes.positions[gazes.links_most - 1]);
        let mut rotations = [quat::identity::<Simd<COUNT>>(); MAX_LINKS as usize];
        let (mut so_far, mut shared) = (quat::identity(), zero);
        let mut position = gazes.positions[0];
        for (at, rotation) in rotations[..gazes.links_most - 1].iter_mut().enumerate() {
            let share = gazes.shares[at] * weight;
            let takes_part = zero.less(share);
            shared = Simd::choose(takes_part, shared + share, shared);
            let now = vec3::part_as_told(whole, shared);
            let now = quat::choose::<Simd<COUNT>>(takes_part, now, so_far);
            let own = quat::mul(now, quat::conjugate(so_far));
            *rotation = quat::choose::<Simd<COUNT>>(takes_part, own, quat::identity());
            so_far = now;
            let bone = vec3::sub(gazes.positions[at + 1], gazes.positions[at]);
            position = vec3::add(position, vec3::rotated(so_far, bone));
        }
        // The other joints have moved the last one. It looks from its new position, and rotates by
        // the remainder.
        let (there, weight) = self.aim(&gazes, &position);
        let part = vec3::part_as_told(there, weight);
        let there = quat::choose::<Simd<COUNT>>(weight.less(one), part, there);
        let left = quat::mul(there, quat::conjugate(so_far));
        for lane in 0..self.members.len() {
            self.rotate_chain(lane, &rotations, &left);
        }
    }

    /// Rotates the first joint of a member's chain, and hands down the rotations of the others.
    #[inline(always)]
    fn rotate_chain(
        &mut self,
        lane: usize,
        rotations: &[[Simd<COUNT>; 4]],
        left: &[Simd<COUNT>; 4],
    ) {
        let Some(Stop { solver, step, mut joints, .. }) = self.stop(lane) else { return };
        let (first, joint) = (step.operand as usize, step.joint as usize);
        let last = solver.links(solver.constraint(step)).len() - 1;
        for (at, rotation) in rotations.iter().enumerate().take(last).skip(1) {
            solver.step_rotations[first + at - 1] = lane_of(rotation, lane);
        }
        let mut own = lane_of(left, lane);
        if last > 0 {
            solver.step_rotations[first + last - 1] = own;
            own = lane_of(&rotations[0], lane);
        }
        joints.keep_model(joint, joints.model_of(joint).rotated(own));
    }
}
