//! The stages of the crowd pipeline in Rust, on all cores. No driver is needed.
//!
//! [`NativeBackend`] implements [`Backend`](populace_device::Backend) with two schedules:
//!
//! - *Staged*: evaluate, pose, transform and write-back, each for all members, through the same
//!   buffers as the OpenCL kernels of the same names.
//! - *Fused*: a member's whole frame at once, sixteen members of one body side by side. It is
//!   compiled for several processors, and the best version is chosen at run time.
//!
//! The arithmetic is the same everywhere, and results do not depend on the number of threads.
//!
//! ```
//! use populace_device::{Backend, Frame, PaletteSource, Schedule, Tables};
//! use populace_native::NativeBackend;
//!
//! let mut backend = NativeBackend::new(2, Schedule::Fused)?;
//! let tables = Tables::new(4);
//! backend.update(&tables)?;
//! backend.run(&tables, Frame::of_all(0))?;
//! assert!(backend.with_page(0, &mut |_| ()).is_err(), "an empty crowd has no page of palettes");
//! # Ok::<(), populace_device::BackendError>(())
//! ```

// Each module uses only modules above it.
mod cache;
mod encoding;
mod errors;
mod lanes;
#[cfg(target_arch = "x86_64")]
mod pair;
mod processor;
#[cfg(target_arch = "x86_64")]
mod registers;
mod split;

mod buffers;
mod history;
mod pages;
mod user_stages;

mod frame;
mod hierarchy;
mod matrices;
mod members;

mod local;
mod playback;
mod rows;
mod slot;

mod block_columns;
mod dispatch;
mod transposition;
mod widths;

mod change;
mod machines;
mod stages;

mod inertialize;
mod sample;

mod constraints;
mod joint;
mod scratch;

mod poses;

mod abreast;

mod evaluate;
mod fused;
mod pose;
mod transform;
mod write_back;

mod floor;
mod reading;

mod backend;

pub use backend::{MAX_THREADS, NativeBackend};
pub use processor::{Machine, RegisterLanes};
