//! The crowd: members of characters, playing clips on a device.

mod attach;
mod builder;
mod controls;
mod events;
mod hand_over;
mod live;
mod machines;
mod motion;
mod people;
mod playback;
mod readback;
mod roles;
mod room;
mod settling;
mod spaces;
mod stages;
mod waiting;
mod watches;

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use populace_core::layout::{PAGE_ENTRIES, Slot};
use populace_core::{
    Affine, AnimationSet, BodyIndex, Character, Clip, ClipIndex, FIRST_TICK, Frame, GlContext, RoleMap,
    Schedule, TICKS_PER_SEC, Tables, nearest_names,
};

use crate::device::{Engine, Opened};
use crate::split::Kept;
use crate::{Devices, Error, Placement, Split};
use attach::Attached;
use live::Stream;
use machines::Machines;
use motion::Moving;
use room::Started;
use spaces::{Space, Steered};
use stages::UserStages;
use waiting::Waiting;

pub use builder::CrowdBuilder;
use controls::{MemberControls, Watches};
pub use events::{Event, EventKind};
pub use machines::MachineId;
pub use spaces::SpaceId;
pub use stages::StageId;
pub use watches::{Sighting, Watch};

/// A character of a crowd.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CharacterId {
    crowd: u32,
    index: u32,
}

impl CharacterId {
    /// The order in which the character was added, from 0.
    #[must_use]
    pub const fn index(self) -> usize {
        self.index as usize
    }
}

/// A clip of a crowd. Any member can play it: it drives the joints whose names it knows, and moves other bodies by their
/// humanoid roles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ClipId {
    crowd: u32,
    index: ClipIndex,
}

/// A mask of a crowd, for the members of one character.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MaskId {
    character: CharacterId,
    first: u32,
}

/// A handle to a member. It goes stale when the member is despawned, and is then refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Member {
    crowd: u32,
    place: u32,
    generation: u32,
}

impl Member {
    /// A number below the crowd's capacity: that of no other member while this one is there. Users' stages get it.
    #[must_use]
    pub const fn number(self) -> u32 {
        self.place
    }
}

/// A handle to a clip or a state machine that was started on a member. It goes stale once another clip has taken its slot, which happens
/// after it has faded out, and when it was to start later and something else was started in its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PlayId {
    member: Member,
    serial: u32,
}

/// What a renderer needs to draw one member.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// The member.
    pub member: Member,
    /// Its character.
    pub character: CharacterId,
    /// Where it was placed.
    pub world_from_model: Affine,
    /// How far from there its clips have moved it, in metres of the world, as far as was known when palettes were last taken:
    /// the palette has it there already.
    pub moved: [f32; 3],
    /// Its first palette entry: page times [`PAGE_ENTRIES`] plus the place within the page.
    pub palette_first: u32,
}

/// The longest step of the clock; a longer one is a mistake.
const MAX_STEP_SECS: f32 = 1e6;

/// Time in whole ticks, with what is left over.
#[derive(Clone, Copy, Debug)]
struct Clock {
    tick: u64,
    left_over: f64,
}

impl Default for Clock {
    fn default() -> Self {
        Self { tick: FIRST_TICK, left_over: 0.0 }
    }
}

struct CharacterState {
    character: Arc<Character>,
    body: BodyIndex,
    /// Found by name, or given.
    roles: Option<RoleMap>,
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
    number: u32,
    devices: Devices,
    opened: Opened,
    /// What devices are opened for.
    gl: Option<Arc<dyn GlContext>>,
    tables: Tables,
    clips: AnimationSet,
    characters: Vec<CharacterState>,
    bound_clips: HashMap<(BodyIndex, ClipIndex), u32>,
    /// Of the skeletons that clips were made for, where given.
    clip_roles: HashMap<ClipIndex, RoleMap>,
    /// Of live clips that poses have come into.
    streams: HashMap<ClipIndex, Stream>,
    members: Vec<MemberState>,
    /// Of members that more than clips move, by place.
    controls: HashMap<u32, MemberControls>,
    watches: Watches,
    /// Of members that are attached to others or bear some, by place.
    attachments: HashMap<u32, Attached>,
    stages: UserStages,
    /// Watches that bring joints to the host.
    readers: HashSet<Watch>,
    /// Members of whom is told what happens.
    listening: Vec<Member>,
    /// Moments of clips that were asked for.
    marks: HashMap<ClipIndex, Vec<events::Mark>>,
    /// What happened in the last update.
    events: Vec<Event>,
    /// Slots of members that are listened to which were left in the course of an update, and when.
    left: Vec<(u32, Slot, u64)>,
    /// What another device kept of members, for the next one.
    kept: Option<Kept>,
    /// Where devices have the lengths of joints, by those.
    proportions: HashMap<Vec<u32>, u32>,
    member_count: usize,
    capacity: usize,
    clock: Clock,
    /// Beside each slot of the tables.
    started: Vec<Started>,
    last_serial: u32,
    /// How often a member's motion has begun.
    motions: u32,
    /// Members that their clips move, by place.
    moving: HashMap<u32, Moving>,
    waiting: Waiting,
    spaces: Vec<Space>,
    /// The blend space that a member plays, by its place.
    steered: HashMap<u32, Steered>,
    machines: Machines,
}

impl Crowd {
    /// Settings to build a crowd from.
    #[must_use]
    pub fn builder() -> CrowdBuilder {
        CrowdBuilder::default()
    }

    /// The devices in use.
    #[must_use]
    pub fn devices(&self) -> &Devices {
        &self.devices
    }

    /// The devices' own names, for people.
    #[must_use]
    pub fn device_name(&self) -> String {
        self.opened.backend().device_name()
    }

    /// The share of the members that each device takes, of 1 in all; measured ones change from frame to frame.
    #[must_use]
    pub fn shares(&self) -> Vec<f64> {
        match &self.opened.engine {
            Engine::Alone(_) => vec![1.0],
            Engine::Split(backend) => backend.shares().to_vec(),
        }
    }

    /// Lets the devices share the members in another way, from the next update on.
    ///
    /// # Errors
    ///
    /// [`Error::BadSplit`] for one that does not fit the devices; the split then stays as it is.
    pub fn set_split(&mut self, split: &Split) -> Result<(), Error> {
        let shares = split.shares(&self.devices)?;
        if let Engine::Split(backend) = &mut self.opened.engine {
            backend.set_shares(shares);
        }
        Ok(())
    }

    /// How stages are mapped to work-items.
    #[must_use]
    pub fn schedule(&self) -> Schedule {
        self.opened.backend().schedule()
    }

    /// Moves the crowd to another device or to several, after one was lost or to compare them. Members, clips and clock
    /// go on. Several share the members by their measured speed, until [`set_split`](Self::set_split) says otherwise.
    ///
    /// # Errors
    ///
    /// A device that is not there or cannot be opened, or that cannot run a user's stage, or [`Error::BadDevices`]; the
    /// crowd then stays where it is.
    pub fn move_to(&mut self, devices: impl Into<Devices>) -> Result<(), Error> {
        let devices = devices.into();
        let mut opened = devices.open(self.schedule(), &Split::Measured, self.gl.as_ref())?;
        opened.backend_mut().set_stages(self.stages.as_slice())?;
        // What the device before this one kept is still here where this one has run no frame.
        if self.kept.is_none() {
            self.kept = Some(Kept::read_all(self.opened.backend_mut(), &self.tables));
        }
        self.opened = opened;
        self.devices = devices;
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
        let id = CharacterId { crowd: self.number, index: u32_from(self.characters.len()) };
        let clips = character.clips.clone();
        let roles = RoleMap::detect(&character.skeleton);
        self.characters.push(CharacterState { character, body, roles, clips: Vec::new() });
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
        let id = ClipId { crowd: self.number, index: self.clips.add(clip) };
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
        let named = state.clips.iter().filter_map(|id| Some((self.clips.get(id.index)?.name(), *id)));
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
        Ok(ids.filter_map(|id| Some((*id, Arc::clone(self.clips.get(id.index)?)))).collect())
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
            self.started.resize(self.members.len() * self.tables.slots_per_member(), Started::default());
        }
        let state = &mut self.members[place as usize];
        state.character = Some(character);
        state.placement = placement;
        self.member_count += 1;
        Ok(Member { crowd: self.number, place, generation: state.generation })
    }

    /// Removes a member; its handle goes stale. What is attached to it falls off.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`].
    pub fn despawn(&mut self, member: Member) -> Result<(), Error> {
        self.detach_all(member)?;
        self.forget_motion(member);
        self.forget_controls(member);
        self.tables.remove_member(member.place);
        self.waiting.retain(member.place, |_| false);
        self.steered.remove(&member.place);
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

    /// Places a member, and what is attached to it. If its clips move it, they do so from there on.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`], a placement that is not finite, or [`Error::BadAttachment`] for a member that is attached to
    /// another.
    pub fn place(&mut self, member: Member, placement: Placement) -> Result<(), Error> {
        self.check(member)?;
        placement.check()?;
        self.check_placeable(member)?;
        self.begin_motion_anew(member)?;
        self.members[member.place as usize].placement = placement;
        self.stand(member)?;
        self.bring_props(member)
    }

    /// Where a member was placed; [`moved`](Self::moved) tells where its clips have moved it from there.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`].
    pub fn placement(&self, member: Member) -> Result<Placement, Error> {
        self.check(member)?;
        Ok(self.members[member.place as usize].placement)
    }

    /// The character that a member is one of.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`].
    pub fn character_of(&self, member: Member) -> Result<CharacterId, Error> {
        self.check(member)
    }

    /// Moves the clock on, starts what was to start by then, and evaluates every member.
    ///
    /// # Errors
    ///
    /// A time that is negative or not finite, or a failing device; the crowd's state survives that, see
    /// [`move_to`](Self::move_to).
    pub fn update(&mut self, dt_secs: f32) -> Result<(), Error> {
        if !(0.0..=MAX_STEP_SECS).contains(&dt_secs) {
            let rule = "from 0 to 1,000,000 seconds";
            return Err(Error::BadValue { what: "the time step", value: dt_secs, rule });
        }
        let ticks = f64::from(dt_secs) * TICKS_PER_SEC as f64 + self.clock.left_over;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "not negative; `as` saturates"
        )]
        let whole = ticks.round().max(0.0) as u64;
        let clock = Clock { tick: self.clock.tick.wrapping_add(whole), left_over: ticks - whole as f64 };
        self.begin_what_is_due(clock.tick)?;
        self.opened.backend_mut().update(&self.tables)?;
        self.tables.mark_clean();
        if let Some(kept) = &self.kept {
            kept.write(self.opened.backend_mut(), &self.tables)?;
        }
        let frame = Frame::of_all(clock.tick).after_ticks(u32::try_from(whole).unwrap_or(u32::MAX));
        self.opened.backend_mut().run(&self.tables, frame)?;
        self.kept = None;
        self.find_events(self.clock.tick, clock.tick);
        self.clock = clock;
        if !self.readers.is_empty() {
            self.opened.backend_mut().fetch_watched(&self.tables, clock.tick)?;
        }
        Ok(())
    }

    /// Waits until the device has done all its work.
    ///
    /// # Errors
    ///
    /// A failing device.
    pub fn finish(&mut self) -> Result<(), Error> {
        Ok(self.opened.backend_mut().finish()?)
    }

    /// What to draw, in order of the members' places.
    pub fn instances(&self) -> impl Iterator<Item = Instance> + '_ {
        let members = self.members.iter().zip(self.tables.members().as_slice());
        members.zip(0u32..).filter_map(|((state, member), place)| {
            Some(Instance {
                member: Member { crowd: self.number, place, generation: state.generation },
                character: state.character?,
                world_from_model: state.placement.world_from_model(),
                moved: self.shift_of(place),
                palette_first: member.palette_first,
            })
        })
    }

    /// Pages of palettes in use.
    #[must_use]
    pub fn page_count(&self) -> usize {
        self.tables.palette_places().div_ceil(PAGE_ENTRIES as usize)
    }

    fn check_crowd(&self, what: &'static str, crowd: u32, index: u32) -> Result<(), Error> {
        if crowd == self.number { Ok(()) } else { Err(Error::UnknownId { what, index }) }
    }

    fn character_state(&self, id: CharacterId) -> Result<&CharacterState, Error> {
        self.check_crowd("character", id.crowd, id.index)?;
        self.characters.get(id.index()).ok_or(Error::UnknownId { what: "character", index: id.index })
    }

    fn character_state_mut(&mut self, id: CharacterId) -> Result<&mut CharacterState, Error> {
        self.check_crowd("character", id.crowd, id.index)?;
        self.characters.get_mut(id.index()).ok_or(Error::UnknownId { what: "character", index: id.index })
    }

    fn check(&self, member: Member) -> Result<CharacterId, Error> {
        let ours = |s: &&MemberState| member.crowd == self.number && s.generation == member.generation;
        let state = self.members.get(member.place as usize).filter(ours);
        state.and_then(|s| s.character).ok_or(Error::StaleMember)
    }
}

#[expect(clippy::cast_possible_truncation, reason = "counts of characters and layers, far below 2^32")]
fn u32_from(index: usize) -> u32 {
    index as u32
}

#[cfg(test)]
mod tests;
