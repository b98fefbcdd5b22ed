//! Playback of clips: starting them in slots, now or scheduled, and masks of layers.

use populace_clip::{ClipIndex, TICKS_PER_SEC, ticks_from_secs};
use populace_device::LayerSettings;
use populace_device::layout::{Layer, NONE, SLOT_LIVE, SLOT_ONCE, Slot};
use populace_model::Mask;

use super::scheduled::{Action, Start};
use super::slots::{Plan, Started, faded_out};
use super::{CharacterId, ClipId, Crowd, MaskId, MemberId, PlaybackId, u32_from};
use crate::Error;
use crate::error::bounded;
use crate::playback::{ActiveClip, Playback, check_layer, check_secs, check_weight};

impl Crowd {
    pub(super) fn play(
        &mut self,
        member: MemberId,
        clip: ClipId,
        play: Playback,
    ) -> Result<PlaybackId, Error> {
        let start = self.start_of(member, clip, play, true)?;
        self.scheduled.retain(member.index, |start| start.play.layer != play.layer);
        self.begin_after(member, start, play.after_secs)
    }

    pub(super) fn blend(
        &mut self,
        member: MemberId,
        clip: ClipId,
        play: Playback,
    ) -> Result<PlaybackId, Error> {
        let start = self.start_of(member, clip, play, false)?;
        self.begin_after(member, start, play.after_secs)
    }

    pub(super) fn queue(
        &mut self,
        member: MemberId,
        clip: ClipId,
        play: Playback,
    ) -> Result<PlaybackId, Error> {
        let mut start = self.start_of(member, clip, play, true)?;
        let gap = ticks_from_secs(f64::from(play.after_secs));
        start.follows_after = Some(gap);
        let due = self.end_of_layer(member.index, play.layer).saturating_add(gap);
        self.begin_or_wait(member.index, due, start)?;
        Ok(PlaybackId { member, serial: start.serial })
    }

    pub(super) fn stop(
        &mut self,
        member: MemberId,
        layer: usize,
        fade_out_secs: f32,
    ) -> Result<(), Error> {
        self.check(member)?;
        check_layer(layer)?;
        check_secs("the time to fade out", fade_out_secs)?;
        self.scheduled.retain(member.index, |start| start.play.layer != layer);
        self.forget_space(member.index, layer);
        let slots = self.slots(member.index).iter().filter(|slot| slot.layer() as usize == layer);
        let mut playing = slots.filter(|slot| !faded_out(slot, self.clock.tick));
        if fade_out_secs > 0.0 && playing.all(|slot| slot.ramps_to(0.0, fade_out_secs)) {
            return Ok(());
        }
        self.fade_out(member.index, layer, fade_out_secs, self.clock.tick)
    }

    pub(super) fn set_weight(
        &mut self,
        id: PlaybackId,
        weight: f32,
        over_secs: f32,
    ) -> Result<(), Error> {
        check_weight("the weight of a clip", weight)?;
        check_secs("the time to change a weight", over_secs)?;
        let Some(first) = self.find_slot(id)? else {
            self.change_scheduled(id, |play| play.weight = weight);
            return Ok(());
        };
        let (place, tick) = (id.member.index, self.clock.tick);
        for index in first..self.slots(place).len() {
            let mut slot = self.slots(place)[index];
            if self.is_of(id, index) {
                // Each of the two slots of a machine has half the weight.
                let own = if slot.machine_instance().is_some() { 0.5 * weight } else { weight };
                if slot.ramps_to(own, over_secs) {
                    continue;
                }
                slot.ramp_weight(tick, slot.weight_at(tick), own, over_secs);
                self.tables.set_slot(place, index, slot)?;
            }
        }
        Ok(())
    }

    pub(super) fn set_speed(&mut self, id: PlaybackId, speed: f32) -> Result<(), Error> {
        bounded("the speed of a clip", &[speed])?;
        let place = id.member.index;
        let Some(index) = self.find_slot(id)? else {
            self.change_scheduled(id, |play| play.speed = speed);
            self.time_the_queue(place);
            return Ok(());
        };
        let mut slot = self.slots(place)[index];
        if slot.is_tied() {
            return Ok(());
        }
        let duration = self.duration_secs(slot.bound_clip);
        slot.set_speed(self.clock.tick, duration, speed, self.started(place, index).once);
        self.tables.set_slot(place, index, slot)?;
        self.time_the_queue(place);
        Ok(())
    }

    pub(super) fn active_clips(&self, member: MemberId) -> Vec<ActiveClip> {
        let tick = self.clock.tick;
        let slots = self.slots(member.index).iter().enumerate();
        let told =
            slots.filter(|(_, slot)| !faded_out(slot, tick) && slot.machine_instance().is_none());
        let mut all: Vec<_> =
            told.map(|(index, slot)| self.playing_slot(member, index, slot)).collect();
        all.sort_by_key(|(serial, playing)| (playing.layer, *serial));
        all.into_iter().map(|(_, playing)| playing).collect()
    }

    fn playing_slot(&self, member: MemberId, index: usize, slot: &Slot) -> (u32, ActiveClip) {
        let tick = self.clock.tick;
        let clip = self.tables.bound_clips().as_slice()[slot.bound_clip as usize].clip;
        let rows = self.tables.clips().as_slice()[clip as usize];
        let started = self.started(member.index, index);
        let ends = slot.end_tick(tick).filter(|_| started.once);
        let time_secs = match slot.mode() {
            SLOT_LIVE => self.live_secs(clip, slot.delay_ticks()),
            _ => slot.time_at(tick, rows.start_secs, rows.duration_secs),
        };
        let playing = ActiveClip {
            id: started.sample.is_none().then_some(PlaybackId { member, serial: started.serial }),
            clip: ClipId { crowd: self.number, index: ClipIndex(clip) },
            layer: slot.layer() as usize,
            time_secs,
            weight: slot.weight_at(tick),
            speed: slot.speed(rows.duration_secs),
            ends_in_secs: ends.map(|end| end.saturating_sub(tick) as f64 / TICKS_PER_SEC as f64),
        };
        (started.serial, playing)
    }

    /// Adds a mask to a character.
    ///
    /// # Errors
    ///
    /// A character of another crowd, a mask of another skeleton, or more data than devices can
    /// address.
    pub fn add_mask(&mut self, character: CharacterId, mask: &Mask) -> Result<MaskId, Error> {
        let joints = self.character_state(character)?.character.skeleton.joint_count();
        let weights = mask.weights().len();
        if weights != joints {
            return Err(populace_model::Error::BadMask { weights, joints }.into());
        }
        Ok(MaskId { character, first: self.tables.add_mask(mask)? })
    }

    pub(super) fn set_layer(
        &mut self,
        member: MemberId,
        layer: usize,
        settings: LayerSettings,
        mask: Option<MaskId>,
    ) -> Result<(), Error> {
        let character = self.check(member)?;
        check_layer(layer)?;
        check_weight("the weight of a layer", settings.weight)?;
        if let Some(mask) = mask.filter(|m| m.character != character) {
            return Err(Error::UnknownId { what: "mask of this character", index: mask.first });
        }
        let value = Layer::new(settings, mask.map(|m| m.first));
        Ok(self.tables.set_layer(member.index, layer, value)?)
    }

    fn start_of(
        &mut self,
        member: MemberId,
        clip: ClipId,
        play: Playback,
        alone: bool,
    ) -> Result<Start, Error> {
        let character = self.check(member)?;
        play.check()?;
        let bound = self.bind(character, clip, play.partial)?;
        self.check_mode(clip, play.mode)?;
        let action = Action::Clip { bound, alone };
        Ok(Start { serial: self.next_serial(), action, play, follows_after: None })
    }

    pub(super) fn next_serial(&mut self) -> u32 {
        self.last_serial = self.last_serial.wrapping_add(1);
        self.last_serial
    }

    pub(super) fn begin_after(
        &mut self,
        member: MemberId,
        start: Start,
        secs: f32,
    ) -> Result<PlaybackId, Error> {
        let due = self.clock.tick.saturating_add(ticks_from_secs(f64::from(secs)));
        self.begin_or_wait(member.index, due, start)?;
        Ok(PlaybackId { member, serial: start.serial })
    }

    pub(super) fn begin_or_wait(
        &mut self,
        place: u32,
        due: u64,
        start: Start,
    ) -> Result<(), Error> {
        if due > self.clock.tick {
            self.scheduled.push(place, due, start);
            return Ok(());
        }
        self.begin(place, start, self.clock.tick)
    }

    /// Executes all starts that are due at or before `tick`, each as of its own tick.
    pub(super) fn begin_due(&mut self, tick: u64) -> Result<(), Error> {
        while let Some((due, place, start)) = self.scheduled.take_due(tick) {
            self.begin(place, start, due)?;
        }
        Ok(())
    }

    fn begin(&mut self, place: u32, start: Start, tick: u64) -> Result<(), Error> {
        match start.action {
            Action::Clip { bound, alone } => self.begin_clip(place, &start, (bound, alone), tick),
            Action::Space { index, at } => self.begin_space(place, &start, (index, at), tick),
            Action::Machine { state, parameters } => {
                self.begin_machine(place, &start, (state, parameters), tick)
            }
            Action::Move { at, over_secs } => self.begin_move(place, &start, (at, over_secs), tick),
        }
    }

    fn begin_clip(
        &mut self,
        place: u32,
        start: &Start,
        (bound, alone): (u32, bool),
        tick: u64,
    ) -> Result<(), Error> {
        let Playback { layer, fade_in_secs: secs, .. } = start.play;
        if alone && secs <= 0.0 {
            self.fade_out(place, layer, 0.0, tick)?;
        }
        let slot = start.play.slot(bound, tick, self.duration_secs(bound));
        let mut slot = slot.on_layer(u32_from(layer));
        let inertializes = alone
            && start.play.inertializes
            && secs > 0.0
            && self.can_inertialize(place, &slot, tick);
        let role = |slot: &Slot, _| {
            if alone && slot.layer() as usize == layer { Plan::Leaves } else { Plan::Apart }
        };
        let needed =
            usize::from(!inertializes || self.unevaluated(place, slot.layer(), tick).is_empty());
        if let Some(due) = self.free_slots(place, needed, secs, tick, role)? {
            self.scheduled.push(place, due, start.at_its_time());
            return Ok(());
        }
        let mut weight = 0.0;
        let at_once = self.is_first(place, layer, tick) || (inertializes && layer == 0);
        if inertializes {
            weight = self.inertialize(place, &slot, secs, tick)?;
        } else if alone {
            self.fade_out(place, layer, secs, tick)?;
        }
        if alone {
            self.forget_space(place, layer);
        }
        slot.ramp_weight(tick, weight, start.play.weight, if at_once { 0.0 } else { secs });
        let once = slot.mode() == SLOT_ONCE;
        self.fill_slot(place, slot, Started { serial: start.serial, sample: None, once }, tick)
    }

    /// Returns whether a start is the first of layer 0. It then has its full weight at once, so
    /// that the rest pose never shows by accident.
    pub(super) fn is_first(&self, place: u32, layer: usize, tick: u64) -> bool {
        layer == 0
            && self.slots(place).iter().all(|slot| slot.layer() != 0 || faded_out(slot, tick))
    }

    pub(super) fn duration_secs(&self, bound: u32) -> f32 {
        let clip = self.tables.bound_clips().as_slice()[bound as usize].clip;
        self.tables.clips().as_slice()[clip as usize].duration_secs
    }

    /// Returns whether a slot belongs to a playback.
    fn is_of(&self, id: PlaybackId, index: usize) -> bool {
        let Started { serial, sample, .. } = self.started(id.member.index, index);
        let is_taken = self.slots(id.member.index)[index].bound_clip != NONE;
        serial == id.serial && sample.is_none() && is_taken
    }

    /// Returns the first slot of a playback; `None` if it is still scheduled.
    fn find_slot(&self, id: PlaybackId) -> Result<Option<usize>, Error> {
        self.check_crowd("play", id.member.crowd, id.serial)?;
        self.check(id.member)?;
        let place = id.member.index;
        if let Some(index) = (0..self.slots(place).len()).find(|index| self.is_of(id, *index)) {
            return Ok(Some(index));
        }
        let waits = self.scheduled.of(place).any(|(_, start)| start.serial == id.serial);
        if waits { Ok(None) } else { Err(Error::StalePlayback) }
    }

    fn change_scheduled(&mut self, id: PlaybackId, change: impl Fn(&mut Playback)) {
        self.scheduled.change(id.member.index, |_, start| {
            if start.serial == id.serial {
                change(&mut start.play);
            }
        });
    }

    /// Returns the tick at which the newest playback of a layer ends.
    fn end_of_layer(&self, place: u32, layer: usize) -> u64 {
        let scheduled =
            self.scheduled.of(place).filter(|(_, start)| start.play.layer == layer).last();
        match scheduled {
            Some((due, start)) => self.end_of_start(due, start),
            None => self.end_of_slots(place, layer),
        }
    }

    fn end_of_slots(&self, place: u32, layer: usize) -> u64 {
        let tick = self.clock.tick;
        let slots = self.slots(place).iter().enumerate();
        let playing = slots.filter(|(_, slot)| {
            let ends = slot.is_inertialization() || slot.end_weight <= 0.0;
            slot.bound_clip != NONE && slot.layer() as usize == layer && !ends
        });
        let last = playing.max_by_key(|(index, _)| self.started(place, *index).serial);
        last.map_or(tick, |(_, slot)| self.end_of(slot, tick))
    }

    fn end_of_start(&self, due: u64, start: &Start) -> u64 {
        let Action::Clip { bound, .. } = start.action else { return due };
        self.end_of(&start.play.slot(bound, due, self.duration_secs(bound)), due)
    }

    /// Returns the tick at which a slot ends, at least `tick`. A clip at speed 0 never ends until
    /// its speed is set.
    fn end_of(&self, slot: &Slot, tick: u64) -> u64 {
        let has_end = !slot.is_tied() && self.duration_secs(slot.bound_clip) > 0.0;
        if has_end { slot.end_tick(tick).unwrap_or(u64::MAX).max(tick) } else { tick }
    }

    /// Reschedules the queued starts of a member after a change to a playback before them.
    fn time_the_queue(&mut self, place: u32) {
        let mut ends = [0, 1, 2, 3].map(|layer| self.end_of_slots(place, layer));
        let scheduled: Vec<_> =
            self.scheduled.of(place).map(|(due, start)| (due, *start)).collect();
        let mut dues = Vec::with_capacity(scheduled.len());
        for (due, start) in scheduled {
            let due =
                start.follows_after.map_or(due, |gap| ends[start.play.layer].saturating_add(gap));
            ends[start.play.layer] = self.end_of_start(due, &start);
            dues.push(due.max(self.clock.tick + 1));
        }
        let mut dues = dues.into_iter();
        self.scheduled.change(place, |due, _| *due = dues.next().unwrap_or(*due));
    }
}
