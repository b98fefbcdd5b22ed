//! Evaluate: each slot's rows and weight from the clock; the twin of `kernels/evaluate.cl`.

use populace_device::Tables;
use populace_device::layout::{ClipRows, Float4, NONE, SLOT_LIVE, Slot, SlotSample};
use rayon::prelude::*;

use crate::machines::slot_now;

pub(crate) fn run(tables: &Tables, running: &[Float4], tick: u64, samples: &mut [SlotSample]) {
    samples.par_iter_mut().zip(tables.slots().as_slice()).with_min_len(4096).for_each(
        |(sample, slot)| *sample = evaluate(tables, &slot_now(tables, running, slot, tick), tick),
    );
}

/// What a slot shows that is no machine's.
pub(crate) fn evaluate(tables: &Tables, slot: &Slot, tick: u64) -> SlotSample {
    let weight = if slot.bound_clip == NONE { 0.0 } else { slot.weight_at(tick) };
    if weight > 0.0 {
        let bound = tables.bound_clips().as_slice()[slot.bound_clip as usize];
        let clip = &tables.clips().as_slice()[bound.clip as usize];
        let (row, next, between) = if slot.mode() == SLOT_LIVE {
            find_live_row(clip, slot, tick)
        } else {
            let secs = slot.time_at(tick, clip.start_secs, clip.duration_secs);
            let (row, between) = tables.find_row(clip, secs);
            (row, if between > 0.0 { row + 1 } else { row }, between)
        };
        let offset = |row: u32| clip.row_first + row * clip.row_stride;
        SlotSample { row0: offset(row), row1: offset(next), between, weight }
    } else {
        SlotSample::default()
    }
}

/// The rows of a live clip around the time that a slot shows, behind the one that additive layers
/// measure from, and how far it is from the first to the second. All in whole ticks, back from the
/// newest row.
fn find_live_row(clip: &ClipRows, slot: &Slot, tick: u64) -> (u32, u32, f32) {
    let back = clip.newest_tick.saturating_sub(tick.saturating_sub(slot.phase_rate));
    let (newest, row_ticks) = (u64::from(clip.newest_ticks), u64::from(clip.row_ticks));
    let older = back.saturating_sub(newest);
    // Rows behind the newest, those between it and the one before it included.
    let behind = u64::from(back > 0) + older.div_ceil(row_ticks);
    let oldest = clip.row_count - 1;
    let place = |behind: u32| {
        let wraps = if behind > clip.newest_row { clip.ring_rows } else { 0 };
        1 + (clip.newest_row + wraps - behind)
    };
    if behind > u64::from(oldest) || behind == 0 {
        let row = place(if behind == 0 { 0 } else { oldest });
        return (row, row, 0.0);
    }
    let (past, per_tick) = if older > 0 {
        ((behind - 1) * row_ticks - older, clip.per_row_tick)
    } else {
        (newest - back, clip.per_newest_tick)
    };
    #[expect(clippy::cast_possible_truncation, reason = "not above the oldest row's")]
    let row = behind as u32;
    let next = if past > 0 { row - 1 } else { row };
    (place(row), place(next), past as f32 * per_tick)
}
