//! Conversions between number types, and checks of numbers, that several crates need.

/// Rounds to the nearest `f32`.
#[must_use]
#[expect(
    clippy::cast_possible_truncation,
    reason = "rounding to the nearest f32 is what is wanted"
)]
pub fn single(number: f64) -> f32 {
    number as f32
}

/// Converts an index to the type that devices store. Callers keep indices within 32 bits; a debug
/// build panics on others.
#[must_use]
#[expect(clippy::cast_possible_truncation, reason = "checked in debug builds")]
pub fn u32_from(index: usize) -> u32 {
    debug_assert!(u32::try_from(index).is_ok(), "{index} does not fit into 32 bits");
    index as u32
}

/// Returns the bits of a place: a key that is equal for 0 and -0.
#[must_use]
pub fn place_bits(place: [f32; 3]) -> [u32; 3] {
    place.map(|component| (component + 0.0).to_bits())
}

/// Returns the first value that is not finite.
#[must_use]
pub fn not_finite(values: &[f32]) -> Option<f32> {
    values.iter().copied().find(|value| !value.is_finite())
}
