//! Inertialized transitions: slots that are left become inertializing slots in place.

use populace_clip::ticks_from_secs;
use populace_device::layout::Slot;

use super::Player;
use super::slots::{SlotSet, Started, weighing};
use crate::Error;
use crate::crowd::base::Base;

impl Player {
    /// Returns whether all slots of the layer can inertialize into `starting`: all are closed-form.
    pub(crate) fn can_inertialize(
        &self,
        base: &Base,
        member_index: u32,
        starting: &Slot,
        tick: u64,
    ) -> bool {
        let slots = base.slots(member_index);
        let mut left = weighing(slots, starting.layer(), tick);
        starting.can_inertialize() && left.all(|index| slots[index].can_inertialize())
    }

    /// Returns the slots of a layer whose inertialization began at this tick: their target has not
    /// been evaluated yet.
    pub(crate) fn unevaluated(
        &self,
        base: &Base,
        member_index: u32,
        layer: u32,
        tick: u64,
    ) -> SlotSet {
        let unevaluated = |slot: &Slot| {
            slot.is_inertialization() && slot.layer() == layer && slot.start_tick == tick
        };
        SlotSet::of(base.slots(member_index), unevaluated)
    }

    /// Starts the inertialization of every playing slot of the layer into `starting`, drops the
    /// unevaluated ones, and returns the total weight of the playing slots.
    pub(crate) fn inertialize(
        &mut self,
        base: &mut Base,
        member_index: u32,
        starting: &Slot,
        secs: f32,
        tick: u64,
    ) -> Result<f32, Error> {
        let (layer, ticks) = (starting.layer(), ticks_from_secs(f64::from(secs)).max(1));
        let target = base.tables.sampled_state(starting, tick);
        let unevaluated = self.unevaluated(base, member_index, layer, tick);
        for index in unevaluated {
            if let Some(slot) = base.slots(member_index)[index].as_inertialization() {
                let slot = slot.with_incoming(target, ticks).into();
                base.tables.set_slot(member_index, index, &slot)?;
            }
        }
        let weighing = weighing(base.slots(member_index), layer, tick);
        let all = weighing.map(|index| weight_and_rate(&base.slots(member_index)[index], tick));
        let total = all.reduce(|sum, one| [sum[0] + one[0], sum[1] + one[1]]).unwrap_or_default();
        let in_all = if self.is_additive(base, member_index, layer) { total[0] } else { 1.0 };
        for index in weighing {
            let slot = base.slots(member_index)[index];
            let [weight, rate] = weight_and_rate(&slot, tick);
            if !unevaluated.is_empty() || weight <= 0.0 {
                self.empty_slot(base, member_index, index)?;
                continue;
            }
            let part = weight / total[0];
            let share = [part * in_all, (rate - part * total[1]) / total[0] * in_all];
            let states = [base.tables.sampled_state(&slot, tick), target];
            let inertialization = Slot::inertialization(tick, ticks, states, share).on_layer(layer);
            let started = Started::default();
            self.put_slot(base, member_index, index, &inertialization, started, tick)?;
            self.leave(base, member_index, slot, tick)?;
        }
        Ok(total[0])
    }

    fn is_additive(&self, base: &Base, member_index: u32, layer: u32) -> bool {
        let of_member = base.tables.layer_range(member_index);
        layer > 0 && base.tables.layers().as_slice()[of_member][layer as usize].is_additive()
    }
}

/// Returns a slot's weight and its rate of change per second.
fn weight_and_rate(slot: &Slot, tick: u64) -> [f32; 2] {
    let weight = slot.weight_at(tick);
    let ramps = slot.weight_tick < tick && weight != slot.end_weight;
    [weight, if ramps { slot.weight_rate } else { 0.0 }]
}
