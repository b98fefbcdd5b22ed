//! Errors of the driver as errors of the backend.

use opencl3::error_codes::ClError;
use populace_device::BackendError;

/// Returns the error of a device that failed at `operation`, which follows "failed to".
pub(crate) fn failed(device: &str, operation: &str, error: &ClError) -> BackendError {
    BackendError::Failed {
        device: device.into(),
        operation: operation.into(),
        cause: error.to_string(),
    }
}
