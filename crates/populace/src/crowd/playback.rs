//! What members play: clips into slots, layers, masks.

use populace_core::layout::{Layer, NONE, Slot};
use populace_core::{Binding, LayerSettings, Mask};

use super::{CharacterId, ClipId, Crowd, MaskId, Member, u32_from};
use crate::play::{Mode, check_layer, check_secs, check_weight};
use crate::{Error, Play};

impl Crowd {
    /// The layer plays this clip from now on; what it played before fades out as this fades in.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`], an id of another crowd, or a setting that is out of its range.
    pub fn play(&mut self, member: Member, clip: ClipId, play: Play) -> Result<(), Error> {
        self.start(member, clip, play, true)
    }

    /// Adds a clip to what the layer plays: clips of a layer are mixed by their weights.
    ///
    /// # Errors
    ///
    /// As for [`play`](Self::play).
    pub fn blend(&mut self, member: Member, clip: ClipId, play: Play) -> Result<(), Error> {
        self.start(member, clip, play, false)
    }

    /// Lets layer 0 change over to a looping clip in so many seconds.
    ///
    /// # Errors
    ///
    /// As for [`play`](Self::play).
    pub fn crossfade(&mut self, member: Member, clip: ClipId, secs: f32) -> Result<(), Error> {
        self.play(member, clip, Play::looping().fade_in_secs(secs))
    }

    /// Fades out all clips of a layer. An empty layer 0 shows the rest pose, any other what lies beneath.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`], or a setting that is out of its range.
    pub fn stop(&mut self, member: Member, layer: usize, fade_out_secs: f32) -> Result<(), Error> {
        self.check(member)?;
        check_layer(layer)?;
        check_secs("the time to fade out", fade_out_secs)?;
        self.fade_out(member, layer, fade_out_secs)
    }

    /// Adds a mask for the members of a character.
    ///
    /// # Errors
    ///
    /// A character of another crowd, a mask of another skeleton, or more data than devices can address.
    pub fn add_mask(&mut self, character: CharacterId, mask: &Mask) -> Result<MaskId, Error> {
        let joints = self.character_state(character)?.character.skeleton.joint_count();
        let weights = mask.weights().len();
        if weights != joints {
            return Err(populace_core::Error::BadMask { weights, joints }.into());
        }
        Ok(MaskId { character, first: self.tables.add_mask(mask)? })
    }

    /// Sets how a layer above 0 meets what lies beneath it, for all joints or through a mask.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`], a mask of another character, or a setting that is out of its range.
    pub fn set_layer(
        &mut self,
        member: Member,
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
        Ok(self.tables.set_layer(member.place, layer, value)?)
    }

    fn start(&mut self, member: Member, clip: ClipId, play: Play, alone: bool) -> Result<(), Error> {
        let character = self.check(member)?;
        play.check()?;
        let bound = self.bind(character, clip)?;
        let tick = self.clock.tick;
        let weighs = |slot: &Slot| slot.bound_clip != NONE && slot.layer() == 0 && !faded_out(slot, tick);
        let first = play.layer == 0 && !self.slots(member).iter().any(weighs);
        if alone {
            self.fade_out(member, play.layer, play.fade_in_secs)?;
        }
        let rows = self.tables.clips().as_slice()[clip.index.0 as usize];
        let duration = rows.duration_secs;
        let slot = match play.mode {
            Mode::Looping => Slot::looping(bound, tick, duration, f64::from(play.phase), play.speed),
            Mode::Once => Slot::once(bound, tick, duration, play.speed),
            Mode::Held { secs } => Slot::held(bound, tick, secs),
        };
        let mut slot = slot.on_layer(u32_from(play.layer));
        slot.ramp_weight(tick, 0.0, play.weight, if first { 0.0 } else { play.fade_in_secs });
        let place = self.weakest_slot(member);
        Ok(self.tables.set_slot(member.place, place, slot)?)
    }

    fn bind(&mut self, character: CharacterId, clip: ClipId) -> Result<u32, Error> {
        self.check_crowd("clip", clip.crowd, clip.index.0)?;
        let state = self.character_state(character)?;
        let key = (state.body, clip.index);
        if let Some(&bound) = self.bound_clips.get(&key) {
            return Ok(bound);
        }
        let known =
            self.clips.get(clip.index).ok_or(Error::UnknownId { what: "clip", index: clip.index.0 })?;
        let (skeleton, roles) = (&state.character.skeleton, state.roles.as_ref());
        let binding = Binding::fitting(known, self.roles_of(known).as_ref(), skeleton, roles)?;
        let bound = self.tables.add_bound_clip(clip.index.0, state.body, &binding)?;
        self.bound_clips.insert(key, bound);
        Ok(bound)
    }

    fn slots(&self, member: Member) -> &[Slot] {
        &self.tables.slots().as_slice()[self.tables.slot_range(member.place)]
    }

    fn fade_out(&mut self, member: Member, layer: usize, secs: f32) -> Result<(), Error> {
        let tick = self.clock.tick;
        for index in 0..self.slots(member).len() {
            let mut slot = self.slots(member)[index];
            if slot.bound_clip != NONE && slot.layer() as usize == layer && slot.end_weight > 0.0 {
                slot.ramp_weight(tick, slot.weight_at(tick), 0.0, secs);
                self.tables.set_slot(member.place, index, slot)?;
            }
        }
        Ok(())
    }

    /// An empty slot, else one that has faded out, else the weakest: when all are taken the weakest gives way.
    fn weakest_slot(&self, member: Member) -> usize {
        let tick = self.clock.tick;
        let strength = |slot: &Slot| {
            if slot.bound_clip == NONE {
                -2.0
            } else if faded_out(slot, tick) {
                -1.0
            } else {
                slot.weight_at(tick)
            }
        };
        let slots = self.slots(member).iter().map(strength).enumerate();
        slots.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(index, _)| index)
    }
}

/// Whether a slot's weight has come down to 0 and stays there.
fn faded_out(slot: &Slot, tick: u64) -> bool {
    slot.end_weight <= 0.0 && slot.weight_at(tick) <= 0.0
}
