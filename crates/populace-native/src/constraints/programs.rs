//! Constraint programs of members side by side, each in a lane of its own, on the way down the
//! hierarchy. A member alone has the only lane.
//!
//! Members can stand side by side if their steps have the same kinds and joints. Gazes, limbs, legs
//! and the rotations that they hand down are computed in lanes, other steps member by member.

use populace_device::layout::{STEP_FOOT, STEP_GAZE, STEP_PELVIS, STEP_REACH, STEP_ROTATION, Step};

use super::targets::{Solver, StepRotations};
use crate::corrections::JointLanes;
use crate::dispatch::{Dispatch, Work};
use crate::frame::FrameInputs;
use crate::hierarchy::{Hierarchy, descend_to};
use crate::history::DeferredWrites;
use crate::lanes::{Simd, put};
use crate::members::steps_of;

/// Returns a number that programs which can stand side by side share: FNV-1a over kinds and joints
/// of the steps.
pub(crate) fn signature(steps: &[Step]) -> u64 {
    let mix = |hash: u64, step: &Step| {
        let word = u64::from(step.kind) << 32 | u64::from(step.joint);
        (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3)
    };
    steps.iter().fold(0xcbf2_9ce4_8422_2325, mix)
}

/// Returns whether two programs can stand side by side.
pub(crate) fn are_alike(a: &[Step], b: &[Step]) -> bool {
    let alike = |(a, b): (&Step, &Step)| (a.kind, a.joint) == (b.kind, b.joint);
    a.len() == b.len() && a.iter().zip(b).all(alike)
}

/// Transforms of members side by side.
pub(crate) trait Company<const COUNT: usize> {
    /// Returns the transforms of the member in a lane.
    fn member(&mut self, lane: usize) -> impl Hierarchy;

    /// Computes the model transforms of a joint. Its parent must have them.
    fn descend_to(&mut self, parents: &[u32], joint: usize);

    /// Rotates the model transforms of a joint about their own origins.
    fn rotate(&mut self, joint: usize, rotations: [Simd<COUNT>; 4]);
}

/// Transforms of a single member.
pub(crate) struct Alone<'a, H>(pub(crate) &'a mut H);

impl<H: Hierarchy> Company<1> for Alone<'_, H> {
    #[inline(always)]
    fn member(&mut self, _lane: usize) -> impl Hierarchy {
        &mut *self.0
    }

    #[inline(always)]
    fn descend_to(&mut self, parents: &[u32], joint: usize) {
        descend_to(self.0, parents, joint);
    }

    #[inline(always)]
    fn rotate(&mut self, joint: usize, [x, y, z, w]: [Simd<1>; 4]) {
        let rotation = [x.0[0], y.0[0], z.0[0], w.0[0]];
        self.0.keep_model(joint, self.0.model_of(joint).rotated(rotation));
    }
}

/// Programs of members side by side, at most one for each of `COUNT` lanes.
pub(crate) struct Programs<'a, C, const COUNT: usize> {
    pub(crate) inputs: &'a FrameInputs<'a>,
    pub(crate) registers: Dispatch,
    /// Indices of the members.
    pub(crate) members: &'a [u32],
    /// The parent of each joint.
    pub(crate) parents: &'a [u32],
    /// Local transforms of joints that the members have not reached, model transforms of others.
    pub(crate) joints: &'a mut C,
    /// Rotations that the steps of each member hand down.
    pub(crate) rotations: &'a mut [StepRotations],
    pub(crate) writes: &'a mut DeferredWrites,
    /// Index of the next step.
    pub(crate) next: usize,
}

/// A member at a step.
pub(super) struct Stop<'a, H> {
    pub(super) solver: Solver<'a>,
    pub(super) step: &'a Step,
    pub(super) joints: H,
    pub(super) parents: &'a [u32],
}

/// The next step of all members, which is of a kind that is computed in lanes.
struct StepInLanes<'a, P, const KIND: u32>(&'a mut P);

impl<C: Company<COUNT>, const KIND: u32, const COUNT: usize> Work
    for StepInLanes<'_, Programs<'_, C, COUNT>, KIND>
{
    const LANES: Option<usize> = Some(COUNT);

    #[inline(always)]
    fn run<J: JointLanes>(self) {
        match KIND {
            STEP_GAZE => self.0.gaze(),
            STEP_REACH => self.0.reach(),
            STEP_PELVIS => self.0.pelvis(),
            STEP_FOOT => self.0.foot(),
            _ => {}
        }
    }
}

impl<C: Company<COUNT>, const COUNT: usize> Programs<'_, C, COUNT> {
    /// Returns the member in a lane at the next step; `None` past the last member.
    #[inline(always)]
    pub(super) fn stop(&mut self, lane: usize) -> Option<Stop<'_, impl Hierarchy>> {
        let member = *self.members.get(lane)?;
        let step = steps_of(self.inputs.tables, member).get(self.next)?;
        let rotations = self.rotations.get_mut(lane)?;
        let solver = Solver::new(self.inputs, member, self.writes, rotations)?;
        Some(Stop { solver, step, joints: self.joints.member(lane), parents: self.parents })
    }

    /// Computes the model transforms of all joints, parents first, and runs the members' steps on
    /// the way.
    #[inline(always)]
    pub(crate) fn descend(&mut self) {
        let tables = self.inputs.tables;
        let steps = self.members.first().map_or(&[][..], |member| steps_of(tables, *member));
        let mut joint = 0;
        for (nth, step) in steps.iter().enumerate() {
            while joint <= step.joint as usize {
                self.joints.descend_to(self.parents, joint);
                joint += 1;
            }
            self.next = nth;
            match step.kind {
                STEP_ROTATION => self.rotate(step.joint as usize),
                STEP_GAZE => self.registers.run(StepInLanes::<_, STEP_GAZE>(self)),
                STEP_REACH => self.registers.run(StepInLanes::<_, STEP_REACH>(self)),
                STEP_PELVIS => self.registers.run(StepInLanes::<_, STEP_PELVIS>(self)),
                STEP_FOOT => self.registers.run(StepInLanes::<_, STEP_FOOT>(self)),
                _ => self.take_steps(),
            }
        }
        for joint in joint..self.parents.len() {
            self.joints.descend_to(self.parents, joint);
        }
    }

    /// Rotates a joint by what earlier steps handed down to the next step.
    #[inline(always)]
    fn rotate(&mut self, joint: usize) {
        let none = Simd([0.0; COUNT]);
        let mut turns = [none, none, none, Simd([1.0; COUNT])];
        for (lane, (member, own)) in self.members.iter().zip(self.rotations.iter()).enumerate() {
            let step = &steps_of(self.inputs.tables, *member)[self.next];
            put(&mut turns, lane, own[step.operand as usize]);
        }
        self.joints.rotate(joint, turns);
    }

    /// Takes the next step of one member after the other.
    #[inline(always)]
    fn take_steps(&mut self) {
        for lane in 0..self.members.len() {
            if let Some(Stop { mut solver, step, mut joints, .. }) = self.stop(lane) {
                solver.take_step(step, &mut joints);
            }
        }
    }
}
