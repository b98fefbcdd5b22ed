//! Characters of a crowd, their clips and their masks.

use std::sync::Arc;

use populace_character::Character;
use populace_clip::Clip;
use populace_model::convert::u32_from;
use populace_model::{Mask, RoleMap, nearest_names};
use populace_settings::parts::{Key, MaskParts, Parts};

use super::reach::Reach;
use super::{Assets, Base, CharacterState};
use crate::crowd::slab::Slab;
use crate::{CharacterId, ClipId, Error, IdKind, MaskId};

impl Assets {
    /// The index of a clip, if it was added.
    pub(crate) fn index_of(&self, clip: &Arc<Clip>) -> Option<u32> {
        let known = self.clips.iter().find(|(_, known)| Arc::ptr_eq(known, clip));
        known.map(|((index, _), _)| index)
    }
}

/// Returns, for each level from 0 on, the number of the reduced body that it evaluates, counted from
/// 1, or 0 for the whole body.
fn reduced_of_levels(character: &Character, reduced: &[usize]) -> Vec<u32> {
    let counts = character.levels().iter().map(|level| level.joint_count);
    let number = |count| reduced.iter().position(|r| *r == count).map_or(0, |at| u32_from(at + 1));
    std::iter::once(0).chain(counts.map(number)).collect()
}

impl Base {
    /// Adds a character without its clips.
    pub(crate) fn add_body(&mut self, character: Arc<Character>) -> Result<CharacterId, Error> {
        let counts = character.levels().iter().map(|level| level.joint_count);
        let mut reduced: Vec<usize> = counts.collect();
        reduced.dedup();
        reduced.retain(|count| *count < character.skeleton.joint_count());
        let (skeleton, palette) = (&character.skeleton, &character.palette);
        let body = self.tables.add_reducible_body(skeleton, palette, &reduced)?;
        let roles = RoleMap::detect(&character.skeleton);
        let reach = Reach::at_rest(&character.skeleton);
        let reduced_of_level = reduced_of_levels(&character, &reduced);
        let state = CharacterState {
            character,
            body,
            reduced_of_level,
            reach,
            roles,
            clips: Vec::new(),
            masks: Slab::default(),
        };
        let (index, generation) = self.assets.characters.insert(state);
        Ok(CharacterId::from_parts(Key { crowd: self.number, index, generation }))
    }

    pub(crate) fn add_clip(
        &mut self,
        character: CharacterId,
        clip: &Arc<Clip>,
    ) -> Result<ClipId, Error> {
        self.character_state(character)?;
        let index = match self.assets.index_of(clip) {
            Some(index) => index,
            None => {
                let index = self.tables.add_clip(clip)?;
                self.assets.clips.insert_at(index, Arc::clone(clip));
                index
            }
        };
        let id = self.clip_id(index);
        let clips = &mut self.character_state_mut(character)?.clips;
        if !clips.contains(&id) {
            clips.push(id);
        }
        Ok(id)
    }

    /// Returns the clip of a character by name, or an error with similar names.
    pub(crate) fn clip(&self, character: CharacterId, name: &str) -> Result<ClipId, Error> {
        let named = || self.clips(character).map(|(id, clip)| (clip.name(), id));
        let state = self.character_state(character)?;
        named().find(|(own, _)| *own == name).map(|(_, id)| id).ok_or_else(|| Error::UnknownClip {
            character: state.character.name.clone(),
            name: name.to_owned(),
            nearest: nearest_names(name, named().map(|(own, _)| own)),
        })
    }

    /// Iterates over the clips of a character, in the order in which they were added.
    pub(crate) fn clips(
        &self,
        character: CharacterId,
    ) -> impl Iterator<Item = (ClipId, &Arc<Clip>)> + Clone {
        let ids = self.character_state(character).map_or(&[][..], |state| &state.clips);
        ids.iter().filter_map(|id| Some((*id, self.known_clip(*id).ok()?)))
    }

    pub(crate) fn add_mask(
        &mut self,
        character: CharacterId,
        mask: &Mask,
    ) -> Result<MaskId, Error> {
        let joints = self.character_state(character)?.character.skeleton.joint_count();
        let weights = mask.weights().len();
        if weights != joints {
            return Err(populace_model::Error::BadMask { weights, joints }.into());
        }
        let first = self.tables.add_mask(mask)?;
        let (index, generation) = self.character_state_mut(character)?.masks.insert(first);
        Ok(MaskId::from_parts(MaskParts { character, index, generation }))
    }

    /// Returns the first weight of a mask of a character in the tables.
    pub(crate) fn first_of_mask(&self, character: CharacterId, mask: MaskId) -> Result<u32, Error> {
        let masks = &self.character_state(character)?.masks;
        let mask = mask.parts();
        let first =
            masks.get((mask.index, mask.generation)).filter(|_| mask.character == character);
        let unknown = Error::UnknownId { what: IdKind::Mask, index: mask.index };
        first.copied().ok_or(unknown)
    }

    pub(crate) fn character_state(&self, id: CharacterId) -> Result<&CharacterState, Error> {
        let Key { crowd, index, generation } = id.parts();
        self.check_crowd(IdKind::Character, crowd, index)?;
        let unknown = || Error::UnknownId { what: IdKind::Character, index };
        self.assets.characters.get((index, generation)).ok_or_else(unknown)
    }

    pub(crate) fn character_state_mut(
        &mut self,
        id: CharacterId,
    ) -> Result<&mut CharacterState, Error> {
        let Key { crowd, index, generation } = id.parts();
        self.check_crowd(IdKind::Character, crowd, index)?;
        let unknown = || Error::UnknownId { what: IdKind::Character, index };
        self.assets.characters.get_mut((index, generation)).ok_or_else(unknown)
    }
}
