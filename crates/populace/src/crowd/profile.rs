//! The devices of a crowd in words and numbers.

use populace_device::{Schedule, Stage};

use super::Crowd;
use crate::{Devices, Error};
use populace_backends::Engine;

/// The devices in use, what they hold, and how members are shared.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq)]
pub struct DeviceInfo {
    /// The devices.
    pub devices: Devices,
    /// The names that they report.
    pub name: String,
    /// The reason for the native device if none was selected, in words; `None` if devices were
    /// selected or an OpenCL device is in use.
    pub fallback: Option<String>,
    /// The mapping of stages to work-items.
    pub schedule: Schedule,
    /// The share of the members that each device evaluates; the sum is 1. Measured shares change
    /// from frame to frame.
    pub shares: Vec<f64>,
    /// The bytes that the devices have allocated for this crowd.
    pub memory_bytes: usize,
    /// The number of times that the host has waited for a device of the kind in use since the
    /// process began. [`Crowd::update`] on one device does not wait. Reading results does, except
    /// for [`Crowd::readback`].
    pub host_waits: u64,
}

/// The times of the last update.
#[non_exhaustive]
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameTimes {
    /// Milliseconds of the update, if it has finished and the device measures time.
    pub frame_ms: Option<f64>,
    /// Milliseconds that the host took to choose visibility and levels of detail; nearly 0 without
    /// a [view](Crowd::view).
    pub view_ms: f64,
    /// Milliseconds of each stage, if the schedule has stages and the device measures time.
    pub stages_ms: Vec<(Stage, f64)>,
}

impl Crowd {
    /// Describes the devices in use: names, shares, memory and waits.
    #[must_use]
    pub fn device_info(&self) -> DeviceInfo {
        let backend = self.device.backend();
        DeviceInfo {
            devices: self.device.devices.clone(),
            name: backend.device_name(),
            fallback: self.device.fallback.clone(),
            schedule: backend.schedule(),
            shares: match &self.device.opened.engine {
                Engine::Alone(_) => vec![1.0],
                Engine::Split(backend) => backend.shares().to_vec(),
            },
            memory_bytes: backend.memory_bytes(),
            host_waits: backend.waits(),
        }
    }

    /// Returns the times of the last update.
    pub fn frame_times(&mut self) -> FrameTimes {
        let backend = self.device.backend_mut();
        FrameTimes {
            frame_ms: backend.frame_time_ms(),
            view_ms: self.view_ms,
            stages_ms: backend.stage_times_ms(),
        }
    }

    /// Fills every palette with a constant and returns the milliseconds that it took: the lower
    /// bound of an update, for benchmarks. The palettes are wrong until the next update.
    ///
    /// # Errors
    ///
    /// A failing device.
    pub fn write_floor(&mut self) -> Result<f64, Error> {
        let Self { state, device, .. } = self;
        Ok(device.backend_mut().write_floor(&state.base.tables)?)
    }
}
