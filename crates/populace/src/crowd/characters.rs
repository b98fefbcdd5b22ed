//! Characters of a crowd, and their clips by name.

use std::sync::Arc;

use populace_character::Character;
use populace_clip::Clip;
use populace_model::{RoleMap, nearest_names};

use super::{CharacterId, CharacterState, ClipId, Crowd, u32_from};
use crate::Error;

impl Crowd {
    /// Adds a character with its clips.
    ///
    /// # Errors
    ///
    /// More data than devices can address.
    pub fn add_character(
        &mut self,
        character: impl Into<Arc<Character>>,
    ) -> Result<CharacterId, Error> {
        let character = character.into();
        let body = self.tables.add_body(&character.skeleton, &character.palette)?;
        let id = CharacterId { crowd: self.number, index: u32_from(self.characters.len()) };
        let clips = character.clips.clone();
        let roles = RoleMap::detect(&character.skeleton);
        self.characters.push(CharacterState { character, body, roles, clips: Vec::new() });
        for clip in &clips {
            self.add_clip(id, clip)?;
        }
        Ok(id)
    }

    /// Adds a clip under its name to a character, at any time. Other characters can play it too.
    ///
    /// # Errors
    ///
    /// A character of another crowd, or more data than devices can address.
    pub fn add_clip(&mut self, character: CharacterId, clip: &Arc<Clip>) -> Result<ClipId, Error> {
        self.character_state(character)?;
        if self.clips.find(clip).is_none() {
            // In the set's order, so that one index names a clip in both.
            self.tables.add_clip(clip)?;
        }
        let id = ClipId { crowd: self.number, index: self.clips.add(clip) };
        let clips = &mut self.character_state_mut(character)?.clips;
        if !clips.contains(&id) {
            clips.push(id);
        }
        Ok(id)
    }

    /// Returns the character of an id.
    ///
    /// # Errors
    ///
    /// A character of another crowd.
    pub fn character(&self, character: CharacterId) -> Result<&Arc<Character>, Error> {
        Ok(&self.character_state(character)?.character)
    }

    /// Returns the clip of a character by name.
    ///
    /// # Errors
    ///
    /// [`Error::UnknownClip`] with similar names.
    pub fn clip(&self, character: CharacterId, name: &str) -> Result<ClipId, Error> {
        let state = self.character_state(character)?;
        let named =
            state.clips.iter().filter_map(|id| Some((self.clips.get(id.index)?.name(), *id)));
        named.clone().find(|(n, _)| *n == name).map(|(_, id)| id).ok_or_else(|| {
            Error::UnknownClip {
                character: state.character.name.clone(),
                name: name.to_owned(),
                nearest: nearest_names(name, named.map(|(n, _)| n)),
            }
        })
    }

    /// Returns the clips of a character, in the order in which they were added.
    ///
    /// # Errors
    ///
    /// A character of another crowd.
    pub fn clips(&self, character: CharacterId) -> Result<Vec<(ClipId, Arc<Clip>)>, Error> {
        let ids = self.character_state(character)?.clips.iter();
        Ok(ids.filter_map(|id| Some((*id, Arc::clone(self.clips.get(id.index)?)))).collect())
    }

    pub(super) fn character_state(&self, id: CharacterId) -> Result<&CharacterState, Error> {
        self.check_crowd("character", id.crowd, id.index)?;
        self.characters
            .get(id.index())
            .ok_or(Error::UnknownId { what: "character", index: id.index })
    }

    pub(super) fn character_state_mut(
        &mut self,
        id: CharacterId,
    ) -> Result<&mut CharacterState, Error> {
        self.check_crowd("character", id.crowd, id.index)?;
        self.characters
            .get_mut(id.index())
            .ok_or(Error::UnknownId { what: "character", index: id.index })
    }
}
