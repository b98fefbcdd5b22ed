//! Constraint programs of members side by side, each in a lane of its own, on the way down the
//! hierarchy. A member alone has the only lane.
//!
//! Members can stand side by side if their programs have one shape.

use populace_device::Tables;
use populace_device::layout::{Constraint, Link, MAX_STEP_ROTATIONS, Step};
use populace_model::Affine;

use super::targets::Solver;
use crate::frame::FrameInputs;
use crate::hierarchy::Hierarchy;
use crate::history::DeferredWrites;
use crate::lanes::{LANES, Line, Members, Simd, load, vectors};
use crate::matrices::{MATRIX, origin, product};
use crate::members::steps_of;
use crate::playback::Play;
use crate::processor::Dispatch;
use crate::widths::JointLanes;

/// Rotations in model space of members side by side, from steps that compute them to steps that
/// apply them.
pub(crate) fn step_rotations<const COUNT: usize>(lines: &mut Vec<Line>) -> &mut [[Simd<COUNT>; 4]] {
    vectors(lines, 4 * MAX_STEP_ROTATIONS as usize).as_chunks_mut().0
}

/// Returns the links of a constraint.
fn links_of<'a>(tables: &'a Tables, constraint: &Constraint) -> &'a [Link] {
    &tables.links().as_slice()[constraint.link_first as usize..][..constraint.link_count as usize]
}

/// Transforms of members side by side.
pub(crate) trait Company<const COUNT: usize> {
    /// Register of the members that are computed at once. `J` holds sixteen joints.
    type Members<J: JointLanes>: Members;

    /// Returns the transforms of the member in a lane.
    fn member(&mut self, lane: usize) -> impl Hierarchy;

    /// Computes the model transforms of a joint. Its parent must have them.
    fn descend_to<R: Members>(&mut self, parents: &[u32], joint: usize);

    /// Rotates the model transforms of a joint about their own origins.
    fn rotate<R: Members>(&mut self, joint: usize, rotations: &[Simd<COUNT>; 4]);

    /// Returns the model transforms of a joint that has them, in lanes from `lane` on.
    fn models_of<R: Members>(&self, joint: usize, lane: usize) -> [R; MATRIX];

    /// Returns the local transforms of a joint that has no model transforms yet, in lanes from
    /// `lane` on.
    fn locals_of<R: Members>(&self, joint: usize, lane: usize) -> [R; MATRIX];

    /// Lowers the model transforms of a joint, by metres.
    fn lower(&mut self, joint: usize, drops: &Simd<COUNT>);
}

/// Returns the transform of a single member in the first lane.
#[inline(always)]
fn only<R: Members>(transform: &Affine) -> [R; MATRIX] {
    let mut lanes = [Simd([0.0; LANES]); MATRIX];
    for (all, number) in lanes.iter_mut().zip(transform.rows.as_flattened()) {
        all.0[0] = *number;
    }
    load(&lanes, 0)
}

/// Transforms of a single member. A trait object, so that all storages share one compilation.
pub(crate) struct Alone<'a>(pub(crate) &'a mut dyn Hierarchy);

impl Company<1> for Alone<'_> {
    type Members<J: JointLanes> = f32;

    #[inline(always)]
    fn member(&mut self, _lane: usize) -> impl Hierarchy {
        &mut *self.0
    }

    #[inline(always)]
    fn descend_to<R: Members>(&mut self, parents: &[u32], joint: usize) {
        self.0.descend_to(parents, joint);
    }

    #[inline(always)]
    fn rotate<R: Members>(&mut self, joint: usize, [x, y, z, w]: &[Simd<1>; 4]) {
        let rotation = [x.0[0], y.0[0], z.0[0], w.0[0]];
        self.0.keep_model(joint, self.0.model_of(joint).rotated(rotation));
    }

    #[inline(always)]
    fn models_of<R: Members>(&self, joint: usize, _lane: usize) -> [R; MATRIX] {
        only(&self.0.model_of(joint))
    }

    #[inline(always)]
    fn locals_of<R: Members>(&self, joint: usize, _lane: usize) -> [R; MATRIX] {
        only(&self.0.local_of(joint))
    }

    #[inline(always)]
    fn lower(&mut self, joint: usize, drops: &Simd<1>) {
        let mut rows = self.0.model_of(joint).rows;
        rows[1][3] -= drops.0[0];
        self.0.keep_model(joint, Affine { rows });
    }
}

/// Programs of members side by side, at most one for each of `COUNT` lanes.
pub(crate) struct Programs<'a, C, const COUNT: usize> {
    pub(crate) inputs: &'a FrameInputs<'a>,
    pub(crate) registers: Dispatch,
    /// Indices of the members.
    pub(crate) members: &'a [u32],
    /// Playing slots of each member. `None` where no step of feet reads them.
    pub(crate) plays: &'a [Option<Play<'a>>],
    /// The parent of each joint.
    pub(crate) parents: &'a [u32],
    /// Local transforms of joints that the members have not reached, model transforms of others.
    pub(crate) joints: &'a mut C,
    /// See [`step_rotations`].
    pub(crate) rotations: &'a mut [[Simd<COUNT>; 4]],
    pub(crate) writes: &'a mut DeferredWrites,
    /// Index of the next step.
    pub(crate) next: usize,
}

/// A member at a step.
pub(super) struct Stop<'a, H> {
    pub(super) solver: Solver<'a>,
    pub(super) step: &'a Step,
    pub(super) joints: H,
}

impl<'a, C: Company<COUNT>, const COUNT: usize> Programs<'a, C, COUNT> {
    /// Returns the member in a lane at the next step; `None` past the last member.
    #[inline(always)]
    pub(super) fn stop(&mut self, lane: usize) -> Option<Stop<'_, impl Hierarchy>> {
        let member = *self.members.get(lane)?;
        let step = steps_of(self.inputs.tables, member).get(self.next)?;
        let solver = Solver::new(self.inputs, member, self.writes)?;
        Some(Stop { solver, step, joints: self.joints.member(lane) })
    }

    /// Returns the next step of the first member, and its constraint. Those of the others have the
    /// same joints and chains.
    #[inline(always)]
    pub(super) fn first_stop(&self) -> Option<(&'a Step, &'a Constraint)> {
        let tables = self.inputs.tables;
        let step = steps_of(tables, *self.members.first()?).get(self.next)?;
        Some((step, &tables.constraints().as_slice()[step.index as usize]))
    }

    /// Returns whether all members have equal programs, and so the same rows.
    #[inline(always)]
    pub(super) fn share_rows(&self) -> bool {
        let rows = |member: &u32| steps_of(self.inputs.tables, *member).as_ptr();
        self.members.iter().all(|member| rows(member) == rows(&self.members[0]))
    }

    /// Walks down chains by their local transforms, in lanes from `lane` on. Writes the positions
    /// of the chain's joints, in model space, and returns the model transform of the last joint.
    #[inline(always)]
    pub(super) fn walk<R: Members>(
        &self,
        links: &[Link],
        lane: usize,
        positions: &mut [[R; 3]],
    ) -> [R; MATRIX] {
        let mut end = [R::splat(0.0); MATRIX];
        for (at, (position, link)) in positions.iter_mut().zip(links).enumerate() {
            let joint = link.joint as usize;
            end = if at == 0 {
                self.joints.models_of(joint, lane)
            } else {
                product(&end, &self.joints.locals_of(joint, lane))
            };
            *position = origin(&end);
        }
        end
    }

    /// Returns the links of a constraint.
    #[inline(always)]
    pub(super) fn links(&self, constraint: &Constraint) -> &'a [Link] {
        links_of(self.inputs.tables, constraint)
    }
}
