//! Spawning, despawning and drawing of members.

use populace_device::Instance;

use super::slots::Started;
use super::{CharacterId, Crowd, MemberId, MemberState};
use crate::{Error, Placement};

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
        placement.check()?;
        if self.member_count == self.capacity {
            return Err(Error::Full { capacity: self.capacity });
        }
        let body = self.character_state(character)?.body;
        let place = self.tables.add_member(body)?;
        if self.members.len() <= place as usize {
            let free =
                MemberState { generation: 0, character: None, placement, user_data: 0, since: 0 };
            self.members.resize(place as usize + 1, free);
            self.started
                .resize(self.members.len() * self.tables.slots_per_member(), Started::default());
        }
        let state = &mut self.members[place as usize];
        state.character = Some(character);
        state.placement = placement;
        state.user_data = 0;
        state.since = self.frame;
        self.member_count += 1;
        Ok(MemberId { crowd: self.number, index: place, generation: state.generation })
    }

    /// Removes a member. Its handle goes stale, and members attached to it are detached.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`].
    pub fn despawn(&mut self, member: MemberId) -> Result<(), Error> {
        self.detach_all(member)?;
        self.forget_watches(member);
        self.forget_motion(member);
        self.forget_controls(member);
        self.tables.remove_member(member.index);
        self.scheduled.retain(member.index, |_| false);
        self.active_space.remove(&member.index);
        let state = &mut self.members[member.index as usize];
        state.character = None;
        state.generation = state.generation.wrapping_add(1);
        self.member_count -= 1;
        Ok(())
    }

    /// The number of members.
    #[must_use]
    pub fn member_count(&self) -> usize {
        self.member_count
    }

    pub(super) fn place(&mut self, member: MemberId, placement: Placement) -> Result<(), Error> {
        self.check(member)?;
        placement.check()?;
        self.check_placeable(member)?;
        self.restart_motion(member)?;
        self.members[member.index as usize].placement = placement;
        self.upload_placement(member)?;
        self.place_children(member)
    }

    /// Returns what a renderer needs to draw a member, without a tint. The root-motion offset is
    /// the one that was known when palettes were last acquired.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`], or [`Error::UnknownId`] for a member of another crowd.
    pub fn instance(&self, member: MemberId) -> Result<Instance<'_>, Error> {
        let character = self.check(member)?;
        Ok(self.instance_at(member.index, character))
    }

    /// Iterates over the [`instance`](Self::instance)s of all members, in the order of
    /// [`members`](Self::members).
    pub fn instances(&self) -> impl Iterator<Item = Instance<'_>> {
        let members = (0u32..).zip(&self.members);
        members.filter_map(|(place, state)| Some(self.instance_at(place, state.character?)))
    }

    fn instance_at(&self, place: u32, character: CharacterId) -> Instance<'_> {
        Instance {
            character: &self.characters[character.index()].character,
            world_from_model: self.members[place as usize].placement.world_from_model(),
            moved: self.shift_of(place),
            palette_first: self.tables.members().as_slice()[place as usize].palette_first,
            tint: [1.0; 3],
        }
    }
}
