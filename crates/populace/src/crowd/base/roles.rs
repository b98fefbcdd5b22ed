//! Humanoid roles of characters, by which clips of one body are retargeted to others.

use std::sync::Arc;

use populace_clip::Clip;
use populace_device::BodyIndex;
use populace_model::{Role, RoleFault, RoleMap};

use super::{Assets, Base, ClipIndex};
use crate::{CharacterId, ClipId, Error};

impl Base {
    pub(crate) fn roles(&self, character: CharacterId) -> Result<Option<&RoleMap>, Error> {
        Ok(self.character_state(character)?.roles.as_ref())
    }

    /// Sets the roles of a character and drops the bindings that depend on them.
    pub(crate) fn set_roles(
        &mut self,
        character: CharacterId,
        roles: RoleMap,
    ) -> Result<(), Error> {
        let state = self.character_state_mut(character)?;
        let (body, joints) = (state.body, state.character.skeleton.joint_count());
        if roles.joint_count() != joints {
            return Err(other_skeleton(&state.character.name, &roles, joints));
        }
        let skeleton = state.character.skeleton.clone();
        state.roles = Some(roles);
        self.assets.replace_bindings(|bound, clip| bound == body || *clip.skeleton() == skeleton);
        Ok(())
    }

    /// Sets the roles of a clip's own skeleton and drops the bindings that depend on them.
    pub(crate) fn set_clip_roles(&mut self, clip: ClipId, roles: RoleMap) -> Result<(), Error> {
        let known = self.known_clip(clip)?;
        let joints = known.skeleton().joint_count();
        if roles.joint_count() != joints {
            return Err(other_skeleton(known.name(), &roles, joints));
        }
        let known = Arc::clone(known);
        self.assets.clip_roles.insert(ClipIndex::of(clip), roles);
        self.assets.replace_bindings(|_, bound| Arc::ptr_eq(bound, &known));
        Ok(())
    }

    /// Returns the roles of the skeleton that a clip was made for: set for the clip, else those of
    /// the character with that skeleton, else detected from names.
    pub(crate) fn roles_of(&self, clip: &Arc<Clip>) -> Option<RoleMap> {
        let assets = &self.assets;
        let index = assets.index_of(clip).map(ClipIndex);
        if let Some(given) = index.and_then(|index| assets.clip_roles.get(&index)) {
            return Some(given.clone());
        }
        let mut states = assets.characters.iter().map(|(_, state)| state);
        let own = states.find(|state| state.character.skeleton == *clip.skeleton());
        own.map_or_else(|| RoleMap::detect(clip.skeleton()), |state| state.roles.clone())
    }
}

impl Assets {
    /// Takes bindings out of use, so that the next start of a clip makes a new one. Slots that play
    /// them keep them.
    fn replace_bindings(&mut self, which: impl Fn(BodyIndex, &Arc<Clip>) -> bool) {
        let Self { clips, bound_clips, replaced, .. } = self;
        let old = bound_clips
            .extract_if(|(body, clip), _| clips.at(clip.0).is_some_and(|clip| which(*body, clip)));
        replaced.extend(old);
    }
}

fn other_skeleton(name: &str, roles: &RoleMap, joints: usize) -> Error {
    let (name, wanted) = (name.to_owned(), roles.joint_count());
    let fault = RoleFault::OtherSkeletonOf { name, wanted, joints };
    populace_model::Error::BadRole { role: Role::Hips, fault }.into()
}
