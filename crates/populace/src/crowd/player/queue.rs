//! The queue of a layer: playbacks that follow the end of those before them.

use populace_device::layout::{NONE, Slot};

use super::Player;
use super::scheduled::{Action, Start};
use crate::crowd::base::Base;

impl Player {
    /// Returns the tick at which the newest playback of a layer ends.
    pub(super) fn end_of_layer(&self, base: &Base, member_index: u32, layer: usize) -> u64 {
        let scheduled =
            self.scheduled.of(member_index).filter(|(_, start)| start.play.layer == layer).last();
        match scheduled {
            Some((due, start)) => end_of_start(base, due, start),
            None => self.end_of_slots(base, member_index, layer).unwrap_or(base.clock.tick),
        }
    }

    /// Returns the tick at which the newest playback of a layer ends that has begun; `None` if
    /// there is none, or it has no end.
    fn end_of_slots(&self, base: &Base, member_index: u32, layer: usize) -> Option<u64> {
        let tick = base.clock.tick;
        let slots = base.slots(member_index).iter().enumerate();
        let playing = slots.filter(|(_, slot)| {
            let ends = slot.is_inertialization() || slot.end_weight <= 0.0;
            slot.bound_clip != NONE && slot.layer() as usize == layer && !ends
        });
        let last = playing.max_by_key(|(index, _)| self.started(base, member_index, *index).serial);
        last.and_then(|(_, slot)| end_of(base, slot, tick))
    }

    /// Reschedules the queued starts of a layer after a change to a playback before them. A start
    /// stays as it is if what it follows has ended or has no end.
    pub(super) fn time_the_queue(&mut self, base: &Base, member_index: u32, layer: usize) {
        let tick = base.clock.tick;
        let mut end = self.end_of_slots(base, member_index, layer).filter(|end| *end > tick);
        self.scheduled.change(member_index, |due, start| {
            if start.play.layer != layer {
                return;
            }
            if let (Some(gap), Some(end)) = (start.follows_after, end)
                && due.saturating_sub(gap) > tick
            {
                *due = end.saturating_add(gap);
            }
            end = Some(end_of_start(base, *due, start));
        });
    }
}

fn end_of_start(base: &Base, due: u64, start: &Start) -> u64 {
    let Action::Clip { bound, .. } = start.action else { return due };
    let slot = start.play.slot(bound, due, base.duration_secs(bound));
    end_of(base, &slot, due).unwrap_or(due)
}

/// Returns the tick at which a slot ends, at least `tick`; `None` if it has no end. A clip at speed
/// 0 never ends until its speed is set.
fn end_of(base: &Base, slot: &Slot, tick: u64) -> Option<u64> {
    let has_end = !slot.is_tied() && base.duration_secs(slot.bound_clip) > 0.0;
    has_end.then(|| slot.end_tick(tick).unwrap_or(u64::MAX).max(tick))
}
