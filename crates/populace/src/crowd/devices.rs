//! The devices of a crowd: their names, their shares, and moves to other devices.

use populace_device::Schedule;

use super::Crowd;
use crate::device::Engine;
use crate::split::Kept;
use crate::{Devices, Error, Split};

impl Crowd {
    /// The devices in use.
    #[must_use]
    pub fn devices(&self) -> &Devices {
        &self.devices
    }

    /// The reason why the crowd is on the native device although none was selected, in words.
    /// `None` if devices were selected or an OpenCL device is in use.
    #[must_use]
    pub fn fallback(&self) -> Option<&str> {
        self.fallback.as_deref()
    }

    /// The names that the devices report.
    #[must_use]
    pub fn device_name(&self) -> String {
        self.opened.backend().device_name()
    }

    /// The share of the members that each device evaluates; the sum is 1. Measured shares change
    /// from frame to frame.
    #[must_use]
    pub fn shares(&self) -> Vec<f64> {
        match &self.opened.engine {
            Engine::Alone(_) => vec![1.0],
            Engine::Split(backend) => backend.shares().to_vec(),
        }
    }

    /// Sets the shares of the devices from the next update on.
    ///
    /// # Errors
    ///
    /// [`Error::BadSplit`] for a split that does not fit the devices; the split then stays.
    pub fn set_split(&mut self, split: &Split) -> Result<(), Error> {
        let shares = split.shares(&self.devices)?;
        if let Engine::Split(backend) = &mut self.opened.engine {
            backend.set_shares(shares);
        }
        Ok(())
    }

    /// The schedule that maps stages to work-items.
    #[must_use]
    pub fn schedule(&self) -> Schedule {
        self.opened.backend().schedule()
    }

    /// Moves the crowd to one or several other devices, such as after a device was lost. Members,
    /// clips and clock continue. Several devices share the members by measured speed until
    /// [`set_split`](Self::set_split) is called. A driver that has to build kernels can take
    /// seconds; [`Device::prepare`](crate::Device::prepare) builds them ahead.
    ///
    /// # Errors
    ///
    /// A device that does not exist, cannot be opened or cannot run a user stage, or
    /// [`Error::BadDevices`]; the crowd then stays where it is.
    pub fn move_to(&mut self, devices: impl Into<Devices>) -> Result<(), Error> {
        let devices = devices.into();
        let mut opened = devices.open(self.schedule(), &Split::Measured, self.gl.as_ref())?;
        opened.backend_mut().set_stages(self.stages.as_slice())?;
        // If this device has run no frame, `kept` still holds the history of the one before.
        if self.kept.is_none() {
            self.kept = Some(Kept::read_all(self.opened.backend_mut(), &self.tables));
        }
        self.opened = opened;
        self.is_readable = false;
        self.devices = devices;
        self.fallback = None;
        self.tables.mark_dirty();
        Ok(())
    }
}
