//! The stages of the crowd pipeline as OpenCL C 1.2 kernels, and the schedules that run them.
//!
//! [`OpenClDevice`] is a device with its context and built program, shared by as many
//! [`OpenClBackend`]s as there are crowds on it. Its schedules are *staged*, the kernels Pose,
//! Transform and Write-Back of Lister & Day 2012, section 3, one work-item per joint, through
//! global memory; and *fused*, one kernel for the whole frame, in two forms: *wide* for CPUs,
//! sixteen joints at a time in one work-item, and *grouped* for GPUs, a work-group for each member.
//!
//! libOpenCL is loaded at run time; without it [`devices`] says [`BackendError::NoRuntime`].
//!
//! ```no_run
//! use populace_device::{Backend, Frame, Schedule, Tables};
//! use populace_opencl::{OpenClBackend, OpenClDevice};
//!
//! let device = OpenClDevice::open(0)?;
//! let mut backend = OpenClBackend::new(&device, Schedule::Fused)?;
//! let tables = Tables::new(4);
//! backend.update(&tables)?;
//! backend.run(&tables, Frame::of_all(0))?;
//! # Ok::<(), populace_device::BackendError>(())
//! ```

mod backend;
mod buffer;
mod cache;
mod device;
mod drivers;
mod finding;
mod fused;
mod gl_sharing;
mod keeping;
mod launch;
mod machines;
mod pages;
mod palette_transport;
mod pocl;
mod program;
mod stage_buffers;
mod staged;
mod tables;
mod upload;
mod user_stages;
mod waits;

pub use backend::OpenClBackend;
pub use device::{DevicePart, OpenClDevice};
pub use finding::{DeviceInfo, DeviceKind, DriverFault, devices, driver_faults};
pub use palette_transport::EmptyPalettes;
pub use populace_device::BackendError;
