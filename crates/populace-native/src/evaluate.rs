//! Evaluate stage: rows and weight of each slot, from the clock. Twin of `kernels/evaluate.cl`.
//!
//! Reads slots, bound clips, clips, row times, and the state of state machines. Writes one sample
//! for each slot.

use populace_device::Tables;
use populace_device::layout::{Float4, SlotSample};
use rayon::prelude::*;

use crate::machines::slot_now;
use crate::slot::sample_of;

/// Evaluates the slots of all members.
pub(crate) fn evaluate(tables: &Tables, running: &[Float4], tick: u64, samples: &mut [SlotSample]) {
    samples.par_iter_mut().zip(tables.slots().as_slice()).with_min_len(4096).for_each(
        |(sample, slot)| {
            *sample = sample_of(tables, &slot_now(tables, running, slot, tick), tick).0
        },
    );
}
