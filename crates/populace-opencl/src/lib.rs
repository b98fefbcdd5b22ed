//! The stages of the crowd pipeline as OpenCL C 1.2 kernels, and the schedules that enqueue them.
//!
//! An [`OpenClDevice`] is a device with its context and programs. Any number of crowds share it,
//! each with an [`OpenClBackend`] of its own.
//!
//! There are two schedules:
//!
//! - *staged*: the kernels Pose, Transform and Write-Back of Lister & Day 2012, section 3, with one
//!   work-item for each joint, through global memory;
//! - *fused*: one kernel from slots to palettes. Its *wide* form, for CPUs, computes eight or sixteen
//!   members of a body side by side in one work-item. Its *grouped* form, for GPUs, computes up to
//!   eight in one work-group, and those that only mix clips in a kernel of their own.
//!
//! libOpenCL is loaded at run time. Without it [`devices`] returns [`BackendError::NoRuntime`].
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
mod context;
mod device;
mod drivers;
mod errors;
mod finding;
mod fused;
mod gl_context;
mod gl_sharing;
mod handles;
mod history;
#[cfg(target_os = "linux")]
mod large_pages;
mod launch;
mod machines;
mod pages;
mod palette_transport;
mod pocl;
mod program;
mod shape;
mod stage_buffers;
mod staged;
mod tables;
mod upload;
mod user_stages;
mod waits;

pub use backend::OpenClBackend;
pub use device::{DevicePart, OpenClDevice};
pub use drivers::DriverFault;
pub use finding::{DeviceInfo, DeviceKind, devices, driver_faults};
pub use palette_transport::EmptyPalettes;
pub use populace_device::BackendError;
