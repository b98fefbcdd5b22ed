//! Legs of characters that walk.

use std::path::Path;

use populace::character::Character;
use populace::model::RoleMap;

use crate::failure::{Failure, UNKNOWN_LEGS};

/// Returns a humanoid with feet that its legs move, as it needs them to walk.
pub(crate) fn on_legs(character: Character, file: &Path) -> Result<Character, Failure> {
    let named = |reason: &dyn std::fmt::Display| {
        Failure::Input(anyhow::anyhow!("{}: {reason}", file.display()))
    };
    let Some(roles) = RoleMap::detect(&character.skeleton) else {
        return Err(named(&UNKNOWN_LEGS));
    };
    if roles.loose_feet(&character.skeleton).next().is_none() {
        return Ok(character);
    }
    character.with_feet_on_legs(&roles).map_err(|e| named(&e))
}
