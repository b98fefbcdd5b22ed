//! Foot IK: planted feet stay where they stand, and the pelvis sinks for them. Twin of
//! `kernels/feet.cl`.
//!
//! Reads constraints, links and the legs' transforms. Writes the model transforms of pelvis or hip,
//! the pelvis' state, and rotations for hips, knees and ankles.

use populace_device::layout::{
    Constraint, Float4, Link, MAX_FEET, MAX_PELVIS_SINK, PELVIS_RISE_SECS, PELVIS_STATE, Step,
};
use populace_model::Affine;
use populace_model::math::{Real, quat, vec3};

use super::foot::{FootGoal, Leg};
use super::limb::Limb;
use super::targets::Solver;
use crate::hierarchy::Hierarchy;
use crate::lanes::Simd;

/// A leg and its goal: one lane of [`Legs`].
#[derive(Clone, Copy, Default)]
struct Stride {
    upper: [f32; 3],
    lower: [f32; 3],
    bend: [f32; 3],
    to: [f32; 3],
    turn: f32,
    follows: [f32; 4],
}

impl Stride {
    #[inline(always)]
    fn new(leg: &Leg, goal: &FootGoal) -> Self {
        let (upper, lower) =
            (vec3::sub(leg.knee, leg.hip), vec3::sub(leg.ankle.origin(), leg.knee));
        let [x, y, z, turn] = goal.ankle;
        let to = vec3::sub([x, y, z], leg.hip);
        Self { upper, lower, bend: leg.bend, to, turn, follows: goal.follows }
    }
}

const FEET: usize = MAX_FEET as usize;

/// One lane for each leg of a member.
type Feet = Simd<FEET>;

/// Legs of a member.
struct Legs {
    limb: Limb<Feet>,
    /// As [`Stepped::turn`].
    turn: Feet,
    /// As [`FootGoal::follows`].
    follows: [Feet; 4],
}

impl Legs {
    #[inline(always)]
    fn new(strides: &[Stride; FEET]) -> Self {
        let each = |of: fn(&Stride) -> &[f32; 3]| -> [Feet; 3] {
            [0, 1, 2].map(|c: usize| Simd::from_fn(|lane| of(&strides[lane])[c]))
        };
        let limb = Limb {
            upper: each(|s| &s.upper),
            lower: each(|s| &s.lower),
            bend: each(|s| &s.bend),
            to: each(|s| &s.to),
        };
        let follows = [0, 1, 2, 3].map(|c: usize| Simd::from_fn(|lane| strides[lane].follows[c]));
        let turn = Simd::from_fn(|lane| strides[lane].turn);
        Self { limb, turn, follows }
    }

    /// Returns the drop of the pelvis, in metres, that each leg needs to reach its goal.
    #[inline(always)]
    fn sinks(&self, soft: f32) -> Feet {
        let length = vec3::length(self.limb.upper) + vec3::length(self.limb.lower);
        let (reach, most) =
            (length * Feet::splat(1.0 - soft), length * Feet::splat(MAX_PELVIS_SINK));
        let [x, y, z] = self.limb.to;
        let needed = -y - vec3::root(reach * reach - x * x - z * z);
        Feet::choose(most.less(needed), most, needed)
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

    /// Solves legs. Writes three rotations for each of the first `count`: hip, knee and ankle.
    #[inline(never)]
    fn leg_rotations(&mut self, legs: &Legs, constraint: &Constraint, first: u32, count: usize) {
        let [soft, weight, ..] = constraint.limits.0;
        let [mut hip, mut knee] = legs.limb.rotations(None, soft);
        if weight < 1.0 {
            [hip, knee] = [hip, knee].map(|rotation| vec3::part_of(rotation, Feet::splat(weight)));
        }
        // The ankle keeps its rotation from before the constraint, and follows the slope: by the
        // rotation from up to the normal.
        let [nx, ny, nz, follows] = legs.follows;
        let tilt = [nz, Feet::splat(0.0), -nx, Feet::splat(1.0) + ny];
        let slope = quat::normalize_or(tilt, quat::identity());
        let slope = vec3::part_as_told(slope, follows * Feet::splat(weight));
        let half_tan = legs.turn * Feet::splat(weight);
        let turned = [Feet::splat(0.0), half_tan, Feet::splat(0.0), Feet::splat(1.0)];
        let turned = quat::normalize_or(turned, quat::identity());
        let ankle = quat::mul(slope, turned);
        let ankle = quat::mul(ankle, quat::conjugate(quat::mul(knee, hip)));
        let rotations = self.step_rotations[first as usize..].as_chunks_mut::<3>().0;
        for (lane, of_leg) in rotations.iter_mut().take(count).enumerate() {
            *of_leg =
                [hip, knee, ankle].map(|rotation| rotation.map(|component| component.0[lane]));
        }
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

    /// Finds the goals of all feet, and lowers the pelvis until the legs can reach them. Solves the
    /// legs too, unless something else moves them after the pelvis.
    #[inline(never)]
    pub(super) fn pelvis(&mut self, joints: &mut impl Hierarchy, joint: usize, step: &Step) {
        let own = joints.model_of(joint);
        let first = self.constraint(step);
        let count = first.target_count as usize;
        let constraints = &self.tables.constraints().as_slice()[step.index as usize..][..count];
        let mut ankles = [Link::default(); FEET];
        for (ankle, constraint) in ankles.iter_mut().zip(constraints) {
            *ankle = self.links(constraint)[ankle_link(constraint)];
        }
        let contacts = self.contacts_of(&ankles, count);
        let mut strides = [Stride::default(); FEET];
        for (foot, constraint) in (0..first.target_count).zip(constraints) {
            let leg = Self::walk_leg(joints, self.links(constraint), constraint, 0, own);
            let goal = self.foot_goal(foot, constraint, &leg, contacts[foot as usize]);
            strides[foot as usize] = Stride::new(&leg, &goal);
            let first = (step.operand + 3 * foot) as usize;
            self.step_rotations[first] = goal.ankle;
            self.step_rotations[first + 1] = goal.follows;
        }
        let mut legs = Legs::new(&strides);
        let mut drop = 0.0;
        for needed in &legs.sinks(first.limits.0[0]).0[..count] {
            drop = if *needed > drop { *needed } else { drop };
        }
        drop = self.eased_drop(drop * first.limits.0[1]);
        let mut rows = own.rows;
        rows[1][3] -= drop;
        joints.keep_model(joint, Affine { rows });
        if first.at_once != 0 {
            legs.limb.to[1] = legs.limb.to[1] + Feet::splat(drop);
            self.leg_rotations(&legs, first, step.operand, count);
        }
    }

    /// Solves a leg that something else has moved after the pelvis, for the goal that
    /// [`pelvis`](Self::pelvis) found.
    #[inline(never)]
    pub(super) fn foot(&mut self, joints: &mut impl Hierarchy, joint: usize, step: &Step) {
        let constraint = self.constraint(step);
        let own = joints.model_of(joint);
        let links = self.links(constraint);
        let leg = Self::walk_leg(joints, links, constraint, constraint.upper as usize, own);
        let first = step.operand as usize;
        let goal =
            FootGoal { ankle: self.step_rotations[first], follows: self.step_rotations[first + 1] };
        let mut strides = [Stride::default(); FEET];
        strides[0] = Stride::new(&leg, &goal);
        self.leg_rotations(&Legs::new(&strides), constraint, step.operand, 1);
        joints.keep_model(joint, own.rotated(self.step_rotations[first]));
    }
}
