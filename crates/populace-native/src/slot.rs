//! Rows and weight of a slot, in closed form from the clock. Twin of the end of `kernels/slot.cl`;
//! twins of the other functions of that file are methods of `Slot`, and `Tables::find_row`.

use populace_device::Tables;
use populace_device::layout::{ClipRows, NONE, SLOT_LIVE, Slot, SlotSample};

/// Returns the row of a live clip that is `behind` rows older than the newest.
fn ring_place(clip: &ClipRows, behind: u32) -> u32 {
    let wraps = if behind > clip.newest_row { clip.ring_rows } else { 0 };
    1 + (clip.newest_row + wraps - behind)
}

/// Two rows of a clip, and the part of the way from the first to the second.
struct Between {
    row: u32,
    next: u32,
    between: f32,
}

/// Finds the rows of a live clip around the time that a slot shows. Row 0 is the one that additive
/// layers measure from and is not counted. All times are whole ticks, back from the newest row.
fn find_live_row(clip: &ClipRows, slot: &Slot, tick: u64) -> Between {
    let back = clip.newest_tick.saturating_sub(tick.saturating_sub(slot.delay_ticks()));
    let (newest, row_ticks) = (u64::from(clip.newest_ticks), u64::from(clip.row_ticks));
    let older = back.saturating_sub(newest);
    // Rows behind the newest, counting the one before it if the time is between the two.
    let behind = u64::from(back > 0) + older.div_ceil(row_ticks);
    let oldest = clip.row_count - 1;
    if behind > u64::from(oldest) || behind == 0 {
        let row = ring_place(clip, if behind == 0 { 0 } else { oldest });
        return Between { row, next: row, between: 0.0 };
    }
    let (past, per_tick) = if older > 0 {
        ((behind - 1) * row_ticks - older, clip.per_row_tick)
    } else {
        (newest - back, clip.per_newest_tick)
    };
    #[expect(clippy::cast_possible_truncation, reason = "at most the oldest row's")]
    let row = behind as u32;
    let next = if past > 0 { row - 1 } else { row };
    Between {
        row: ring_place(clip, row),
        next: ring_place(clip, next),
        between: past as f32 * per_tick,
    }
}

/// Samples a slot that is not a state machine's. Also returns its time in seconds after the start of
/// its clip: NaN for live clips and for slots without weight.
pub(crate) fn sample_of(tables: &Tables, slot: &Slot, tick: u64) -> (SlotSample, f32) {
    let weight = if slot.bound_clip == NONE { 0.0 } else { slot.weight_at(tick) };
    if weight > 0.0 {
        let bound = tables.bound_clips().as_slice()[slot.bound_clip as usize];
        let clip = &tables.clips().as_slice()[bound.rows as usize];
        let (Between { row, next, between }, after_start) = if slot.mode() == SLOT_LIVE {
            (find_live_row(clip, slot, tick), f32::NAN)
        } else {
            let secs = slot.time_at(tick, clip.start_secs, clip.duration_secs);
            let (row, between) = tables.find_row(clip, secs);
            let next = if between > 0.0 { row + 1 } else { row };
            (Between { row, next, between }, secs - clip.start_secs)
        };
        let offset = |row: u32| clip.row_first + row * clip.row_stride;
        (SlotSample { row0: offset(row), row1: offset(next), between, weight }, after_start)
    } else {
        (SlotSample::default(), f32::NAN)
    }
}
