//! Procedural people: dressed bodies of closed surfaces on two kinds of skeleton, with clips for
//! what people do in streets, stands and battles. A crowd of them needs no asset files.
//!
//! Spaces and units are those of [`populace_model`]: metres, Y up, facing +Z, soles on y = 0.
//!
//! # Clips
//!
//! Each character has the same clips, solved for its own body:
//!
//! - Standing and gaits, which loop: `Idle`, `Idle_Shift`, `Walk` and `Run`. The gaits are in
//!   place; [`ClipStats`](populace_clip::ClipStats) gives their ground speed.
//! - Getting up, played once: `GetUp_Back`, `GetUp_Front`, `GetUp_Left` and `GetUp_Right` start
//!   lying on that side of the body.
//! - Loops: `Idle_Look` (looks to both sides), `Look_In` (bends to a shop window), `Lean`
//!   (against a wall), `Sit`, `Drive`, `Talk`, `Talk_Listen`, `Phone`, `Text`, `Wave`, `Clap`,
//!   `Cheer`, `Carry` (a box), `Push` (a bar), `Shield` (in the left hand) and `Spear` (in the
//!   right hand).
//! - Played once: `Sit_Down`, `Stand_Up`, `Point`, `Open_Door`, `Get_In`, `Get_Out`,
//!   `Spear_Thrust`, `Hit` (from the front) and `Push_Away`.
//!
//! Clips that play once begin in the first pose of `Idle` and end in it, with the feet around the
//! origin. Those on the ground begin lying. `Sit_Down` ends in the first pose of `Sit`, where
//! `Stand_Up` begins. `Get_In` ends in that of `Drive`, where `Get_Out` begins. In `Talk`,
//! `Talk_Listen`, `Phone`, `Text`, `Wave`, `Clap`, `Carry`, `Push` and `Spear` the legs only
//! stand, so trunk and arms also play alone above a walk.
//!
//! Constants such as [`SEAT_HEIGHT_M`], [`CAR_SEAT_M`] and [`DOOR_HANDLE_M`] say where the things
//! are that the clips use. [`grip`], [`helmet`] and [`phone_at_ear`] say how props are attached.
//!
//! ```
//! use populace_cast::{Look, person};
//!
//! let tall = person(&Look { height_m: 1.9, ..Look::man() })?;
//! assert!((tall.height_m() - 1.9).abs() < 0.01);
//! assert_eq!(tall.clips.len(), 33);
//! let broken = Look { height_m: f64::NAN, ..Look::man() };
//! assert!(person(&broken).is_err());
//! # Ok::<(), populace_character::Error>(())
//! ```
//!
//! The names of materials start with their region: `Skin`, `Hair`, `Eyes`, `Top`, `Trousers`,
//! `Shoes` or `Accessory`. Hair, hats, glasses and bags are parts of their own, which members can swap:
//! see [`person_with_options`].
//!
//! Surfaces and motions are defined for one set of 54 body segments, and a rig maps segments to
//! joints. Both skeletons therefore share all bodies and motions, while each has its own joint
//! names and rest rotations.

mod anatomy;
mod dressed;
mod grip;
mod look;
mod motion;
mod places;
mod rig;
mod surface;

use populace_character::{Character, Error};

pub use anatomy::Side;
pub use grip::{carried, grip, helmet, phone_at_ear, phone_to_read};
pub use look::{Bag, Bottom, Colors, Extra, Face, Glasses, Hair, Hat, Look, Reach, Rig, Top};
pub use places::{
    CAR_FLOOR_M, CAR_ROOF_M, CAR_SEAT_M, CARRY_WIDTH, DOOR_HANDLE_M, DOOR_HINGE_M, DOOR_OPEN_RAD,
    LEAN_WALL_M, PUSH_BAR, SEAT_BACK_M, SEAT_HEIGHT_M, STEERING_WHEEL_M, STEERING_WHEEL_RADIUS_M,
    STEERING_WHEEL_TILT_RAD,
};

/// Returns one character for each preset, in the order of [`Look::presets`].
///
/// # Errors
///
/// The errors of [`person`]. The presets cause none.
pub fn cast() -> Result<Vec<Character>, Error> {
    dress(&Look::presets())
}

/// Returns all presets in `outfits` outfits each, for a crowd without clones. The outfits of a
/// preset share their clips.
///
/// # Errors
///
/// The errors of [`person`]. The presets cause none.
pub fn people(outfits: usize) -> Result<Vec<Character>, Error> {
    let presets = Look::presets();
    let all =
        (0..outfits).flat_map(|number| presets.iter().map(move |look| look.in_outfit(number)));
    dress(&all.collect::<Vec<_>>())
}

/// Returns one person with clips, in what the look wears. The result is deterministic: equal looks
/// give equal data.
///
/// # Errors
///
/// An [`Error`] of [`populace_character`] if a number of the look is not finite, or if it gives an
/// invalid body.
pub fn person(look: &Look) -> Result<Character, Error> {
    dressed::one(look, false)
}

/// Returns one person with clips and with all options of the look as parts: what it wears, and then
/// what it has to spare. Joints and clips are those of [`person`].
///
/// Options are the parts that [`option_of`] knows. At most one of a group may be shown on a body,
/// and always one of the group `hair`. [`Look::worn_parts`] names those to show by default.
///
/// # Errors
///
/// The errors of [`person`].
pub fn person_with_options(look: &Look) -> Result<Character, Error> {
    dressed::one(look, true)
}

/// Returns a [`person`] for each look, on all cores. Looks of one build, such as those of
/// [`Look::in_outfit`], share their clips: motions are solved once for each build.
///
/// # Errors
///
/// The errors of [`person`].
pub fn dress(looks: &[Look]) -> Result<Vec<Character>, Error> {
    dressed::all(looks, false)
}

/// Returns a [`person_with_options`] for each look, as [`dress`] does.
///
/// # Errors
///
/// The errors of [`person`].
pub fn dress_with_options(looks: &[Look]) -> Result<Vec<Character>, Error> {
    dressed::all(looks, true)
}

/// Returns the group and the name of an option, by the name of its part
/// ([`Part::node_name`](populace_character::Part::node_name)): `Option:hair:bob` is the option
/// `bob` of the group `hair`. `None` for parts that are always shown.
#[must_use]
pub fn option_of(part: &str) -> Option<(&str, &str)> {
    part.strip_prefix(OPTION)?.split_once(':')
}

/// Start of the names of parts that can be hidden.
const OPTION: &str = "Option:";
