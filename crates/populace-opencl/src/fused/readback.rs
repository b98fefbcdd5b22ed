//! Reading of one member's samples, local transforms and matrices, which the fused schedules do not
//! store.

use populace_device::layout::{Float4, POSE_PLANES, SlotSample};
use populace_device::{BackendError, StageBuffer, Tables};

use super::MATRIX;
use crate::OpenClDevice;
use crate::buffer::Buffer;
use crate::context::FrameContext;

/// Buffers into which a member is evaluated once more.
pub(super) struct ScratchOutputs {
    pub(super) samples: Buffer<SlotSample>,
    /// Local transforms: ten planes, each of the body's padded joints.
    pub(super) planes: Buffer<f32>,
    pub(super) matrices: Buffer<Float4>,
    joint_count: usize,
}

impl ScratchOutputs {
    pub(super) fn new(
        device: &OpenClDevice,
        host: &Tables,
        member: u32,
    ) -> Result<Self, BackendError> {
        let body =
            host.bodies().as_slice()[host.members().as_slice()[member as usize].body as usize];
        let padded = body.padded_count as usize;
        Ok(Self {
            samples: Buffer::new(device, host.slots_per_member(), "a member's samples")?,
            planes: Buffer::new(
                device,
                POSE_PLANES as usize * padded,
                "a member's local transforms",
            )?,
            matrices: Buffer::new(device, padded * MATRIX, "a member's matrices")?,
            joint_count: body.joint_count as usize,
        })
    }

    /// Waits for the evaluation and reads the results.
    pub(super) fn read(
        &self,
        context: &FrameContext,
        device: &OpenClDevice,
        member: u32,
    ) -> Result<MemberReadback, BackendError> {
        let mut readback = MemberReadback {
            member,
            samples: vec![SlotSample::default(); self.samples.len()],
            planes: vec![0.0; self.planes.len()],
            matrices: vec![Float4::default(); self.joint_count * MATRIX],
        };
        let samples = self.samples.read(context.queue, 0, &mut readback.samples);
        let read = samples
            .and_then(|()| self.planes.read(context.queue, 0, &mut readback.planes))
            .and_then(|()| self.matrices.read(context.queue, 0, &mut readback.matrices));
        read.map_err(|e| device.failed("read a member's joints", &e))?;
        Ok(readback)
    }
}

/// The results on the host.
pub(super) struct MemberReadback {
    pub(super) member: u32,
    samples: Vec<SlotSample>,
    planes: Vec<f32>,
    matrices: Vec<Float4>,
}

impl MemberReadback {
    /// Returns an element as the buffers of the staged schedule hold it; `None` past the member's
    /// end.
    pub(super) fn element(&self, buffer: StageBuffer, at: usize) -> Option<Float4> {
        let joint_count = self.matrices.len() / MATRIX;
        if buffer == StageBuffer::Samples {
            return self.samples.get(at).map(|sample| bytemuck::cast(*sample));
        }
        if at >= joint_count {
            return None;
        }
        let padded = self.planes.len() / POSE_PLANES as usize;
        let plane = |plane: usize| self.planes[plane * padded + at];
        let row = |row: usize| self.matrices[at * MATRIX + row];
        Some(match buffer {
            StageBuffer::Rotations => Float4([plane(0), plane(1), plane(2), plane(3)]),
            StageBuffer::Translations => Float4([plane(4), plane(5), plane(6), 0.0]),
            StageBuffer::Scales => Float4([plane(7), plane(8), plane(9), 0.0]),
            StageBuffer::ModelRow0 => row(0),
            StageBuffer::ModelRow1 => row(1),
            StageBuffer::ModelRow2 => row(2),
            StageBuffer::Samples
            | StageBuffer::Palette
            | StageBuffer::States
            | StageBuffer::Watched
            | StageBuffer::Running => return None,
        })
    }
}
