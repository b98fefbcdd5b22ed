//! The setting for the most lanes of a processor's vectors.

use crate::BackendError;

/// Environment variable for the most lanes.
const LANES: &str = "POPULACE_LANES";

/// Returns the most lanes that vectors may have on a CPU: the environment variable
/// `POPULACE_LANES`, which is 4, 8 or 16, or 16 without it. Results are the same with any. `device`
/// is the name for errors.
///
/// # Errors
///
/// [`BackendError::Failed`] for another value.
pub fn lanes_allowed(device: &str) -> Result<u32, BackendError> {
    let given = std::env::var_os(LANES).filter(|value| !value.is_empty());
    let Some(given) = given else {
        return Ok(16);
    };
    match given.to_str() {
        Some("4") => Ok(4),
        Some("8") => Ok(8),
        Some("16") => Ok(16),
        _ => Err(BackendError::Failed {
            device: device.into(),
            operation: "choose registers".into(),
            cause: format!("{LANES} is {}; write 4, 8 or 16", given.display()),
        }),
    }
}
