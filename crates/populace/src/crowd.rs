//! The crowd: members of characters, playing clips on a device.

mod attach;
mod bindings;
mod blend_spaces;
mod builder;
mod characters;
mod constraints;
mod devices;
mod events;
mod humanoid;
mod inertialization;
mod interop;
mod live;
mod machines;
mod member;
mod members;
mod motion;
mod playback;
mod prepare;
mod readback;
mod roles;
mod scheduled;
mod slots;
mod stages;
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
use crate::ids::{CharacterId, ClipId, MaskId, MemberId, PlaybackId};
use crate::split::Kept;
use crate::{Devices, Error, Placement};
use attach::Attached;
use blend_spaces::{ActiveSpace, Space};
use live::Stream;
use machines::Machines;
use motion::Moving;
use scheduled::ScheduledStarts;
use slots::Started;
use stages::UserStages;

pub use blend_spaces::BlendSpaceId;
pub use builder::CrowdBuilder;
use constraints::{MemberControls, Watches};
pub use events::{Event, EventKind};
pub use machines::MachineId;
pub use member::{MemberMut, MemberRef, MemberView};
pub use members::Instance;
pub use stages::StageId;
pub use watches::{JointReadback, Watch};

/// The longest time step that is accepted, in seconds.
const MAX_STEP_SECS: f32 = 1e6;

/// Time in whole ticks, and the remaining fraction of a tick.
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
    /// Detected from joint names, or set.
    roles: Option<RoleMap>,
    /// The clips that came with the character or were added to it.
    clips: Vec<ClipId>,
}

#[derive(Clone, Copy)]
struct MemberState {
    generation: u32,
    /// `None` while the index is free.
    character: Option<CharacterId>,
    placement: Placement,
    user_data: u64,
    /// The number of updates when the member was spawned.
    since: u64,
}

/// Members of characters, playing clips on a device.
pub struct Crowd {
    number: u32,
    devices: Devices,
    opened: Opened,
    /// The reason for the native device, if no device was selected.
    fallback: Option<String>,
    /// The OpenGL context that devices share buffers with.
    gl: Option<Arc<dyn GlContext>>,
    tables: Tables,
    clips: AnimationSet,
    characters: Vec<CharacterState>,
    bound_clips: HashMap<(BodyIndex, ClipIndex), bindings::Bound>,
    /// Roles of the skeletons that clips were made for, where set.
    clip_roles: HashMap<ClipIndex, RoleMap>,
    /// Streams of the live clips that have received poses.
    streams: HashMap<ClipIndex, Stream>,
    members: Vec<MemberState>,
    /// Constraint programs of members, by member index.
    controls: HashMap<u32, MemberControls>,
    watches: Watches,
    /// Attachments of members, by member index.
    attachments: HashMap<u32, Attached>,
    stages: UserStages,
    /// Watches that copy joints to the host, by serial number, and the tick at which each began.
    readers: BTreeMap<u32, (Watch, u64)>,
    /// Members whose events are reported.
    listening: Vec<MemberId>,
    /// Event markers of clips.
    marks: HashMap<ClipIndex, Vec<events::Mark>>,
    /// Events of the last update.
    events: Vec<Event>,
    /// Slots of members with reported events that were left during an update, and the tick.
    left: Vec<(u32, Slot, u64)>,
    /// History that the previous device held, for the next device.
    kept: Option<Kept>,
    /// The number of updates.
    frame: u64,
    /// Whether the device holds the results of the last update.
    is_readable: bool,
    /// Offsets of bone-length factors on the device, by the bits of the factors.
    proportions: HashMap<Vec<u32>, u32>,
    member_count: usize,
    capacity: usize,
    clock: Clock,
    /// What was started in each slot of the tables.
    started: Vec<Started>,
    last_serial: u32,
    /// The number of times that root motion has begun.
    motions: u32,
    /// Members with root motion, by member index.
    moving: HashMap<u32, Moving>,
    scheduled: ScheduledStarts,
    spaces: Vec<Space>,
    /// The blend space that a member plays, by member index.
    active_space: HashMap<u32, ActiveSpace>,
    machines: Machines,
}

impl Crowd {
    /// Returns the settings from which a crowd is built.
    #[must_use]
    pub fn builder() -> CrowdBuilder {
        CrowdBuilder::default()
    }

    /// Advances the clock by `dt_secs`, starts what is scheduled by then, and evaluates every
    /// member.
    ///
    /// # Errors
    ///
    /// A time that is negative or not finite, or a failing device. The crowd's state survives a
    /// failing device: [`move_to`](Self::move_to) continues on another.
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
        self.begin_due(clock.tick)?;
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

    /// Waits until the device has finished all work.
    ///
    /// # Errors
    ///
    /// A failing device.
    pub fn finish(&mut self) -> Result<(), Error> {
        Ok(self.opened.backend_mut().finish()?)
    }

    /// The number of palette pages in use.
    #[must_use]
    pub fn page_count(&self) -> usize {
        self.tables.palette_places().div_ceil(PAGE_ENTRIES as usize)
    }

    fn check_crowd(&self, what: &'static str, crowd: u32, index: u32) -> Result<(), Error> {
        if crowd == self.number { Ok(()) } else { Err(Error::UnknownId { what, index }) }
    }

    /// Refuses to read if the device holds no results of the last update.
    fn check_readable(&self) -> Result<(), BackendError> {
        if self.is_readable { Ok(()) } else { Err(BackendError::NotEvaluated) }
    }

    fn check(&self, member: MemberId) -> Result<CharacterId, Error> {
        self.check_crowd("member", member.crowd, member.index)?;
        let same = |s: &&MemberState| s.generation == member.generation;
        let state = self.members.get(member.index as usize).filter(same);
        state.and_then(|s| s.character).ok_or(Error::StaleMember)
    }
}

#[cfg(test)]
mod tests;
