//! The stages of the crowd pipeline as OpenCL C 1.2 kernels, and the schedules that run them.
//!
//! [`OpenClDevice`] is a device with its context and built program, shared by as many [`OpenClBackend`]s as there are
//! crowds on it. The schedule is *staged*: the kernels Pose, Transform and Write-Back of Lister & Day 2012, one
//! work-item per joint, through global memory, after a small kernel that evaluates slots from the clock.
//!
//! libOpenCL is loaded at run time; without it [`devices`] says [`BackendError::NoRuntime`].
//!
//! ```no_run
//! use populace_core::{Backend, Frame, Tables};
//! use populace_opencl::{OpenClBackend, OpenClDevice};
//!
//! let device = OpenClDevice::open(0)?;
//! let mut backend = OpenClBackend::new(&device)?;
//! let tables = Tables::new(4);
//! backend.update(&tables)?;
//! backend.run(&tables, Frame { tick: 0 })?;
//! # Ok::<(), populace_core::BackendError>(())
//! ```

mod backend;
mod buffer;
mod device;
mod launch;
mod program;
mod stage_buffers;
mod tables;

pub use backend::OpenClBackend;
pub use device::{DeviceInfo, DeviceKind, OpenClDevice, devices};
pub use populace_core::BackendError;
