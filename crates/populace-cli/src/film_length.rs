//! Frames of films of trajectory files.

use populace_film::FrameRate;
use populace_trajectory::Recording;

use crate::cli::MOST_FRAMES;
use crate::failure::Failure;

/// Frames per second of a film, if none are given.
const DEFAULT_FPS: u32 = 25;

/// Returns the rate of a film of people who follow trajectories: the one that was asked for, or 25.
pub(crate) fn film_rate(asked: Option<FrameRate>) -> Result<FrameRate, Failure> {
    Ok(asked.map_or_else(|| FrameRate::new(DEFAULT_FPS, 1), Ok)?)
}

/// Returns the number of frames from the beginning of a recording to its end, at least 1 and at
/// most [`MOST_FRAMES`].
pub(crate) fn frame_count(recording: &Recording, rate: FrameRate) -> u32 {
    let [from, until] = recording.secs();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
    let last = ((until - from) * rate.per_sec() + 1e-6).floor() as u32;
    last.saturating_add(1).min(MOST_FRAMES)
}
