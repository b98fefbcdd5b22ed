//! The sampled state of a slot's clip at a tick.

use super::Tables;
use crate::layout::{ClipRows, SLOT_ONCE, Slot};
use crate::playback::{SampledState, far_row, row_before};

/// Rows closer than this, in seconds, are a STEP of the clip and have no speed.
const STEP_SECS: f32 = 1e-3;

impl Tables {
    /// Returns the sampled state of a looping, once-playing or held slot at a tick not before its
    /// start.
    ///
    /// # Panics
    ///
    /// If the slot is empty.
    #[must_use]
    pub fn sampled_state(&self, slot: &Slot, tick: u64) -> SampledState {
        let bound = self.bound_clips().as_slice()[slot.bound_clip as usize];
        let clip = self.clips().as_slice()[bound.rows as usize];
        let (row, between) =
            self.find_row(&clip, slot.time_at(tick, clip.start_secs, clip.duration_secs));
        let at = row as f32 + between;
        let ended = slot.mode() == SLOT_ONCE && slot.end_tick(tick).is_some_and(|end| end <= tick);
        let speed = if ended { 0.0 } else { slot.speed(clip.duration_secs) };
        SampledState {
            bound_clip: slot.bound_clip,
            row: at,
            pace: speed * self.far_rate(&clip, at),
        }
    }

    /// Returns the rate of a clip, in units of (far row - row) per second of its own time.
    fn far_rate(&self, clip: &ClipRows, at: f32) -> f32 {
        let last = clip.row_count - 1;
        let far = far_row(at, last);
        let distance = far as f32 - at;
        if last == 0 || distance == 0.0 {
            return 0.0;
        }
        if clip.rows_per_sec > 0.0 {
            return clip.rows_per_sec / distance;
        }
        let first = clip.time_first as usize + row_before(at, last).min(far) as usize;
        let times = self.row_times().as_slice();
        let gap = times[first + 1] - times[first];
        if gap < STEP_SECS { 0.0 } else { 1.0 / (gap * distance) }
    }
}
