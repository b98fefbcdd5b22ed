//! The devices of a crowd: their names, their shares, and moves to other devices.

use super::Crowd;
use super::active_device::ActiveDevice;
use crate::{Device, Devices, Error, Schedule, Split};
use populace_backends::Engine;

impl Crowd {
    /// Sets the shares of the devices from the next update on.
    ///
    /// # Errors
    ///
    /// [`DevicesError::BadSplit`](crate::DevicesError::BadSplit) for a split that does not fit the
    /// devices; the split then stays.
    pub fn set_split(&mut self, split: &Split) -> Result<(), Error> {
        let shares = split.shares(&self.device.devices)?;
        if let Engine::Split(backend) = &mut self.device.opened.engine {
            backend.set_shares(shares);
        }
        Ok(())
    }

    /// Moves the crowd to one or several other devices, such as after a device was lost. Members,
    /// clips and clock continue. Several devices share the members by measured speed until
    /// [`set_split`](Self::set_split) is called. The schedule stays, but
    /// [`Schedule::FusedGrouped`] becomes [`Schedule::Fused`] with the native device. A driver that
    /// has to build kernels can take seconds; [`Device::prepare`](crate::Device::prepare) builds
    /// them ahead.
    ///
    /// # Errors
    ///
    /// A device that does not exist, cannot be opened or cannot run a user stage, or
    /// [`DevicesError::BadDevices`](crate::DevicesError::BadDevices); the crowd then stays where it
    /// is.
    pub fn move_to(&mut self, devices: impl Into<Devices>) -> Result<(), Error> {
        let devices = devices.into();
        let gl = self.device.gl.clone();
        let schedule = schedule_for(&devices, self.device.backend().schedule());
        let mut opened = devices.open(schedule, &Split::Measured, gl.as_ref())?;
        opened.backend_mut().set_stages(self.state.stages.as_slice())?;
        // A lost device has no history: feet are planted again, and machines restart.
        let history = self.device.history(&self.state.base.tables).unwrap_or_default();
        let _ = self.update_offsets();
        self.device = ActiveDevice::new(devices, opened, None, gl);
        self.device.history = Some(history);
        self.state.base.tables.mark_dirty();
        Ok(())
    }
}

/// Returns the schedule, or the one in its place where devices lack it: the native device has no
/// form for GPUs.
pub(super) fn schedule_for(devices: &Devices, schedule: Schedule) -> Schedule {
    let is_native = |device: &Device| matches!(device, Device::Native { .. });
    match schedule {
        Schedule::FusedGrouped if devices.as_slice().iter().any(is_native) => Schedule::Fused,
        schedule => schedule,
    }
}
