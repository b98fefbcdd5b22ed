//! Buffers that one stage writes and the next one reads.

use opencl3::error_codes::ClError;
use populace_device::layout::{Float4, MAX_STEP_ROTATIONS, SlotSample};
use populace_device::{BackendError, StageBuffer, Tables};

use crate::OpenClDevice;
use crate::buffer::{Buffer, Element};
use crate::handles::CommandQueue;

/// The buffers between stages. Those of joints are as long as the joint buffer.
pub(crate) struct StageBuffers {
    pub(crate) samples: Buffer<SlotSample>,
    pub(crate) translations: Buffer<Float4>,
    pub(crate) rotations: Buffer<Float4>,
    pub(crate) scales: Buffer<Float4>,
    /// Rows of `model_from_joint`.
    pub(crate) models: [Buffer<Float4>; 3],
    /// Rotations that constraint programs hand down from level to level.
    pub(crate) step_rotations: Buffer<Float4>,
}

impl StageBuffers {
    pub(crate) fn new(device: &OpenClDevice) -> Result<Self, BackendError> {
        let empty = || Buffer::new(device, 0, "an empty buffer");
        Ok(Self {
            samples: Buffer::new(device, 0, "an empty buffer")?,
            translations: empty()?,
            rotations: empty()?,
            scales: empty()?,
            models: [empty()?, empty()?, empty()?],
            step_rotations: empty()?,
        })
    }

    /// Grows to the size that the tables need. A buffer that grows loses its contents, which the
    /// next frame writes again.
    pub(crate) fn update(
        &mut self,
        device: &OpenClDevice,
        tables: &Tables,
    ) -> Result<(), BackendError> {
        let joints = tables.joint_places();
        grow(
            device,
            &mut self.samples,
            tables.member_places() * tables.slots_per_member(),
            "slot samples",
        )?;
        grow(device, &mut self.translations, joints, "joint translations")?;
        grow(device, &mut self.rotations, joints, "joint rotations")?;
        grow(device, &mut self.scales, joints, "joint scales")?;
        for rows in &mut self.models {
            grow(device, rows, joints, "model transforms")?;
        }
        grow(
            device,
            &mut self.step_rotations,
            step_rotation_count(tables),
            "rotations of members",
        )?;
        Ok(())
    }

    /// Returns whether the memory suffices for the tables, as it does after an update.
    pub(crate) fn hold(&self, tables: &Tables) -> bool {
        let joints =
            [&self.translations, &self.rotations, &self.scales].into_iter().chain(&self.models);
        tables.member_places() * tables.slots_per_member() <= self.samples.len()
            && step_rotation_count(tables) <= self.step_rotations.len()
            && joints.into_iter().all(|buffer| tables.joint_places() <= buffer.len())
    }

    pub(crate) fn bytes(&self) -> usize {
        let joints = [&self.translations, &self.rotations, &self.scales];
        let all = joints.into_iter().chain(&self.models);
        self.samples.bytes() + self.step_rotations.bytes() + all.map(Buffer::bytes).sum::<usize>()
    }

    /// Returns a buffer of joints; `None` for other kinds.
    fn joints(&mut self, buffer: StageBuffer) -> Option<&mut Buffer<Float4>> {
        match buffer {
            StageBuffer::Translations => Some(&mut self.translations),
            StageBuffer::Rotations => Some(&mut self.rotations),
            StageBuffer::Scales => Some(&mut self.scales),
            StageBuffer::ModelRow0 => Some(&mut self.models[0]),
            StageBuffer::ModelRow1 => Some(&mut self.models[1]),
            StageBuffer::ModelRow2 => Some(&mut self.models[2]),
            StageBuffer::Samples
            | StageBuffer::Palette
            | StageBuffer::States
            | StageBuffer::Watched
            | StageBuffer::Running => None,
        }
    }

    pub(crate) fn read(
        &mut self,
        queue: &CommandQueue,
        buffer: StageBuffer,
        first: usize,
        into: &mut [Float4],
    ) -> Result<(), ClError> {
        match self.joints(buffer) {
            Some(joints) => joints.read(queue, first, into),
            None => self.samples.read(queue, first, bytemuck::cast_slice_mut(into)),
        }
    }

    pub(crate) fn write(
        &mut self,
        queue: &CommandQueue,
        buffer: StageBuffer,
        first: usize,
        from: &[Float4],
    ) -> Result<(), ClError> {
        match self.joints(buffer) {
            Some(joints) => joints.write(queue, first, from),
            None => self.samples.write(queue, first, bytemuck::cast_slice(from)),
        }
    }
}

fn step_rotation_count(tables: &Tables) -> usize {
    tables.controls().as_slice().len() * MAX_STEP_ROTATIONS as usize
}

fn grow<T: Element>(
    device: &OpenClDevice,
    buffer: &mut Buffer<T>,
    count: usize,
    what: &str,
) -> Result<(), BackendError> {
    if count > buffer.len() {
        *buffer = Buffer::new(device, count, what)?;
    }
    Ok(())
}
