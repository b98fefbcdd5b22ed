//! Transform: local transforms down the hierarchy, with constraints and overrides on the way; the
//! twin of `kernels/transform.cl`.

use populace_device::layout::{Float4, JOINT_BLOCK};
use populace_device::{Frame, Tables};
use populace_model::{Affine, Trs};

use crate::controls::{self, Clock, Keeping, Models, Steering};
use crate::fused::{Scratch, scratch_of};
use crate::stages::Stages;
use crate::{JointBuffer, ModelRows, split};

const BLOCK: usize = JOINT_BLOCK as usize;

/// A member's joints in the buffers of the staged schedule.
struct Rows<'a> {
    joints: &'a JointBuffer,
    /// The member's first joint.
    first: usize,
    rows: [&'a mut [Float4]; 3],
}

impl Models for Rows<'_> {
    #[inline(always)]
    fn model(&self, joint: usize) -> Affine {
        Affine { rows: self.rows.each_ref().map(|rows| rows[joint].0) }
    }

    #[inline(always)]
    fn local(&self, joint: usize) -> Affine {
        let at = self.first + joint;
        Affine::from_trs(&Trs {
            translation: self.joints.translations[at].xyz(),
            rotation: self.joints.rotations[at].0,
            scale: self.joints.scales[at].xyz(),
        })
    }

    #[inline(always)]
    fn set(&mut self, joint: usize, model: Affine) {
        for (rows, row) in self.rows.iter_mut().zip(model.rows) {
            rows[joint] = Float4(row);
        }
    }
}

pub(crate) fn run(
    tables: &Tables,
    frame: Frame,
    (stages, keeping): (&Stages, &Keeping),
    joints: &JointBuffer,
    scratch: &[Scratch],
    models: &mut ModelRows,
) {
    let arrays = models.0.each_mut().map(Vec::as_mut_slice);
    let job = |place: u32, first: usize, rows: [&mut [Float4]; 3]| {
        let member = &tables.members().as_slice()[place as usize];
        if !frame.evaluates(place) || !frame.reaches(member) {
            return;
        }
        let body = &tables.bodies().as_slice()[member.body as usize];
        let first_parent = body.joint_first as usize;
        let parents =
            &tables.parents().as_slice()[first_parent..first_parent + body.joint_count as usize];
        let mut rows = Rows { joints, first: first * BLOCK, rows };
        if controls::control_of(tables, place).is_none() {
            return controls::descend(&mut rows, parents);
        }
        let mut own = scratch_of(scratch);
        if let Some(mut steering) =
            Steering::new(tables, place, Clock::of(frame, stages), keeping, &mut own.left)
        {
            steering.descend(&mut rows, parents);
        }
    };
    split::for_each_member::<BLOCK, 3>(tables.joint_blocks().as_slice(), arrays, &job);
}
