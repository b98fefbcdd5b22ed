//! The builder of a crowd.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use populace_device::{GlContext, MAX_SLOTS, Schedule};

use super::Crowd;
use super::active_device::ActiveDevice;
use super::base::Base;
use super::devices::schedule_for;
use super::state::State;
use crate::{Allowed, Device, Devices, Error, Split};
use populace_backends::Opened;

/// Settings from which a crowd is built.
#[derive(Clone, Debug)]
pub struct CrowdBuilder {
    devices: Option<Devices>,
    split: Split,
    schedule: Schedule,
    gl: Option<Arc<dyn GlContext>>,
    capacity: usize,
    slots_per_member: usize,
}

impl Default for CrowdBuilder {
    fn default() -> Self {
        Self {
            devices: None,
            split: Split::default(),
            schedule: Schedule::default(),
            gl: None,
            capacity: 1000,
            slots_per_member: 4,
        }
    }
}

impl CrowdBuilder {
    /// Sets the device. Unless set it is [`Device::best`], or the native device if that cannot be
    /// opened; [`DeviceInfo::fallback`](crate::DeviceInfo::fallback) then
    /// holds the reason.
    #[must_use]
    pub fn device(self, device: Device) -> Self {
        self.devices(device)
    }

    /// Sets several devices that evaluate at the same time, such as
    /// `[Device::native(), Device::opencl(0)]`. Each takes a share of the members. Each holds the
    /// tables of the whole crowd and space for all palettes. The first shares buffers with OpenGL.
    #[must_use]
    pub fn devices(mut self, devices: impl Into<Devices>) -> Self {
        self.devices = Some(devices.into());
        self
    }

    /// Sets the shares of several devices; [`Split::Measured`] unless set.
    #[must_use]
    pub fn split(mut self, split: Split) -> Self {
        self.split = split;
        self
    }

    /// Sets how stages are mapped to work-items; [`Schedule::Fused`] unless set. All schedules
    /// compute the same poses. A crowd that falls back to the native device takes
    /// [`Schedule::Fused`] instead of [`Schedule::FusedGrouped`].
    #[must_use]
    pub fn schedule(mut self, schedule: Schedule) -> Self {
        self.schedule = schedule;
        self
    }

    /// Sets the OpenGL context that draws the crowd. A device that can share buffers with OpenGL,
    /// as GPUs can, then writes palettes into buffers of that context.
    ///
    /// Call [`build`](Self::build) on the thread on which the context is current: some drivers
    /// require it.
    #[must_use]
    pub fn for_gl(mut self, context: Arc<dyn GlContext>) -> Self {
        self.gl = Some(context);
        self
    }

    /// Sets the largest number of members; 1,000 unless set. An OpenCL device allocates for all of
    /// them when the first is added, a native one as members are added.
    #[must_use]
    pub fn capacity(mut self, members: usize) -> Self {
        self.capacity = members;
        self
    }

    /// Sets the number of clips that a member can play at once, 1 to 8; 4 unless set.
    #[must_use]
    pub fn slots_per_member(mut self, slots: usize) -> Self {
        self.slots_per_member = slots;
        self
    }

    /// Opens the devices and returns an empty crowd.
    ///
    /// # Errors
    ///
    /// A number of slots that is out of its range, a device that does not exist or cannot be
    /// opened, [`DevicesError::BadDevices`](crate::DevicesError::BadDevices) or
    /// [`DevicesError::BadSplit`](crate::DevicesError::BadSplit).
    pub fn build(self) -> Result<Crowd, Error> {
        // Ids carry the number of their crowd, so that ids of another crowd are refused.
        static CROWDS: AtomicU32 = AtomicU32::new(0);
        if !(1..=MAX_SLOTS).contains(&self.slots_per_member) {
            return Err(Error::BadValue {
                what: "the number of slots per member",
                value: self.slots_per_member as f32,
                allowed: Allowed::Range { least: 1.0, most: MAX_SLOTS as f64 },
            });
        }
        let Start { devices, opened, fallback } = self.open()?;
        let number = CROWDS.fetch_add(1, Ordering::Relaxed);
        let base = Base::new(number, self.slots_per_member, self.capacity);
        let device = ActiveDevice::new(devices, opened, fallback, self.gl);
        Ok(Crowd { state: State::new(base), device, view_ms: 0.0 })
    }

    /// Opens the selected devices, or the best device that opens.
    fn open(&self) -> Result<Start, Error> {
        let open = |devices: Devices, schedule, fallback| {
            let opened = devices.open(schedule, &self.split, self.gl.as_ref())?;
            Ok(Start { devices, opened, fallback })
        };
        if let Some(devices) = &self.devices {
            return open(devices.clone(), self.schedule, None);
        }
        let started = Device::best_opencl().and_then(|device| {
            let opened = open(device.into(), self.schedule, None);
            opened.map_err(|error: Error| error.to_string())
        });
        started.or_else(|reason| {
            let native = Device::native().into();
            let schedule = schedule_for(&native, self.schedule);
            open(native, schedule, Some(reason))
        })
    }
}

/// The devices on which a crowd starts.
struct Start {
    devices: Devices,
    opened: Opened,
    /// The reason for the native device, if none was selected.
    fallback: Option<String>,
}
