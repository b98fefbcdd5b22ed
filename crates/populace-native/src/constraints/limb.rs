//! Two-bone inverse kinematics, of one limb or of several in SIMD lanes. Twin of `kernels/limb.cl`.
//!
//! Reads constraints, links and targets, and the chain's transforms. Writes the first joint's model
//! transform, and rotations for the others.

use populace_device::layout::{LIMB_LARGEST_SQUARE, LIMB_OWN_BEND, MAX_LINKS};
use populace_model::math::{Real, quat, vec3};

use super::programs::{Company, Programs, Stop};
use super::targets::WeightedPoint;
use crate::dispatch::Work;
use crate::lanes::{Members, Simd, lane_of, load, put, store};
use crate::matrices::{origin, transform_vector};
use crate::widths::JointLanes;

/// A limb before the constraint, in model space, and its goal.
#[derive(Clone, Copy)]
pub(super) struct Limb<R> {
    /// From the first joint to the middle one.
    pub(super) upper: [R; 3],
    /// From the middle joint to the last one.
    pub(super) lower: [R; 3],
    /// Direction that the middle joint bends to when the limb is straight.
    pub(super) bend: [R; 3],
    /// From the first joint to the end's goal.
    pub(super) to: [R; 3],
}

/// Lengths of a limb's bones, in metres.
#[derive(Clone, Copy)]
pub(super) struct BoneLengths<R> {
    pub(super) upper: R,
    pub(super) lower: R,
    /// Inverse of `upper`.
    shrinks: R,
}

/// Direction in model space that the middle joint is drawn to, where `counts` is true.
pub(super) struct Pole<R: Real> {
    direction: [R; 3],
    counts: R::Choice,
}

fn none<R: Real>() -> [R; 3] {
    [R::splat(0.0); 3]
}

/// Returns the distance that the end of a chain goes to for a target at `distance`. The end reaches
/// from `least` to `length`. Above `length * (1 - soft)` and below `least + (length - least) *
/// soft` it approaches the limit ever more slowly, so that the chain does not snap straight.
#[inline(always)]
pub(super) fn soft_distance<R: Real>(distance: R, length: R, least: R, soft: R) -> R {
    let (far, near) = (length - length * soft, least + (length - least) * soft);
    let beyond = far.less(distance);
    let over = R::choose(beyond, distance - far, near - distance);
    let slack = R::choose(beyond, length * soft, near - least);
    let eased = slack * over / (slack + over);
    R::choose(beyond, far + eased, R::choose(distance.less(near), near - eased, distance))
}

/// Returns the shortest rotation from one vector to another. `lengths` is the product of their
/// lengths; `about` is the axis for opposite vectors, at right angles to them.
#[inline(always)]
fn swing_between<R: Real>(from: [R; 3], to: [R; 3], lengths: R, about: [R; 3]) -> [R; 4] {
    let ([x, y, z], w) = (vec3::cross(from, to), lengths + vec3::dot(from, to));
    let over = [about[0], about[1], about[2], R::splat(0.0)];
    let rotation = quat::choose::<R>((lengths * R::splat(1e-6)).less(w), [x, y, z, w], over);
    quat::normalize_or(rotation, quat::identity())
}

impl<R: Real> Limb<R> {
    /// Returns the lengths of the bones.
    #[inline(always)]
    pub(super) fn bone_lengths(&self) -> BoneLengths<R> {
        let square = vec3::dot(self.upper, self.upper);
        let (upper, lower) = (vec3::root(square), vec3::length(self.lower));
        BoneLengths { upper, lower, shrinks: square.inverse_sqrt() }
    }

    /// Returns the axis about which the middle joint bends, of any length: at right angles to the
    /// limb's own bend. The straighter the limb, the more its preferred bend direction counts.
    /// `shrinks` is the inverse of the upper bone's length.
    #[inline(always)]
    fn hinge(&self, shrinks: R) -> [R; 3] {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let (x, y) = ([one, zero, zero], [zero, one, zero]);
        let upper = vec3::scale(self.upper, shrinks);
        let chain = vec3::add(upper, vec3::scale(self.lower, shrinks));
        let out =
            vec3::add_scaled(upper, vec3::unit_or(self.bend, none()), R::splat(LIMB_OWN_BEND));
        let hinge = vec3::cross(out, chain);
        let stands = R::splat(1e-10).less(vec3::dot(hinge, hinge));
        let leans = (upper[0] * upper[0]).less(R::splat(0.5));
        vec3::choose::<R>(stands, hinge, vec3::cross(upper, vec3::choose::<R>(leans, x, y)))
    }

    /// Returns the rotation about the line from the first joint to the goal that brings the middle
    /// joint nearest to a pole.
    #[inline(always)]
    fn pole_rotation(&self, first: [R; 4], hinge: [R; 3], pole: [R; 3]) -> [R; 4] {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let ahead = vec3::unit_or(self.to, [one, zero, zero]);
        let upper = vec3::rotated(first, self.upper);
        let bend = vec3::cross(ahead, vec3::rotated(first, hinge));
        let out = vec3::unit_or(vec3::across(upper, ahead), bend);
        let drawn = vec3::unit_or(vec3::across(pole, ahead), out);
        swing_between(out, drawn, one, ahead)
    }

    /// Returns the rotations that bring the end to its goal: that of the first joint, and that of
    /// the middle joint after the first one's. Identities for a limb of no length.
    #[inline(always)]
    pub(super) fn limb_rotations(
        &self,
        lengths: BoneLengths<R>,
        pole: Option<Pole<R>>,
        soft: R,
    ) -> [[R; 4]; 2] {
        let (upper, lower) = (self.upper, self.lower);
        let (zero, one, half, two) = (R::splat(0.0), R::splat(1.0), R::splat(0.5), R::splat(2.0));
        let (aa, bb) = (vec3::dot(upper, upper), vec3::dot(lower, lower));
        let (a, b, distance) = (lengths.upper, lengths.lower, vec3::length(self.to));
        let shorter = R::choose(a.less(b), a, b);
        let longer = R::choose(a.less(b), b, a);
        let reach = soft_distance(distance, a + b, longer - shorter, soft);
        // The lower bone rotates about the hinge until both bones together reach the distance. The
        // part along the hinge stays, and the dot product of both bones is a cosine of the angle.
        // All is scaled by nn, the square of the hinge's length, so that no term has to wait for
        // the root.
        let hinge = self.hinge(lengths.shrinks);
        let side = vec3::cross(hinge, lower);
        let nn = vec3::dot(hinge, hinge);
        let unit = nn.inverse_sqrt();
        let along = vec3::dot(hinge, lower);
        let still = vec3::dot(hinge, upper) * along;
        let (p, q) = (vec3::dot(upper, lower) * nn - still, vec3::dot(upper, side));
        let most = p * p + q * q * nn;
        let k = most.inverse_sqrt();
        let wanted = ((reach * reach - aa - bb) * half * nn - still) * k;
        let below = R::choose(wanted.less(one), wanted, one);
        let c = R::choose((-one).less(below), below, -one);
        let s = vec3::root((one - c) * (one + c));
        let (p, q) = (p * k, q * vec3::root(nn) * k);
        let (cosine, sine) = (p * c - q * s, q * c + p * s);
        // Half the angle, from the larger one of its sine and cosine.
        let back = cosine.less(zero);
        let (x, w) = (R::choose(back, one - cosine, sine), R::choose(back, sine, one + cosine));
        let half_unit = (x * x + w * w).inverse_sqrt();
        // Then the whole limb swings to the goal.
        let rest = vec3::scale(hinge, along * (unit * unit));
        let level = vec3::add_scaled(lower, rest, -one);
        let lower = vec3::add_scaled(vec3::add_scaled(rest, level, cosine), side, sine * unit);
        let reached = vec3::root(aa + bb + (still + most * k * c) * (unit * unit) * two);
        let axis = vec3::scale(hinge, unit);
        let mut first = swing_between(vec3::add(upper, lower), self.to, reached * distance, axis);
        if let Some(Pole { direction, counts }) = pole {
            let drawn = quat::mul(self.pole_rotation(first, axis, direction), first);
            first = quat::choose::<R>(counts, drawn, first);
        }
        let bend = vec3::scale(vec3::rotated(first, axis), x * half_unit);
        let second = [bend[0], bend[1], bend[2], w * half_unit];
        let size = R::choose(shorter.less(distance), shorter, distance);
        let size = R::choose(most.less(R::splat(LIMB_LARGEST_SQUARE)), size, zero);
        let stands = R::splat(1e-6).less(size);
        let none = quat::identity();
        [quat::choose::<R>(stands, first, none), quat::choose::<R>(stands, second, none)]
    }
}

/// Scales rotations by weights below 1. If all weights are 1, it returns the rotations at once.
#[inline(always)]
pub(super) fn weighted<R: Members>(rotation: [R; 4], weight: R) -> [R; 4] {
    let partly = weight.less(R::splat(1.0));
    if !R::any(partly) {
        return rotation;
    }
    quat::choose::<R>(partly, vec3::part_of(rotation, weight), rotation)
}

/// Numbers of a limb's constraint: its axis, its pole and whether it has one, its softness, whether
/// it keeps its end, and the position and weight of its goal.
const NUMBERS: usize = 13;

/// The next step of members side by side, a limb.
pub(super) struct ReachStep<'a, P>(pub(super) &'a mut P);

impl<C: Company<COUNT>, const COUNT: usize> Work for ReachStep<'_, Programs<'_, C, COUNT>> {
    const IS_WIDE: bool = COUNT > 1;

    #[inline(always)]
    fn run<J: JointLanes>(self) {
        self.0.reach::<C::Members<J>>();
    }
}

impl<C: Company<COUNT>, const COUNT: usize> Programs<'_, C, COUNT> {
    /// Collects numbers of the members' constraints. `from` are the positions of the first joints.
    #[inline(always)]
    fn put_limbs(&mut self, from: &[Simd<COUNT>; 3]) -> [Simd<COUNT>; NUMBERS] {
        let mut numbers = [Simd([0.0; COUNT]); NUMBERS];
        for lane in 0..self.members.len() {
            let Some(Stop { solver, step, .. }) = self.stop(lane) else { continue };
            let constraint = solver.constraint(step);
            let WeightedPoint { position: [tx, ty, tz], weight } =
                solver.goal(constraint, lane_of(from, lane));
            let ([x, y, z], [px, py, pz, has_pole]) = (constraint.axis.xyz(), constraint.front.0);
            let keeps_end = if constraint.keeps_end == 0 { 0.0 } else { 1.0 };
            let soft = constraint.limits.0[0];
            let own = [x, y, z, px, py, pz, has_pole, soft, keeps_end, tx, ty, tz, weight];
            put(&mut numbers, lane, own);
        }
        numbers
    }

    /// Brings the ends of limbs to their targets.
    #[inline(always)]
    fn reach<R: Members>(&mut self) {
        let Some((step, constraint)) = self.first_stop() else { return };
        let (joint, operand) = (step.joint as usize, step.operand as usize);
        let (links, middle) = (self.links(constraint), constraint.middle as usize);
        let mut from = [Simd([0.0; COUNT]); 3];
        for lane in (0..self.members.len()).step_by(R::COUNT) {
            store(&origin(&self.joints.models_of::<R>(joint, lane)), &mut from, lane);
        }
        let numbers = self.put_limbs(&from);
        let zero = R::splat(0.0);
        let mut firsts = quat::identity::<Simd<COUNT>>();
        for lane in (0..self.members.len()).step_by(R::COUNT) {
            let [x, y, z, px, py, pz, has_pole, soft, keeps_end, tx, ty, tz, weight] =
                load::<R, COUNT, NUMBERS>(&numbers, lane);
            let mut positions = [[zero; 3]; MAX_LINKS as usize];
            self.walk(links, lane, &mut positions);
            let own = self.joints.models_of(joint, lane);
            let limb = Limb {
                upper: vec3::sub(positions[middle], positions[0]),
                lower: vec3::sub(positions[links.len() - 1], positions[middle]),
                bend: transform_vector(&own, [x, y, z]),
                to: vec3::sub([tx, ty, tz], positions[0]),
            };
            let counts = zero.less(has_pole);
            let pole = R::any(counts).then_some(Pole { direction: [px, py, pz], counts });
            let aims = zero.less(weight);
            let mut rotations = limb.limb_rotations(limb.bone_lengths(), pole, soft);
            for rotation in &mut rotations {
                *rotation = quat::choose::<R>(aims, *rotation, quat::identity());
                *rotation = weighted(*rotation, weight);
            }
            let [first, second] = rotations;
            let undone = quat::conjugate(quat::mul(second, first));
            let undone = quat::choose::<R>(zero.less(keeps_end), undone, quat::identity());
            store(&first, &mut firsts, lane);
            store(&second, &mut self.rotations[operand], lane);
            store(&undone, &mut self.rotations[operand + 1], lane);
        }
        self.joints.rotate::<R>(joint, &firsts);
    }
}
