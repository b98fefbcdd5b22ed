//! Look-at constraints: the joints of a chain share a rotation, and the last joint faces the
//! targets. Twin of `kernels/gaze.cl`.
//!
//! Reads constraints, links and targets, and the chain's transforms. Writes the first joint's model
//! transform, and rotations for the others.
//!
//! The rotation is a yaw about the up direction and a pitch about the left direction of the frame
//! that carries the chain, so that heads do not tilt. Both come straight from the directions before
//! and after. Angles are needed only beyond the limits and between several targets.

use populace_device::layout::{GAZE_STEEP, GAZE_UPRIGHT, Link, MAX_LINKS, NONE};
use populace_model::math::{Real, angle, quat, vec3};

use super::programs::{Company, Programs, Stop};
use super::targets::WeightedPoint;
use crate::dispatch::Work;
use crate::lanes::{LANES, Members, Simd, lane_of, load, put, store};
use crate::matrices::transform_vector;
use crate::widths::JointLanes;

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

/// A gaze's constraint and chain, of one member or of several in lanes.
struct Gaze<R> {
    /// The first of the lanes.
    lane: usize,
    frame: Frame<R>,
    /// Direction that the end of the chain faces.
    start: Sight<R>,
    /// Positions of the chain's joints before the constraint.
    positions: [[R; 3]; MAX_LINKS as usize],
    /// Share of the whole rotation for each joint; 0 for the last joint.
    shares: [R; MAX_LINKS as usize],
    /// Tangents of the limits: to either side, up, down.
    tangents: [R; 3],
    /// The limits in radians.
    limits: [R; 3],
    /// The largest number of targets.
    targets_most: usize,
}

/// Numbers of a gaze's constraint: front, up, the axis that the end faces, tangents, limits.
const NUMBERS: usize = 15;

/// Numbers of members' constraints, as collected member by member.
struct Collected<const COUNT: usize> {
    numbers: [Simd<COUNT>; NUMBERS],
    shares: [Simd<COUNT>; MAX_LINKS as usize],
    targets_most: usize,
}

/// A target.
struct Seen<R: Real> {
    sight: Sight<R>,
    weight: R,
    counts: R::Choice,
}

/// The next step of members side by side, a gaze.
pub(super) struct GazeStep<'a, P>(pub(super) &'a mut P);

impl<C: Company<COUNT>, const COUNT: usize> Work for GazeStep<'_, Programs<'_, C, COUNT>> {
    const IS_WIDE: bool = COUNT > 1;

    #[inline(always)]
    fn run<J: JointLanes>(self) {
        self.0.gaze::<C::Members<J>>();
    }
}

impl<C: Company<COUNT>, const COUNT: usize> Programs<'_, C, COUNT> {
    /// Collects numbers of the members' constraints.
    #[inline(always)]
    fn put_gazes(&mut self) -> Collected<COUNT> {
        let zero = Simd([0.0; COUNT]);
        let mut all = Collected {
            numbers: [zero; NUMBERS],
            shares: [zero; MAX_LINKS as usize],
            targets_most: 0,
        };
        for lane in 0..self.members.len() {
            let Some(Stop { solver, step, .. }) = self.stop(lane) else { continue };
            let constraint = solver.constraint(step);
            all.targets_most = all.targets_most.max(constraint.target_count as usize);
            let [ax, ay, az, side] = constraint.axis.0;
            let [fx, fy, fz, up] = constraint.front.0;
            let [ux, uy, uz, down] = constraint.up.0;
            let [yaw, rise, fall] = constraint.limits.xyz();
            let own = [fx, fy, fz, ux, uy, uz, ax, ay, az, side, up, down, yaw, rise, fall];
            put(&mut all.numbers, lane, own);
            let links = solver.links(constraint);
            for (share, link) in all.shares.iter_mut().zip(&links[..links.len() - 1]) {
                share.0[lane] = link.share;
            }
        }
        all
    }

    /// Returns the gazes of as many members as `R` has lanes. `joint` is the first of their chains.
    #[inline(always)]
    fn gaze_of<R: Members>(
        &self,
        all: &Collected<COUNT>,
        (joint, links): (usize, &[Link]),
        lane: usize,
    ) -> Gaze<R> {
        let zero = R::splat(0.0);
        let [fx, fy, fz, ux, uy, uz, ax, ay, az, side, rise, fall, limits @ ..] =
            load::<R, COUNT, NUMBERS>(&all.numbers, lane);
        let (mut front, mut up) = ([fx, fy, fz], [ux, uy, uz]);
        let mut positions = [[zero; 3]; MAX_LINKS as usize];
        let end = self.walk(links, lane, &mut positions);
        if self.parents[joint] != NONE {
            let parent = self.joints.models_of(self.parents[joint] as usize, lane);
            front = transform_vector(&parent, front);
            up = transform_vector(&parent, up);
        }
        let frame = Frame::frame_of(front, up);
        // Straight up or down there is no side to turn from: that counts as front.
        let start = frame.seen_in(transform_vector(&end, [ax, ay, az]));
        let steep = R::splat(GAZE_UPRIGHT);
        let upright = start.level.less(steep);
        let start = Sight {
            left: R::choose(upright, zero, start.left),
            up: start.up,
            front: R::choose(upright, steep, start.front),
            level: R::choose(upright, steep, start.level),
        };
        let (shares, tangents) = (load(&all.shares, lane), [side, rise, fall]);
        let targets_most = all.targets_most;
        Gaze { lane, frame, start, positions, shares, tangents, limits, targets_most }
    }

    /// Returns target `nth` of each member as seen from a point, its weight, and whether it counts.
    #[inline(always)]
    fn see_target<R: Members>(&mut self, gaze: &Gaze<R>, nth: usize, from: [R; 3]) -> Seen<R> {
        let mut places = [Simd([0.0; LANES]); 3];
        let mut weights = [Simd([0.0; LANES])];
        store(&from, &mut places, 0);
        for lane in 0..R::COUNT {
            let Some(Stop { solver, step, .. }) = self.stop(gaze.lane + lane) else { continue };
            if let Some(target) = solver.targets(solver.constraint(step)).get(nth) {
                let seen: WeightedPoint = solver.sight(target, lane_of(&places, lane));
                put(&mut places, lane, seen.position);
                put(&mut weights, lane, [seen.weight]);
            }
        }
        let (place, [weight]) = (load::<R, LANES, 3>(&places, 0), load::<R, LANES, 1>(&weights, 0));
        let sight = gaze.frame.seen_in(vec3::sub(place, from));
        let Sight { left, up, front, .. } = sight;
        let (zero, length) = (R::splat(0.0), left * left + up * up + front * front);
        Seen { sight, weight, counts: R::both(zero.less(weight), zero.less(length)) }
    }

    /// Returns the rotation towards the weighted mean of all targets, within the limits.
    #[inline(always)]
    fn aim_by_angles<R: Members>(&mut self, gaze: &Gaze<R>, from: [R; 3]) -> [R; 4] {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let [side, most, down] = gaze.limits;
        let least = -down;
        let (mut yaw, mut pitch, mut total) = (zero, zero, zero);
        for nth in 0..gaze.targets_most {
            let Seen { sight: seen, weight, counts } = self.see_target(gaze, nth, from);
            let is_steep = seen.level.less(R::splat(GAZE_STEEP));
            let steep = R::choose(is_steep, seen.level * R::splat(1.0 / GAZE_STEEP), one);
            let upwards = angle::of(seen.up, seen.level);
            let raised = R::choose(most.less(upwards), most, upwards);
            let raised = R::choose(raised.less(least), least, raised);
            let to_side = held(angle::of(seen.left, seen.front), side) * steep * weight;
            yaw = R::choose(counts, yaw + to_side, yaw);
            pitch = R::choose(counts, pitch + raised * weight, pitch);
            total = R::choose(counts, total + weight, total);
        }
        let (k, half) = (one / total, R::splat(0.5));
        let start = angle::of(gaze.start.left, gaze.start.front);
        let (side, ahead) = angle::sin_cos(half * (yaw * k - start));
        let (height, level) = angle::sin_cos(pitch * k);
        gaze.frame.gaze_rotation(&gaze.start, HalfYaw { side, ahead }, level, height)
    }

    /// Returns the rotation from facing `start` to facing the targets as seen from a point, and the
    /// sum of their weights, at most 1.
    #[inline(always)]
    fn aim<R: Members>(&mut self, gaze: &Gaze<R>, from: [R; 3]) -> ([R; 4], R) {
        let (zero, one, half) = (R::splat(0.0), R::splat(1.0), R::splat(0.5));
        let mut to = Sight { left: zero, up: zero, front: zero, level: zero };
        let (mut total, mut count) = (zero, zero);
        for nth in 0..gaze.targets_most {
            let Seen { sight: seen, weight, counts } = self.see_target(gaze, nth, from);
            to = Sight {
                left: R::choose(counts, seen.left, to.left),
                up: R::choose(counts, seen.up, to.up),
                front: R::choose(counts, seen.front, to.front),
                level: R::choose(counts, seen.level, to.level),
            };
            total = R::choose(counts, total + weight, total);
            count = R::choose(counts, count + one, count);
        }
        // Tangents of the limits. If start and target are both in front, the shortest rotation
        // passes the front.
        let ([side, up, down], start) = (gaze.tangents, &gaze.start);
        let is_level = R::splat(GAZE_STEEP).at_most(to.level);
        let to_sides = to.left.abs().at_most(side * to.front);
        let in_height = R::both(to.up.at_most(up * to.level), (-to.up).at_most(down * to.level));
        let within = R::both(R::both(is_level, to_sides), in_height);
        let any_target = half.less(count);
        let only_one = R::both(any_target, count.less(one + half));
        let straight = R::both(R::both(only_one, within), zero.less(start.front));
        let by_angles = R::both(any_target, R::others(straight));
        let side = start.front * to.left - start.left * to.front;
        let ahead = start.level * to.level + (start.left * to.left + start.front * to.front);
        let rotation = gaze.frame.gaze_rotation(start, HalfYaw { side, ahead }, to.level, to.up);
        let mut rotation = quat::choose::<R>(straight, rotation, quat::identity());
        if R::any(by_angles) {
            let bent = self.aim_by_angles(gaze, from);
            rotation = quat::choose::<R>(by_angles, bent, rotation);
        }
        (rotation, R::choose(total.less(one), total, one))
    }

    /// Returns the rotations of a chain of `count` joints towards the targets.
    #[inline(always)]
    fn chain_rotations<R: Members>(
        &mut self,
        gaze: &Gaze<R>,
        count: usize,
    ) -> [[R; 4]; MAX_LINKS as usize] {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let (whole, weight) = self.aim(gaze, gaze.positions[count - 1]);
        let mut rotations = [quat::identity::<R>(); MAX_LINKS as usize];
        let (mut so_far, mut shared) = (quat::identity(), zero);
        let mut position = gaze.positions[0];
        for (at, rotation) in rotations[..count - 1].iter_mut().enumerate() {
            let share = gaze.shares[at] * weight;
            let takes_part = zero.less(share);
            shared = R::choose(takes_part, shared + share, shared);
            let now = vec3::part_as_told(whole, shared);
            let now = quat::choose::<R>(takes_part, now, so_far);
            let own = quat::mul(now, quat::conjugate(so_far));
            *rotation = quat::choose::<R>(takes_part, own, quat::identity());
            so_far = now;
            let bone = vec3::sub(gaze.positions[at + 1], gaze.positions[at]);
            position = vec3::add(position, vec3::rotated(so_far, bone));
        }
        // The other joints have moved the last one. It looks from its new position, and rotates by
        // the remainder.
        let (there, weight) = self.aim(gaze, position);
        let part = vec3::part_as_told(there, weight);
        let there = quat::choose::<R>(weight.less(one), part, there);
        rotations[count - 1] = quat::mul(there, quat::conjugate(so_far));
        rotations
    }

    /// Turns chains towards their targets.
    #[inline(always)]
    fn gaze<R: Members>(&mut self) {
        let Some((step, constraint)) = self.first_stop() else { return };
        let (joint, operand) = (step.joint as usize, step.operand as usize);
        let links = self.links(constraint);
        let all = self.put_gazes();
        let mut firsts = quat::identity::<Simd<COUNT>>();
        for lane in (0..self.members.len()).step_by(R::COUNT) {
            let gaze: Gaze<R> = self.gaze_of(&all, (joint, links), lane);
            let rotations = self.chain_rotations(&gaze, links.len());
            store(&rotations[0], &mut firsts, lane);
            for (at, rotation) in rotations[1..links.len()].iter().enumerate() {
                store(rotation, &mut self.rotations[operand + at], lane);
            }
        }
        self.joints.rotate::<R>(joint, &firsts);
    }
}
