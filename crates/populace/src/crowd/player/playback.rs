//! Playback of clips: what users ask for, change and are told, and masks of layers.

use populace_clip::{TICKS_PER_SEC, ticks_from_secs};
use populace_device::LayerSettings;
use populace_device::layout::{Layer, NONE, SLOT_LIVE, Slot};
use populace_settings::parts::{
    Check, Parts, Playback, PlaybackParts, bounded, check_layer, check_secs, check_weight,
};

use super::Player;
use super::scheduled::{Action, Start};
use super::slots::{Started, faded_out};
use crate::crowd::base::Base;
use crate::crowd::live::LiveClips;
use crate::crowd::{CharacterId, ClipId, MaskId, MemberId, PlaybackId};
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
        let bound = bind_to_play(base, character, clip, &play)?;
        let start = self.start_of(Action::Clip { bound, alone: true }, play);
        self.scheduled.retain(member.number(), |start| start.play.layer != play.layer);
        self.begin_after(base, member, &start, play.after_secs)
    }

    pub(crate) fn blend(
        &mut self,
        base: &mut Base,
        member: MemberId,
        character: CharacterId,
        clip: ClipId,
        play: Playback,
    ) -> Result<PlaybackId, Error> {
        let bound = bind_to_play(base, character, clip, &play)?;
        let start = self.start_of(Action::Clip { bound, alone: false }, play);
        self.begin_after(base, member, &start, play.after_secs)
    }

    pub(crate) fn queue(
        &mut self,
        base: &mut Base,
        member: MemberId,
        character: CharacterId,
        clip: ClipId,
        play: Playback,
    ) -> Result<PlaybackId, Error> {
        let bound = bind_to_play(base, character, clip, &play)?;
        let mut start = self.start_of(Action::Clip { bound, alone: true }, play);
        let gap = ticks_from_secs(f64::from(play.after_secs));
        start.follows_after = Some(gap);
        let due = self.end_of_layer(base, member.number(), play.layer).saturating_add(gap);
        self.begin_or_wait(base, member.number(), due, &start)?;
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
        base.tables.set_slot(member_index, index, &slot)?;
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
}

/// Checks the settings of a clip and returns the index of its binding.
fn bind_to_play(
    base: &mut Base,
    character: CharacterId,
    clip: ClipId,
    play: &Playback,
) -> Result<u32, Error> {
    play.check()?;
    let bound = base.bind(character, clip, play.partial)?;
    base.check_mode(clip, play.mode)?;
    Ok(bound)
}

pub(super) fn playback_id(member: MemberId, serial: u64) -> PlaybackId {
    PlaybackId::from_parts(PlaybackParts { member, serial })
}
