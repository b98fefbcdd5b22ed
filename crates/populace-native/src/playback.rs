//! Slots of a member that play now, and those that inertialize. Twin of `kernels/playback.cl`.

use populace_device::layout::{LEAST_TOTAL, Layer, Slot, SlotSample};
use populace_device::{MAX_SLOTS, Tables};

use crate::cache::fetch_lines;
use crate::encoding::Rows;
use crate::frame::FrameInputs;
use crate::machines::slot_now;
use crate::members::{member_layers, member_slots};
use crate::slot::sample_of;

/// A slot as it plays now.
#[derive(Clone, Copy, Default)]
pub(crate) struct Playing {
    pub(crate) rows: Rows,
    pub(crate) weight: f32,
    pub(crate) bound_clip: u32,
    pub(crate) layer: u32,
}

impl Playing {
    #[inline(always)]
    pub(crate) fn new(at: &SlotSample, bound_clip: u32, layer: u32) -> Self {
        Self { rows: Rows::of(at), weight: at.weight, bound_clip, layer }
    }
}

/// Returns a bit for each layer that plays one slot, whose weight does not count in the layer's mean.
pub(crate) fn alone_in_layers(playing: &[Playing]) -> u32 {
    let (mut any, mut alone) = (0, 0);
    for slot in playing.iter().filter(|slot| slot.weight > 0.0) {
        let layer = 1 << slot.layer;
        let first = any & layer == 0 && slot.weight > LEAST_TOTAL;
        alone = if first { alone | layer } else { alone & !layer };
        any |= layer;
    }
    alone
}

/// Slots to search for those that inertialize at a tick.
#[derive(Clone, Copy)]
pub(crate) struct Inertialization<'a> {
    /// All slots of the member; empty if none of them inertializes.
    pub(crate) slots: &'a [Slot],
    pub(crate) tick: u64,
}

/// Returns the slots of a member if any of them inertializes, else none.
#[inline(always)]
pub(crate) fn inertialization_of(tables: &Tables, member: u32, tick: u64) -> Inertialization<'_> {
    let slots = member_slots(tables, member);
    let any = slots.iter().any(|slot| slot.inertializes(tick));
    Inertialization { slots: if any { slots } else { &[] }, tick }
}

/// Playing slots of a member, and its layers.
pub(crate) struct Play<'a> {
    playing: [Playing; MAX_SLOTS],
    /// Seconds after the start of each clip; NaN for live clips.
    secs: [f32; MAX_SLOTS],
    count: usize,
    /// A bit for each layer that plays one slot.
    pub(crate) alone: u32,
    pub(crate) inertialization: Inertialization<'a>,
    /// Layers that the member uses.
    pub(crate) layers: &'a [Layer],
}

impl<'a> Play<'a> {
    /// Collects the member's slots that have weight now, in order.
    pub(crate) fn play_all(inputs: &FrameInputs<'a>, member: u32) -> Self {
        let FrameInputs { tables, frame, history, .. } = *inputs;
        let (mut playing, mut secs) = ([Playing::default(); MAX_SLOTS], [0.0; MAX_SLOTS]);
        let mut count = 0;
        for slot in member_slots(tables, member) {
            let slot = slot_now(tables, &history.running, slot, frame.tick);
            let (at, after_start) = sample_of(tables, &slot, frame.tick);
            if at.weight > 0.0 {
                playing[count] = Playing::new(&at, slot.bound_clip, slot.layer());
                secs[count] = after_start;
                count += 1;
            }
        }
        let inertialization = inertialization_of(tables, member, frame.tick);
        Self {
            playing,
            secs,
            count,
            alone: alone_in_layers(&playing[..count]),
            inertialization,
            layers: member_layers(tables, member),
        }
    }

    /// Asks for the rows that the slots mix.
    pub(crate) fn fetch_rows(&self, tables: &Tables) {
        for Playing { rows, bound_clip, .. } in self.playing() {
            let clip = tables.bound_clips().as_slice()[*bound_clip as usize].rows as usize;
            let stride = tables.clips().as_slice()[clip].row_stride as usize;
            for row in [rows.from, rows.to] {
                fetch_lines(&tables.rows().as_slice()[row as usize..][..stride]);
            }
        }
    }

    /// Returns the slots that have weight.
    #[inline(always)]
    pub(crate) fn playing(&self) -> &[Playing] {
        &self.playing[..self.count]
    }

    /// Returns the `nth` slot with weight, and its seconds after the start of the clip (NaN for a
    /// live clip); `None` past the last.
    #[inline(always)]
    pub(crate) fn nth(&self, nth: usize) -> Option<(&Playing, f32)> {
        self.playing().get(nth).zip(self.secs.get(nth).copied())
    }
}
