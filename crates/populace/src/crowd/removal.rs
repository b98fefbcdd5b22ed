//! Removal of characters, clips, masks, blend spaces, state machines and stages.

use populace_device::layout::{NONE, Slot};
use populace_device::{BodyIndex, Tables};
use populace_settings::parts::{MaskParts, Parts};

use super::base::{Base, ClipIndex};
use super::player::scheduled::{Action, Start};
use super::player::slots::faded_out;
use super::state::State;
use super::{Crowd, StageId};
use crate::{BlendSpaceId, CharacterId, ClipId, Error, IdKind, MachineId, MaskId, User};

/// Anything that was added to a crowd and can be removed from it.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AssetId {
    /// A character.
    Character(CharacterId),
    /// A clip.
    Clip(ClipId),
    /// A mask.
    Mask(MaskId),
    /// A blend space.
    BlendSpace(BlendSpaceId),
    /// A state machine.
    Machine(MachineId),
    /// A user stage.
    Stage(StageId),
}

macro_rules! into_asset {
    ($($id:ty => $kind:ident,)*) => {
        $(impl From<$id> for AssetId {
            fn from(id: $id) -> Self {
                Self::$kind(id)
            }
        })*
    };
}
into_asset!(
    CharacterId => Character,
    ClipId => Clip,
    MaskId => Mask,
    BlendSpaceId => BlendSpace,
    MachineId => Machine,
    StageId => Stage,
);

impl Crowd {
    /// Removes a character, clip, mask, blend space, state machine or stage. Its id goes stale, and
    /// its memory is free for others.
    ///
    /// With a character go its masks, and those of its clips that nothing else has. Members that
    /// run a removed stage go on without it.
    ///
    /// ```
    /// # use populace::{ClipPlayback, Crowd, Device, Error, Placement};
    /// # let mut crowd = Crowd::builder().device(Device::native()).build()?;
    /// # let knight = populace::doc_fixture::knight(&mut crowd)?;
    /// let member = crowd.spawn(knight, Placement::at([0.0; 3]))?;
    /// assert!(matches!(crowd.remove(knight), Err(Error::InUse { .. })));
    /// crowd.despawn(member)?;
    /// crowd.remove(knight)?;
    /// # Ok::<(), Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::InUse`] for a character with members, a clip or blend space or machine that a
    /// member plays or is scheduled to play, a clip of a blend space or machine, and a mask of a
    /// member's layer. [`Error::UnknownId`] for what was removed before, or a failing device for a
    /// stage. Nothing is changed then.
    pub fn remove(&mut self, asset: impl Into<AssetId>) -> Result<(), Error> {
        match asset.into() {
            AssetId::Character(id) => self.state.remove_character(id),
            AssetId::Clip(id) => self.state.remove_clip(id),
            AssetId::Mask(id) => self.state.base.remove_mask(id),
            AssetId::BlendSpace(id) => self.state.remove_blend_space(id),
            AssetId::Machine(id) => self.state.remove_machine(id),
            AssetId::Stage(id) => self.remove_stage(id),
        }
    }
}

fn in_use(what: IdKind, by: User) -> Error {
    Error::InUse { what, by }
}

impl State {
    pub(super) fn remove_character(&mut self, id: CharacterId) -> Result<(), Error> {
        let state = self.base.character_state(id)?;
        let (body, clips) = (state.body, state.clips.clone());
        let masks: Vec<u32> = state.masks.iter().map(|(_, first)| *first).collect();
        if self.members().any(|member| member.character() == id) {
            return Err(in_use(IdKind::Character, User::Member));
        }
        let (player, base) = self.player();
        player.machines.remove_states(&mut base.tables, |of, _| of == body)?;
        base.remove_bindings(|(of, _)| of == body)?;
        masks.into_iter().try_for_each(|first| base.tables.remove_mask(first))?;
        base.tables.remove_body(body)?;
        base.assets.characters.remove(id.parts().index);
        for clip in clips {
            let is_known = |state: &super::base::CharacterState| state.clips.contains(&clip);
            if !self.base.assets.characters.iter().any(|(_, state)| is_known(state))
                && self.check_clip_unused(clip).is_ok()
            {
                self.remove_clip(clip)?;
            }
        }
        Ok(())
    }

    fn remove_clip(&mut self, id: ClipId) -> Result<(), Error> {
        self.base.known_clip(id)?;
        self.check_clip_unused(id)?;
        let own = ClipIndex::of(id);
        let Self { base, live, events, .. } = self;
        base.clear_slots(|slot, tables| plays_clip(slot, tables, own))?;
        base.remove_bindings(|(_, clip)| clip == own)?;
        base.tables.remove_clip(own.0)?;
        base.assets.clips.remove(own.0);
        base.assets.clip_roles.remove(&own);
        for state in base.assets.characters.values_mut() {
            state.clips.retain(|clip| *clip != id);
        }
        live.forget(own);
        events.forget(own);
        Ok(())
    }

    /// Refuses a clip that a blend space or machine has, or that a member plays or is to play.
    fn check_clip_unused(&self, id: ClipId) -> Result<(), Error> {
        let Self { base, player, .. } = self;
        let own = ClipIndex::of(id);
        if player.spaces.iter().any(|(_, space)| space.space.clips().contains(&id)) {
            return Err(in_use(IdKind::Clip, User::BlendSpace));
        }
        if player.machines.uses_clip(id) {
            return Err(in_use(IdKind::Clip, User::Machine));
        }
        let is_due = |start: &Start| match start.action {
            Action::Clip { bound, .. } => bound_to(&base.tables, bound, own),
            _ => false,
        };
        let plays = |slot: &Slot| plays_clip(slot, &base.tables, own);
        if base.is_playing(plays) || player.scheduled.any(is_due) {
            return Err(in_use(IdKind::Clip, User::Playback));
        }
        Ok(())
    }

    fn remove_blend_space(&mut self, id: BlendSpaceId) -> Result<(), Error> {
        let (player, base) = self.player();
        player.known_space(base, id)?;
        let own = id.parts().index;
        let is_due = |start: &Start| match start.action {
            Action::Space { index, .. } => index == own,
            _ => false,
        };
        let is_active = |index: u32, space: &super::player::blend_spaces::ActiveSpace| {
            space.space == own && player.is_heard(base, index, space)
        };
        let active = player.active_space.iter().any(|(index, space)| is_active(index, space));
        if active || player.scheduled.any(is_due) {
            return Err(in_use(IdKind::BlendSpace, User::Playback));
        }
        player.active_space.retain(|space| space.space != own);
        player.spaces.remove(own);
        Ok(())
    }

    fn remove_machine(&mut self, id: MachineId) -> Result<(), Error> {
        let (player, base) = self.player();
        player.known_machine(base, id)?;
        let own = id.parts().index;
        let machines = &player.machines;
        let runs = |slot: &Slot, tables: &Tables| {
            let instance = slot.machine_instance().and_then(|i| tables.machine_instance(i).ok());
            instance.and_then(|row| machines.index_of(row.state)) == Some(own)
        };
        let is_due =
            |start: &Start| start.machine().and_then(|state| machines.index_of(state)) == Some(own);
        if base.is_playing(|slot| runs(slot, &base.tables)) || player.scheduled.any(is_due) {
            return Err(in_use(IdKind::Machine, User::Playback));
        }
        base.clear_slots(runs)?;
        player.machines.remove_states(&mut base.tables, |_, index| index == own)?;
        player.machines.remove(id);
        Ok(())
    }
}

fn bound_to(tables: &Tables, bound: u32, clip: ClipIndex) -> bool {
    tables.bound_clips().as_slice().get(bound as usize).is_some_and(|row| row.clip == clip.0)
}

/// Returns whether a slot reads a clip: plays it, or inertializes from or into it.
fn plays_clip(slot: &Slot, tables: &Tables, clip: ClipIndex) -> bool {
    if slot.machine_instance().is_some() || slot.bound_clip == NONE {
        return false;
    }
    let target = slot.as_inertialization().map(|slot| slot.incoming_state().bound_clip);
    [Some(slot.bound_clip), target].into_iter().flatten().any(|b| bound_to(tables, b, clip))
}

impl Base {
    fn remove_mask(&mut self, id: MaskId) -> Result<(), Error> {
        let MaskParts { character, index, .. } = id.parts();
        let first = self.first_of_mask(character, id)?;
        let has_it = |index: u32| {
            let layers = &self.tables.layers().as_slice()[self.tables.layer_range(index)];
            layers.iter().any(|layer| layer.mask() == Some(first))
        };
        if self.present().any(has_it) {
            return Err(in_use(IdKind::Mask, User::Layer));
        }
        self.tables.remove_mask(first)?;
        self.character_state_mut(character)?.masks.remove(index);
        Ok(())
    }

    /// Iterates over the indices of the present members.
    fn present(&self) -> impl Iterator<Item = u32> + use<> {
        let members = (0u32..).zip(&self.members.all);
        let present = members.filter(|(_, state)| state.character.is_some());
        present.map(|(index, _)| index).collect::<Vec<_>>().into_iter()
    }

    /// Returns whether a slot that `which` selects has not faded out.
    fn is_playing(&self, which: impl Fn(&Slot) -> bool) -> bool {
        let tick = self.clock.tick;
        let is_heard = |slot: &&Slot| !faded_out(slot, tick) || slot.inertializes(tick);
        self.present().any(|index| self.slots(index).iter().filter(is_heard).any(&which))
    }

    /// Empties the slots that `which` selects.
    fn clear_slots(&mut self, which: impl Fn(&Slot, &Tables) -> bool) -> Result<(), Error> {
        for index in self.present() {
            for slot in 0..self.slots(index).len() {
                if which(&self.slots(index)[slot], &self.tables) {
                    let empty = Slot { bound_clip: NONE, ..Slot::default() };
                    self.tables.set_slot(index, slot, &empty)?;
                }
            }
        }
        Ok(())
    }

    /// Removes the bindings that `which` selects by body and clip.
    fn remove_bindings(
        &mut self,
        which: impl Fn((BodyIndex, ClipIndex)) -> bool,
    ) -> Result<(), Error> {
        let super::base::Assets { bound_clips, replaced, .. } = &mut self.assets;
        let current = bound_clips.extract_if(|key, _| which(*key));
        let old = replaced.extract_if(.., |(key, _)| which(*key));
        let mut rows: Vec<u32> = current.chain(old).map(|(_, bound)| bound.index).collect();
        // Sorted, so that equal calls leave equal tables.
        rows.sort_unstable();
        Ok(rows.into_iter().try_for_each(|row| self.tables.remove_bound_clip(row))?)
    }
}

#[cfg(test)]
mod tests;
