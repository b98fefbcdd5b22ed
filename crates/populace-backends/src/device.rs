//! Devices that evaluate a crowd.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use populace_device::{Backend, GlContext, PaletteSource, Schedule};
use populace_native::NativeBackend;

use crate::error::Error;
use crate::split::SplitBackend;

/// A device, selected by name. It is opened when a crowd is built on it.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Device {
    /// The CPU without a driver, on `threads` threads; 0 means one per core.
    Native {
        /// The number of threads, at most 1,024.
        threads: usize,
    },
    /// The OpenCL device with an index, as [`devices`] lists them.
    OpenCl {
        /// The index.
        index: usize,
    },
    /// One of several equal parts of an OpenCL device. Each part has compute units of its own.
    OpenClPart {
        /// The index of the device.
        index: usize,
        /// The part, from 1 to `parts`.
        part: usize,
        /// The number of parts.
        parts: usize,
    },
}

impl Device {
    /// Returns the native device on all cores.
    #[must_use]
    pub const fn native() -> Self {
        Self::Native { threads: 0 }
    }

    /// Returns the OpenCL device with an index.
    #[must_use]
    pub const fn opencl(index: usize) -> Self {
        Self::OpenCl { index }
    }

    /// Returns part `part` (from 1) of an OpenCL device divided into `parts` equal parts. CPUs can
    /// be divided down to single compute units; GPU drivers do not support it.
    #[must_use]
    pub const fn opencl_part(index: usize, part: usize, parts: usize) -> Self {
        Self::OpenClPart { index, part, parts }
    }

    /// Returns the best device of this machine: an OpenCL GPU, else an OpenCL CPU, else the native
    /// device. OpenCL devices with an incomplete driver are skipped; [`devices`] lists what each
    /// lacks.
    #[must_use]
    pub fn best() -> Self {
        Self::best_opencl().unwrap_or(Self::native())
    }

    /// Returns the best OpenCL device.
    ///
    /// # Errors
    ///
    /// The reason why there is none, in words.
    pub fn best_opencl() -> Result<Self, String> {
        opencl::best()
    }

    /// Returns an empty source of palettes on this device for `Renderer::connect_palettes`, which
    /// then tells how palettes reach an OpenGL context from here. It builds no kernels.
    ///
    /// # Errors
    ///
    /// A device that does not exist or cannot be opened.
    pub fn empty_palettes(self, gl: &Arc<dyn GlContext>) -> Result<Box<dyn PaletteSource>, Error> {
        match self {
            Self::Native { threads } => {
                Ok(Box::new(NativeBackend::new(threads, Schedule::default())?))
            }
            Self::OpenCl { index } => opencl::empty_palettes((index, None), gl),
            Self::OpenClPart { index, part, parts } => {
                opencl::empty_palettes((index, Some((part, parts))), gl)
            }
        }
    }

    /// Opens the device, sharing buffers with the OpenGL context if one is given and the driver
    /// supports it.
    pub(crate) fn open(
        self,
        schedule: Schedule,
        gl: Option<&Arc<dyn GlContext>>,
    ) -> Result<Opened, Error> {
        match self {
            Self::Native { threads } => Ok(Opened {
                engine: Engine::alone(NativeBackend::new(threads, schedule)?),
                not_for_gl: None,
            }),
            Self::OpenCl { index } => opencl::open((index, None), schedule, gl),
            Self::OpenClPart { index, part, parts } => {
                opencl::open((index, Some((part, parts))), schedule, gl)
            }
        }
    }
}

/// The backend of a crowd.
pub enum Engine {
    /// One device.
    Alone(Box<dyn Backend>),
    /// Several devices.
    Split(Box<SplitBackend>),
}

impl Engine {
    fn alone(backend: impl Backend + 'static) -> Self {
        Self::Alone(Box::new(backend))
    }

    pub(crate) fn into_backend(self) -> Box<dyn Backend> {
        match self {
            Self::Alone(backend) => backend,
            Self::Split(backend) => backend,
        }
    }
}

/// An opened device, or several that share a crowd.
pub struct Opened {
    /// The backend.
    pub engine: Engine,
    /// The reason why it does not share buffers with the given OpenGL context.
    pub not_for_gl: Option<String>,
}

impl Opened {
    /// The backend.
    #[must_use]
    pub fn backend(&self) -> &dyn Backend {
        match &self.engine {
            Engine::Alone(backend) => &**backend,
            Engine::Split(backend) => &**backend,
        }
    }

    /// The backend, to run frames on.
    pub fn backend_mut(&mut self) -> &mut dyn Backend {
        match &mut self.engine {
            Engine::Alone(backend) => &mut **backend,
            Engine::Split(backend) => &mut **backend,
        }
    }
}

impl fmt::Display for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Native { threads: 0 } => f.write_str("native"),
            Self::Native { threads } => write!(f, "native:{threads}"),
            Self::OpenCl { index } => write!(f, "opencl:{index}"),
            Self::OpenClPart { index, part, parts } => write!(f, "opencl:{index}:{part}/{parts}"),
        }
    }
}

impl FromStr for Device {
    type Err = Error;

    /// Parses `native`, `native:N` (N threads, at most 1,024), `opencl` (the first OpenCL device),
    /// `opencl:N`, or `opencl:N:K/P` (part K of P equal parts).
    fn from_str(name: &str) -> Result<Self, Error> {
        let words: Vec<&str> = name.split(':').collect();
        let number = |word: &str| word.parse::<usize>().ok();
        let device = match words[..] {
            ["native"] => Some(Self::native()),
            ["native", threads] => {
                number(threads).filter(|n| *n > 0).map(|threads| Self::Native { threads })
            }
            ["opencl"] => Some(Self::opencl(0)),
            ["opencl", index] => number(index).map(Self::opencl),
            ["opencl", index, part] => part.split_once('/').and_then(|(part, parts)| {
                let (part, parts) = (number(part)?, number(parts)?);
                (1..=parts).contains(&part).then_some(Self::opencl_part(
                    number(index)?,
                    part,
                    parts,
                ))
            }),
            _ => None,
        };
        device.ok_or_else(|| Error::UnknownDevice { name: name.to_owned() })
    }
}

/// A device of this machine, or the reason why a kind is missing.
#[derive(Clone, Debug, PartialEq)]
pub struct DeviceReport {
    /// The device; `None` if the kind cannot be used.
    pub device: Option<Device>,
    /// The name of the device, or of the missing kind.
    pub name: String,
    /// A description, or the reason why the kind cannot be used and how to mend it.
    pub detail: String,
}

/// Lists the devices of this machine, and the reasons why others cannot be used.
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

    use populace_device::{BackendError, GlContext, PaletteSource, Schedule};
    use populace_opencl::{DeviceKind, DevicePart, EmptyPalettes, OpenClBackend, OpenClDevice};

    use super::{Device, DeviceReport, Engine, Opened};
    use crate::error::Error;

    /// The index of a device, and its part if it is divided.
    type Name = (usize, Option<(usize, usize)>);

    pub(super) fn best() -> Result<Device, String> {
        let found = populace_opencl::devices().map_err(|error| match error {
            BackendError::NoRuntime { cause } => format!("OpenCL cannot be used: {cause}"),
            other => other.to_string(),
        })?;
        let first = |kind| found.iter().find(|d| d.kind == kind && d.fault.is_none());
        if let Some(device) = first(DeviceKind::Gpu).or(first(DeviceKind::Cpu)) {
            return Ok(Device::opencl(device.index));
        }
        let faults = found
            .iter()
            .filter_map(|d| Some(format!("{} cannot be used: {}", d.name, d.fault.as_ref()?)));
        let faults: Vec<_> = faults.collect();
        Err(if faults.is_empty() {
            "OpenCL offers neither a GPU nor a CPU".into()
        } else {
            faults.join("; ")
        })
    }

    pub(super) fn open(
        device: Name,
        schedule: Schedule,
        gl: Option<&Arc<dyn GlContext>>,
    ) -> Result<Opened, Error> {
        let (device, not_for_gl) = ready(device, gl)?;
        Ok(Opened { engine: Engine::alone(OpenClBackend::new(&device, schedule)?), not_for_gl })
    }

    pub(super) fn empty_palettes(
        device: Name,
        gl: &Arc<dyn GlContext>,
    ) -> Result<Box<dyn PaletteSource>, Error> {
        let (device, not_for_gl) = ready(device, Some(gl))?;
        Ok(Box::new(EmptyPalettes::new(&device, not_for_gl)?))
    }

    /// Opens a device. Also returns the reason why it does not share buffers with the OpenGL
    /// context. Context and kernels are shared by all crowds of the process, except those made for
    /// OpenGL.
    fn ready(
        device: Name,
        gl: Option<&Arc<dyn GlContext>>,
    ) -> Result<(Arc<OpenClDevice>, Option<String>), Error> {
        match gl.map(|gl| OpenClDevice::open_for_gl(device.0, part_of(device), Arc::clone(gl))) {
            None => Ok((shared(device)?, None)),
            Some(Ok(device)) => Ok((device, None)),
            Some(Err(error)) => {
                let device = shared(device)?;
                // If the driver does not support sharing at all, the backend reports it.
                let reason = device.info().shares_with_gl.then(|| error.to_string());
                Ok((device, reason))
            }
        }
    }

    fn part_of((_, part): Name) -> Option<DevicePart> {
        part.map(|(part, parts)| DevicePart { part, parts })
    }

    fn shared(name: Name) -> Result<Arc<OpenClDevice>, Error> {
        static OPEN: OnceLock<Mutex<HashMap<Name, Arc<OpenClDevice>>>> = OnceLock::new();
        let mut open =
            OPEN.get_or_init(Mutex::default).lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(device) = open.get(&name) {
            return Ok(Arc::clone(device));
        }
        let device = match part_of(name) {
            None => OpenClDevice::open(name.0)?,
            Some(part) => OpenClDevice::open_part(name.0, part)?,
        };
        Ok(Arc::clone(open.entry(name).or_insert(device)))
    }

    pub(super) fn reports() -> Vec<DeviceReport> {
        let missing = |name, detail| DeviceReport { device: None, name, detail };
        let found = match populace_opencl::devices() {
            Ok(found) => found,
            Err(error) => return vec![missing("opencl".into(), error.to_string())],
        };
        let devices = found.into_iter().map(|d| match d.fault {
            Some(fault) => missing(d.name, fault),
            None => DeviceReport {
                device: Some(Device::opencl(d.index)),
                detail: format!(
                    "{}, {:?}, {} compute units{}, {} MiB, at most {} MiB at once",
                    d.driver,
                    d.kind,
                    d.compute_units,
                    if d.most_parts > 1 {
                        format!(" for up to {} equal parts", d.most_parts)
                    } else {
                        String::new()
                    },
                    d.memory_bytes >> 20,
                    d.max_allocation_bytes >> 20
                ),
                name: d.name,
            },
        });
        let faults = populace_opencl::driver_faults().into_iter();
        devices.chain(faults.map(|fault| missing(fault.driver, fault.cause))).collect()
    }
}

#[cfg(not(feature = "opencl"))]
mod opencl {
    use std::sync::Arc;

    use populace_device::{GlContext, PaletteSource, Schedule};

    use super::{Device, DeviceReport, Opened};
    use crate::error::Error;

    pub(super) fn best() -> Result<Device, String> {
        Err(Error::WithoutOpenCl.to_string())
    }

    pub(super) fn empty_palettes(
        _device: (usize, Option<(usize, usize)>),
        _gl: &Arc<dyn GlContext>,
    ) -> Result<Box<dyn PaletteSource>, Error> {
        Err(Error::WithoutOpenCl)
    }

    pub(super) fn open(
        _device: (usize, Option<(usize, usize)>),
        _schedule: Schedule,
        _gl: Option<&Arc<dyn GlContext>>,
    ) -> Result<Opened, Error> {
        Err(Error::WithoutOpenCl)
    }

    pub(super) fn reports() -> Vec<DeviceReport> {
        vec![DeviceReport {
            device: None,
            name: "opencl".into(),
            detail: Error::WithoutOpenCl.to_string(),
        }]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn device_names_parse_and_bad_names_are_refused() {
        let (two_threads, half) = (Device::Native { threads: 2 }, Device::opencl_part(1, 2, 2));
        for device in [Device::native(), two_threads, Device::opencl(0), Device::opencl(3), half] {
            assert_eq!(device.to_string().parse(), Ok(device));
        }
        assert_eq!("opencl".parse(), Ok(Device::opencl(0)));
        assert_eq!("opencl:1:2/2".parse(), Ok(half));
        let no_parts = [
            "opencl:0:",
            "opencl:0:2",
            "opencl:0:0/2",
            "opencl:0:3/2",
            "opencl:0:1/0",
            "opencl:0:1/2/3",
        ];
        let others = [
            "",
            "cuda",
            "opencl:",
            "opencl:x",
            "opencl:-1",
            "native:",
            "native:0",
            "native:1/2",
            "native:1:2",
        ];
        for name in no_parts.into_iter().chain(others) {
            assert_eq!(name.parse::<Device>(), Err(Error::UnknownDevice { name: name.into() }));
        }
    }
}
