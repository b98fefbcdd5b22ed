//! Spawning, despawning and drawing of members.

use populace_device::{Instance, MemberLook};
use populace_model::convert::u32_from;
use populace_settings::parts::{Check, Key, Parts};
use rayon::prelude::*;

use super::base::{Base, MemberDetails, MemberState, Members};
use super::{CharacterId, Crowd, MemberId};
use crate::{Error, Placement};

impl Base {
    pub(super) fn add_member(
        &mut self,
        character: CharacterId,
        placement: Placement,
    ) -> Result<MemberId, Error> {
        placement.check()?;
        self.check_room_for(1)?;
        let body = self.character_state(character)?.body;
        let index = self.tables.add_member(body)?;
        let free = MemberState::free(placement);
        let new = MemberDetails { user_data: 0, look: MemberLook::PLAIN, since: self.clock.frame };
        let Members { all, details, .. } = &mut self.members;
        let len = all.len().max(index as usize + 1);
        all.resize(len, free);
        details.resize(len, new);
        let state = &mut all[index as usize];
        let generation = state.generation;
        *state = MemberState { generation, character: Some(character), ..free };
        details[index as usize] = new;
        self.members.count += 1;
        Ok(MemberId::from_parts(Key { crowd: self.number, index, generation }))
    }

    /// Refuses `count` more members than the crowd was built for.
    pub(super) fn check_room_for(&self, count: usize) -> Result<(), Error> {
        let Members { count: present, capacity, .. } = self.members;
        if count <= capacity - present { Ok(()) } else { Err(Error::Full { capacity }) }
    }

    /// Returns whether the member at an index was spawned since the last update. Before the first
    /// update none was: renderers refuse such a crowd, instead of drawing nobody.
    pub(super) fn is_new(&self, member_index: u32) -> bool {
        let frame = self.clock.frame;
        frame > 0 && self.members.details[member_index as usize].since == frame
    }

    /// Returns whether the last update evaluated the member at an index. It left out those that it
    /// hid and those that were spawned since.
    pub(super) fn is_evaluated(&self, member_index: u32) -> bool {
        let index = member_index as usize;
        let is_hidden = self.tables.members().as_slice()[index].is_hidden();
        self.members.details[index].since < self.clock.frame && !is_hidden
    }

    pub(super) fn remove_member(&mut self, member: MemberId) {
        self.tables.remove_member(member.number());
        let state = &mut self.members.all[member.number() as usize];
        state.character = None;
        state.generation = state.generation.wrapping_add(1);
        self.members.count -= 1;
    }
}

impl Crowd {
    /// Adds a member. It shows the rest pose until a clip plays.
    ///
    /// # Errors
    ///
    /// [`Error::Full`], a character of another crowd, or a placement that is not finite.
    pub fn spawn(
        &mut self,
        character: CharacterId,
        placement: Placement,
    ) -> Result<MemberId, Error> {
        let (player, base) = self.state.player();
        let added = base.add_member(character, placement);
        player.set_slot_count(base.members.all.len() * base.tables.slots_per_member());
        added
    }

    /// Removes a member. Its handle goes stale, and members attached to it are detached.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`].
    pub fn despawn(&mut self, member: MemberId) -> Result<(), Error> {
        self.state.despawn(member)
    }

    /// The number of members.
    #[must_use]
    pub fn member_count(&self) -> usize {
        self.state.base.members.count
    }

    /// Iterates over the instances of all members, in the order of [`members`](Self::members).
    pub fn instances(&self) -> impl Iterator<Item = Instance<'_>> {
        self.members().map(|member| member.instance())
    }

    /// Returns the instances of all members, in the order of [`members`](Self::members). Works on
    /// all threads.
    pub(super) fn all_instances(&self) -> Vec<Instance<'_>> {
        let state = &self.state;
        let indices = (0..u32_from(state.base.members.all.len())).into_par_iter();
        indices.filter_map(|index| Some(state.member_at(index)?.instance())).collect()
    }
}
