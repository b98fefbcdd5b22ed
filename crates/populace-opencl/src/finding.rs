//! Finding the OpenCL devices of this machine, and why a driver gives none.

use std::sync::{Mutex, PoisonError};

use opencl3::device::{
    CL_DEVICE_PARTITION_EQUALLY, CL_DEVICE_TYPE_ALL, CL_DEVICE_TYPE_CPU, CL_DEVICE_TYPE_GPU, Device,
};
use opencl3::error_codes::ClError;
use opencl3::platform::get_platforms;
use populace_device::BackendError;

use crate::device::failed;
use crate::gl_sharing::is_offered;
use crate::{drivers, pocl};

/// What cl3 answers when there is no libOpenCL to load.
const NO_LIBRARY: i32 = -2000;
/// `CL_PLATFORM_NOT_FOUND_KHR`: a loader without any driver.
const NO_PLATFORM: i32 = -1001;
/// `CL_DEVICE_NOT_FOUND`: a driver without any device.
const NO_DEVICE: i32 = -1;

const NO_LOADER: &str =
    "this machine has no libOpenCL; install an OpenCL loader and a driver, such as PoCL";
const NO_DRIVER: &str = "no driver is installed; install that of the graphics processor, or PoCL";

/// What a device is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum DeviceKind {
    /// A graphics processor.
    Gpu,
    /// The host's processor.
    Cpu,
    /// Anything else.
    Other,
}

/// A device for people to choose from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceInfo {
    /// The number that [`open`](crate::OpenClDevice::open) takes.
    pub index: usize,
    /// The device's own name.
    pub name: String,
    /// The driver and its version.
    pub driver: String,
    /// What it is.
    pub kind: DeviceKind,
    /// Compute units.
    pub compute_units: u32,
    /// Into how many equal parts the device can be cut at most, for
    /// [`open_part`](crate::OpenClDevice::open_part); 1 where it cannot be cut.
    pub most_parts: u32,
    /// Memory in bytes.
    pub memory_bytes: u64,
    /// The most that can be allocated at once, in bytes.
    pub max_allocation_bytes: u64,
    /// What the work-items of a group share, in bytes.
    pub local_memory_bytes: u64,
    /// Whether the driver offers `cl_khr_gl_sharing`; see
    /// [`open_for_gl`](crate::OpenClDevice::open_for_gl).
    pub shares_with_gl: bool,
    /// Why the device cannot be used on this machine, as far as that shows without building a
    /// kernel.
    pub fault: Option<String>,
}

/// A driver that is set up on this machine and gives no device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DriverFault {
    /// The platform's name, or the driver's library.
    pub driver: String,
    /// What is wrong, and where.
    pub cause: String,
}

/// All OpenCL devices of this machine, in the order of their platforms. No kernel is built.
///
/// # Errors
///
/// [`BackendError::NoRuntime`] without libOpenCL or without any device; it says why each driver
/// gives none.
pub fn devices() -> Result<Vec<DeviceInfo>, BackendError> {
    let found = all_devices()?;
    found
        .iter()
        .enumerate()
        .map(|(index, device)| {
            info(index, device).map_err(|e| failed("OpenCL", "describe a device", &e))
        })
        .collect()
}

/// The drivers of this machine that give no device, each with its reason: those that the loader
/// cannot load, then platforms without a device.
#[must_use]
pub fn driver_faults() -> Vec<DriverFault> {
    let platforms = find().map(|found| found.faults).unwrap_or_default();
    drivers::faults().into_iter().chain(platforms).collect()
}

pub(crate) fn all_devices() -> Result<Vec<Device>, BackendError> {
    let found = find()?;
    if !found.devices.is_empty() {
        return Ok(found.devices);
    }
    let faults = drivers::faults().into_iter().chain(found.faults);
    let causes: Vec<_> = faults.map(|fault| format!("{}: {}", fault.driver, fault.cause)).collect();
    let cause = if causes.is_empty() { NO_DRIVER.into() } else { causes.join("; ") };
    Err(BackendError::NoRuntime { cause })
}

/// What the platforms of this machine offer.
#[derive(Default)]
struct Found {
    devices: Vec<Device>,
    /// Platforms without a device.
    faults: Vec<DriverFault>,
}

fn find() -> Result<Found, BackendError> {
    // Two threads that ask for the first time at once can both be told that there is no platform:
    // the loader's own set-up is not safe against that.
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
    let _guard = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
    let platforms = match get_platforms() {
        Err(ClError(NO_LIBRARY)) => {
            return Err(BackendError::NoRuntime { cause: NO_LOADER.into() });
        }
        Err(ClError(NO_PLATFORM)) => Vec::new(),
        other => other.map_err(|e| failed("OpenCL", "list its platforms", &e))?,
    };
    let mut found = Found::default();
    for platform in platforms {
        let cause = match platform.get_devices(CL_DEVICE_TYPE_ALL) {
            Ok(devices) if !devices.is_empty() => {
                found.devices.extend(devices.into_iter().map(Device::new));
                continue;
            }
            Ok(_) | Err(ClError(NO_DEVICE)) if pocl::is(&platform) => pocl::fault(),
            Ok(_) | Err(ClError(NO_DEVICE)) => None,
            Err(error) => Some(format!("it does not list its devices: {error}")),
        };
        let driver = platform.name().unwrap_or_else(|_| "a platform without a name".into());
        let cause = cause.unwrap_or_else(|| "it finds no device that it can use".into());
        found.faults.push(DriverFault { driver, cause });
    }
    Ok(found)
}

pub(crate) fn info(index: usize, device: &Device) -> Result<DeviceInfo, ClError> {
    let kind = device.dev_type()?;
    Ok(DeviceInfo {
        index,
        name: device.name()?.trim().to_owned(),
        driver: format!("{} {}", device.vendor()?.trim(), device.driver_version()?.trim()),
        kind: if kind & CL_DEVICE_TYPE_GPU != 0 {
            DeviceKind::Gpu
        } else if kind & CL_DEVICE_TYPE_CPU != 0 {
            DeviceKind::Cpu
        } else {
            DeviceKind::Other
        },
        compute_units: device.max_compute_units()?,
        most_parts: most_parts(device)?,
        memory_bytes: device.global_mem_size()?,
        max_allocation_bytes: device.max_mem_alloc_size()?,
        local_memory_bytes: device.local_mem_size()?,
        shares_with_gl: is_offered(device)?,
        fault: if pocl::offers(device) { pocl::fault() } else { None },
    })
}

fn most_parts(device: &Device) -> Result<u32, ClError> {
    let is_cut_equally = device.partition_properties()?.contains(&CL_DEVICE_PARTITION_EQUALLY);
    Ok(if is_cut_equally {
        device.partition_max_sub_devices()?.clamp(1, device.max_compute_units()?)
    } else {
        1
    })
}
