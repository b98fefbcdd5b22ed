//! Foot IK: planted feet stay where they stand, and the pelvis sinks for them. Twin of
//! `kernels/feet.cl`.
//!
//! Reads constraints, links and the legs' transforms. Writes the model transforms of pelvis or hip,
//! the pelvis' state, and rotations for hips, knees and ankles.

use populace_device::layout::{
    Constraint, Float4, Link, MAX_FEET, MAX_PELVIS_SINK, PELVIS_RISE_SECS, PELVIS_STATE,
};
use populace_model::Affine;
use populace_model::math::{Real, quat, vec3};

use super::foot::{FootGoal, Leg};
use super::limb::Limb;
use super::programs::{Company, Programs, Stop};
use super::targets::Solver;
use crate::hierarchy::Hierarchy;
use crate::lanes::{Simd, lane_of, put};

const FEET: usize = MAX_FEET as usize;

/// Legs of members side by side, one of each member, and the settings of their constraints.
#[derive(Clone, Copy)]
struct Legs<const COUNT: usize> {
    limb: Limb<Simd<COUNT>>,
    /// Tangent of half the angle about +Y by which the foot turns.
    turn: Simd<COUNT>,
    /// As [`FootGoal::follows`].
    follows: [Simd<COUNT>; 4],
    soft: Simd<COUNT>,
    weight: Simd<COUNT>,
}

impl<const COUNT: usize> Legs<COUNT> {
    /// Legs of no length.
    const NONE: Self = {
        let (zero, one) = (Simd([0.0; COUNT]), Simd([1.0; COUNT]));
        Self {
            limb: Limb::<Simd<COUNT>>::NONE,
            turn: zero,
            follows: [zero, zero, zero, one],
            soft: zero,
            weight: zero,
        }
    };

    /// Puts a leg into a lane.
    #[inline(always)]
    fn put_leg(&mut self, lane: usize, leg: &Leg, goal: &FootGoal, constraint: &Constraint) {
        let [x, y, z, turn] = goal.ankle;
        let one = Limb {
            upper: vec3::sub(leg.knee, leg.hip),
            lower: vec3::sub(leg.ankle.origin(), leg.knee),
            bend: leg.bend,
            to: vec3::sub([x, y, z], leg.hip),
        };
        self.limb.put_limb(lane, &one);
        put(&mut self.follows, lane, goal.follows);
        let [soft, weight, ..] = constraint.limits.0;
        (self.turn.0[lane], self.soft.0[lane], self.weight.0[lane]) = (turn, soft, weight);
    }

    /// Returns the drop of the pelvis, in metres, that each leg needs to reach its goal.
    #[inline(always)]
    fn sinks(&self) -> Simd<COUNT> {
        let length = vec3::length(self.limb.upper) + vec3::length(self.limb.lower);
        let one = Simd([1.0; COUNT]);
        let (reach, most) = (length * (one - self.soft), length * Simd::splat(MAX_PELVIS_SINK));
        let [x, y, z] = self.limb.to;
        let needed = -y - vec3::root(reach * reach - x * x - z * z);
        Simd::choose(most.less(needed), most, needed)
    }

    /// Returns the rotations of hips, knees and ankles.
    #[inline(always)]
    fn leg_rotations(&self) -> [[Simd<COUNT>; 4]; 3] {
        let (zero, one) = (Simd([0.0; COUNT]), Simd([1.0; COUNT]));
        let weight = self.weight;
        let [mut hip, mut knee] = self.limb.limb_rotations(None, self.soft);
        let partly = weight.less(one);
        if partly.contains(&true) {
            hip = quat::choose::<Simd<COUNT>>(partly, vec3::part_of(hip, weight), hip);
            knee = quat::choose::<Simd<COUNT>>(partly, vec3::part_of(knee, weight), knee);
        }
        // The ankle keeps its rotation from before the constraint, and follows the slope: by the
        // rotation from up to the normal.
        let [nx, ny, nz, follows] = self.follows;
        let slope = quat::normalize_or([nz, zero, -nx, one + ny], quat::identity());
        let slope = vec3::part_as_told(slope, follows * weight);
        let turned = quat::normalize_or([zero, self.turn * weight, zero, one], quat::identity());
        let ankle = quat::mul(slope, turned);
        let ankle = quat::mul(ankle, quat::conjugate(quat::mul(knee, hip)));
        [hip, knee, ankle]
    }
}

/// Returns the index of a foot's link to the ankle.
#[inline(always)]
fn ankle_link(foot: &Constraint) -> usize {
    (foot.link_count - 1 - foot.toe_links) as usize
}

impl Solver<'_> {
    /// Walks down a leg's chain from link `start`. `from` is the model transform of its joint.
    #[inline(never)]
    fn walk_leg(
        joints: &impl Hierarchy,
        links: &[Link],
        foot: &Constraint,
        start: usize,
        from: Affine,
    ) -> Leg {
        let none = [0.0; 3];
        let mut leg = Leg { hip: none, knee: none, bend: none, ankle: from, toes: from };
        let mut model = from;
        let ankle = ankle_link(foot);
        for (at, link) in links.iter().enumerate().skip(start) {
            if at > start {
                model = model.mul(&joints.local_of(link.joint as usize));
            }
            if at == foot.upper as usize {
                leg.hip = model.origin();
                leg.bend = model.transform_vector(foot.axis.xyz());
            }
            if at == foot.middle as usize {
                leg.knee = model.origin();
            }
            if at == ankle {
                leg.ankle = model;
            }
        }
        leg.toes = model;
        leg
    }

    /// Returns how far the pelvis is lowered, in metres, and keeps it. It sinks at once, so that
    /// feet reach the ground, and takes its time to rise.
    fn eased_drop(&mut self, wanted: f32) -> f32 {
        let Float4([before, _, _, bits]) = self.state(PELVIS_STATE);
        let elapsed_secs = self.inputs.frame.elapsed_secs();
        let drop = if wanted < before && bits.to_bits() == self.control.epoch {
            before + (wanted - before) * (elapsed_secs / (elapsed_secs + PELVIS_RISE_SECS))
        } else {
            wanted
        };
        let bits = f32::from_bits(self.control.epoch);
        self.keep_state(PELVIS_STATE, Float4([drop, 0.0, 0.0, bits]));
        drop
    }
}

impl<H: Hierarchy> Stop<'_, H> {
    /// Finds the goals of a member's feet, and puts its legs into a lane. Returns the number of
    /// feet. The goals are also handed down, for legs that another step moves after the pelvis.
    #[inline(never)]
    fn put_feet<const COUNT: usize>(
        &mut self,
        legs: &mut [Legs<COUNT>; FEET],
        lane: usize,
    ) -> usize {
        let Self { solver, step, joints, .. } = self;
        let own = joints.model_of(step.joint as usize);
        let first = solver.constraint(step);
        let count = first.target_count as usize;
        let constraints = &solver.tables.constraints().as_slice()[step.index as usize..][..count];
        let mut ankles = [Link::default(); FEET];
        for (ankle, constraint) in ankles.iter_mut().zip(constraints) {
            *ankle = solver.links(constraint)[ankle_link(constraint)];
        }
        let contacts = solver.contacts_of(&ankles, count);
        for (foot, constraint) in (0..first.target_count).zip(constraints) {
            let leg = Solver::walk_leg(&*joints, solver.links(constraint), constraint, 0, own);
            let goal = solver.foot_goal(foot, constraint, &leg, contacts[foot as usize]);
            legs[foot as usize].put_leg(lane, &leg, &goal, first);
            let to = (step.operand + 3 * foot) as usize;
            solver.step_rotations[to] = goal.ankle;
            solver.step_rotations[to + 1] = goal.follows;
        }
        count
    }

    /// Lowers a member's pelvis for its legs, which are in a lane.
    #[inline(always)]
    fn sink<const COUNT: usize>(
        &mut self,
        legs: &mut [Legs<COUNT>; FEET],
        needed: &[Simd<COUNT>; FEET],
        lane: usize,
    ) {
        let Self { solver, step, joints, .. } = self;
        let first = solver.constraint(step);
        let mut drop = 0.0;
        for needed in &needed[..first.target_count as usize] {
            drop = if needed.0[lane] > drop { needed.0[lane] } else { drop };
        }
        drop = solver.eased_drop(drop * first.limits.0[1]);
        let mut rows = joints.model_of(step.joint as usize).rows;
        rows[1][3] -= drop;
        joints.keep_model(step.joint as usize, Affine { rows });
        for leg in legs {
            leg.limb.to[1].0[lane] += drop;
        }
    }
}

impl<C: Company<COUNT>, const COUNT: usize> Programs<'_, C, COUNT> {
    /// Finds the goals of all feet, and lowers the pelvis until the legs can reach them. Solves the
    /// legs too, unless something else moves them after the pelvis.
    #[inline(always)]
    pub(super) fn pelvis(&mut self) {
        let (mut legs, mut most) = ([Legs::<COUNT>::NONE; FEET], 0);
        for lane in 0..self.members.len() {
            if let Some(mut stop) = self.stop(lane) {
                most = most.max(stop.put_feet(&mut legs, lane));
            }
        }
        let mut needed = [Simd([0.0; COUNT]); FEET];
        for (needed, legs) in needed.iter_mut().zip(&legs[..most]) {
            *needed = legs.sinks();
        }
        for lane in 0..self.members.len() {
            if let Some(mut stop) = self.stop(lane) {
                stop.sink(&mut legs, &needed, lane);
            }
        }
        for (foot, legs) in legs[..most].iter().enumerate() {
            let rotations = legs.leg_rotations();
            for lane in 0..self.members.len() {
                let Some(Stop { solver, step, .. }) = self.stop(lane) else { continue };
                let first = solver.constraint(step);
                if first.at_once != 0 && foot < first.target_count as usize {
                    let to = step.operand as usize + 3 * foot;
                    hand_down(&mut solver.step_rotations[to..], &rotations, lane);
                }
            }
        }
    }

    /// Solves legs that something else has moved after the pelvis, for the goals that
    /// [`pelvis`](Self::pelvis) found.
    #[inline(always)]
    pub(super) fn foot(&mut self) {
        let mut legs = Legs::<COUNT>::NONE;
        for lane in 0..self.members.len() {
            let Some(Stop { solver, step, joints, .. }) = self.stop(lane) else { continue };
            let constraint = solver.constraint(step);
            let (own, links) = (joints.model_of(step.joint as usize), solver.links(constraint));
            let start = constraint.upper as usize;
            let leg = Solver::walk_leg(&joints, links, constraint, start, own);
            let [ankle, follows] =
                [0, 1].map(|at: usize| solver.step_rotations[step.operand as usize + at]);
            legs.put_leg(lane, &leg, &FootGoal { ankle, follows }, constraint);
        }
        let rotations = legs.leg_rotations();
        for lane in 0..self.members.len() {
            let Some(Stop { solver, step, mut joints, .. }) = self.stop(lane) else { continue };
            let to = &mut solver.step_rotations[step.operand as usize..];
            hand_down(to, &rotations, lane);
            let joint = step.joint as usize;
            joints.keep_model(joint, joints.model_of(joint).rotated(to[0]));
        }
    }
}

/// Hands a leg's rotations down to the steps of hip, knee and ankle.
#[inline(always)]
fn hand_down<const COUNT: usize>(
    to: &mut [[f32; 4]],
    rotations: &[[Simd<COUNT>; 4]; 3],
    lane: usize,
) {
    for (to, rotation) in to.iter_mut().zip(rotations) {
        *to = lane_of(rotation, lane);
    }
}
