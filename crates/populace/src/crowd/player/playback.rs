//! Playback of clips: starting them in slots, now or scheduled, and masks of layers.

use populace_clip::{TICKS_PER_SEC, ticks_from_secs};
use populace_device::LayerSettings;
use populace_device::layout::{Layer, NONE, SLOT_LIVE, SLOT_ONCE, Slot};
use populace_settings::parts::{
    Check, Parts, Playback, PlaybackParts, bounded, check_layer, check_secs, check_weight,
};

use super::scheduled::{Action, Start};
use super::slots::{Plan, Started, faded_out, weighing};
use super::{Player, tick_after};
use crate::crowd::base::Base;
use crate::crowd::live::LiveClips;
use crate::crowd::{CharacterId, ClipId, MaskId, MemberId, PlaybackId, u32_from};
use crate::{ActiveClip, Allowed, Error, IdKind};

impl Player {
    pub(crate) fn play(
        &mut self,
        base: &mut Base,
        member: MemberId,
        character: CharacterId,
        clip: ClipId,
        play: Playback,
    ) -> Result<PlaybackId, Error> {
        let start = self.start_of(base, character, clip, play, true)?;
        self.scheduled.retain(member.number(), |start| start.play.layer != play.layer);
        self.begin_after(base, member, start, play.after_secs)
    }

    pub(crate) fn blend(
        &mut self,
        base: &mut Base,
        member: MemberId,
        character: CharacterId,
        clip: ClipId,
        play: Playback,
    ) -> Result<PlaybackId, Error> {
        let start = self.start_of(base, character, clip, play, false)?;
        self.begin_after(base, member, start, play.after_secs)
    }

    pub(crate) fn queue(
        &mut self,
        base: &mut Base,
        member: MemberId,
        character: CharacterId,
        clip: ClipId,
        play: Playback,
    ) -> Result<PlaybackId, Error> {
        let mut start = self.start_of(base, character, clip, play, true)?;
        let gap = ticks_from_secs(f64::from(play.after_secs));
        start.follows_after = Some(gap);
        let due = self.end_of_layer(base, member.number(), play.layer).saturating_add(gap);
        self.begin_or_wait(base, member.number(), due, start)?;
        Ok(playback_id(member, start.serial))
    }

    pub(crate) fn stop(
        &mut self,
        base: &mut Base,
        member: MemberId,
        layer: usize,
        fade_out_secs: f32,
    ) -> Result<(), Error> {
        base.check(member)?;
        check_layer(layer)?;
        check_secs("the time to fade out", fade_out_secs)?;
        self.scheduled.retain(member.number(), |start| start.play.layer != layer);
        self.forget_space(member.number(), layer);
        let slots =
            base.slots(member.number()).iter().filter(|slot| slot.layer() as usize == layer);
        let mut playing = slots.filter(|slot| !faded_out(slot, base.clock.tick));
        if fade_out_secs > 0.0 && playing.all(|slot| slot.ramps_to(0.0, fade_out_secs)) {
            return Ok(());
        }
        self.fade_out(base, member.number(), layer, fade_out_secs, base.clock.tick)?;
        Ok(())
    }

    pub(crate) fn set_weight(
        &mut self,
        base: &mut Base,
        id: PlaybackId,
        weight: f32,
        over_secs: f32,
    ) -> Result<(), Error> {
        check_weight("the weight of a clip", weight)?;
        check_secs("the time to change a weight", over_secs)?;
        let Some(first) = self.find_slot(base, id)? else {
            self.change_scheduled(id, |play| play.weight = weight);
            return Ok(());
        };
        let (member_index, tick) = (id.member().number(), base.clock.tick);
        for index in first..base.slots(member_index).len() {
            if self.is_of(base, id, index) {
                let slot = &base.slots(member_index)[index];
                // Each of the two slots of a machine has half the weight.
                let own = if slot.machine_instance().is_some() { 0.5 * weight } else { weight };
                if slot.ramps_to(own, over_secs) {
                    continue;
                }
                base.tables.ramp_slot(member_index, index, tick, own, over_secs)?;
            }
        }
        Ok(())
    }

    pub(crate) fn set_speed(
        &mut self,
        base: &mut Base,
        id: PlaybackId,
        speed: f32,
    ) -> Result<(), Error> {
        bounded("the speed of a clip", &[speed])?;
        let member_index = id.member().number();
        let Some(index) = self.find_slot(base, id)? else {
            self.change_scheduled(id, |play| play.speed = speed);
            let is_it = |start: &Start| start.serial == id.parts().serial;
            let found = self.scheduled.of(member_index).find(|(_, start)| is_it(start));
            if let Some(layer) = found.map(|(_, start)| start.play.layer) {
                self.time_the_queue(base, member_index, layer);
            }
            return Ok(());
        };
        let mut slot = base.slots(member_index)[index];
        if slot.is_tied() {
            return Ok(());
        }
        let duration = base.duration_secs(slot.bound_clip);
        slot.set_speed(
            base.clock.tick,
            duration,
            speed,
            self.started(base, member_index, index).once,
        );
        base.tables.set_slot(member_index, index, slot)?;
        self.time_the_queue(base, member_index, slot.layer() as usize);
        Ok(())
    }

    pub(crate) fn active_clips(
        &self,
        base: &Base,
        live: &LiveClips,
        member: MemberId,
    ) -> Vec<ActiveClip> {
        let tick = base.clock.tick;
        let slots = base.slots(member.number()).iter().enumerate();
        let told =
            slots.filter(|(_, slot)| !faded_out(slot, tick) && slot.machine_instance().is_none());
        let mut all: Vec<_> =
            told.map(|(index, slot)| self.playing_slot(base, live, member, index, slot)).collect();
        all.sort_by_key(|(serial, playing)| (playing.layer, *serial));
        all.into_iter().map(|(_, playing)| playing).collect()
    }

    fn playing_slot(
        &self,
        base: &Base,
        live: &LiveClips,
        member: MemberId,
        index: usize,
        slot: &Slot,
    ) -> (u64, ActiveClip) {
        let tick = base.clock.tick;
        let clip = base.tables.bound_clips().as_slice()[slot.bound_clip as usize].clip;
        let rows = base.tables.clips().as_slice()[clip as usize];
        let started = self.started(base, member.number(), index);
        let ends = slot.end_tick(tick).filter(|_| started.once);
        let time_secs = match slot.mode() {
            SLOT_LIVE => live.live_secs(base, clip, slot.delay_ticks()),
            _ => slot.time_at(tick, rows.start_secs, rows.duration_secs),
        };
        let playing = ActiveClip {
            id: started.sample.is_none().then_some(playback_id(member, started.serial)),
            clip: base.clip_id(clip),
            layer: slot.layer() as usize,
            time_secs,
            weight: slot.weight_at(tick),
            speed: slot.speed(rows.duration_secs),
            ends_in_secs: ends.map(|end| end.saturating_sub(tick) as f64 / TICKS_PER_SEC as f64),
        };
        (started.serial, playing)
    }

    pub(crate) fn set_layer(
        &mut self,
        base: &mut Base,
        member: MemberId,
        layer: usize,
        settings: LayerSettings,
        mask: Option<MaskId>,
    ) -> Result<(), Error> {
        let character = base.check(member)?;
        check_layer(layer)?;
        if layer == 0 {
            let (what, allowed) = ("the layer to set", Allowed::Range { least: 1.0, most: 3.0 });
            return Err(Error::BadValue { what, value: 0.0, allowed });
        }
        check_weight("the weight of a layer", settings.weight)?;
        let first = mask.map(|mask| base.first_of_mask(character, mask)).transpose()?;
        let value = Layer::new(settings, first);
        Ok(base.tables.set_layer(member.number(), layer, value)?)
    }

    fn start_of(
        &mut self,
        base: &mut Base,
        character: CharacterId,
        clip: ClipId,
        play: Playback,
        alone: bool,
    ) -> Result<Start, Error> {
        play.check()?;
        let bound = base.bind(character, clip, play.partial)?;
        base.check_mode(clip, play.mode)?;
        let action = Action::Clip { bound, alone };
        Ok(Start { serial: self.next_serial(), action, play, follows_after: None })
    }

    pub(crate) fn begin_after(
        &mut self,
        base: &mut Base,
        member: MemberId,
        start: Start,
        secs: f32,
    ) -> Result<PlaybackId, Error> {
        let due = tick_after(base.clock.tick, secs);
        self.begin_or_wait(base, member.number(), due, start)?;
        Ok(playback_id(member, start.serial))
    }

    pub(crate) fn begin_or_wait(
        &mut self,
        base: &mut Base,
        member_index: u32,
        due: u64,
        start: Start,
    ) -> Result<(), Error> {
        if due > base.clock.tick {
            self.scheduled.push(member_index, due, start);
            return Ok(());
        }
        self.begin(base, member_index, start, base.clock.tick)
    }

    /// Executes all starts that are due at or before `tick`, each as of its own tick.
    pub(crate) fn begin_due(&mut self, base: &mut Base, tick: u64) -> Result<(), Error> {
        while let Some((due, member_index, start)) = self.scheduled.take_due(tick) {
            self.begin(base, member_index, start, due)?;
        }
        Ok(())
    }

    fn begin(
        &mut self,
        base: &mut Base,
        member_index: u32,
        start: Start,
        tick: u64,
    ) -> Result<(), Error> {
        match start.action {
            Action::Clip { bound, alone } => {
                self.begin_clip(base, member_index, &start, (bound, alone), tick)
            }
            Action::Space { index, at } => {
                self.begin_space(base, member_index, &start, (index, at), tick)
            }
            Action::Machine { state, parameters } => {
                self.begin_machine(base, member_index, &start, (state, parameters), tick)
            }
            Action::Move { at, over_secs } => {
                self.begin_move(base, member_index, &start, (at, over_secs), tick)
            }
        }
    }

    fn begin_clip(
        &mut self,
        base: &mut Base,
        member_index: u32,
        start: &Start,
        (bound, alone): (u32, bool),
        tick: u64,
    ) -> Result<(), Error> {
        let Playback { layer, fade_in_secs: secs, .. } = start.play;
        if alone && secs <= 0.0 {
            self.fade_out(base, member_index, layer, 0.0, tick)?;
        }
        let slot = start.play.slot(bound, tick, base.duration_secs(bound));
        let mut slot = slot.on_layer(u32_from(layer));
        let inertializes = alone
            && start.play.inertializes
            && secs > 0.0
            && self.can_inertialize(base, member_index, &slot, tick);
        let role = |slot: &Slot, _| {
            if alone && slot.layer() as usize == layer { Plan::Leaves } else { Plan::Apart }
        };
        let needed = usize::from(
            !inertializes || self.unevaluated(base, member_index, slot.layer(), tick).is_empty(),
        );
        // Fading others out leaves a vacant slot vacant, but inertialization may take it.
        let vacant = self.vacant_slot(base, member_index, None, tick).filter(|_| !inertializes);
        if vacant.is_none()
            && let Some(due) = self.free_slots(base, member_index, needed, secs, tick, role)?
        {
            self.scheduled.push(member_index, due, start.at_its_time());
            return Ok(());
        }
        let (weight, nothing_fades) = if inertializes {
            (self.inertialize(base, member_index, &slot, secs, tick)?, true)
        } else if alone {
            (0.0, !self.fade_out(base, member_index, layer, secs, tick)?)
        } else {
            (0.0, self.is_first(base, member_index, layer, tick))
        };
        if alone {
            self.forget_space(member_index, layer);
        }
        let at_once = nothing_fades && layer == 0;
        slot.ramp_weight(tick, weight, start.play.weight, if at_once { 0.0 } else { secs });
        let once = slot.mode() == SLOT_ONCE;
        let started = Started { serial: start.serial, sample: None, once };
        match vacant {
            Some(index) => self.put_slot(base, member_index, index, slot, started, tick),
            None => self.fill_slot(base, member_index, slot, started, tick),
        }
    }

    /// Returns whether a start is the first of layer 0. It then has its full weight at once, so
    /// that the rest pose never shows by accident.
    pub(crate) fn is_first(&self, base: &Base, member_index: u32, layer: usize, tick: u64) -> bool {
        layer == 0 && weighing(base.slots(member_index), 0, tick).is_empty()
    }

    /// Returns whether a slot belongs to a playback that has not ended.
    fn is_of(&self, base: &Base, id: PlaybackId, index: usize) -> bool {
        let Started { serial, sample, .. } = self.started(base, id.member().number(), index);
        let slot = &base.slots(id.member().number())[index];
        // A playback that has ended keeps its slot until another takes it. One that has begun at
        // weight 0 waits for more.
        let begins_at_0 = slot.bound_clip != NONE && slot.start_weight <= 0.0;
        let has_ended = faded_out(slot, base.clock.tick) && !begins_at_0;
        serial == id.parts().serial && sample.is_none() && !has_ended
    }

    /// Returns the first slot of a playback; `None` if it is still scheduled.
    fn find_slot(&self, base: &Base, id: PlaybackId) -> Result<Option<usize>, Error> {
        let PlaybackParts { member, serial } = id.parts();
        let number = u32::try_from(serial).unwrap_or(u32::MAX);
        base.check_crowd(IdKind::Playback, member.parts().crowd, number)?;
        base.check(member)?;
        let member_index = member.number();
        if let Some(index) =
            (0..base.slots(member_index).len()).find(|index| self.is_of(base, id, *index))
        {
            return Ok(Some(index));
        }
        let waits = self.scheduled.of(member_index).any(|(_, start)| start.serial == serial);
        if waits { Ok(None) } else { Err(Error::StalePlayback) }
    }

    fn change_scheduled(&mut self, id: PlaybackId, change: impl Fn(&mut Playback)) {
        self.scheduled.change(id.member().number(), |_, start| {
            if start.serial == id.parts().serial {
                change(&mut start.play);
            }
        });
    }

    /// Returns the tick at which the newest playback of a layer ends.
    fn end_of_layer(&self, base: &Base, member_index: u32, layer: usize) -> u64 {
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
    fn time_the_queue(&mut self, base: &Base, member_index: u32, layer: usize) {
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

fn playback_id(member: MemberId, serial: u64) -> PlaybackId {
    PlaybackId::from_parts(PlaybackParts { member, serial })
}
