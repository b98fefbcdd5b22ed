//! Errors of naming, opening and sharing devices.

use populace_device::BackendError;
use populace_model::ErrorKind;

/// The reason why devices cannot be opened or share a crowd.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A device that failed, or is not there.
    #[error(transparent)]
    Backend(#[from] BackendError),
    /// Data that does not describe a skeleton.
    #[error(transparent)]
    Model(#[from] populace_model::Error),
    /// Tables that do not fit a device.
    #[error(transparent)]
    Tables(#[from] populace_device::Error),
    /// Text that names no device.
    #[error(
        "there is no device \"{name}\"; devices are native, opencl and opencl:N; native:2 takes \
         two threads, opencl:N:1/2 the first of two equal parts, and + joins several"
    )]
    UnknownDevice {
        /// The name given.
        name: String,
    },
    /// Devices that cannot share a crowd.
    #[error("{devices}{}{fault}", if devices.is_empty() { "" } else { ": " })]
    BadDevices {
        /// The devices, joined.
        devices: String,
        /// The fault.
        fault: DevicesFault,
    },
    /// A split that does not fit its devices.
    #[error("the split {0}")]
    BadSplit(SplitFault),
    /// OpenCL was requested from a build without it.
    #[error(
        "this build has no OpenCL; build with the feature \"opencl\", or choose the native device"
    )]
    WithoutOpenCl,
}

impl Error {
    /// Returns the kind of the error.
    #[must_use]
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::Backend(error) => error.kind(),
            Self::Model(error) => error.kind(),
            Self::Tables(error) => error.kind(),
            Self::UnknownDevice { .. } => ErrorKind::NotFound,
            Self::BadDevices { .. } | Self::BadSplit(_) => ErrorKind::InvalidInput,
            Self::WithoutOpenCl => ErrorKind::Unsupported,
        }
    }
}

/// The reason why devices cannot share a crowd.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DevicesFault {
    /// An empty list.
    #[error("no device is named; name at least one")]
    None,
    /// A device that is named twice.
    #[error("{0} is named twice; name each device once")]
    Twice(String),
}

/// The reason why a split does not fit its devices.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SplitFault {
    /// Another number of shares than of devices.
    #[error(
        "has {} for {}, {devices}; give each device one",
        number(*shares, "share"),
        number(*count, "device")
    )]
    Count {
        /// The number of shares.
        shares: usize,
        /// The number of devices.
        count: usize,
        /// The devices, joined.
        devices: String,
    },
    /// A share that is negative or not finite.
    #[error("has a share of {0}; shares must be finite and at least 0")]
    Share(f64),
    /// Shares whose sum is not finite.
    #[error("has shares whose sum is too large")]
    TooLarge,
    /// Only shares of 0.
    #[error("has no share above 0; at least one device must have members")]
    AllZero,
    /// Text that is no list of numbers.
    #[error(
        "\"{0}\" is not a list of numbers; give a share for each device, as in 60,40, or measured"
    )]
    Text(String),
}

fn number(count: usize, what: &str) -> String {
    if count == 1 { format!("one {what}") } else { format!("{count} {what}s") }
}
