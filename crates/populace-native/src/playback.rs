//! Slots of a member that play now, and those that inertialize. Twin of `kernels/playback.cl`.

use populace_device::Tables;
use populace_device::layout::{Slot, SlotSample};

use crate::members::member_slots;

/// A slot as it plays now.
#[derive(Clone, Copy, Default)]
pub(crate) struct Playing {
    pub(crate) at: SlotSample,
    pub(crate) bound_clip: u32,
    pub(crate) layer: u32,
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
