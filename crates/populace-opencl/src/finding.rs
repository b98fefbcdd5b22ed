//! Discovery of the OpenCL devices of this machine, and of the reasons why a driver lists none.

use opencl3::device::{
    CL_DEVICE_PARTITION_EQUALLY, CL_DEVICE_TYPE_ALL, CL_DEVICE_TYPE_CPU, CL_DEVICE_TYPE_GPU, Device,
};
use opencl3::error_codes::ClError;
use opencl3::platform::get_platforms;
use populace_device::{BackendError, driver_start};

use crate::drivers::DriverFault;
use crate::errors::failed;
use crate::gl_context::is_offered;
use crate::{drivers, pocl};

/// Returned by cl3 if there is no libOpenCL to load.
const NO_LIBRARY: i32 = -2000;
/// `CL_PLATFORM_NOT_FOUND_KHR`: a loader without any driver.
const NO_PLATFORM: i32 = -1001;
/// `CL_DEVICE_NOT_FOUND`: a driver without any device.
const NO_DEVICE: i32 = -1;

const NO_LOADER: &str =
    "this machine has no libOpenCL; install an OpenCL loader and a driver, such as PoCL";
const NO_DRIVER: &str = "no driver is installed; install the graphics processor's driver, or PoCL";

/// Kind of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum DeviceKind {
    /// A graphics processor.
    Gpu,
    /// The host's processor.
    Cpu,
    /// Any other kind.
    Other,
}

/// Description of a device, for users to choose from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceInfo {
    /// Index for [`open`](crate::OpenClDevice::open).
    pub index: usize,
    /// The device's own name.
    pub name: String,
    /// Vendor and version of the driver.
    pub driver: String,
    /// Kind of the device.
    pub kind: DeviceKind,
    /// Number of compute units.
    pub compute_units: u32,
    /// Maximum number of equal parts for [`open_part`](crate::OpenClDevice::open_part); 1 if the
    /// device cannot be split.
    pub most_parts: u32,
    /// Memory in bytes.
    pub memory_bytes: u64,
    /// Maximum size of one allocation, in bytes.
    pub max_allocation_bytes: u64,
    /// Local memory of a work-group, in bytes.
    pub local_memory_bytes: u64,
    /// True if the driver supports `cl_khr_gl_sharing`; see
    /// [`open_for_gl`](crate::OpenClDevice::open_for_gl).
    pub shares_with_gl: bool,
    /// Reason why the device cannot be used on this machine, as far as that is known without
    /// building a kernel.
    pub fault: Option<String>,
}

/// Lists all OpenCL devices of this machine, in the order of their platforms. No kernel is built.
///
/// # Errors
///
/// [`BackendError::NoRuntime`] without libOpenCL or without any device. It names the fault of each
/// driver.
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

/// Lists the drivers of this machine that list no device, with reasons: first those that the loader
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

/// Devices and faults of all platforms.
#[derive(Default)]
struct Found {
    devices: Vec<Device>,
    /// Platforms without a device.
    faults: Vec<DriverFault>,
}

fn find() -> Result<Found, BackendError> {
    // The loader's initialization is not thread-safe: two threads that ask at once for the first
    // time may both be told that there is no platform. Nor is that of drivers.
    let _starting = driver_start();
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
