//! Descent of members side by side down their hierarchy. Twin of `descend` in
//! `kernels/fused_wide.cl`.
//!
//! Reads parents and the members' steps. Writes model transforms. Gazes, limbs, legs and the
//! rotations that they hand down are computed in lanes, other steps member by member.

use populace_device::layout::{
    STEP_CHAIN, STEP_FOOT, STEP_GAZE, STEP_PELVIS, STEP_REACH, STEP_ROTATION,
};

use super::feet::{FootStep, PelvisStep};
use super::gaze::GazeStep;
use super::limb::ReachStep;
use super::programs::{Company, Programs, Stop};
use crate::lanes::{Members, put};
use crate::members::steps_of;

impl<C: Company<COUNT>, const COUNT: usize> Programs<'_, C, COUNT> {
    /// Computes the model transforms of all joints, parents first, and runs the members' steps on
    /// the way.
    #[inline(always)]
    pub(crate) fn descend<R: Members>(&mut self) {
        let tables = self.inputs.tables;
        let steps = self.members.first().map_or(&[][..], |member| steps_of(tables, *member));
        let mut joint = 0;
        for (nth, step) in steps.iter().enumerate() {
            while joint <= step.joint as usize {
                self.joints.descend_to::<R>(self.parents, joint);
                joint += 1;
            }
            self.next = nth;
            match step.kind {
                STEP_ROTATION => {
                    let rotations = &self.rotations[step.operand as usize];
                    self.joints.rotate::<R>(step.joint as usize, rotations);
                }
                STEP_CHAIN => self.chains(),
                STEP_GAZE => self.registers.run(GazeStep(self)),
                STEP_REACH => self.registers.run(ReachStep(self)),
                STEP_PELVIS => self.registers.run(PelvisStep(self)),
                STEP_FOOT => self.registers.run(FootStep(self)),
                _ => self.take_steps(),
            }
        }
        for joint in joint..self.parents.len() {
            self.joints.descend_to::<R>(self.parents, joint);
        }
    }

    /// Bends the chains of one member after the other.
    #[inline(always)]
    fn chains(&mut self) {
        for lane in 0..self.members.len() {
            let Some(Stop { solver, step, mut joints }) = self.stop(lane) else { continue };
            let turned = solver.chain(&mut joints, step);
            let links = solver.constraint(step).link_count as usize;
            let first = step.operand as usize;
            drop(joints);
            for (all, one) in self.rotations[first..].iter_mut().zip(&turned[1..links]) {
                put(all, lane, *one);
            }
        }
    }

    /// Takes the next step of one member after the other.
    #[inline(always)]
    fn take_steps(&mut self) {
        for lane in 0..self.members.len() {
            if let Some(Stop { mut solver, step, mut joints }) = self.stop(lane) {
                solver.take_step(step, &mut joints);
            }
        }
    }
}
