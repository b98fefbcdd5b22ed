//! The setting for the most lanes of a processor's vectors.

use std::ffi::OsStr;

use crate::BackendError;

/// Environment variable for the most lanes.
const LANES: &str = "POPULACE_LANES";

/// Returns the most lanes that vectors may have on a CPU: the environment variable
/// `POPULACE_LANES`, which is 4, 8 or 16; 16 if it is unset or empty. OpenCL takes 4 as 8. Results
/// are the same with any. `device` is the name in errors.
///
/// # Errors
///
/// [`BackendError::Failed`] for another value.
pub fn lanes_allowed(device: &str) -> Result<u32, BackendError> {
    lanes_in(std::env::var_os(LANES).as_deref(), device)
}

fn lanes_in(given: Option<&OsStr>, device: &str) -> Result<u32, BackendError> {
    let Some(given) = given.filter(|value| !value.is_empty()) else {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_are_four_eight_or_sixteen() {
        let lanes = |given: &str| lanes_in(Some(OsStr::new(given)), "a device");
        assert_eq!(lanes_in(None, "a device").unwrap(), 16);
        for (given, wanted) in [("", 16), ("4", 4), ("8", 8), ("16", 16)] {
            assert_eq!(lanes(given).unwrap(), wanted, "{given}");
        }
        for given in ["5", "08", " 8", "eight"] {
            let error = lanes(given).unwrap_err().to_string();
            assert!(error.contains(&format!("POPULACE_LANES is {given}; write")), "{error}");
        }
    }
}
