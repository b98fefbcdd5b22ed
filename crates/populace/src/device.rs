//! Devices to evaluate a crowd on.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use populace_core::{Backend, GlContext, Schedule};
use populace_native::NativeBackend;

use crate::Error;

/// A device, chosen by name; it is opened when a crowd is built on it.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Device {
    /// The CPU, without a driver, on as many threads; 0 takes one for each core.
    Native {
        /// How many threads.
        threads: usize,
    },
    /// The OpenCL device of a number, as [`devices`] lists them.
    OpenCl {
        /// The number.
        index: usize,
    },
}

impl Device {
    /// The CPU, on all cores.
    #[must_use]
    pub const fn native() -> Self {
        Self::Native { threads: 0 }
    }

    /// The OpenCL device of a number.
    #[must_use]
    pub const fn opencl(index: usize) -> Self {
        Self::OpenCl { index }
    }

    /// The best device of this machine: an OpenCL GPU, else an OpenCL CPU, else the native one.
    #[must_use]
    pub fn best() -> Self {
        opencl::best().unwrap_or(Self::native())
    }

    /// Opens the device; for a context of OpenGL's where one is given and the device's driver takes it.
    pub(crate) fn open(self, schedule: Schedule, gl: Option<&Arc<dyn GlContext>>) -> Result<Opened, Error> {
        match self {
            Self::Native { threads } => {
                Ok(Opened { backend: Box::new(NativeBackend::new(threads, schedule)?), not_for_gl: None })
            }
            Self::OpenCl { index } => opencl::open(index, schedule, gl),
        }
    }
}

/// A device that is ready.
pub(crate) struct Opened {
    pub(crate) backend: Box<dyn Backend>,
    /// Why it was not opened for the context of OpenGL's that was given.
    pub(crate) not_for_gl: Option<String>,
}

impl fmt::Display for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Native { .. } => f.write_str("native"),
            Self::OpenCl { index } => write!(f, "opencl:{index}"),
        }
    }
}

impl FromStr for Device {
    type Err = Error;

    /// Reads `native`, `opencl` (the first OpenCL device) or `opencl:N`.
    fn from_str(name: &str) -> Result<Self, Error> {
        let unknown = || Error::UnknownDevice { name: name.to_owned() };
        match name.split_once(':') {
            None if name == "native" => Ok(Self::native()),
            None if name == "opencl" => Ok(Self::opencl(0)),
            Some(("opencl", index)) => index.parse().map(Self::opencl).map_err(|_| unknown()),
            _ => Err(unknown()),
        }
    }
}

/// A device of this machine, or why there is none of its kind.
#[derive(Clone, Debug, PartialEq)]
pub struct DeviceReport {
    /// The device, `None` where the kind cannot be used.
    pub device: Option<Device>,
    /// What it is, or which kind is missing.
    pub name: String,
    /// Facts for people, or why the kind cannot be used and what would mend it.
    pub detail: String,
}

/// What can be used on this machine, and why not what cannot.
#[must_use]
pub fn devices() -> Vec<DeviceReport> {
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let native = DeviceReport {
        device: Some(Device::native()),
        name: "native".into(),
        detail: format!("the CPU without a driver, {cores} threads"),
    };
    std::iter::once(native).chain(opencl::reports()).collect()
}

#[cfg(feature = "opencl")]
mod opencl {
    use std::collections::HashMap;
    use std::sync::{Arc, Mutex, OnceLock, PoisonError};

    use populace_core::{GlContext, Schedule};
    use populace_opencl::{DeviceKind, OpenClBackend, OpenClDevice};

    use super::{Device, DeviceReport, Opened};
    use crate::Error;

    pub(super) fn best() -> Option<Device> {
        let found = populace_opencl::devices().ok()?;
        let first = |kind| found.iter().find(|d| d.kind == kind);
        first(DeviceKind::Gpu).or(first(DeviceKind::Cpu)).map(|d| Device::opencl(d.index))
    }

    /// Opens a device. Its context and kernels are for this crowd alone if made for OpenGL, else all crowds of this
    /// process share them.
    pub(super) fn open(
        index: usize,
        schedule: Schedule,
        gl: Option<&Arc<dyn GlContext>>,
    ) -> Result<Opened, Error> {
        let for_gl = gl.map(|gl| OpenClDevice::open_for_gl(index, Arc::clone(gl)));
        let (device, not_for_gl) = match for_gl {
            None => (shared(index)?, None),
            Some(Ok(device)) => (device, None),
            Some(Err(error)) => {
                let device = shared(index)?;
                // Of a driver that does not offer it at all the backend itself tells.
                let reason = device.info().shares_with_gl.then(|| error.to_string());
                (device, reason)
            }
        };
        Ok(Opened { backend: Box::new(OpenClBackend::new(&device, schedule)?), not_for_gl })
    }

    fn shared(index: usize) -> Result<Arc<OpenClDevice>, Error> {
        static OPEN: OnceLock<Mutex<HashMap<usize, Arc<OpenClDevice>>>> = OnceLock::new();
        let mut open = OPEN.get_or_init(Mutex::default).lock().unwrap_or_else(PoisonError::into_inner);
        Ok(match open.get(&index) {
            Some(device) => Arc::clone(device),
            None => Arc::clone(open.entry(index).or_insert(OpenClDevice::open(index)?)),
        })
    }

    pub(super) fn reports() -> Vec<DeviceReport> {
        let found = match populace_opencl::devices() {
            Ok(found) => found,
            Err(error) => {
                return vec![DeviceReport { device: None, name: "opencl".into(), detail: error.to_string() }];
            }
        };
        found
            .into_iter()
            .map(|d| DeviceReport {
                device: Some(Device::opencl(d.index)),
                detail: format!(
                    "{}, {:?}, {} compute units, {} MiB, at most {} MiB at once",
                    d.driver,
                    d.kind,
                    d.compute_units,
                    d.memory_bytes >> 20,
                    d.max_allocation_bytes >> 20
                ),
                name: d.name,
            })
            .collect()
    }
}

#[cfg(not(feature = "opencl"))]
mod opencl {
    use std::sync::Arc;

    use populace_core::{GlContext, Schedule};

    use super::{Device, DeviceReport, Opened};
    use crate::Error;

    pub(super) fn best() -> Option<Device> {
        None
    }

    pub(super) fn open(
        _index: usize,
        _schedule: Schedule,
        _gl: Option<&Arc<dyn GlContext>>,
    ) -> Result<Opened, Error> {
        Err(Error::WithoutOpenCl)
    }

    pub(super) fn reports() -> Vec<DeviceReport> {
        vec![DeviceReport { device: None, name: "opencl".into(), detail: Error::WithoutOpenCl.to_string() }]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_read_back_and_nonsense_is_refused() {
        for device in [Device::native(), Device::opencl(0), Device::opencl(3)] {
            assert_eq!(device.to_string().parse(), Ok(device));
        }
        assert_eq!("opencl".parse(), Ok(Device::opencl(0)));
        for name in ["", "cuda", "opencl:", "opencl:x", "opencl:-1", "native:2"] {
            assert_eq!(name.parse::<Device>(), Err(Error::UnknownDevice { name: name.into() }));
        }
    }
}
