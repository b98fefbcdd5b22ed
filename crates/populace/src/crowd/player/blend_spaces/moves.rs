//! Starts and moves of blend spaces: the slots that their clips get, with weights and phases.

use populace_clip::TICKS_PER_SEC;
use populace_device::layout::{NONE, Slot};
use populace_model::convert::single;
use populace_settings::parts::{MOST, Playback, Weights, phase_offset, weights_at};

use super::{ActiveSpace, CYCLE};
use crate::Error;
use crate::SpacePoint;
use crate::crowd::base::Base;
use crate::crowd::player::eviction::Plan;
use crate::crowd::player::scheduled::{Action, Start};
use crate::crowd::player::slots::{Started, faded_out};
use crate::crowd::player::{Player, tick_after};
use crate::crowd::u32_from;

impl Player {
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
                self.note_left(base, member_index, index, tick);
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
            base.tables.set_slot(member_index, index, &slot)?;
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
            &slot,
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
