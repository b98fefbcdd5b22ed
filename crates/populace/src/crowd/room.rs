//! Slots for what starts: which one is free, and what happens when none is.
//!
//! Nothing that weighs is dropped. Where no slot is free, the weakest fades out first, as fast as
//! the crossfade that was asked for would move the pose, and what was to start waits until it has
//! gone: a fade of its share of the layer, so the less it weighed the sooner. Slots that
//! inertialize cannot be hurried; before something else has to give way, what was to start waits
//! for the first of them.

use populace_clip::ticks_from_secs;
use populace_device::layout::{NONE, Slot};
use populace_device::{MAX_LAYERS, MAX_SLOTS};

use super::Crowd;
use crate::Error;

/// A slot that has faded to less than this share of its layer is free: to drop it moves the pose by
/// less than a frame of any crossfade that takes less than ten seconds.
const NEGLIGIBLE: f32 = 1e-3;

/// What a start means for a slot that is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Plan {
    /// It will fade out.
    Leaves,
    /// It will go on with another weight.
    Stays,
    /// It is not touched.
    Apart,
}

/// What the host knows of a slot beside what devices do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Started {
    /// Which start of the crowd it was; all slots of a blend space are of one.
    pub(crate) serial: u32,
    /// Which clip of its blend space it plays, if it is of one.
    pub(crate) sample: Option<u16>,
    /// Whether it plays once, which one that stands still does not tell itself.
    pub(crate) once: bool,
}

/// Whether a slot's weight has come down to 0 and stays there, as that of one that inertializes
/// has.
pub(crate) fn faded_out(slot: &Slot, tick: u64) -> bool {
    slot.bound_clip == NONE
        || slot.is_inertialization()
        || (slot.end_weight <= 0.0 && slot.weight_at(tick) <= 0.0)
}

impl Crowd {
    pub(super) fn slots(&self, place: u32) -> &[Slot] {
        &self.tables.slots().as_slice()[self.tables.slot_range(place)]
    }

    pub(super) fn started(&self, place: u32, index: usize) -> Started {
        self.started[self.tables.slot_range(place).start + index]
    }

    /// Each slot's part of what its layer shows, from 0 to 1; 0 for those that inertialize, nothing
    /// for free ones.
    fn slot_shares(&self, place: u32, tick: u64) -> [Option<f32>; MAX_SLOTS] {
        let mut totals = [0.0_f32; MAX_LAYERS];
        let weighing =
            |slot: &Slot| if slot.bound_clip == NONE { 0.0 } else { slot.weight_at(tick) };
        for slot in self.slots(place) {
            totals[slot.layer() as usize] += weighing(slot);
        }
        // Layer 0 is divided by its total however small; layers above it leave the remainder to
        // what lies beneath.
        totals[1..].iter_mut().for_each(|total| *total = total.max(1.0));
        let mut shares = [None; MAX_SLOTS];
        for (share, slot) in shares.iter_mut().zip(self.slots(place)) {
            let of_layer = weighing(slot) / totals[slot.layer() as usize].max(f32::MIN_POSITIVE);
            let free = faded_out(slot, tick) || (slot.end_weight <= 0.0 && of_layer < NEGLIGIBLE);
            *share = (!free || slot.inertializes(tick)).then_some(of_layer);
        }
        shares
    }

    /// The free slot that weighs least.
    pub(super) fn free_slot(&self, place: u32, tick: u64) -> Option<usize> {
        let shares = self.slot_shares(place, tick);
        let slots =
            self.slots(place).iter().enumerate().filter(|(index, _)| shares[*index].is_none());
        // One that was cut since the last update still moves the member up to then.
        let played = |slot: &Slot| !slot.is_inertialization() && slot.weight_tick > self.clock.tick;
        let weight = |slot: &Slot| match faded_out(slot, tick) {
            true if played(slot) => -1.0,
            true => -2.0,
            false => slot.weight_at(tick),
        };
        slots.min_by(|a, b| weight(a.1).total_cmp(&weight(b.1))).map(|(index, _)| index)
    }

    /// Sees to it that so many slots are free. Gives the tick at which they will be, where they are
    /// not yet: the weakest are then on their way out, and the layer stands still otherwise but for
    /// the strongest, which takes what they leave.
    pub(super) fn make_room(
        &mut self,
        place: u32,
        needed: usize,
        secs: f32,
        tick: u64,
        plan: impl Fn(&Slot, Started) -> Plan,
    ) -> Result<Option<u64>, Error> {
        let shares = self.slot_shares(place, tick);
        let count = self.slots(place).len();
        let missing = needed.saturating_sub((0..count).filter(|i| shares[*i].is_none()).count());
        if missing == 0 {
            return Ok(None);
        }
        let plans = self.plans(place, plan);
        let (mut victims, others) = self.by_strength(place, &shares, &plans);
        let smoothly = victims.len() >= missing;
        victims.extend(others);
        let splits = victims.get(missing - 1).and_then(|last| self.mate(place, *last))
            == victims.get(missing).copied();
        victims.truncate(missing + usize::from(splits));
        if secs <= 0.0 || !smoothly {
            for index in victims {
                self.cut(place, index, tick)?;
            }
            return Ok(None);
        }
        let share: f32 = victims.iter().filter_map(|i| shares[*i]).sum();
        self.hasten(place, &victims, &plans, share * secs, tick).map(Some)
    }

    /// How many slots are free or can be made so without a cut.
    pub(super) fn room_for(
        &self,
        place: u32,
        tick: u64,
        plan: impl Fn(&Slot, Started) -> Plan,
    ) -> usize {
        let shares = self.slot_shares(place, tick);
        let free = (0..self.slots(place).len()).filter(|index| shares[*index].is_none()).count();
        free + self.by_strength(place, &shares, &self.plans(place, plan)).0.len()
    }

    fn plans(&self, place: u32, plan: impl Fn(&Slot, Started) -> Plan) -> Vec<Plan> {
        let slots = self.slots(place).iter().enumerate();
        slots.map(|(index, slot)| plan(slot, self.started(place, index))).collect()
    }

    /// The other slot of the state machine of which a slot is one: which of them shows how much
    /// only the device knows, so they stay and leave together.
    fn mate(&self, place: u32, index: usize) -> Option<usize> {
        let slots = self.slots(place);
        slots[index].machine_instance()?;
        let is_mate = |slot: &Slot| {
            slot.machine_instance().is_some() && slot.bound_clip == slots[index].bound_clip ^ 1
        };
        slots.iter().position(is_mate)
    }

    /// The slots that can give way: those on their way out first, then those that inertialize, of
    /// these the weakest first and the first to end, and both of a machine side by side. Apart from
    /// them those that cannot fade, since the base layer would be left with nothing.
    fn by_strength(
        &self,
        place: u32,
        shares: &[Option<f32>; MAX_SLOTS],
        plans: &[Plan],
    ) -> (Vec<usize>, Vec<usize>) {
        let slots = self.slots(place);
        let rank = |i: usize| match slots[i].is_inertialization() {
            true => (1, slots[i].inertialization_tick()),
            false if plans[i] == Plan::Leaves || slots[i].end_weight <= 0.0 => (0, 0),
            false => (2, 0),
        };
        let is_second = |i: usize| self.mate(place, i).is_some_and(|mate| mate < i);
        let gives_way =
            |i: &usize| shares[*i].is_some() && plans[*i] != Plan::Stays && !is_second(*i);
        let mut order: Vec<_> = (0..slots.len()).filter(gives_way).collect();
        let both = |i: usize| [Some(i), self.mate(place, i)].into_iter().flatten();
        let share = |i: usize| both(i).filter_map(|i| shares[i]).sum::<f32>();
        order.sort_by(|&a, &b| rank(a).cmp(&rank(b)).then(share(a).total_cmp(&share(b))));
        let mut base = 0.0;
        let (fading, others): (Vec<_>, Vec<_>) = order.into_iter().partition(|&index| {
            let of_base = if slots[index].layer() == 0 { share(index) } else { 0.0 };
            let fades = base + of_base < 1.0 - NEGLIGIBLE;
            base += if fades { of_base } else { 0.0 };
            fades
        });
        (fading.into_iter().flat_map(both).collect(), others.into_iter().flat_map(both).collect())
    }

    /// Lets slots fade out in so many seconds at most. What the start is to change otherwise stands
    /// still until then, so that no pose moves faster than by one crossfade at a time.
    fn hasten(
        &mut self,
        place: u32,
        victims: &[usize],
        plans: &[Plan],
        secs: f32,
        tick: u64,
    ) -> Result<u64, Error> {
        let mut due = tick + 1;
        let mut left_behind = [0.0_f32; MAX_LAYERS];
        for &index in victims {
            let mut slot = self.slots(place)[index];
            if slot.is_inertialization() {
                due = due.max(slot.inertialization_tick());
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
            slot.ramp_weight(tick, weight, 0.0, secs);
            due = due.max(tick.saturating_add(ticks_from_secs(f64::from(secs))).saturating_add(1));
            left_behind[slot.layer() as usize] += weight;
            self.tables.set_slot(place, index, slot)?;
        }
        for (layer, left) in (0..).zip(left_behind) {
            let of_layer = |i: &usize| {
                plans[*i] != Plan::Apart
                    && !victims.contains(i)
                    && self.slots(place)[*i].layer() == layer
            };
            let mut still: Vec<_> = (0..plans.len()).filter(of_layer).collect();
            let weight = |i: &usize| self.slots(place)[*i].weight_at(tick);
            still.sort_by(|a, b| weight(b).total_cmp(&weight(a)));
            let heirs: Vec<_> = still
                .first()
                .iter()
                .flat_map(|i| [Some(**i), self.mate(place, **i)])
                .flatten()
                .collect();
            for index in still {
                let mut slot = self.slots(place)[index];
                if left > 0.0 && !faded_out(&slot, tick) {
                    let weight = slot.weight_at(tick);
                    let more = if heirs.contains(&index) { left / heirs.len() as f32 } else { 0.0 };
                    slot.ramp_weight(tick, weight, weight + more, secs);
                    self.tables.set_slot(place, index, slot)?;
                }
            }
        }
        Ok(due)
    }

    /// Fades out all clips of a layer together, keeping their proportions, so that what fades in
    /// meanwhile takes the layer over evenly. What inertializes goes on, unless this takes no time.
    pub(super) fn fade_out(
        &mut self,
        place: u32,
        layer: usize,
        secs: f32,
        tick: u64,
    ) -> Result<(), Error> {
        for index in 0..self.slots(place).len() {
            let mut slot = self.slots(place)[index];
            if slot.layer() as usize != layer {
                continue;
            }
            if secs <= 0.0 {
                self.cut(place, index, tick)?;
            } else if !faded_out(&slot, tick) {
                slot.ramp_weight(tick, slot.weight_at(tick), 0.0, secs);
                self.tables.set_slot(place, index, slot)?;
            }
        }
        Ok(())
    }

    /// Lets a slot weigh nothing from now on; until another takes it, it tells what it weighed
    /// before.
    fn cut(&mut self, place: u32, index: usize, tick: u64) -> Result<(), Error> {
        let mut slot = self.slots(place)[index];
        if slot.inertializes(tick) {
            return self.empty_slot(place, index);
        }
        if faded_out(&slot, tick) {
            return Ok(());
        }
        self.note_left(place, &slot, tick);
        slot.ramp_weight(tick, slot.weight_at(tick), 0.0, 0.0);
        Ok(self.tables.set_slot(place, index, slot)?)
    }

    /// Keeps a slot that is left in the course of an update for those who ask what happened until
    /// then.
    pub(super) fn note_left(&mut self, place: u32, slot: &Slot, tick: u64) {
        if tick > self.clock.tick && self.listening.iter().any(|member| member.place == place) {
            self.left.push((place, *slot, tick));
        }
    }

    /// Keeps a slot that is left in the course of an update in a free one, where there is one: cut,
    /// so that it moves the member up to then.
    pub(super) fn leave(&mut self, place: u32, mut slot: Slot, tick: u64) -> Result<(), Error> {
        self.note_left(place, &slot, tick);
        let moves = tick > self.clock.tick && self.moving.contains_key(&place);
        let Some(index) = self.free_slot(place, tick).filter(|_| moves) else { return Ok(()) };
        slot.ramp_weight(tick, slot.weight_at(tick), 0.0, 0.0);
        self.put_slot(place, index, slot, Started::default())
    }

    pub(super) fn empty_slot(&mut self, place: u32, index: usize) -> Result<(), Error> {
        let empty = Slot { bound_clip: NONE, ..Slot::default() };
        Ok(self.tables.set_slot(place, index, empty)?)
    }

    /// Puts a slot into a free one; [`make_room`](Self::make_room) has seen to it that there is
    /// one.
    pub(super) fn fill_slot(
        &mut self,
        place: u32,
        slot: Slot,
        started: Started,
        tick: u64,
    ) -> Result<(), Error> {
        self.put_slot(place, self.free_slot(place, tick).unwrap_or(0), slot, started)
    }

    pub(super) fn put_slot(
        &mut self,
        place: u32,
        index: usize,
        slot: Slot,
        started: Started,
    ) -> Result<(), Error> {
        self.tables.set_slot(place, index, slot)?;
        let range = self.tables.slot_range(place);
        self.started[range.start + index] = started;
        Ok(())
    }
}
