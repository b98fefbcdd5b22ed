//! Evaluate: each slot's rows and weight from the clock; the twin of `kernels/evaluate.cl`.

use populace_core::Tables;
use populace_core::layout::{ClipRows, NONE, Slot, SlotSample};
use rayon::prelude::*;

pub(crate) fn run(tables: &Tables, tick: u64, samples: &mut [SlotSample]) {
    samples
        .par_iter_mut()
        .zip(tables.slots().as_slice())
        .with_min_len(4096)
        .for_each(|(sample, slot)| *sample = evaluate(tables, slot, tick));
}

pub(crate) fn evaluate(tables: &Tables, slot: &Slot, tick: u64) -> SlotSample {
    let weight = if slot.bound_clip == NONE { 0.0 } else { slot.weight_at(tick) };
    if weight > 0.0 {
        let bound = tables.bound_clips().as_slice()[slot.bound_clip as usize];
        let clip = &tables.clips().as_slice()[bound.clip as usize];
        let secs = slot.time_at(tick, clip.start_secs, clip.duration_secs);
        let (row, between) = find_row(tables, clip, secs);
        let next = if between > 0.0 { row + 1 } else { row };
        let offset = |row: u32| clip.row_first + row * clip.row_stride;
        SlotSample { row0: offset(row), row1: offset(next), between, weight }
    } else {
        SlotSample::default()
    }
}

/// The last row at or before a time, and how far it is to the next; the first and the last row hold outside.
fn find_row(tables: &Tables, clip: &ClipRows, secs: f32) -> (u32, f32) {
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
        let row = whole(at);
        return (row, at - row as f32);
    }
    let times = &tables.row_times().as_slice()[clip.time_first as usize..];
    if secs >= times[last as usize] {
        return (last, 0.0);
    }
    let bucket = whole((passed * clip.buckets_per_sec).max(0.0)).min(clip.bucket_count - 1);
    let mut row = tables.buckets().as_slice()[(clip.bucket_first + bucket) as usize];
    while times[row as usize + 1] <= secs {
        row += 1;
    }
    let (from, to) = (times[row as usize], times[row as usize + 1]);
    (row, ((secs - from) / (to - from)).max(0.0))
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "not negative, and cut off on purpose"
)]
fn whole(x: f32) -> u32 {
    x as u32
}
