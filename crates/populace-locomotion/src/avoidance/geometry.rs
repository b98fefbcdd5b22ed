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

/// Eight directions, a quarter turn and an eighth apart in turns, so that neighbours differ much.
const DIRECTIONS: [Vec2; 8] = {
    const R: f32 = std::f32::consts::FRAC_1_SQRT_2;
    [
        Vec2::new(1.0, 0.0),
        Vec2::new(-R, R),
        Vec2::new(0.0, 1.0),
        Vec2::new(R, R),
        Vec2::new(-1.0, 0.0),
        Vec2::new(R, -R),
        Vec2::new(0.0, -1.0),
        Vec2::new(-R, -R),
    ]
};

/// Returns the direction from one walker to another at the same place. The opposite one the other
/// way around.
pub(crate) fn parting(from: u32, to: u32) -> Vec2 {
    let (low, high) = (from.min(to), from.max(to));
    let nth = low.wrapping_mul(3).wrapping_add(high) & 7;
    let direction = DIRECTIONS[nth as usize];
    if from < to { direction } else { -direction }
}
