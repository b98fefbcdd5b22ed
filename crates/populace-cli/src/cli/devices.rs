//! The choice of devices, and the arguments of `populace devices`.

use clap::Args;
use populace::{Crowd, CrowdBuilder, Device, Devices, Schedule, Split};

use crate::failure::Failure;

#[derive(Args, Debug)]
pub(crate) struct DevicesArgs {
    /// Print one JSON document
    #[arg(long)]
    pub(crate) json: bool,
}

/// The choice of devices.
#[derive(Args, Clone, Debug)]
pub(crate) struct DeviceArgs {
    /// Device to evaluate on: native, opencl or opencl:N, or several joined by +; see `populace
    /// devices --help` [default: the best available]
    #[arg(long, value_name = "DEVICE[+DEVICE]")]
    pub(crate) device: Option<Devices>,
    /// Distribution of members over several devices: measured balances them by their times; shares
    /// such as 60,40 are fixed
    #[arg(
        long,
        value_name = "measured|SHARE,SHARE",
        default_value_t = Split::Measured,
        allow_hyphen_values = true
    )]
    pub(crate) split: Split,
    /// Mapping of the pipeline to the device: staged runs one kernel per stage, fused all stages in
    /// one, as fused-wide for CPUs or fused-grouped for GPUs
    #[arg(
        long,
        value_name = "staged|fused|fused-wide|fused-grouped",
        default_value_t = Schedule::Fused
    )]
    pub(crate) schedule: Schedule,
}

impl DeviceArgs {
    /// Returns a builder for a crowd on these devices, or on the best device if none is named.
    pub(crate) fn crowd(&self) -> CrowdBuilder {
        let builder = Crowd::builder().split(self.split.clone()).schedule(self.schedule);
        self.device.iter().cloned().fold(builder, CrowdBuilder::devices)
    }

    /// Returns a builder for a crowd on these devices, or on the native device if none is named. It
    /// reads single members fastest: elsewhere each read is a call of a driver.
    pub(crate) fn crowd_to_read(&self) -> CrowdBuilder {
        let builder = self.crowd();
        if self.device.is_none() { builder.device(Device::native()) } else { builder }
    }
}

/// Builds a crowd, and reports if it falls back to the native device.
pub(crate) fn build(builder: CrowdBuilder) -> Result<Crowd, Failure> {
    let crowd = builder.build()?;
    if let Some(reason) = crowd.device_info().fallback {
        crate::report::message!("using the native device: {reason}");
    }
    Ok(crowd)
}
