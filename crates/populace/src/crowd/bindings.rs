//! Bindings of clips to bodies.

use std::sync::Arc;

use populace_clip::Clip;
use populace_retarget::{Binding, BindingReport};

use super::{CharacterId, CharacterState, ClipId, Crowd};
use crate::Error;

/// A clip bound to a body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bound {
    /// The index among the bound clips of the tables.
    pub(super) index: u32,
    report: BindingReport,
}

impl Crowd {
    /// Reports how well a clip fits a character: how its joints are found, the share of its joints
    /// that are bound, and the difference of the rest poses.
    ///
    /// A clip bound by names alone is refused below [`BindingReport::LEAST_SHARE`], unless played
    /// by [`ClipPlayback::partial`](crate::ClipPlayback::partial). Between that and 80 % it plays
    /// with a part of its motion missing.
    ///
    /// # Errors
    ///
    /// An id of another crowd, or a clip that moves no joint of the character.
    pub fn binding(&self, character: CharacterId, clip: ClipId) -> Result<BindingReport, Error> {
        let (state, known) = self.to_bind(character, clip)?;
        match self.bound_clips.get(&(state.body, clip.index)) {
            Some(bound) => Ok(bound.report),
            None => Ok(*self.make_binding(state, known)?.report()),
        }
    }

    /// Returns the index of the clip's binding to a character's body, and makes it if needed.
    /// `partial` accepts any share bound by names alone.
    pub(super) fn bind(
        &mut self,
        character: CharacterId,
        clip: ClipId,
        partial: bool,
    ) -> Result<u32, Error> {
        let (state, known) = self.to_bind(character, clip)?;
        let key = (state.body, clip.index);
        let check =
            |report: &BindingReport| if partial { Ok(()) } else { report.check(known.name()) };
        if let Some(bound) = self.bound_clips.get(&key) {
            check(&bound.report)?;
            return Ok(bound.index);
        }
        let binding = self.make_binding(state, known)?;
        let report = *binding.report();
        check(&report)?;
        let index = self.tables.add_bound_clip(clip.index.0, key.0, &binding)?;
        self.bound_clips.insert(key, Bound { index, report });
        Ok(index)
    }

    fn to_bind(
        &self,
        character: CharacterId,
        clip: ClipId,
    ) -> Result<(&CharacterState, &Arc<Clip>), Error> {
        self.check_crowd("clip", clip.crowd, clip.index.0)?;
        let known = self.clips.get(clip.index);
        let known = known.ok_or(Error::UnknownId { what: "clip", index: clip.index.0 })?;
        Ok((self.character_state(character)?, known))
    }

    fn make_binding(&self, state: &CharacterState, clip: &Arc<Clip>) -> Result<Binding, Error> {
        let (skeleton, roles) = (&state.character.skeleton, state.roles.as_ref());
        Ok(Binding::partial(clip, self.roles_of(clip).as_ref(), skeleton, roles)?)
    }
}
