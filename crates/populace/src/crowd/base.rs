//! The data that all subsystems of a crowd work on: tables, clock, assets and members.

mod bindings;
mod characters;
mod reach;
mod roles;

use std::collections::HashMap;
use std::sync::Arc;

use populace_character::Character;
use populace_clip::{Clip, FIRST_TICK};
use populace_device::layout::Slot;
use populace_device::{BodyIndex, MemberLook, Place, Tables, View, Visibility};
use populace_model::RoleMap;
use populace_settings::parts::{Key, Parts};
use rustc_hash::FxHashMap;

use super::slab::Slab;
use crate::{CharacterId, ClipId, Error, IdKind, MemberId, Placement};
use bindings::Bound;
pub(super) use reach::Reach;

/// The tables, the clock, the assets and the members of a crowd.
#[derive(Clone)]
pub(super) struct Base {
    /// The crowd's number, which its ids carry.
    pub(super) number: u32,
    pub(super) tables: Tables,
    pub(super) clock: Clock,
    pub(super) assets: Assets,
    pub(super) members: Members,
    pub(super) view: Option<View>,
    /// Whether the members were chosen for a view in the last update.
    pub(super) is_viewed: bool,
}

/// Time in whole ticks, and the remaining fraction of a tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clock {
    pub(super) tick: u64,
    pub(super) left_over: f64,
    /// The number of updates.
    pub(super) frame: u64,
    /// The ticks of the latest updates and the number of updates with each.
    recent: [(u64, u64); RECENT],
}

/// Updates whose ticks are known. Results on their way to the host are of one of these.
const RECENT: usize = 8;

impl Clock {
    /// Ends an update at a tick.
    pub(super) fn end_frame(&mut self, tick: u64, left_over: f64) {
        (self.tick, self.left_over) = (tick, left_over);
        self.frame += 1;
        self.recent.rotate_right(1);
        self.recent[0] = (tick, self.frame);
    }

    /// Returns the number of updates with the earliest of the recent ones at a tick; `None` if
    /// there is none. Jumps back in time make ticks smaller, but not this number.
    pub(super) fn frame_of(&self, tick: u64) -> Option<u64> {
        let at_tick = self.recent.iter().filter(|(of, frame)| *of == tick && *frame > 0);
        at_tick.map(|(_, frame)| *frame).min()
    }
}

/// The index of a clip in the tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct ClipIndex(pub(super) u32);

impl ClipIndex {
    pub(super) fn of(clip: ClipId) -> Self {
        Self(clip.parts().index)
    }
}

/// Characters and clips, and the bindings between them.
#[derive(Clone, Default)]
pub(super) struct Assets {
    /// By their index in the tables.
    pub(super) clips: Slab<Arc<Clip>>,
    pub(super) characters: Slab<CharacterState>,
    pub(super) bound_clips: FxHashMap<(BodyIndex, ClipIndex), Bound>,
    /// Bound clips that were replaced after roles had changed. Slots may still play them.
    pub(super) replaced: Vec<((BodyIndex, ClipIndex), Bound)>,
    /// Roles of the skeletons that clips were made for, where set.
    pub(super) clip_roles: HashMap<ClipIndex, RoleMap>,
}

#[derive(Clone)]
pub(super) struct CharacterState {
    pub(super) character: Arc<Character>,
    pub(super) body: BodyIndex,
    /// The reduced body that each level of detail evaluates, counted from 1; 0 for the whole one.
    pub(super) reduced_of_level: Vec<u32>,
    /// Around all poses of the clips that were bound to it so far, except for live ones.
    pub(super) reach: Reach,
    /// Detected from joint names, or set.
    pub(super) roles: Option<RoleMap>,
    /// The clips that came with the character or were added to it.
    pub(super) clips: Vec<ClipId>,
    /// The first weight of each mask in the tables.
    pub(super) masks: Slab<u32>,
}

/// Members by index, and the limit of their number.
#[derive(Clone)]
pub(super) struct Members {
    pub(super) all: Vec<MemberState>,
    /// One for each of `all`.
    pub(super) details: Vec<MemberDetails>,
    pub(super) count: usize,
    pub(super) capacity: usize,
}

/// State of a member that every update reads.
#[derive(Clone, Copy)]
pub(super) struct MemberState {
    pub(super) generation: u32,
    /// `None` while the index is free.
    pub(super) character: Option<CharacterId>,
    pub(super) placement: Placement,
    /// True if root motion moves the member.
    pub(super) moves: bool,
    pub(super) seen: Seen,
}

/// State of a member that updates do not read. It is stored apart, because the choice of levels
/// waits for memory and reads half as much without it.
#[derive(Clone, Copy)]
pub(super) struct MemberDetails {
    pub(super) user_data: u64,
    pub(super) look: MemberLook,
    /// The number of updates when the member was spawned.
    pub(super) since: u64,
}

/// What a member is seen as in the present view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Seen {
    pub(super) visibility: Visibility,
    pub(super) level: u32,
}

impl MemberState {
    /// Returns the state of an index that was never used.
    pub(super) fn free(placement: Placement) -> Self {
        Self { generation: 0, character: None, placement, moves: false, seen: Seen::default() }
    }
}

impl Base {
    pub(super) fn new(number: u32, slots_per_member: usize, capacity: usize) -> Self {
        Self {
            number,
            tables: Tables::with_capacity(slots_per_member, capacity),
            clock: Clock { tick: FIRST_TICK, left_over: 0.0, frame: 0, recent: [(0, 0); RECENT] },
            assets: Assets::default(),
            members: Members { all: Vec::new(), details: Vec::new(), count: 0, capacity },
            view: None,
            is_viewed: false,
        }
    }

    /// Refuses an id of another crowd.
    pub(super) fn check_crowd(&self, what: IdKind, crowd: u32, index: u32) -> Result<(), Error> {
        if crowd == self.number { Ok(()) } else { Err(Error::UnknownId { what, index }) }
    }

    /// Returns the character of a member, or refuses a stale handle.
    pub(super) fn check(&self, member: MemberId) -> Result<CharacterId, Error> {
        let Key { crowd, index, generation } = member.parts();
        self.check_crowd(IdKind::Member, crowd, index)?;
        match self.members.all.get(index as usize) {
            Some(MemberState { generation: own, character: Some(character), .. })
                if *own == generation =>
            {
                Ok(*character)
            }
            _ => Err(Error::StaleMember),
        }
    }

    /// Returns the handle of the member at an index.
    pub(super) fn member_id(&self, index: u32) -> MemberId {
        let generation = self.members.all[index as usize].generation;
        MemberId::from_parts(Key { crowd: self.number, index, generation })
    }

    /// Returns the handle of the clip at an index.
    pub(super) fn clip_id(&self, index: u32) -> ClipId {
        let generation = self.assets.clips.generation(index);
        ClipId::from_parts(Key { crowd: self.number, index, generation })
    }

    pub(super) fn known_clip(&self, clip: ClipId) -> Result<&Arc<Clip>, Error> {
        let Key { crowd, index, generation } = clip.parts();
        self.check_crowd(IdKind::Clip, crowd, index)?;
        match self.assets.clips.get((index, generation)) {
            Some(known) => Ok(known),
            None => Err(Error::UnknownId { what: IdKind::Clip, index }),
        }
    }

    /// The slots of the member at an index.
    pub(super) fn slots(&self, member_index: u32) -> &[Slot] {
        &self.tables.slots().as_slice()[self.tables.slot_range(member_index)]
    }

    /// The length of a bound clip.
    pub(super) fn duration_secs(&self, bound: u32) -> f32 {
        let clip = self.tables.bound_clips().as_slice()[bound as usize].clip;
        self.tables.clips().as_slice()[clip as usize].duration_secs
    }

    /// Uploads the placement of a member that has a constraint program.
    pub(super) fn upload_placement(&mut self, member: MemberId) -> Result<(), Error> {
        if !self.tables.has_control(member.number()) {
            return Ok(());
        }
        let placement = self.members.all[member.number() as usize].placement;
        let [cos_row, _, _] = placement.scaled(1.0).world_from_model().rows;
        let sin_cos = [cos_row[2], cos_row[0]];
        Ok(self.tables.set_place(member.number(), &place(&placement, sin_cos))?)
    }

    /// Sets the placement of a member, and uploads it if the member has a constraint program. The
    /// one from before must have been uploaded.
    pub(super) fn move_member(
        &mut self,
        member: MemberId,
        placement: Placement,
    ) -> Result<(), Error> {
        let before = &mut self.members.all[member.number() as usize].placement;
        let yaw_rad = std::mem::replace(before, placement).yaw_rad();
        // Most members keep their heading from frame to frame; its sine and cosine stay.
        match self.tables.sin_cos(member.number()) {
            Some(sin_cos) if yaw_rad.to_bits() == placement.yaw_rad().to_bits() => {
                Ok(self.tables.set_place(member.number(), &place(&placement, sin_cos))?)
            }
            Some(_) => self.upload_placement(member),
            None => Ok(()),
        }
    }
}

fn place(placement: &Placement, sin_cos: [f32; 2]) -> Place {
    Place { position: placement.position(), sin_cos, scale: placement.scale() }
}
