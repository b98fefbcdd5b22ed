//! The crowd: members of characters, playing clips on a device.

mod attach;
mod bindings;
mod builder;
mod characters;
mod controls;
mod devices;
mod events;
mod hand_over;
mod inertialization;
mod live;
mod machines;
mod members;
mod motion;
mod people;
mod playback;
mod readback;
mod roles;
mod room;
mod spaces;
mod stages;
mod waiting;
mod watches;

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use populace_character::Character;
use populace_clip::{AnimationSet, ClipIndex, FIRST_TICK, TICKS_PER_SEC};
use populace_device::layout::{PAGE_ENTRIES, Slot};
use populace_device::{BackendError, BodyIndex, Frame, GlContext, Tables};
use populace_model::RoleMap;
use populace_model::convert::u32_from;

use crate::device::Opened;
use crate::split::Kept;
use crate::{Devices, Error, Placement};
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
pub use members::Instance;
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

/// A clip of a crowd. Any member can play it: it drives the joints whose names it knows, and moves
/// other bodies by their humanoid roles.
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
    /// A number below the crowd's capacity: that of no other member while this one is there. Users'
    /// stages get it.
    #[must_use]
    pub const fn number(self) -> u32 {
        self.place
    }
}

/// A handle to a clip or a state machine that was started on a member. It goes stale once another
/// clip has taken its slot, which happens after it has faded out, and when it was to start later
/// and something else was started in its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PlayId {
    member: Member,
    serial: u32,
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
    /// The number of updates when it came.
    since: u64,
}

/// Members of characters, playing clips on a device.
pub struct Crowd {
    number: u32,
    devices: Devices,
    opened: Opened,
    /// Why it is the native device, where none was named.
    fallback: Option<String>,
    /// What devices are opened for.
    gl: Option<Arc<dyn GlContext>>,
    tables: Tables,
    clips: AnimationSet,
    characters: Vec<CharacterState>,
    bound_clips: HashMap<(BodyIndex, ClipIndex), bindings::Bound>,
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
    /// Watches that bring joints to the host, by serial number, and the clock when each began.
    readers: BTreeMap<u32, (Watch, u64)>,
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
    /// Updates that evaluated all members.
    frame: u64,
    /// Whether the device holds the results of the last of them.
    is_readable: bool,
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

    /// Moves the clock on, starts what was to start by then, and evaluates every member.
    ///
    /// # Errors
    ///
    /// A time that is negative or not finite, or a failing device; the crowd's state survives that,
    /// see [`move_to`](Self::move_to).
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
        let clock =
            Clock { tick: self.clock.tick.wrapping_add(whole), left_over: ticks - whole as f64 };
        self.begin_what_is_due(clock.tick)?;
        self.tables.check_ranges()?;
        self.is_readable = false;
        if let Some(kept) = &mut self.kept {
            kept.forget_new_watched(&self.tables);
        }
        self.opened.backend_mut().update(&self.tables)?;
        self.tables.mark_clean();
        if let Some(kept) = &self.kept {
            kept.write(self.opened.backend_mut(), &self.tables)?;
        }
        let frame = Frame::of_all(clock.tick).after_ticks(u32::try_from(whole).unwrap_or(u32::MAX));
        self.opened.backend_mut().run(&self.tables, frame)?;
        self.kept = None;
        (self.is_readable, self.frame) = (true, self.frame + 1);
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

    /// Pages of palettes in use.
    #[must_use]
    pub fn page_count(&self) -> usize {
        self.tables.palette_places().div_ceil(PAGE_ENTRIES as usize)
    }

    fn check_crowd(&self, what: &'static str, crowd: u32, index: u32) -> Result<(), Error> {
        if crowd == self.number { Ok(()) } else { Err(Error::UnknownId { what, index }) }
    }

    /// Refuses to read where the device holds no results of the last update.
    fn check_readable(&self) -> Result<(), BackendError> {
        if self.is_readable { Ok(()) } else { Err(BackendError::NotEvaluated) }
    }

    fn check(&self, member: Member) -> Result<CharacterId, Error> {
        self.check_crowd("member", member.crowd, member.place)?;
        let same = |s: &&MemberState| s.generation == member.generation;
        let state = self.members.get(member.place as usize).filter(same);
        state.and_then(|s| s.character).ok_or(Error::StaleMember)
    }
}

#[cfg(test)]
mod tests;
