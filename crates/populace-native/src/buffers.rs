//! Buffers of the staged schedule, and how buffers grow.

use populace_device::layout::{Float4, SlotSample};
use populace_device::{BackendError, StageBuffer, Tables};

use crate::errors::DEVICE;

/// Intermediate results of the stages, for all members.
#[derive(Default)]
pub(crate) struct StageBuffers {
    pub(crate) samples: Vec<SlotSample>,
    pub(crate) joints: JointBuffer,
    pub(crate) models: ModelRows,
}

/// Local transforms of all joints, as separate arrays (the bone buffer of Lister & Day 2012,
/// section 3.1, fig. 3).
#[derive(Default)]
pub(crate) struct JointBuffer {
    pub(crate) translations: Vec<Float4>,
    pub(crate) rotations: Vec<Float4>,
    pub(crate) scales: Vec<Float4>,
}

/// `model_from_joint` of all joints, as one array for each of three rows.
#[derive(Default)]
pub(crate) struct ModelRows(pub(crate) [Vec<Float4>; 3]);

impl StageBuffers {
    /// Grows all buffers to the size of the tables.
    pub(crate) fn grow(&mut self, tables: &Tables) -> Result<(), BackendError> {
        let joints = tables.joint_places();
        let slots = tables.member_places() * tables.slots_per_member();
        grow(&mut self.samples, slots, "slot samples")?;
        grow(&mut self.joints.translations, joints, "joint translations")?;
        grow(&mut self.joints.rotations, joints, "joint rotations")?;
        grow(&mut self.joints.scales, joints, "joint scales")?;
        self.models.0.iter_mut().try_for_each(|rows| grow(rows, joints, "model transforms"))
    }

    /// Returns a buffer; `None` if it is not one of these.
    pub(crate) fn elements(&mut self, buffer: StageBuffer) -> Option<&mut [Float4]> {
        match buffer {
            StageBuffer::Samples => Some(bytemuck::cast_slice_mut(&mut self.samples)),
            StageBuffer::Translations => Some(&mut self.joints.translations),
            StageBuffer::Rotations => Some(&mut self.joints.rotations),
            StageBuffer::Scales => Some(&mut self.joints.scales),
            StageBuffer::ModelRow0 => Some(&mut self.models.0[0]),
            StageBuffer::ModelRow1 => Some(&mut self.models.0[1]),
            StageBuffer::ModelRow2 => Some(&mut self.models.0[2]),
            StageBuffer::Palette
            | StageBuffer::States
            | StageBuffer::Watched
            | StageBuffer::Running => None,
        }
    }

    /// Returns the `Float4` elements held.
    pub(crate) fn element_count(&self) -> usize {
        self.samples.len() + self.joints.translations.len() * 3 + self.models.0[0].len() * 3
    }
}

/// Grows a buffer to `count` elements, with default values. It never shrinks.
///
/// # Errors
///
/// [`BackendError::OutOfMemory`], naming the buffer by `what`.
pub(crate) fn grow<T: Clone + Default>(
    buffer: &mut Vec<T>,
    count: usize,
    what: &str,
) -> Result<(), BackendError> {
    let more = count.saturating_sub(buffer.len());
    if buffer.try_reserve_exact(more).is_err() {
        let bytes = count.saturating_mul(size_of::<T>());
        return Err(BackendError::OutOfMemory { device: DEVICE.into(), what: what.into(), bytes });
    }
    buffer.resize(buffer.len() + more, T::default());
    Ok(())
}
