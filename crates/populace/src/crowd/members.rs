//! Members of a crowd: they come and go, are placed and drawn.

use populace_model::Affine;

use super::room::Started;
use super::{CharacterId, Crowd, Member, MemberState};
use crate::{Error, Placement};

/// What a renderer needs to draw one member.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// The member.
    pub member: Member,
    /// Its character.
    pub character: CharacterId,
    /// Where it was placed.
    pub world_from_model: Affine,
    /// How far from there its clips have moved it, in metres of the world, as far as was known when
    /// palettes were last taken: the palette has it there already.
    pub moved: [f32; 3],
    /// Its first palette entry: page times
    /// [`PAGE_ENTRIES`](populace_device::layout::PAGE_ENTRIES) plus the place within the page.
    pub palette_first: u32,
}

impl Crowd {
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
            let free = MemberState { generation: 0, character: None, placement, since: 0 };
            self.members.resize(place as usize + 1, free);
            self.started
                .resize(self.members.len() * self.tables.slots_per_member(), Started::default());
        }
        let state = &mut self.members[place as usize];
        state.character = Some(character);
        state.placement = placement;
        state.since = self.frame;
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
        self.forget_watches(member);
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
    /// [`Error::StaleMember`], a placement that is not finite, or [`Error::BadAttachment`] for a
    /// member that is attached to another.
    pub fn place(&mut self, member: Member, placement: Placement) -> Result<(), Error> {
        self.check(member)?;
        placement.check()?;
        self.check_placeable(member)?;
        self.begin_motion_anew(member)?;
        self.members[member.place as usize].placement = placement;
        self.stand(member)?;
        self.bring_props(member)
    }

    /// Where a member was placed; [`moved`](Self::moved) tells where its clips have moved it from
    /// there.
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
}
