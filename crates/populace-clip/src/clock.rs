//! The clock of playback, in whole ticks.

/// Ticks per second: a multiple of the usual frame rates (24, 25, 30, 50, 60, 120, 144), so that
/// whole frames are whole numbers of ticks.
pub const TICKS_PER_SEC: u64 = 705_600;
/// The tick at which a crowd's clock starts, most of a year after 0. A change of speed is stored as
/// an earlier start, which may lie long before the crowd was built.
pub const FIRST_TICK: u64 = 1 << 44;
/// One tick in seconds, rounded to single precision.
pub const TICK_SECS: f32 = 1.0 / 705_600.0;

/// Converts seconds to ticks, rounded to the nearest.
///
/// Negative times and NaN give 0. Times that no tick can count, infinity included, give the last
/// tick, [`u64::MAX`].
#[must_use]
pub fn ticks_from_secs(secs: f64) -> u64 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "`as` saturates, which is wanted"
    )]
    let ticks = (secs * TICKS_PER_SEC as f64).round() as u64;
    ticks
}
