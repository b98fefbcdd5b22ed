//! The devices of a crowd: which they are, what each takes, and moves to others.

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

    /// Why the crowd is on the native device although none was named: what OpenCL lacks on this
    /// machine, for people. `None` where devices were named, or an OpenCL one is in use.
    #[must_use]
    pub fn fallback(&self) -> Option<&str> {
        self.fallback.as_deref()
    }

    /// The devices' own names, for people.
    #[must_use]
    pub fn device_name(&self) -> String {
        self.opened.backend().device_name()
    }

    /// The share of the members that each device takes, of 1 in all; measured ones change from
    /// frame to frame.
    #[must_use]
    pub fn shares(&self) -> Vec<f64> {
        match &self.opened.engine {
            Engine::Alone(_) => vec![1.0],
            Engine::Split(backend) => backend.shares().to_vec(),
        }
    }

    /// Lets the devices share the members in another way, from the next update on.
    ///
    /// # Errors
    ///
    /// [`Error::BadSplit`] for one that does not fit the devices; the split then stays as it is.
    pub fn set_split(&mut self, split: &Split) -> Result<(), Error> {
        let shares = split.shares(&self.devices)?;
        if let Engine::Split(backend) = &mut self.opened.engine {
            backend.set_shares(shares);
        }
        Ok(())
    }

    /// How stages are mapped to work-items.
    #[must_use]
    pub fn schedule(&self) -> Schedule {
        self.opened.backend().schedule()
    }

    /// Moves the crowd to another device or to several, after one was lost or to compare them.
    /// Members, clips and clock go on. Several share the members by their measured speed, until
    /// [`set_split`](Self::set_split) says otherwise. A driver that has to build kernels first can
    /// take seconds; [`Device::prepare`](crate::Device::prepare) does that ahead.
    ///
    /// # Errors
    ///
    /// A device that is not there or cannot be opened, or that cannot run a user's stage, or
    /// [`Error::BadDevices`]; the crowd then stays where it is.
    pub fn move_to(&mut self, devices: impl Into<Devices>) -> Result<(), Error> {
        let devices = devices.into();
        let mut opened = devices.open(self.schedule(), &Split::Measured, self.gl.as_ref())?;
        opened.backend_mut().set_stages(self.stages.as_slice())?;
        // What the device before this one kept is still here where this one has run no frame.
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
