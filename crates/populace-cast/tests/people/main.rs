//! Whether the cast stands, walks and runs like people, seen from outside: skinned here, in double
//! precision.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod bodies;
mod gaits;
mod motions;
mod skinning;

use std::sync::OnceLock;

use populace_character::Character;

/// The cast, made once.
fn people() -> &'static [Character] {
    static PEOPLE: OnceLock<Vec<Character>> = OnceLock::new();
    PEOPLE.get_or_init(|| populace_cast::cast().unwrap())
}
