//! Spawning, despawning and drawing of members.

use populace_model::Affine;

use super::slots::Started;
use super::{CharacterId, Crowd, MemberId, MemberState};
use crate::{Error, Placement};

/// The data that a renderer needs to draw one member.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// The member.
    pub member: MemberId,
    /// Its character.
    pub character: CharacterId,
    /// The member's placement.
    pub world_from_model: Affine,
    /// The root-motion offset from the placement, in metres in world space, as known when palettes
    /// were last acquired. The palette includes it.
    pub moved: [f32; 3],
    /// The first palette entry: page times
    /// [`PAGE_ENTRIES`](populace_device::layout::PAGE_ENTRIES) plus the offset in the page.
    pub palette_first: u32,
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

    /// Iterates over the instances to draw, in order of the members' indices.
    pub fn instances(&self) -> impl Iterator<Item = Instance> + '_ {
        let members = self.members.iter().zip(self.tables.members().as_slice());
        members.zip(0u32..).filter_map(|((state, member), place)| {
            Some(Instance {
                member: MemberId { crowd: self.number, index: place, generation: state.generation },
                character: state.character?,
                world_from_model: state.placement.world_from_model(),
                moved: self.shift_of(place),
                palette_first: member.palette_first,
            })
        })
    }
}
