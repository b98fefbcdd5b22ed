//! Views of one member: everything that can be asked of it or done with it.

mod constraints;
mod motion;
mod playback;
mod reading;

use std::borrow::Borrow;

use populace_device::{Instance, MemberLook, Visibility};
use populace_model::convert::u32_from;
use populace_model::{JointIndex, Role};
use populace_settings::parts::Parts;

use super::base::{MemberDetails, MemberState};
use super::state::State;
use super::{CharacterId, Crowd, MemberId};
use crate::{Error, Placement};

/// A borrowed view of a member, whose handle has been checked. [`MemberRef`] reads, [`MemberMut`]
/// reads and changes.
#[derive(Debug)]
pub struct MemberView<C> {
    crowd: C,
    id: MemberId,
    character: CharacterId,
}

/// A view that reads a member; see [`Crowd::member`].
pub type MemberRef<'a> = MemberView<&'a State>;

/// A view that reads and changes a member; see [`Crowd::member_mut`].
pub type MemberMut<'a> = MemberView<&'a mut Crowd>;

impl Crowd {
    /// Returns a view of a member.
    ///
    /// # Errors
    ///
    /// [`Error::StaleMember`] for a member that was despawned, [`Error::UnknownId`] for one of
    /// another crowd.
    pub fn member(&self, id: MemberId) -> Result<MemberRef<'_>, Error> {
        let character = self.state.base.check(id)?;
        Ok(MemberView { crowd: &self.state, id, character })
    }

    /// Returns a view of a member by which it can be changed.
    ///
    /// ```
    /// # use populace::{ClipPlayback, Crowd, MemberId, ClipId, Error};
    /// fn wave_at(crowd: &mut Crowd, member: MemberId, wave: ClipId) -> Result<(), Error> {
    ///     let mut member = crowd.member_mut(member)?;
    ///     member.play(wave, ClipPlayback::once().on_layer(1).fade_in_secs(0.2))?;
    ///     member.look_at([0.0, 1.6, 5.0], populace::Weight::FULL)
    /// }
    /// ```
    ///
    /// # Errors
    ///
    /// As for [`member`](Self::member).
    #[inline]
    pub fn member_mut(&mut self, id: MemberId) -> Result<MemberMut<'_>, Error> {
        let character = self.state.base.check(id)?;
        Ok(MemberView { crowd: self, id, character })
    }

    /// Iterates over all members, in order of their indices.
    pub fn members(&self) -> impl Iterator<Item = MemberRef<'_>> {
        self.state.members()
    }
}

impl State {
    pub(super) fn members(&self) -> impl Iterator<Item = MemberRef<'_>> {
        let indices = 0..u32_from(self.base.members.all.len());
        indices.filter_map(|index| self.member_at(index))
    }

    /// Returns the member of an index; `None` if the index is free.
    pub(super) fn member_at(&self, index: u32) -> Option<MemberRef<'_>> {
        let character = self.base.members.all.get(index as usize)?.character?;
        Some(MemberView { crowd: self, id: self.base.member_id(index), character })
    }
}

impl Borrow<State> for &mut Crowd {
    fn borrow(&self) -> &State {
        &self.state
    }
}

impl<'a> MemberRef<'a> {
    /// Returns what a renderer needs to draw the member. The root-motion offset is as of
    /// [`bounding_sphere`](Self::bounding_sphere). A member that was spawned since the last update
    /// is [hidden](Visibility::Hidden): it has no palette yet.
    #[must_use]
    pub fn instance(&self) -> Instance<'a> {
        let State { base, .. } = self.crowd;
        let index = self.id.number();
        let (seen, is_new) = (self.member().seen, base.is_new(index));
        Instance {
            character: &base.assets.characters[self.character.parts().index].character,
            world_from_model: self.placement().world_from_model(),
            moved: self.crowd.offset_of(index),
            palette_first: base.tables.members().as_slice()[index as usize].palette_first,
            look: self.look(),
            level: seen.level,
            visibility: if is_new { Visibility::Hidden } else { seen.visibility },
        }
    }
}

impl MemberRef<'_> {
    /// Returns a sphere in world space around the member in every pose that the clips bound to its
    /// character so far can give it: centre and radius in metres. Overrides, proportions, user
    /// stages, live clips and attachments can lead out of it. It takes the worst of each joint at
    /// once: for characters of files its radius is 1.5 to 2.5 times the distance to the farthest
    /// vertex in any pose. It is finite, and 1e18 at most at scale 1.
    ///
    /// Root motion takes the sphere along. On the native device it is where the member is after the
    /// last update. Other devices run ahead of the host: there it is where the member was in the
    /// newest update that has reached the host, some frames old, or in the last one if a call has
    /// waited for it since. [`Crowd::finish`](crate::Crowd::finish), every read of results and the
    /// acquisition of palettes do.
    #[must_use]
    pub fn bounding_sphere(&self) -> ([f32; 3], f32) {
        self.crowd.sphere_of(self.id.number() as usize, self.character)
    }
}

impl<C: Borrow<State>> MemberView<C> {
    fn state(&self) -> &State {
        self.crowd.borrow()
    }

    fn member(&self) -> &MemberState {
        &self.state().base.members.all[self.id.number() as usize]
    }

    fn details(&self) -> &MemberDetails {
        &self.state().base.members.details[self.id.number() as usize]
    }

    /// The member's handle.
    #[must_use]
    pub const fn id(&self) -> MemberId {
        self.id
    }

    /// The member's character.
    #[must_use]
    pub const fn character(&self) -> CharacterId {
        self.character
    }

    /// The joint that has a humanoid role; `None` if the character's roles are unknown or no joint
    /// has this one.
    #[must_use]
    pub fn joint(&self, role: Role) -> Option<JointIndex> {
        self.state().base.roles(self.character).ok()??.joint(role)
    }

    /// The member's placement. Root motion moves the member away from it: see
    /// [`moved_placement`](Self::moved_placement).
    #[must_use]
    pub fn placement(&self) -> Placement {
        self.member().placement
    }

    /// The number set by [`set_user_data`](Self::set_user_data), 0 unless set.
    #[must_use]
    pub fn user_data(&self) -> u64 {
        self.details().user_data
    }
}

impl<C: Borrow<State>> MemberView<C> {
    /// The member's tints and the options of its character that it does not show;
    /// [`MemberLook::PLAIN`] unless set.
    #[must_use]
    pub fn look(&self) -> MemberLook {
        self.details().look
    }
}

impl MemberMut<'_> {
    fn details_mut(&mut self) -> &mut MemberDetails {
        &mut self.crowd.state.base.members.details[self.id.number() as usize]
    }

    /// Sets the member's tints, and the options of its character that it does not show.
    ///
    /// ```
    /// # use populace::{Crowd, Error, MemberId, MemberLook, character::Region};
    /// fn dress(crowd: &mut Crowd, member: MemberId) -> Result<(), Error> {
    ///     let look = MemberLook::PLAIN
    ///         .tinted(Region::Top, [0.4, 0.5, 1.2])
    ///         .tinted(Region::Hair, [0.3, 0.3, 0.3])
    ///         .without_option(0);
    ///     crowd.member_mut(member)?.set_look(look);
    ///     Ok(())
    /// }
    /// ```
    pub fn set_look(&mut self, look: MemberLook) {
        self.details_mut().look = look;
    }

    /// Sets the placement of the member and of all that is attached to it. Root motion continues
    /// from there. A member with root motion is drawn there after the next update: until then its
    /// palette still holds the way that it has moved.
    ///
    /// # Errors
    ///
    /// A placement that is not finite, or [`Error::BadAttachment`] if the member is attached to
    /// another, which sets its placement.
    pub fn set_placement(&mut self, placement: Placement) -> Result<(), Error> {
        self.crowd.state.set_placement(self.id, placement)
    }

    /// Stores a number of the caller's own beside the member, such as an index or a key.
    pub fn set_user_data(&mut self, user_data: u64) {
        self.details_mut().user_data = user_data;
    }
}
