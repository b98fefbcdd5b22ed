//! Tests of bodies and motions by the public data of characters, which are skinned here in double
//! precision.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod acts;
mod bodies;
mod gaits;
mod get_ups;
mod held;
mod motions;
mod options;
mod skinning;

use std::sync::OnceLock;

use populace_character::Character;

/// Returns all presets, which are generated once.
fn people() -> &'static [Character] {
    static PEOPLE: OnceLock<Vec<Character>> = OnceLock::new();
    PEOPLE.get_or_init(|| populace_cast::cast().unwrap())
}
