//! Errors of the native device.

use populace_device::BackendError;

/// The device's name in errors.
pub(crate) const DEVICE: &str = "the native device";

/// Makes the error of an operation that failed.
pub(crate) fn failed(operation: &str, cause: impl std::fmt::Display) -> BackendError {
    BackendError::Failed {
        device: DEVICE.into(),
        operation: operation.into(),
        cause: cause.to_string(),
    }
}
