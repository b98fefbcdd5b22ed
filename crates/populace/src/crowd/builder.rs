//! Building a crowd.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use populace_clip::AnimationSet;
use populace_device::{GlContext, MAX_SLOTS, Schedule, Tables};

use super::controls::Watches;
use super::machines::Machines;
use super::stages::UserStages;
use super::waiting::Waiting;
use super::{Clock, Crowd};
use crate::device::Opened;
use crate::{Device, Devices, Error, Split};

/// Settings of a crowd to be built.
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
    /// The device to evaluate on. Unless one is named, [`Device::best`], or the native one where
    /// that cannot be opened; [`Crowd::fallback`] then tells why.
    #[must_use]
    pub fn device(self, device: Device) -> Self {
        self.devices(device)
    }

    /// Several devices to evaluate on at the same time, such as
    /// `[Device::native(), Device::opencl(0)]`: each takes some of the members. The first is linked
    /// to OpenGL. Each holds the whole crowd's tables and has room for all palettes.
    #[must_use]
    pub fn devices(mut self, devices: impl Into<Devices>) -> Self {
        self.devices = Some(devices.into());
        self
    }

    /// How several devices share the members; [`Split::Measured`] unless set.
    #[must_use]
    pub fn split(mut self, split: Split) -> Self {
        self.split = split;
        self
    }

    /// How stages are mapped to work-items; [`Schedule::Fused`] unless named. All give the same
    /// poses.
    #[must_use]
    pub fn schedule(mut self, schedule: Schedule) -> Self {
        self.schedule = schedule;
        self
    }

    /// The context of OpenGL's to be drawn with. A device that shares buffers with OpenGL, as
    /// graphics processors do, then writes palettes where OpenGL draws from; others are opened as
    /// ever.
    ///
    /// Call [`build`](Self::build) on the thread on which that context is current: some drivers
    /// want that.
    #[must_use]
    pub fn for_gl(mut self, context: Arc<dyn GlContext>) -> Self {
        self.gl = Some(context);
        self
    }

    /// The most members there may be at once; 1,000 unless set. The device makes room for all of
    /// them with the first.
    #[must_use]
    pub fn capacity(mut self, members: usize) -> Self {
        self.capacity = members;
        self
    }

    /// Clips that a member can play at once, 1 to 8; 4 unless set. [`build`](Self::build) refuses
    /// others.
    #[must_use]
    pub fn slots_per_member(mut self, slots: usize) -> Self {
        self.slots_per_member = slots;
        self
    }

    /// Opens the devices.
    ///
    /// # Errors
    ///
    /// A number of slots that is out of its range, a device that is not there or cannot be opened,
    /// [`Error::BadDevices`] or [`Error::BadSplit`].
    pub fn build(self) -> Result<Crowd, Error> {
        // Ids carry their crowd's number, so that those of another crowd are refused rather than
        // mistaken.
        static CROWDS: AtomicU32 = AtomicU32::new(0);
        if !(1..=MAX_SLOTS).contains(&self.slots_per_member) {
            return Err(Error::BadValue {
                what: "the number of slots per member",
                value: self.slots_per_member as f32,
                rule: "from 1 to 8",
            });
        }
        let Start { devices, opened, fallback } = self.open()?;
        Ok(Crowd {
            number: CROWDS.fetch_add(1, Ordering::Relaxed),
            opened,
            devices,
            fallback,
            gl: self.gl,
            tables: Tables::with_capacity(self.slots_per_member, self.capacity),
            clips: AnimationSet::default(),
            characters: Vec::new(),
            bound_clips: HashMap::new(),
            clip_roles: HashMap::new(),
            streams: HashMap::new(),
            members: Vec::new(),
            controls: HashMap::new(),
            watches: Watches::default(),
            attachments: HashMap::new(),
            stages: UserStages::default(),
            readers: BTreeMap::new(),
            listening: Vec::new(),
            marks: HashMap::new(),
            events: Vec::new(),
            left: Vec::new(),
            kept: None,
            frame: 0,
            is_readable: false,
            proportions: HashMap::new(),
            member_count: 0,
            capacity: self.capacity,
            clock: Clock::default(),
            started: Vec::new(),
            last_serial: 0,
            motions: 0,
            moving: HashMap::new(),
            waiting: Waiting::default(),
            spaces: Vec::new(),
            steered: HashMap::new(),
            machines: Machines::default(),
        })
    }

    /// Opens the devices named, or the best device that opens.
    fn open(&self) -> Result<Start, Error> {
        let open = |devices: Devices, fallback| {
            let opened = devices.open(self.schedule, &self.split, self.gl.as_ref())?;
            Ok(Start { devices, opened, fallback })
        };
        if let Some(devices) = &self.devices {
            return open(devices.clone(), None);
        }
        let started = Device::best_opencl()
            .and_then(|device| open(device.into(), None).map_err(|error: Error| error.to_string()));
        started.or_else(|reason| open(Device::native().into(), Some(reason)))
    }
}

/// The devices that a crowd starts on.
struct Start {
    devices: Devices,
    opened: Opened,
    /// Why it is the native one, where none was named.
    fallback: Option<String>,
}
