//! Transform stage: local transforms down the hierarchy, with constraints and overrides on the way.
//! Twin of `kernels/transform.cl`.
//!
//! Reads the joint buffer, parents, and all that [`constraints`](crate::constraints) read. Writes
//! three rows of `model_from_joint` for each joint, and deferred states and watched joints. The
//! result is rows, not a translation, rotation and scale, because a rotated child under a
//! non-uniform scale shears.

use populace_device::layout::{Float4, JOINT_BLOCK, STEP_PELVIS};
use populace_model::{Affine, Trs};

use crate::buffers::{JointBuffer, ModelRows};
use crate::constraints::{Alone, Programs, step_rotations};
use crate::frame::FrameInputs;
use crate::hierarchy::Hierarchy;
use crate::members::{body_of, parents_of, steps_of};
use crate::playback::Play;
use crate::processor::Dispatch;
use crate::scratch::{Scratch, ScratchPool};
use crate::split;

const BLOCK: usize = JOINT_BLOCK as usize;

/// Transforms of a member in the buffers of the staged schedule.
struct Rows<'a> {
    joints: &'a JointBuffer,
    /// The member's first joint in the joint buffer.
    first: usize,
    rows: [&'a mut [Float4]; 3],
}

impl Hierarchy for Rows<'_> {
    #[inline(always)]
    fn model_of(&self, joint: usize) -> Affine {
        Affine { rows: self.rows.each_ref().map(|rows| rows[joint].0) }
    }

    #[inline(always)]
    fn local_of(&self, joint: usize) -> Affine {
        let at = self.first + joint;
        Affine::from_trs(&Trs {
            translation: self.joints.translations[at].xyz(),
            rotation: self.joints.rotations[at].0,
            scale: self.joints.scales[at].xyz(),
        })
    }

    #[inline(always)]
    fn keep_model(&mut self, joint: usize, model: Affine) {
        for (rows, row) in self.rows.iter_mut().zip(model.rows) {
            rows[joint] = Float4(row);
        }
    }
}

/// Transforms the joints of the frame's members.
pub(crate) fn transform(
    inputs: &FrameInputs,
    joints: &JointBuffer,
    scratch: &ScratchPool,
    models: &mut ModelRows,
) {
    let FrameInputs { tables, frame, .. } = *inputs;
    let arrays = models.0.each_mut().map(Vec::as_mut_slice);
    let job = |index: u32, first_block: usize, rows: [&mut [Float4]; 3]| {
        let member = &tables.members().as_slice()[index as usize];
        if !frame.evaluates(index) || !frame.reaches(member) {
            return;
        }
        let parents = parents_of(tables, body_of(tables, index));
        let mut rows = Rows { joints, first: first_block * BLOCK, rows };
        let Scratch { rotations, writes, .. } = &mut *scratch.of_current_thread();
        let rotations = step_rotations(rotations);
        let joints = &mut Alone(&mut rows);
        let has_feet = steps_of(tables, index).iter().any(|step| step.kind == STEP_PELVIS);
        let plays = &[has_feet.then(|| Play::play_all(inputs, index))];
        let (members, registers, next) = (&[index], Dispatch::Baseline, 0);
        Programs { inputs, registers, members, plays, parents, joints, rotations, writes, next }
            .descend::<f32>();
    };
    split::for_each_member::<BLOCK, 3>(tables.joint_blocks().as_slice(), arrays, &job);
}
