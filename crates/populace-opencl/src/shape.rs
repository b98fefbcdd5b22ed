//! Division of work on a kind of device.

use populace_device::{BackendError, lanes_allowed};

use crate::{DeviceKind, OpenClDevice};

/// Division of work on a kind of device.
#[derive(Clone, Copy)]
pub(crate) struct DispatchShape {
    /// Work-items in a work-group.
    pub(crate) group: usize,
    /// Members whose levels are all transformed before those of the next members.
    pub(crate) members: usize,
    /// Work-items in a work-group of the fused grouped schedule.
    pub(crate) fused_group: usize,
    /// Members side by side in a work-item of the fused wide schedule: 8 or 16.
    pub(crate) lanes: usize,
}

/// Work-groups are whole blocks of 16 joints, and a multiple of the 32 or 64 lanes that run
/// together.
pub(crate) const GPU_SHAPE: DispatchShape =
    DispatchShape { group: 64, members: usize::MAX, fused_group: 128, lanes: 16 };
/// On a CPU a work-group is a loop on one core, and scheduling it costs more than a joint does, so
/// large groups are faster. The joints of 512 members stay in the caches of a core from one level
/// to the next.
const CPU_SHAPE: DispatchShape =
    DispatchShape { group: 1024, members: 512, fused_group: 128, lanes: 16 };

impl DispatchShape {
    /// Returns the shape for a device. `POPULACE_LANES` is the most lanes on a CPU; below 8 counts
    /// as 8.
    ///
    /// # Errors
    ///
    /// [`BackendError::Failed`] if `POPULACE_LANES` is not a number of lanes.
    pub(crate) fn of(device: &OpenClDevice) -> Result<Self, BackendError> {
        if device.info.kind != DeviceKind::Cpu {
            return Ok(GPU_SHAPE);
        }
        // With AVX2 sixteen lanes take two registers for each component, and its sixteen registers
        // do not hold a sum.
        let native_lanes = device.device.native_vector_width_float().unwrap_or(8);
        let most = lanes_allowed(&device.info.name)?.min(native_lanes);
        let lanes = if most >= 16 { 16 } else { 8 };
        Ok(Self { lanes, ..CPU_SHAPE })
    }
}
