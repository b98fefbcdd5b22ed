//! The devices of a crowd: their names, their shares, and moves to other devices.

use super::Crowd;
use super::active_device::ActiveDevice;
use super::base::Clock;
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
    /// clips and clock continue. After an update, the crowd is evaluated at its time once more, so
    /// that results can be read at once, as after [`restore`](Self::restore).
    ///
    /// Several devices share the members by measured speed until [`set_split`](Self::set_split) is
    /// called. The schedule stays, but [`Schedule::FusedGrouped`] becomes [`Schedule::Fused`] with
    /// the native device. A driver that has to build kernels can take seconds;
    /// [`Device::prepare`](crate::Device::prepare) builds them ahead.
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
        let now = ActiveDevice::new(devices, opened, None, gl);
        let before = std::mem::replace(&mut self.device, now);
        self.device.history = Some(history);
        let moved = self.evaluate_again();
        if moved.is_err() {
            self.device = before;
            self.state.base.tables.mark_dirty();
        }
        moved
    }

    /// Evaluates the last update again on a device that has only its history, so that joints can be
    /// read before the next update, as ragdolls do.
    pub(super) fn evaluate_again(&mut self) -> Result<(), Error> {
        self.state.base.tables.mark_dirty();
        let Clock { tick, frame, .. } = self.state.base.clock;
        if frame == 0 {
            return Ok(());
        }
        self.device.run_again(&mut self.state.base.tables, tick)
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
