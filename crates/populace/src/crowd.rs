//! The crowd: members of characters, playing clips on a device.

use std::collections::HashMap;
use std::sync::Arc;

use populace_core::layout::{Body, Float4, Layer, NONE, PAGE_ENTRIES, Slot};
use populace_core::{
    Affine, AnimationSet, Backend, Binding, BodyIndex, Character, Clip, ClipIndex, Frame, LayerSettings,
    Mask, Stage, StageBuffer, TICKS_PER_SEC, Tables, Trs,
};

use crate::error::nearest_names;
use crate::play::{Mode, check_layer, check_secs, check_weight};
use crate::{Device, Error, Placement, Play};

/// A character of a crowd.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CharacterId(u32);

impl CharacterId {
    /// The order in which the character was added, from 0.
    #[must_use]
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

/// A clip of a crowd. Any member can play it; it drives the joints whose names it knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ClipId(ClipIndex);

/// A mask of a crowd, for the members of one character.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MaskId {
    character: CharacterId,
    first: u32,
}

/// A handle to a member. It goes stale when the member is despawned, and is then refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Member {
    place: u32,
    generation: u32,
}

/// What a renderer needs to draw one member.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// The member.
    pub member: Member,
    /// Its character.
    pub character: CharacterId,
    /// Where it stands.
    pub world_from_model: Affine,
    /// Its first palette entry: page times [`PAGE_ENTRIES`] plus the place within the page.
    pub palette_first: u32,
}

/// Settings of a crowd to be built.
#[derive(Clone, Copy, Debug)]
pub struct CrowdBuilder {
    device: Option<Device>,
    capacity: usize,
    slots_per_member: usize,
}

impl CrowdBuilder {
    /// The device to evaluate on; [`Device::best`] unless named.
    #[must_use]
    pub fn device(mut self, device: Device) -> Self {
        self.device = Some(device);
        self
    }

    /// The most members there may be at once; 1,000 unless set.
    #[must_use]
    pub fn capacity(mut self, members: usize) -> Self {
        self.capacity = members;
        self
    }

    /// Clips that a member can play at once, 1 to 8; 4 unless set.
    #[must_use]
    pub fn slots_per_member(mut self, slots: usize) -> Self {
        self.slots_per_member = slots;
        self
    }

    /// Opens the device.
    ///
    /// # Errors
    ///
    /// A device that is not there or cannot be opened.
    pub fn build(self) -> Result<Crowd, Error> {
        let device = self.device.unwrap_or_else(Device::best);
        Ok(Crowd {
            device,
            backend: device.open()?,
            tables: Tables::new(self.slots_per_member),
            clips: AnimationSet::default(),
            characters: Vec::new(),
            bound_clips: HashMap::new(),
            members: Vec::new(),
            member_count: 0,
            capacity: self.capacity,
            clock: Clock::default(),
        })
    }
}

/// Time in whole ticks, with what is left over.
#[derive(Clone, Copy, Debug, Default)]
struct Clock {
    tick: u64,
    left_over: f64,
}

struct CharacterState {
    character: Arc<Character>,
    body: BodyIndex,
    /// The clips that came with the character or were added to it, by name.
    clips: Vec<ClipId>,
}

#[derive(Clone, Copy)]
struct MemberState {
    generation: u32,
    /// `None` while the place is free.
    character: Option<CharacterId>,
    placement: Placement,
}

/// Members of characters, playing clips on a device.
pub struct Crowd {
    device: Device,
    backend: Box<dyn Backend>,
    tables: Tables,
    clips: AnimationSet,
    characters: Vec<CharacterState>,
    bound_clips: HashMap<(BodyIndex, ClipIndex), u32>,
    members: Vec<MemberState>,
    member_count: usize,
    capacity: usize,
    clock: Clock,
}

impl Crowd {
    /// Settings to build a crowd from.
    #[must_use]
    pub fn builder() -> CrowdBuilder {
        CrowdBuilder { device: None, capacity: 1000, slots_per_member: 4 }
    }

    /// The device in use.
    #[must_use]
    pub fn device(&self) -> Device {
        self.device
    }

    /// The device's own name, for people.
    #[must_use]
    pub fn device_name(&self) -> String {
        self.backend.device_name()
    }

    /// How stages are mapped to work-items.
    #[must_use]
    pub fn schedule(&self) -> &'static str {
        self.backend.schedule()
    }

    /// Moves the crowd to another device, after one was lost or to compare them. Members, clips and clock go on.
    ///
    /// # Errors
    ///
    /// A device that is not there or cannot be opened; the crowd then stays where it is.
    pub fn move_to(&mut self, device: Device) -> Result<(), Error> {
        self.backend = device.open()?;
        self.device = device;
        self.tables.mark_dirty();
        Ok(())
    }

    /// Adds a character with its clips.
    ///
    /// # Errors
    ///
    /// More data than devices can address.
    pub fn add_character(&mut self, character: impl Into<Arc<Character>>) -> Result<CharacterId, Error> {
        let character = character.into();
        let body = self.tables.add_body(&character.skeleton, &character.palette)?;
        let id = CharacterId(u32_from(self.characters.len()));
        let clips = character.clips.clone();
        self.characters.push(CharacterState { character, body, clips: Vec::new() });
        for clip in &clips {
            self.add_clip(id, clip)?;
        }
        Ok(id)
    }

    /// Adds a clip for a character to find by name, at any time; other characters can play it too.
    ///
    /// # Errors
    ///
    /// A character of another crowd, or more data than devices can address.
    pub fn add_clip(&mut self, character: CharacterId, clip: &Arc<Clip>) -> Result<ClipId, Error> {
        self.character_state(character)?;
        if self.clips.find(clip).is_none() {
            self.tables.add_clip(clip)?; // in the set's order, so that one index names a clip in both
        }
        let id = ClipId(self.clips.add(clip));
        let clips = &mut self.character_state_mut(character)?.clips;
        if !clips.contains(&id) {
            clips.push(id);
        }
        Ok(id)
    }

    /// The character of an id.
    ///
    /// # Errors
    ///
    /// A character of another crowd.
    pub fn character(&self, character: CharacterId) -> Result<&Arc<Character>, Error> {
        Ok(&self.character_state(character)?.character)
    }

    /// A character's clip of a name.
    ///
    /// # Errors
    ///
    /// [`Error::UnknownClip`] with the nearest names.
    pub fn clip(&self, character: CharacterId, name: &str) -> Result<ClipId, Error> {
        let state = self.character_state(character)?;
        let named = state.clips.iter().filter_map(|id| Some((self.clips.get(id.0)?.name(), *id)));
        named.clone().find(|(n, _)| *n == name).map(|(_, id)| id).ok_or_else(|| Error::UnknownClip {
            character: state.character.name.clone(),
            name: name.to_owned(),
            nearest: nearest_names(name, named.map(|(n, _)| n)),
        })
    }

    /// A character's clips, in the order they were added.
    ///
    /// # Errors
    ///
    /// A character of another crowd.
    pub fn clips(&self, character: CharacterId) -> Result<Vec<(ClipId, Arc<Clip>)>, Error> {
        let ids = self.character_state(character)?.clips.iter();
        Ok(ids.filter_map(|id| Some((*id, Arc::clone(self.clips.get(id.0)?)))).collect())
    }

    /// Adds a member. Until a clip plays it stands in the rest pose.
    ///
    /// # Errors
    ///
    /// [`Error::Full`], a character of another crowd, or a placement that is not finite.
    pub fn spawn(&mut self, character: CharacterId, placement: Placement) -> Result<Member, Error> {
        placement.check()?;
        if self.member_count == self.capacity {
            return Err(Error::Full { capacity: self.capacity });
        }
        let body = self.character_state(character)?.body;
        let place = self.tables.add_member(body)?;
        if self.members.len() <= place as usize {
            let free = MemberState { generation: 0, character: None, placement };
            self.members.resize(place as usize + 1, free);
        }
        let state = &mut self.members[place as usize];
        state.character = Some(character);
        state.placement = placement;
        self.member_count += 1;
        Ok(Member { place, generation: state.generation })
    }

    /// Removes a member; its handle goes stale.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`].
    pub fn despawn(&mut self, member: Member) -> Result<(), Error> {
        self.check(member)?;
        self.tables.remove_member(member.place);
        let state = &mut self.members[member.place as usize];
        state.character = None;
        state.generation = state.generation.wrapping_add(1);
        self.member_count -= 1;
        Ok(())
    }

    /// How many members there are.
    #[must_use]
    pub fn member_count(&self) -> usize {
        self.member_count
    }

    /// Places a member.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`], or a placement that is not finite.
    pub fn place(&mut self, member: Member, placement: Placement) -> Result<(), Error> {
        self.check(member)?;
        placement.check()?;
        self.members[member.place as usize].placement = placement;
        Ok(())
    }

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
        self.fade_out(member, layer, fade_out_secs);
        Ok(())
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
        let place = self.tables.layer_range(member.place).start + layer;
        let mask = mask.map_or(NONE, |m| m.first);
        let value = Layer { weight: settings.weight, mask, mode: settings.mode.device_value(), unused: 0 };
        self.tables.layers.set(place, value);
        self.use_layer(member, layer);
        Ok(())
    }

    /// Moves the clock on and evaluates every member.
    ///
    /// # Errors
    ///
    /// A time that is negative or not finite, or a failing device; the crowd's state survives that, see
    /// [`move_to`](Self::move_to).
    pub fn update(&mut self, dt_secs: f32) -> Result<(), Error> {
        check_secs("the time step", dt_secs)?;
        let ticks = f64::from(dt_secs) * TICKS_PER_SEC as f64 + self.clock.left_over;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "not negative; `as` saturates"
        )]
        let whole = ticks.round().max(0.0) as u64;
        self.clock = Clock { tick: self.clock.tick.wrapping_add(whole), left_over: ticks - whole as f64 };
        self.evaluate()
    }

    fn evaluate(&mut self) -> Result<(), Error> {
        self.backend.update(&self.tables)?;
        self.tables.mark_clean();
        Ok(self.backend.run(&self.tables, Frame { tick: self.clock.tick })?)
    }

    /// Waits until the device has done all its work.
    ///
    /// # Errors
    ///
    /// A failing device.
    pub fn finish(&mut self) -> Result<(), Error> {
        Ok(self.backend.finish()?)
    }

    /// What to draw, in order of the members' places.
    pub fn instances(&self) -> impl Iterator<Item = Instance> + '_ {
        let members = self.members.iter().zip(self.tables.members.as_slice());
        members.zip(0u32..).filter_map(|((state, member), place)| {
            Some(Instance {
                member: Member { place, generation: state.generation },
                character: state.character?,
                world_from_model: state.placement.world_from_model(),
                palette_first: member.palette_first,
            })
        })
    }

    /// Pages of palettes in use.
    #[must_use]
    pub fn page_count(&self) -> usize {
        self.tables.palette_places().div_ceil(PAGE_ENTRIES as usize)
    }

    /// Hands a page of palettes to `reader`, three elements for each palette entry, waiting for the last update.
    /// Where the device shares memory with the host, nothing is copied.
    ///
    /// # Errors
    ///
    /// A page that is not in use, or a failing device.
    pub fn with_page(&mut self, page: usize, reader: &mut dyn FnMut(&[Float4])) -> Result<(), Error> {
        Ok(self.backend.with_page(page, reader)?)
    }

    /// A member's matrix palette after the last update: `model_from_bind`, one for each palette entry. Waits for it.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`], or a failing device.
    pub fn palette(&mut self, member: Member) -> Result<Vec<Affine>, Error> {
        let (row, body) = self.device_member(member)?;
        let mut elements = vec![Float4::default(); body.entry_count as usize * 3];
        self.backend.read(StageBuffer::Palette, row.palette_first as usize * 3, &mut elements)?;
        Ok(elements.as_chunks::<3>().0.iter().map(|rows| Affine { rows: rows.map(|r| r.0) }).collect())
    }

    /// A member's joints in model space after the last update, in level order. Waits for it.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`], or a failing device.
    pub fn model_from_joints(&mut self, member: Member) -> Result<Vec<Affine>, Error> {
        let buffers = [StageBuffer::ModelRow0, StageBuffer::ModelRow1, StageBuffer::ModelRow2];
        let [a, b, c] = self.read_joints(member, buffers)?;
        Ok(a.iter().zip(&b).zip(&c).map(|((a, b), c)| Affine { rows: [a.0, b.0, c.0] }).collect())
    }

    /// A member's local transforms after the last update, in level order. Waits for it.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`], or a failing device.
    pub fn local_pose(&mut self, member: Member) -> Result<Vec<Trs>, Error> {
        let buffers = [StageBuffer::Translations, StageBuffer::Rotations, StageBuffer::Scales];
        let [t, r, s] = self.read_joints(member, buffers)?;
        let joints = t.iter().zip(&r).zip(&s);
        Ok(joints.map(|((t, r), s)| Trs { translation: t.xyz(), rotation: r.0, scale: s.xyz() }).collect())
    }

    /// Milliseconds that each stage of the last update took on the device, where it measures that.
    pub fn stage_times_ms(&mut self) -> Vec<(Stage, f64)> {
        self.backend.stage_times_ms()
    }

    /// Milliseconds that writing every palette with a constant takes: the floor under an update, for benchmarks. The
    /// palettes are wrong until the next update.
    ///
    /// # Errors
    ///
    /// A failing device.
    pub fn write_floor(&mut self) -> Result<f64, Error> {
        Ok(self.backend.write_floor(&self.tables)?)
    }

    /// Bytes that the device holds for this crowd.
    #[must_use]
    pub fn device_memory_bytes(&self) -> usize {
        self.backend.memory_bytes()
    }

    fn read_joints(&mut self, member: Member, buffers: [StageBuffer; 3]) -> Result<[Vec<Float4>; 3], Error> {
        let (row, body) = self.device_member(member)?;
        let mut arrays = [(); 3].map(|()| vec![Float4::default(); body.joint_count as usize]);
        for (buffer, array) in buffers.into_iter().zip(&mut arrays) {
            self.backend.read(buffer, row.joint_first as usize, array)?;
        }
        Ok(arrays)
    }

    fn device_member(&self, member: Member) -> Result<(populace_core::layout::Member, Body), Error> {
        self.check(member)?;
        let row = self.tables.members.as_slice()[member.place as usize];
        Ok((row, self.tables.bodies.as_slice()[row.body as usize]))
    }

    fn character_state(&self, id: CharacterId) -> Result<&CharacterState, Error> {
        self.characters.get(id.index()).ok_or(Error::UnknownId { what: "character", index: id.0 })
    }

    fn character_state_mut(&mut self, id: CharacterId) -> Result<&mut CharacterState, Error> {
        self.characters.get_mut(id.index()).ok_or(Error::UnknownId { what: "character", index: id.0 })
    }

    fn check(&self, member: Member) -> Result<CharacterId, Error> {
        let state = self.members.get(member.place as usize).filter(|s| s.generation == member.generation);
        state.and_then(|s| s.character).ok_or(Error::StaleMember)
    }

    fn start(&mut self, member: Member, clip: ClipId, play: Play, alone: bool) -> Result<(), Error> {
        let character = self.check(member)?;
        play.check()?;
        let bound = self.bind(character, clip)?;
        let tick = self.clock.tick;
        let weighs = |slot: &Slot| slot.bound_clip != NONE && slot.layer == 0 && !faded_out(slot, tick);
        let first = play.layer == 0 && !self.slots(member).iter().any(weighs);
        if alone {
            self.fade_out(member, play.layer, play.fade_in_secs);
        }
        let rows = self.tables.clips.as_slice()[clip.0.0 as usize];
        let (start, duration) = (rows.start_secs, rows.duration_secs);
        let mut slot = match play.mode {
            Mode::Looping => Slot::looping(bound, tick, duration, f64::from(play.phase), play.speed),
            Mode::Once => Slot::once(bound, tick, start, duration, play.speed),
            Mode::Held { secs } => Slot::held(bound, tick, secs),
        };
        slot.layer = u32_from(play.layer);
        slot.ramp_weight(tick, 0.0, play.weight, if first { 0.0 } else { play.fade_in_secs });
        let place = self.weakest_slot(member);
        self.tables.slots.set(place, slot);
        self.use_layer(member, play.layer);
        Ok(())
    }

    fn bind(&mut self, character: CharacterId, clip: ClipId) -> Result<u32, Error> {
        let state = self.character_state(character)?;
        let key = (state.body, clip.0);
        if let Some(&bound) = self.bound_clips.get(&key) {
            return Ok(bound);
        }
        let known = self.clips.get(clip.0).ok_or(Error::UnknownId { what: "clip", index: clip.0.0 })?;
        let binding = Binding::new(known, &state.character.skeleton);
        let bound = self.tables.add_bound_clip(clip.0.0, &binding)?;
        self.bound_clips.insert(key, bound);
        Ok(bound)
    }

    fn slots(&self, member: Member) -> &[Slot] {
        &self.tables.slots.as_slice()[self.tables.slot_range(member.place)]
    }

    fn fade_out(&mut self, member: Member, layer: usize, secs: f32) {
        let tick = self.clock.tick;
        for place in self.tables.slot_range(member.place) {
            let mut slot = self.tables.slots.as_slice()[place];
            if slot.bound_clip != NONE && slot.layer as usize == layer && slot.end_weight > 0.0 {
                slot.ramp_weight(tick, slot.weight_at(tick), 0.0, secs);
                self.tables.slots.set(place, slot);
            }
        }
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
        let range = self.tables.slot_range(member.place);
        let slots = self.tables.slots.as_slice();
        range
            .clone()
            .min_by(|&a, &b| strength(&slots[a]).total_cmp(&strength(&slots[b])))
            .unwrap_or(range.start)
    }

    fn use_layer(&mut self, member: Member, layer: usize) {
        let mut row = self.tables.members.as_slice()[member.place as usize];
        if row.layer_count <= u32_from(layer) {
            row.layer_count = u32_from(layer) + 1;
            self.tables.members.set(member.place as usize, row);
        }
    }
}

/// Whether a slot's weight has come down to 0 and stays there.
fn faded_out(slot: &Slot, tick: u64) -> bool {
    slot.end_weight <= 0.0 && slot.weight_at(tick) <= 0.0
}

#[expect(clippy::cast_possible_truncation, reason = "counts of characters and layers, far below 2^32")]
fn u32_from(index: usize) -> u32 {
    index as u32
}
