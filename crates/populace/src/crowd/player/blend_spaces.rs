//! Blend spaces that members play.

use populace_clip::TICKS_PER_SEC;
use populace_device::layout::{NONE, Slot};
use populace_model::convert::single;
use populace_settings::parts::{
    Check, Key, MOST, Parts, Playback, Weights, check_secs, phase_offset, slots_needed, weights_at,
};

use super::scheduled::{Action, Start};
use super::slots::{Plan, Started, faded_out};
use super::{Player, tick_after};
use crate::crowd::base::Base;
use crate::crowd::{BlendSpaceId, MemberId, u32_from};
use crate::{BlendSpace, BlendSpaceFault, Error, IdKind, SpacePoint};

/// A cycle in the unit of phases.
const CYCLE: f64 = 18_446_744_073_709_551_616.0;

/// A blend space and the durations of its clips.
#[derive(Clone)]
pub(crate) struct Space {
    pub(crate) space: BlendSpace,
    durations_secs: Vec<f32>,
}

/// The blend space that a member plays, with its phase in closed form.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ActiveSpace {
    serial: u64,
    pub(crate) space: u32,
    play: Playback,
    /// The position, or the one it moves to; `None` while it waits for a slot.
    at: Option<SpacePoint>,
    start_tick: u64,
    /// The phase at `start_tick`, in 2^-64 of a cycle.
    phase: u64,
    cycles_per_sec: f64,
    /// The tick at which its fade ends.
    faded_in_tick: u64,
}

impl ActiveSpace {
    /// Returns the phase at a tick, in 2^-64 of a cycle.
    fn phase_at(&self, tick: u64) -> u64 {
        let rate = Slot::in_phase(0, 0, 0, self.cycles_per_sec).phase_rate;
        self.phase.wrapping_add(tick.wrapping_sub(self.start_tick).wrapping_mul(rate))
    }

    /// Returns whether another slot of the layer fades out for the blend space. What started before
    /// it does, even if the slot holds its weight while others are evicted.
    fn replaces(&self, slot: &Slot, started: Started) -> bool {
        slot.end_weight <= 0.0 || started.serial < self.serial
    }
}

fn live_in_space(name: &str) -> Error {
    Error::BadBlendSpace(BlendSpaceFault::LiveClip(name.to_owned()))
}

impl Player {
    pub(crate) fn add_blend_space(
        &mut self,
        base: &mut Base,
        space: BlendSpace,
    ) -> Result<BlendSpaceId, Error> {
        let mut durations_secs = Vec::new();
        for clip in space.clips() {
            let known = base.known_clip(*clip)?;
            if known.ring().is_some() {
                return Err(live_in_space(known.name()));
            }
            durations_secs.push(known.duration_secs());
        }
        let (index, generation) = self.spaces.insert(Space { space, durations_secs });
        Ok(BlendSpaceId::from_parts(Key { crowd: base.number, index, generation }))
    }

    /// Returns a blend space, or an error if it was removed or belongs to another crowd.
    pub(crate) fn known_space(&self, base: &Base, id: BlendSpaceId) -> Result<&Space, Error> {
        let Key { crowd, index, generation } = id.parts();
        base.check_crowd(IdKind::BlendSpace, crowd, index)?;
        let unknown = Error::UnknownId { what: IdKind::BlendSpace, index };
        self.spaces.get((index, generation)).ok_or(unknown)
    }

    pub(crate) fn play_space(
        &mut self,
        base: &mut Base,
        member: MemberId,
        space: BlendSpaceId,
        at: SpacePoint,
        play: Playback,
    ) -> Result<(), Error> {
        let character = base.check(member)?;
        let known = self.known_space(base, space)?;
        play.check()?;
        at.check()?;
        let (needed, slots) = (slots_needed(&known.space), base.tables.slots_per_member());
        if needed > slots {
            return Err(Error::BadBlendSpace(BlendSpaceFault::Slots { needed, slots }));
        }
        // Bound now, so that a scheduled start cannot fail.
        for clip in known.space.clips().to_vec() {
            base.bind(character, clip, play.partial)?;
        }
        self.scheduled.retain(member.number(), |start| start.play.layer != play.layer);
        let action = Action::Space { index: space.parts().index, at };
        let start = Start { serial: self.next_serial(), action, play, follows_after: None };
        let due = tick_after(base.clock.tick, play.after_secs);
        self.begin_or_wait(base, member.number(), due, start)
    }

    pub(crate) fn set_blend_parameter(
        &mut self,
        base: &mut Base,
        member: MemberId,
        at: SpacePoint,
        over_secs: f32,
    ) -> Result<(), Error> {
        base.check(member)?;
        at.check()?;
        check_secs("the time to move in a blend space", over_secs)?;
        let mut waits = false;
        self.scheduled.change(member.number(), |_, start| {
            if let Action::Space { at: point, .. } = &mut start.action {
                *point = at;
                waits = true;
            }
        });
        let Some(active_space) = self.active_space.get(member.number()) else {
            let not_playing = Error::BadBlendSpace(BlendSpaceFault::NotPlaying);
            return if waits { Ok(()) } else { Err(not_playing) };
        };
        let (play, serial) = (active_space.play, active_space.serial);
        if active_space.at == Some(at) && self.scheduled.is_empty() {
            return Ok(());
        }
        self.scheduled
            .retain(member.number(), |start| !matches!(start.action, Action::Move { .. }));
        let action = Action::Move { at, over_secs };
        let start = Start { serial, action, play, follows_after: None };
        self.begin_move(base, member.number(), &start, (at, over_secs), base.clock.tick)
    }

    /// Returns the phase of the blend space that a member plays, 0 to 1.
    pub(crate) fn space_phase(&self, base: &Base, member: MemberId) -> Option<f32> {
        let active_space = self.active_space.get(member.number())?;
        Some(single(active_space.phase_at(base.clock.tick) as f64 / CYCLE))
    }

    /// Returns whether a slot of the active blend space of the member at an index has weight.
    pub(crate) fn is_heard(&self, base: &Base, index: u32, active: &ActiveSpace) -> bool {
        let tick = base.clock.tick;
        let slots = (0..).zip(base.slots(index));
        let mut own =
            slots.filter(|(slot, _)| self.started(base, index, *slot).serial == active.serial);
        own.any(|(_, slot)| !faded_out(slot, tick))
    }

    /// Forgets the blend space of a layer that something else takes over.
    pub(crate) fn forget_space(&mut self, member_index: u32, layer: usize) {
        if self
            .active_space
            .get(member_index)
            .is_some_and(|active_space| active_space.play.layer == layer)
        {
            self.active_space.remove(member_index);
        }
    }

    pub(crate) fn begin_space(
        &mut self,
        base: &mut Base,
        member_index: u32,
        start: &Start,
        (index, at): (u32, SpacePoint),
        tick: u64,
    ) -> Result<(), Error> {
        let Playback { layer, fade_in_secs: secs, .. } = start.play;
        if secs <= 0.0 {
            self.fade_out(base, member_index, layer, 0.0, tick)?;
        }
        let plan = |slot: &Slot, _| {
            if slot.layer() as usize == layer { Plan::Leaves } else { Plan::Apart }
        };
        let all = weights_at(&self.spaces[index].space, at);
        let weights =
            strongest(all, |_| false, self.free_slot_count(base, member_index, tick, plan));
        let needed = weights.iter().filter(|(_, weight)| *weight > 0.0).count();
        if let Some(due) = self.free_slots(base, member_index, needed, secs, tick, plan)? {
            self.scheduled.push(member_index, due, start.at_its_time());
            return Ok(());
        }
        let secs = if self.is_first(base, member_index, layer, tick) { 0.0 } else { secs };
        self.fade_out(base, member_index, layer, secs, tick)?;
        let phase = f64::from(start.play.phase.rem_euclid(1.0));
        let active_space = ActiveSpace {
            serial: start.serial,
            space: index,
            play: start.play,
            at: Some(at),
            start_tick: tick,
            phase: cycles(phase),
            cycles_per_sec: self.cycles_per_sec(index, at, &weights, start.play.speed),
            faded_in_tick: tick_after(tick, secs),
        };
        self.active_space.insert(member_index, active_space);
        for (sample, weight) in weights.into_iter().filter(|(_, weight)| *weight > 0.0) {
            self.add_sample(base, member_index, &active_space, (sample, weight), secs, tick)?;
        }
        if weights != all {
            self.schedule_move(member_index, start, (at, secs), tick);
        }
        Ok(())
    }

    /// Schedules another move to the same position, because some clips have no slot yet.
    fn schedule_move(
        &mut self,
        member_index: u32,
        start: &Start,
        (at, secs): (SpacePoint, f32),
        tick: u64,
    ) {
        let due = tick_after(tick, secs).saturating_add(1);
        let action = Action::Move { at, over_secs: secs };
        self.scheduled.push(member_index, due, Start { action, ..start.at_its_time() });
        if let Some(active_space) = self.active_space.get_mut(member_index) {
            active_space.at = None;
        }
    }

    pub(crate) fn begin_move(
        &mut self,
        base: &mut Base,
        member_index: u32,
        start: &Start,
        (at, over_secs): (SpacePoint, f32),
        tick: u64,
    ) -> Result<(), Error> {
        let Some(active_space) =
            self.active_space.get(member_index).copied().filter(|s| s.serial == start.serial)
        else {
            return Ok(()); // Something else has started since.
        };
        if active_space.at == Some(at) {
            return Ok(());
        }
        let all = weights_at(&self.spaces[active_space.space].space, at);
        let fading_in =
            active_space.faded_in_tick.saturating_sub(tick) as f64 / TICKS_PER_SEC as f64;
        let secs = over_secs.max(single(fading_in));
        let layer = active_space.play.layer;
        let plan = |slot: &Slot, started: Started| {
            let own = started.serial == active_space.serial && slot.layer() as usize == layer;
            match started.sample.filter(|_| own) {
                Some(sample) if weight_of(&all, sample) > 0.0 => Plan::Stays,
                Some(_) => Plan::Leaves,
                None if slot.layer() as usize == layer && active_space.replaces(slot, started) => {
                    Plan::Leaves
                }
                None => Plan::Apart,
            }
        };
        let is_there = |sample| {
            self.sample_slot(base, member_index, active_space.serial, sample, tick).is_some()
        };
        let all_there = all.iter().all(|(sample, weight)| *weight <= 0.0 || is_there(*sample));
        let weights = if secs > 0.0 && !all_there {
            strongest(all, is_there, self.free_slot_count(base, member_index, tick, plan))
        } else {
            all
        };
        let missing = weights.iter().filter(|(sample, weight)| *weight > 0.0 && !is_there(*sample));
        let needed = missing.count();
        if secs <= 0.0 {
            self.move_slots(base, member_index, &active_space, &weights, 0.0, tick)?;
        }
        if let Some(due) = self.free_slots(base, member_index, needed, secs, tick, plan)? {
            self.scheduled.push(member_index, due, *start);
            self.active_space.insert(member_index, ActiveSpace { at: None, ..active_space });
            return Ok(());
        }
        let cycles_per_sec =
            self.cycles_per_sec(active_space.space, at, &weights, active_space.play.speed);
        let phase = active_space.phase_at(tick);
        let active_space =
            ActiveSpace { at: Some(at), start_tick: tick, phase, cycles_per_sec, ..active_space };
        self.active_space.insert(member_index, active_space);
        self.move_slots(base, member_index, &active_space, &weights, secs, tick)?;
        for (sample, weight) in weights.into_iter().filter(|(_, weight)| *weight > 0.0) {
            if self.sample_slot(base, member_index, active_space.serial, sample, tick).is_none() {
                self.add_sample(base, member_index, &active_space, (sample, weight), secs, tick)?;
            }
        }
        if weights != all {
            self.schedule_move(member_index, start, (at, over_secs), tick);
        }
        Ok(())
    }

    /// Fades the slots of a blend space to new weights and speed, and those that it replaces out.
    fn move_slots(
        &mut self,
        base: &mut Base,
        member_index: u32,
        active_space: &ActiveSpace,
        weights: &Weights,
        secs: f32,
        tick: u64,
    ) -> Result<(), Error> {
        for index in 0..base.slots(member_index).len() {
            let (mut slot, started) =
                (base.slots(member_index)[index], self.started(base, member_index, index));
            if slot.layer() as usize != active_space.play.layer || faded_out(&slot, tick) {
                continue;
            }
            let own = started.sample.filter(|_| started.serial == active_space.serial);
            if let Some(sample) = own {
                let paced = self.in_phase(active_space, usize::from(sample), NONE, tick);
                self.note_left(base, member_index, &slot, tick);
                slot = Slot {
                    start_tick: tick,
                    start_phase: paced.start_phase,
                    phase_rate: paced.phase_rate,
                    ..slot
                };
            } else if !active_space.replaces(&slot, started) {
                continue;
            }
            let weight =
                own.map_or(0.0, |sample| weight_of(weights, sample)) * active_space.play.weight;
            slot.ramp_weight(tick, base.slots(member_index)[index].weight_at(tick), weight, secs);
            base.tables.set_slot(member_index, index, slot)?;
        }
        Ok(())
    }

    fn add_sample(
        &mut self,
        base: &mut Base,
        member_index: u32,
        active_space: &ActiveSpace,
        (sample, weight): (usize, f32),
        secs: f32,
        tick: u64,
    ) -> Result<(), Error> {
        let clip = self.spaces[active_space.space].space.clips()[sample];
        let bound = base.bind_again(member_index, clip, active_space.play.partial)?;
        let mut slot = self
            .in_phase(active_space, sample, bound, tick)
            .on_layer(u32_from(active_space.play.layer));
        slot.ramp_weight(tick, 0.0, weight * active_space.play.weight, secs);
        let sample = u16::try_from(sample).ok();
        self.fill_slot(
            base,
            member_index,
            slot,
            Started { serial: active_space.serial, sample, once: false },
            tick,
        )
    }

    /// Returns a slot that plays a bound clip in the phase of its blend space.
    fn in_phase(&self, active_space: &ActiveSpace, sample: usize, bound: u32, tick: u64) -> Slot {
        let space = &self.spaces[active_space.space].space;
        let offset = cycles(f64::from(phase_offset(space, sample).rem_euclid(1.0)));
        let phase = active_space.phase_at(tick).wrapping_add(offset);
        Slot::in_phase(bound, tick, phase, active_space.cycles_per_sec)
    }

    /// Returns the slot of a clip of a blend space, unless it has faded out.
    fn sample_slot(
        &self,
        base: &Base,
        member_index: u32,
        serial: u64,
        sample: usize,
        tick: u64,
    ) -> Option<usize> {
        (0..base.slots(member_index).len()).find(|&index| {
            let started = self.started(base, member_index, index);
            !faded_out(&base.slots(member_index)[index], tick)
                && started.serial == serial
                && started.sample.map(usize::from) == Some(sample)
        })
    }

    /// Returns the cycles per second at a point: its own, or the weighted mean of the clips'. Clips
    /// of no length do not count.
    fn cycles_per_sec(&self, space: u32, at: SpacePoint, weights: &Weights, speed: f32) -> f64 {
        if let Some(cycles_per_sec) = at.cycles_per_sec {
            return f64::from(cycles_per_sec);
        }
        let durations = &self.spaces[space].durations_secs;
        let (mut sum, mut total) = (0.0, 0.0);
        for (sample, weight) in weights.iter().filter(|(sample, _)| durations[*sample] > 0.0) {
            sum += f64::from(*weight) / f64::from(durations[*sample]);
            total += f64::from(*weight);
        }
        if total > 0.0 { f64::from(speed) * sum / total } else { 0.0 }
    }
}

/// Returns the clips that have a slot and the strongest of the others, as many as `room` allows but
/// at least one, with weights in the same proportions.
fn strongest(all: Weights, is_there: impl Fn(usize) -> bool, room: usize) -> Weights {
    let mut order = all;
    order.sort_by(|a, b| is_there(b.0).cmp(&is_there(a.0)).then(b.1.total_cmp(&a.1)));
    let weighing = |(_, weight): &&(usize, f32)| *weight > 0.0;
    let there = order.iter().filter(weighing).filter(|(sample, _)| is_there(*sample)).count();
    let kept = order.iter().filter(weighing).take((there + room).max(1));
    let kept: Vec<_> = kept.copied().collect();
    if kept.len() == order.iter().filter(weighing).count() {
        return all;
    }
    let total: f32 = kept.iter().map(|(_, weight)| weight).sum();
    let mut weights = [(0, 0.0); MOST];
    weights.iter_mut().zip(kept).for_each(|(to, (sample, weight))| *to = (sample, weight / total));
    weights
}

fn weight_of(weights: &[(usize, f32); MOST], sample: u16) -> f32 {
    weights.iter().filter(|(own, _)| *own == usize::from(sample)).map(|(_, weight)| *weight).sum()
}

/// Converts a fraction of a cycle, 0 to 1, to 2^-64 of a cycle.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "not negative; `as` saturates"
)]
fn cycles(part: f64) -> u64 {
    (part * CYCLE) as u64
}
