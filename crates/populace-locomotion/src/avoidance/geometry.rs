//! Points of the ground as pairs (x, z).

use glam::Vec2;

/// Returns the square root. IEEE 754 rounds it alike everywhere.
#[expect(clippy::disallowed_methods, reason = "no device computes these; hosts round alike")]
pub(crate) fn root(square: f32) -> f32 {
    square.max(0.0).sqrt()
}

/// Returns the index of the cell of a grid in which a coordinate is. Far coordinates saturate.
#[expect(clippy::cast_possible_truncation, reason = "the conversion saturates")]
pub(crate) fn cell(coordinate: f32, cells_per_m: f32) -> i32 {
    (coordinate * cells_per_m).floor() as i32
}

/// Returns an index as devices and tables store it. Slices longer than that do not fit memory.
pub(crate) fn index(nth: usize) -> u32 {
    u32::try_from(nth).unwrap_or(u32::MAX)
}

/// Returns the point of a line segment that is nearest to the origin.
pub(crate) fn nearest_to_origin(from: Vec2, to: Vec2) -> Vec2 {
    let along = to - from;
    let share = -from.dot(along) / along.length_squared();
    from + along * share.clamp(0.0, 1.0)
}

/// Returns the direction from one walker to another at the same place, by their indices. It is the
/// opposite one the other way around.
pub(crate) fn parting(from: u32, to: u32) -> Vec2 {
    if from < to { Vec2::X } else { Vec2::NEG_X }
}
