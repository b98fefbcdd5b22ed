//! Humanoid roles of characters, by which clips of one body are retargeted to others.

use populace_clip::Clip;
use populace_model::{Role, RoleFault, RoleMap};

use super::{CharacterId, ClipId, Crowd};
use crate::Error;

impl Crowd {
    /// Returns the humanoid roles of a character's joints, detected from their names or set; `None`
    /// if neither.
    ///
    /// # Errors
    ///
    /// A character of another crowd.
    pub fn roles(&self, character: CharacterId) -> Result<Option<&RoleMap>, Error> {
        Ok(self.character_state(character)?.roles.as_ref())
    }

    /// Sets the humanoid roles of a character's joints, in place of those detected from names.
    /// Retargeting from and to the character uses them from now on. Clips that already play keep
    /// their binding.
    ///
    /// # Errors
    ///
    /// A character of another crowd, or a map of another skeleton.
    pub fn set_roles(&mut self, character: CharacterId, roles: RoleMap) -> Result<(), Error> {
        let state = self.character_state_mut(character)?;
        let (body, joints) = (state.body, state.character.skeleton.joint_count());
        if roles.joint_count() != joints {
            return Err(other_skeleton(&state.character.name, &roles, joints));
        }
        let skeleton = state.character.skeleton.clone();
        state.roles = Some(roles);
        let clips = &self.clips;
        let stays = |clip| clips.get(clip).is_none_or(|clip| *clip.skeleton() != skeleton);
        self.bound_clips.retain(|(bound, clip), _| *bound != body && stays(*clip));
        self.machines.unbind();
        Ok(())
    }

    /// Sets the humanoid roles of the skeleton that a clip was made for, which need not be the
    /// skeleton of a character.
    ///
    /// # Errors
    ///
    /// A clip of another crowd, or a map of another skeleton.
    pub fn set_clip_roles(&mut self, clip: ClipId, roles: RoleMap) -> Result<(), Error> {
        self.check_crowd("clip", clip.crowd, clip.index.0)?;
        let known = self.clips.get(clip.index);
        let known = known.ok_or(Error::UnknownId { what: "clip", index: clip.index.0 })?;
        let joints = known.skeleton().joint_count();
        if roles.joint_count() != joints {
            return Err(other_skeleton(known.name(), &roles, joints));
        }
        self.clip_roles.insert(clip.index, roles);
        self.bound_clips.retain(|(_, bound), _| *bound != clip.index);
        self.machines.unbind();
        Ok(())
    }

    /// Returns the roles of the skeleton that a clip was made for: set for the clip, else those of
    /// the character with that skeleton, else detected from names.
    pub(super) fn roles_of(&self, clip: &std::sync::Arc<Clip>) -> Option<RoleMap> {
        if let Some(given) = self.clips.find(clip).and_then(|index| self.clip_roles.get(&index)) {
            return Some(given.clone());
        }
        let own = self.characters.iter().find(|state| state.character.skeleton == *clip.skeleton());
        own.map_or_else(|| RoleMap::detect(clip.skeleton()), |state| state.roles.clone())
    }
}

fn other_skeleton(name: &str, roles: &RoleMap, joints: usize) -> Error {
    let (name, wanted) = (name.to_owned(), roles.joint_count());
    let fault = RoleFault::OtherSkeletonOf { name, wanted, joints };
    populace_model::Error::BadRole { role: Role::Hips, fault }.into()
}
