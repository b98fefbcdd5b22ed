//! Finds the row of a clip for a time.

use super::Tables;
use crate::layout::ClipRows;

impl Tables {
    /// Returns the last row of a clip at or before a time on its own axis, and the fraction of the
    /// way to the next row. Before the first row that row holds, after the last row the last. Twin
    /// of `find_row` in `kernels/slot.cl`.
    #[inline]
    #[must_use]
    pub fn find_row(&self, clip: &ClipRows, secs: f32) -> (u32, f32) {
        let last = clip.row_count - 1;
        let passed = secs - clip.start_secs;
        if last == 0 || passed <= 0.0 && clip.rows_per_sec > 0.0 {
            return (0, 0.0);
        }
        if clip.rows_per_sec > 0.0 {
            let at = passed * clip.rows_per_sec;
            if at >= last as f32 {
                return (last, 0.0);
            }
            let row = truncated(at);
            return (row, at - row as f32);
        }
        let times = &self.row_times().as_slice()[clip.time_first as usize..];
        if secs >= times[last as usize] {
            return (last, 0.0);
        }
        let bucket = truncated((passed * clip.buckets_per_sec).max(0.0)).min(clip.bucket_count - 1);
        let mut row = self.buckets().as_slice()[(clip.bucket_first + bucket) as usize];
        while times[row as usize + 1] <= secs {
            row += 1;
        }
        let (from, to) = (times[row as usize], times[row as usize + 1]);
        (row, ((secs - from) / (to - from)).max(0.0))
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "not negative; truncation is intended"
)]
fn truncated(x: f32) -> u32 {
    x as u32
}
