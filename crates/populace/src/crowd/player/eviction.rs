//! Slot eviction: the weakest slots give way to a start if none is free.
//!
//! A slot with weight is never dropped. If no slot is free, the weakest fades out first and the
//! start is scheduled for the end of that fade. The fade takes the start's own fade time times the
//! slot's share of the layer, so the pose moves no faster than by the requested crossfade.
//! Inertializing slots cannot be hastened: the start waits for the first of them to end before
//! another slot is evicted.

use arrayvec::ArrayVec;
use populace_device::layout::Slot;
use populace_device::{MAX_LAYERS, MAX_SLOTS};

use super::slots::{NEGLIGIBLE, Started, faded_out, is_vacant};
use super::{Player, tick_after};
use crate::Error;
use crate::crowd::base::Base;

/// The effect of a start on an occupied slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Plan {
    /// The slot will fade out.
    Leaves,
    /// The slot continues with another weight.
    Stays,
    /// The slot is not affected.
    Apart,
}

/// Something for each of a member's slots, or for some of them.
type OfSlots<T> = ArrayVec<T, MAX_SLOTS>;

impl Player {
    /// Frees `needed` slots. If too few are free, fades out the weakest and returns the tick at
    /// which they become free. Meanwhile the other weights of the layer hold, except for the
    /// strongest slot, which takes up the weight of those that fade.
    pub(crate) fn free_slots(
        &mut self,
        base: &mut Base,
        member_index: u32,
        needed: usize,
        secs: f32,
        tick: u64,
        plan: impl Fn(&Slot, Started) -> Plan,
    ) -> Result<Option<u64>, Error> {
        let vacant = base.slots(member_index).iter().filter(|slot| is_vacant(slot, tick));
        if vacant.take(needed).count() == needed {
            return Ok(None);
        }
        let shares = self.slot_shares(base, member_index, tick);
        let plans = self.plans(base, member_index, plan);
        let free = count_free(base.slots(member_index), &shares, &plans, tick);
        let missing = needed.saturating_sub(free);
        if missing == 0 {
            return Ok(None);
        }
        let (mut evicted, others) = self.by_strength(base, member_index, &shares, &plans);
        let smoothly = evicted.len() >= missing;
        evicted.extend(others);
        let splits =
            evicted.get(missing - 1).and_then(|last| self.partner(base, member_index, *last))
                == evicted.get(missing).copied();
        evicted.truncate(missing + usize::from(splits));
        if secs <= 0.0 || !smoothly {
            for index in evicted {
                self.cut(base, member_index, index, tick)?;
            }
            return Ok(None);
        }
        let share: f32 = evicted.iter().filter_map(|i| shares[*i]).sum();
        self.fade_out_for(base, member_index, &evicted, &plans, share * secs, tick).map(Some)
    }

    /// The number of slots that are free or can be freed without a jump of the pose.
    pub(crate) fn free_slot_count(
        &self,
        base: &Base,
        member_index: u32,
        tick: u64,
        plan: impl Fn(&Slot, Started) -> Plan,
    ) -> usize {
        let shares = self.slot_shares(base, member_index, tick);
        let plans = self.plans(base, member_index, plan);
        let free = count_free(base.slots(member_index), &shares, &plans, tick);
        free + self.by_strength(base, member_index, &shares, &plans).0.len()
    }

    fn plans(
        &self,
        base: &Base,
        member_index: u32,
        plan: impl Fn(&Slot, Started) -> Plan,
    ) -> OfSlots<Plan> {
        let slots = base.slots(member_index).iter().enumerate();
        slots.map(|(index, slot)| plan(slot, self.started(base, member_index, index))).collect()
    }

    /// Returns the other slot of a state machine. Only the device knows their weights, so both stay
    /// or leave together.
    fn partner(&self, base: &Base, member_index: u32, index: usize) -> Option<usize> {
        let slots = base.slots(member_index);
        slots[index].machine_instance()?;
        let is_mate = |slot: &Slot| {
            slot.machine_instance().is_some() && slot.bound_clip == slots[index].bound_clip ^ 1
        };
        slots.iter().position(is_mate)
    }

    /// Returns the slots that can be evicted, in order: slots that fade out, then inertializing
    /// slots by their end, then the others by weight, with the two slots of a machine next to each
    /// other. The second list holds slots that cannot fade because layer 0 would be left empty.
    fn by_strength(
        &self,
        base: &Base,
        member_index: u32,
        shares: &[Option<f32>; MAX_SLOTS],
        plans: &[Plan],
    ) -> (OfSlots<usize>, OfSlots<usize>) {
        let slots = base.slots(member_index);
        let rank = |i: usize| match slots[i].as_inertialization() {
            Some(inertialization) => (1, inertialization.end_tick()),
            None if plans[i] == Plan::Leaves || slots[i].end_weight <= 0.0 => (0, 0),
            None => (2, 0),
        };
        let is_second =
            |i: usize| self.partner(base, member_index, i).is_some_and(|partner| partner < i);
        let gives_way =
            |i: &usize| shares[*i].is_some() && plans[*i] != Plan::Stays && !is_second(*i);
        let mut order: OfSlots<_> = (0..slots.len()).filter(gives_way).collect();
        let both = |i: usize| [Some(i), self.partner(base, member_index, i)].into_iter().flatten();
        let share = |i: usize| both(i).filter_map(|i| shares[i]).sum::<f32>();
        order.sort_by(|&a, &b| rank(a).cmp(&rank(b)).then(share(a).total_cmp(&share(b))));
        let mut base = 0.0;
        let (fading, others): (OfSlots<_>, OfSlots<_>) = order.into_iter().partition(|&index| {
            let of_base = if slots[index].layer() == 0 { share(index) } else { 0.0 };
            let fades = base + of_base < 1.0 - NEGLIGIBLE;
            base += if fades { of_base } else { 0.0 };
            fades
        });
        (fading.into_iter().flat_map(both).collect(), others.into_iter().flat_map(both).collect())
    }

    /// Fades out `evicted` within `secs` and returns the tick at which they are free. Other slots
    /// that the start affects hold their weights until then, so that the pose moves no faster than
    /// by one crossfade.
    fn fade_out_for(
        &mut self,
        base: &mut Base,
        member_index: u32,
        evicted: &[usize],
        plans: &[Plan],
        secs: f32,
        tick: u64,
    ) -> Result<u64, Error> {
        let mut due = tick + 1;
        let mut left_behind = [0.0_f32; MAX_LAYERS];
        for &index in evicted {
            let slot = base.slots(member_index)[index];
            if let Some(inertialization) = slot.as_inertialization() {
                due = due.max(inertialization.end_tick());
                continue;
            }
            let weight = slot.weight_at(tick);
            let own =
                if slot.weight_rate < 0.0 && slot.end_weight <= 0.0 && tick >= slot.weight_tick {
                    weight / -slot.weight_rate
                } else {
                    f32::INFINITY
                };
            let secs = secs.min(own);
            base.tables.ramp_slot(member_index, index, tick, 0.0, secs)?;
            due = due.max(tick_after(tick, secs).saturating_add(1));
            left_behind[slot.layer() as usize] += weight;
        }
        for (layer, left) in (0..).zip(left_behind) {
            let of_layer = |i: &usize| {
                plans[*i] != Plan::Apart
                    && !evicted.contains(i)
                    && base.slots(member_index)[*i].layer() == layer
            };
            let mut still: OfSlots<_> = (0..plans.len()).filter(of_layer).collect();
            let weight = |i: &usize| base.slots(member_index)[*i].weight_at(tick);
            still.sort_by(|a, b| weight(b).total_cmp(&weight(a)));
            let heirs: OfSlots<_> = still
                .first()
                .iter()
                .flat_map(|i| [Some(**i), self.partner(base, member_index, **i)])
                .flatten()
                .collect();
            for index in still {
                let slot = &base.slots(member_index)[index];
                if left > 0.0 && !faded_out(slot, tick) {
                    let more = if heirs.contains(&index) { left / heirs.len() as f32 } else { 0.0 };
                    let weight = slot.weight_at(tick) + more;
                    base.tables.ramp_slot(member_index, index, tick, weight, secs)?;
                }
            }
        }
        Ok(due)
    }
}

/// Returns the number of free slots. One of negligible weight that the start keeps is not free: its
/// weight rises again.
fn count_free(
    slots: &[Slot],
    shares: &[Option<f32>; MAX_SLOTS],
    plans: &[Plan],
    tick: u64,
) -> usize {
    let all = slots.iter().zip(shares).zip(plans);
    let is_free = |slot: &Slot, share: &Option<f32>, plan: Plan| {
        share.is_none() && (plan != Plan::Stays || faded_out(slot, tick))
    };
    all.filter(|((slot, share), plan)| is_free(slot, share, **plan)).count()
}
