//! Bindings of clips to bodies.

use std::sync::Arc;

use populace_clip::Clip;
use populace_device::ConstraintFault;
use populace_retarget::{Binding, BindingReport};

use populace_settings::parts::{check_contact, contact_row};

use super::reach::Reach;
use super::{Base, CharacterState, ClipIndex};
use crate::{CharacterId, ClipId, Contact, Error};

/// A clip bound to a body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bound {
    /// The index among the bound clips of the tables.
    pub(crate) index: u32,
    report: BindingReport,
}

impl Base {
    /// Reports how well a clip fits a character.
    pub(crate) fn binding(
        &self,
        character: CharacterId,
        clip: ClipId,
    ) -> Result<BindingReport, Error> {
        let (state, known) = self.to_bind(character, clip)?;
        match self.assets.bound_clips.get(&(state.body, ClipIndex::of(clip))) {
            Some(bound) => Ok(bound.report),
            None => {
                let (skeleton, roles) = (&state.character.skeleton, state.roles.as_ref());
                Ok(BindingReport::new(known, self.roles_of(known).as_ref(), skeleton, roles)?)
            }
        }
    }

    /// Returns the index of the clip's binding to a character's body, and makes it if needed.
    /// `partial` accepts any share bound by names alone.
    pub(crate) fn bind(
        &mut self,
        character: CharacterId,
        clip: ClipId,
        partial: bool,
    ) -> Result<u32, Error> {
        let (state, known) = self.to_bind(character, clip)?;
        let key = (state.body, ClipIndex::of(clip));
        let check =
            |report: &BindingReport| if partial { Ok(()) } else { report.check(known.name()) };
        if let Some(bound) = self.assets.bound_clips.get(&key) {
            check(&bound.report)?;
            return Ok(bound.index);
        }
        let is_bounded = known.ring().is_none();
        let binding = self.make_binding(state, known)?;
        let report = *binding.report();
        check(&report)?;
        let index = self.tables.add_bound_clip(key.1.0, key.0, &binding)?;
        self.assets.bound_clips.insert(key, Bound { index, report });
        // Live clips pose bodies anywhere, so members that play one are always shown.
        if is_bounded {
            let state = self.character_state_mut(character)?;
            let reach = Reach::with_clip(&state.character.skeleton, &binding);
            state.reach = state.reach.and(reach);
        }
        Ok(index)
    }

    /// Returns the index of a binding to a member's body that [`bind`](Self::bind) has made before.
    /// If roles have changed since, the clip is bound again; if it no longer fits, the binding from
    /// before goes on.
    pub(crate) fn bind_again(
        &mut self,
        member_index: u32,
        clip: ClipId,
        partial: bool,
    ) -> Result<u32, Error> {
        let member = self.members.all.get(member_index as usize);
        let character = member.and_then(|member| member.character).ok_or(Error::StaleMember)?;
        let key = (self.character_state(character)?.body, ClipIndex::of(clip));
        if let Some(bound) = self.assets.bound_clips.get(&key) {
            return Ok(bound.index);
        }
        self.bind(character, clip, partial).or_else(|error| {
            let mut replaced = self.assets.replaced.iter().rev();
            let newest = replaced.find(|(of, _)| *of == key);
            newest.map(|(_, bound)| bound.index).ok_or(error)
        })
    }

    /// Sets the contacts of a clip on a character's body, in place of those that it had.
    pub(crate) fn set_contacts(
        &mut self,
        character: CharacterId,
        clip: ClipId,
        contacts: &[Contact],
    ) -> Result<(), Error> {
        let (state, known) = self.to_bind(character, clip)?;
        let joints = state.character.skeleton.joint_count();
        for contact in contacts {
            check_contact(contact, known.duration_secs())?;
            if contact.ankle.index() >= joints {
                let fault = ConstraintFault::NoJoint { joint: contact.ankle.0, count: joints };
                return Err(Error::Tables(fault.into()));
            }
        }
        let bound = self.bind(character, clip, true)?;
        let rows: Vec<_> = contacts.iter().map(contact_row).collect();
        Ok(self.tables.set_contacts(bound, &rows)?)
    }

    fn to_bind(
        &self,
        character: CharacterId,
        clip: ClipId,
    ) -> Result<(&CharacterState, &Arc<Clip>), Error> {
        let known = self.known_clip(clip)?;
        Ok((self.character_state(character)?, known))
    }

    fn make_binding(&self, state: &CharacterState, clip: &Arc<Clip>) -> Result<Binding, Error> {
        let (skeleton, roles) = (&state.character.skeleton, state.roles.as_ref());
        Ok(Binding::partial(clip, self.roles_of(clip).as_ref(), skeleton, roles)?)
    }
}
