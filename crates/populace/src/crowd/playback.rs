//! What members play: clips into slots, now or in time, and masks on layers.

use populace_clip::{ClipIndex, TICKS_PER_SEC, ticks_from_secs};
use populace_device::LayerSettings;
use populace_device::layout::{Layer, NONE, SLOT_LIVE, SLOT_ONCE, Slot};
use populace_model::Mask;

use super::room::{Plan, Started, faded_out};
use super::waiting::{Action, Start};
use super::{CharacterId, ClipId, Crowd, MaskId, Member, PlayId, u32_from};
use crate::error::bounded;
use crate::play::{Playing, check_layer, check_secs, check_weight};
use crate::{Error, Play};

impl Crowd {
    /// The layer plays this clip from now on, or from [`Play::after_secs`] on; what it played
    /// before fades out as this fades in, and what was queued is forgotten.
    ///
    /// Where all slots of the member are taken, the weakest fades out first and this waits for it,
    /// for a small part of its own fade, or for what still inertializes
    /// ([`Play::inertialize_in_secs`]): a pose never jumps. One that starts without a fade takes
    /// the weakest's slot at once, and a member with one slot has nothing to fade with.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`], an id of another crowd, a setting that is out of its range, or a
    /// clip that does not fit ([`binding`](Self::binding)).
    pub fn play(&mut self, member: Member, clip: ClipId, play: Play) -> Result<PlayId, Error> {
        let start = self.start_of(member, clip, play, true)?;
        self.waiting.retain(member.place, |waiting| waiting.play.layer != play.layer);
        self.begin_after(member, start, play.after_secs)
    }

    /// Adds a clip to what the layer plays: clips of a layer are mixed by their weights.
    ///
    /// # Errors
    ///
    /// As for [`play`](Self::play).
    pub fn blend(&mut self, member: Member, clip: ClipId, play: Play) -> Result<PlayId, Error> {
        let start = self.start_of(member, clip, play, false)?;
        self.begin_after(member, start, play.after_secs)
    }

    /// The layer plays this clip once what it plays now has ended: at the end of a clip that plays
    /// once, of a cycle of one that loops; at once where nothing plays, or a clip is held or live.
    /// What is queued further begins after this in turn. [`Play::after_secs`] counts from that end.
    /// The clip before holds its end while this fades in.
    ///
    /// ```
    /// # use populace::{Crowd, Device, Placement, Play};
    /// # use populace::character::{Character, CharacterSource, PaletteEntry};
    /// # use populace::clip::Clip;
    /// # use populace::model::{Affine, ClipSource, Interpolation, JointIndex, JointSource, Property, Skeleton, Track, Trs};
    /// # let joint = JointSource { name: "hips".into(), parent: None, rest: Trs::IDENTITY };
    /// # let skeleton = Skeleton::new(&[joint])?;
    /// # let clip = |name: &str, to| { let track = Track { joint: "hips".into(), property: Property::Translation,
    /// #     interpolation: Interpolation::Linear, times: vec![0.0, 1.0], values: vec![0.0, 0.0, 0.0, 0.0, to, 0.0] };
    /// #     Clip::new(ClipSource { name: name.into(), tracks: vec![track] }, &skeleton) };
    /// # let clips = vec![clip("Wave", 2.0)?.into(), clip("Idle", 0.0)?.into()];
    /// # let knight = Character::new(CharacterSource { name: "knight".into(), palette: vec![],
    /// #     skeleton: skeleton.clone(), parts: vec![], materials: vec![], images: vec![], skins: vec![], clips })?;
    /// # let mut crowd = Crowd::builder().device(Device::native()).build()?;
    /// # let knight = crowd.add_character(knight)?;
    /// # let member = crowd.spawn(knight, Placement::at([0.0; 3]))?;
    /// let (wave, idle) = (crowd.clip(knight, "Wave")?, crowd.clip(knight, "Idle")?);
    /// crowd.play(member, wave, Play::once())?;
    /// crowd.queue(member, idle, Play::looping().fade_in_secs(0.5))?; // once, then back
    /// crowd.update(1.25)?;
    /// let playing = crowd.playing(member)?;
    /// assert_eq!((playing[0].clip, playing[1].clip), (wave, idle));
    /// assert!((playing[1].weight - 0.5).abs() < 1e-3 && (playing[1].time_secs - 0.25).abs() < 1e-3);
    /// # Ok::<(), populace::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As for [`play`](Self::play).
    pub fn queue(&mut self, member: Member, clip: ClipId, play: Play) -> Result<PlayId, Error> {
        let mut start = self.start_of(member, clip, play, true)?;
        let gap = ticks_from_secs(f64::from(play.after_secs));
        start.follows_after = Some(gap);
        let due = self.end_of_layer(member.place, play.layer).saturating_add(gap);
        self.begin_or_wait(member.place, due, start)?;
        Ok(PlayId { member, serial: start.serial })
    }

    /// Lets layer 0 change over to a looping clip in so many seconds.
    ///
    /// # Errors
    ///
    /// As for [`play`](Self::play).
    pub fn crossfade(&mut self, member: Member, clip: ClipId, secs: f32) -> Result<PlayId, Error> {
        self.play(member, clip, Play::looping().fade_in_secs(secs))
    }

    /// Fades out all clips of a layer, and forgets what was queued. An empty layer 0 shows the rest
    /// pose, any other what lies beneath. The same call repeated lets the fade go on.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`], or a setting that is out of its range.
    pub fn stop(&mut self, member: Member, layer: usize, fade_out_secs: f32) -> Result<(), Error> {
        self.check(member)?;
        check_layer(layer)?;
        check_secs("the time to fade out", fade_out_secs)?;
        self.waiting.retain(member.place, |waiting| waiting.play.layer != layer);
        self.forget_space(member.place, layer);
        let slots = self.slots(member.place).iter().filter(|slot| slot.layer() as usize == layer);
        let mut playing = slots.filter(|slot| !faded_out(slot, self.clock.tick));
        if fade_out_secs > 0.0 && playing.all(|slot| slot.ramps_to(0.0, fade_out_secs)) {
            return Ok(());
        }
        self.fade_out(member.place, layer, fade_out_secs, self.clock.tick)
    }

    /// Lets the weight of a clip or of a state machine run to another in so many seconds. One of 0
    /// ends it: once it is reached, the slot is free for others. The same call repeated changes
    /// nothing: the weight goes on to where it runs.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`], [`Error::StalePlay`], or a value that is out of its range.
    pub fn set_weight(&mut self, id: PlayId, weight: f32, over_secs: f32) -> Result<(), Error> {
        check_weight("the weight of a clip", weight)?;
        check_secs("the time to change a weight", over_secs)?;
        let Some(first) = self.find_slot(id)? else {
            self.change_waiting(id, |play| play.weight = weight);
            return Ok(());
        };
        let (place, tick) = (id.member.place, self.clock.tick);
        for index in first..self.slots(place).len() {
            let mut slot = self.slots(place)[index];
            if self.is_of(id, index) {
                // Each slot of a machine has half of it.
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

    /// Lets a clip run at another speed from now on, from where it stands; negative runs backwards,
    /// 0 stands. What is queued after it keeps to its new end. Held and live clips and state
    /// machines stay as they are.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`], [`Error::StalePlay`], or a speed that is not finite.
    pub fn set_speed(&mut self, id: PlayId, speed: f32) -> Result<(), Error> {
        bounded("the speed of a clip", &[speed])?;
        let place = id.member.place;
        let Some(index) = self.find_slot(id)? else {
            self.change_waiting(id, |play| play.speed = speed);
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

    /// What a member plays now, layer by layer, the clip that was started first in front. What
    /// waits for its time is not among it, nor what has faded out, nor what state machines play:
    /// where those are depends on their parameters in every frame, and only the device follows
    /// that. [`state_of`](Self::state_of) asks it, and waits.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`].
    pub fn playing(&self, member: Member) -> Result<Vec<Playing>, Error> {
        self.check(member)?;
        let tick = self.clock.tick;
        let slots = self.slots(member.place).iter().enumerate();
        let told =
            slots.filter(|(_, slot)| !faded_out(slot, tick) && slot.machine_instance().is_none());
        let mut all: Vec<_> =
            told.map(|(index, slot)| self.playing_slot(member, index, slot)).collect();
        all.sort_by_key(|(serial, playing)| (playing.layer, *serial));
        Ok(all.into_iter().map(|(_, playing)| playing).collect())
    }

    fn playing_slot(&self, member: Member, index: usize, slot: &Slot) -> (u32, Playing) {
        let tick = self.clock.tick;
        let clip = self.tables.bound_clips().as_slice()[slot.bound_clip as usize].clip;
        let rows = self.tables.clips().as_slice()[clip as usize];
        let started = self.started(member.place, index);
        let ends = slot.end_tick(tick).filter(|_| started.once);
        let time_secs = match slot.mode() {
            SLOT_LIVE => self.live_secs(clip, slot.phase_rate),
            _ => slot.time_at(tick, rows.start_secs, rows.duration_secs),
        };
        let playing = Playing {
            id: started.sample.is_none().then_some(PlayId { member, serial: started.serial }),
            clip: ClipId { crowd: self.number, index: ClipIndex(clip) },
            layer: slot.layer() as usize,
            time_secs,
            weight: slot.weight_at(tick),
            speed: slot.speed(rows.duration_secs),
            ends_in_secs: ends.map(|end| end.saturating_sub(tick) as f64 / TICKS_PER_SEC as f64),
        };
        (started.serial, playing)
    }

    /// Adds a mask for the members of a character.
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

    fn start_of(
        &mut self,
        member: Member,
        clip: ClipId,
        play: Play,
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
        member: Member,
        start: Start,
        secs: f32,
    ) -> Result<PlayId, Error> {
        let due = self.clock.tick.saturating_add(ticks_from_secs(f64::from(secs)));
        self.begin_or_wait(member.place, due, start)?;
        Ok(PlayId { member, serial: start.serial })
    }

    pub(super) fn begin_or_wait(
        &mut self,
        place: u32,
        due: u64,
        start: Start,
    ) -> Result<(), Error> {
        if due > self.clock.tick {
            self.waiting.push(place, due, start);
            return Ok(());
        }
        self.begin(place, start, self.clock.tick)
    }

    /// Starts all that is due at or before a tick, each as of its own.
    pub(super) fn begin_what_is_due(&mut self, tick: u64) -> Result<(), Error> {
        while let Some((due, place, start)) = self.waiting.take_due(tick) {
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
            Action::Steer { at, over_secs } => {
                self.begin_steer(place, &start, (at, over_secs), tick)
            }
        }
    }

    fn begin_clip(
        &mut self,
        place: u32,
        start: &Start,
        (bound, alone): (u32, bool),
        tick: u64,
    ) -> Result<(), Error> {
        let Play { layer, fade_in_secs: secs, .. } = start.play;
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
            usize::from(!inertializes || self.unseen(place, slot.layer(), tick).is_empty());
        if let Some(due) = self.make_room(place, needed, secs, tick, role)? {
            self.waiting.push(place, due, start.at_its_time());
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

    /// Whether what starts is the first to play in layer 0: it then has its weight at once, so that
    /// nobody sees the rest pose by accident.
    pub(super) fn is_first(&self, place: u32, layer: usize, tick: u64) -> bool {
        layer == 0
            && self.slots(place).iter().all(|slot| slot.layer() != 0 || faded_out(slot, tick))
    }

    pub(super) fn duration_secs(&self, bound: u32) -> f32 {
        let clip = self.tables.bound_clips().as_slice()[bound as usize].clip;
        self.tables.clips().as_slice()[clip as usize].duration_secs
    }

    /// Whether a slot is one of a start.
    fn is_of(&self, id: PlayId, index: usize) -> bool {
        let Started { serial, sample, .. } = self.started(id.member.place, index);
        let is_taken = self.slots(id.member.place)[index].bound_clip != NONE;
        serial == id.serial && sample.is_none() && is_taken
    }

    /// The first slot of a start; `None` where it still waits.
    fn find_slot(&self, id: PlayId) -> Result<Option<usize>, Error> {
        self.check_crowd("play", id.member.crowd, id.serial)?;
        self.check(id.member)?;
        let place = id.member.place;
        if let Some(index) = (0..self.slots(place).len()).find(|index| self.is_of(id, *index)) {
            return Ok(Some(index));
        }
        let waits = self.waiting.of(place).any(|(_, start)| start.serial == id.serial);
        if waits { Ok(None) } else { Err(Error::StalePlay) }
    }

    fn change_waiting(&mut self, id: PlayId, change: impl Fn(&mut Play)) {
        self.waiting.change(id.member.place, |_, start| {
            if start.serial == id.serial {
                change(&mut start.play);
            }
        });
    }

    /// When what a layer was last told to play ends.
    fn end_of_layer(&self, place: u32, layer: usize) -> u64 {
        let waiting = self.waiting.of(place).filter(|(_, start)| start.play.layer == layer).last();
        match waiting {
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

    /// When a slot ends, not before `tick`. One that stands at speed 0 never does, until it is set
    /// to run.
    fn end_of(&self, slot: &Slot, tick: u64) -> u64 {
        let has_end = !slot.is_tied() && self.duration_secs(slot.bound_clip) > 0.0;
        if has_end { slot.end_tick(tick).unwrap_or(u64::MAX).max(tick) } else { tick }
    }

    /// Finds anew when what is queued for a member begins, after something before it changed its
    /// end.
    fn time_the_queue(&mut self, place: u32) {
        let mut ends = [0, 1, 2, 3].map(|layer| self.end_of_slots(place, layer));
        let waiting: Vec<_> = self.waiting.of(place).map(|(due, start)| (due, *start)).collect();
        let mut dues = Vec::with_capacity(waiting.len());
        for (due, start) in waiting {
            let due =
                start.follows_after.map_or(due, |gap| ends[start.play.layer].saturating_add(gap));
            ends[start.play.layer] = self.end_of_start(due, &start);
            dues.push(due.max(self.clock.tick + 1));
        }
        let mut dues = dues.into_iter();
        self.waiting.change(place, |due, _| *due = dues.next().unwrap_or(*due));
    }
}
