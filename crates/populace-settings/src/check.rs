//! Checks of numbers that callers give.

use populace_model::LARGEST;
use populace_model::convert::not_finite;

use crate::error::Error;
use crate::fault::Allowed;

/// A setting whose numbers can be out of their ranges.
pub trait Check {
    /// Refuses the setting if a number is out of its range.
    ///
    /// # Errors
    ///
    /// [`Error::BadValue`].
    fn check(&self) -> Result<(), Error>;
}

/// Refuses values that are not finite or larger than [`LARGEST`], whose products overflow.
///
/// # Errors
///
/// [`Error::BadValue`].
pub fn bounded(what: &'static str, values: &[f32]) -> Result<(), Error> {
    match values.iter().find(|v| v.is_nan() || v.abs() > LARGEST) {
        Some(&value) => {
            Err(Error::BadValue { what, value, allowed: Allowed::Size { most: LARGEST } })
        }
        None => Ok(()),
    }
}

/// Refuses values that are not finite.
///
/// # Errors
///
/// [`Error::BadValue`].
pub fn finite(what: &'static str, values: &[f32]) -> Result<(), Error> {
    match not_finite(values) {
        Some(value) => Err(Error::BadValue { what, value, allowed: Allowed::Finite }),
        None => Ok(()),
    }
}

/// Refuses weights outside of 0 to 1.
///
/// # Errors
///
/// [`Error::BadValue`].
pub fn check_weight(what: &'static str, value: f32) -> Result<(), Error> {
    if (0.0..=1.0).contains(&value) {
        Ok(())
    } else {
        Err(Error::BadValue { what, value, allowed: Allowed::Range { least: 0.0, most: 1.0 } })
    }
}

/// Refuses times below 0 or above [`LARGEST`].
///
/// # Errors
///
/// [`Error::BadValue`].
pub fn check_secs(what: &'static str, value: f32) -> Result<(), Error> {
    if (0.0..=LARGEST).contains(&value) {
        Ok(())
    } else {
        Err(Error::BadValue {
            what,
            value,
            allowed: Allowed::Range { least: 0.0, most: LARGEST.into() },
        })
    }
}

/// Refuses layers that members do not have.
///
/// # Errors
///
/// [`Error::BadValue`].
pub fn check_layer(layer: usize) -> Result<(), Error> {
    if layer < populace_device::MAX_LAYERS {
        Ok(())
    } else {
        Err(Error::BadValue {
            what: "the layer",
            value: layer as f32,
            allowed: Allowed::Range { least: 0.0, most: 3.0 },
        })
    }
}
