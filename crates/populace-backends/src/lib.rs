//! Devices by name, and crowds that several devices share.
//!
//! ```
//! use populace_backends::{Device, Devices};
//! let device: Device = "native:2".parse()?;
//! let both: Devices = "native:2+native".parse()?;
//! assert_eq!((device.to_string(), both.as_slice().len()), ("native:2".into(), 2));
//! # Ok::<(), populace_backends::Error>(())
//! ```

mod device;
mod devices;
mod error;
mod history;
mod prepare;
mod split;

pub use device::{Device, DeviceReport, Engine, Opened, devices};
pub use devices::{Devices, Split};
pub use error::{DevicesFault, Error, SplitFault};
pub use history::DeviceHistory;
pub use split::SplitBackend;
