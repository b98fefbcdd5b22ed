//! The sizes of characters, which may be in another unit than metres.

use populace::character::Character;

use super::{ClipChoice, has_roles};
use crate::report::message;

/// In a crowd of several characters, heights outside of this range are taken to be in another unit
/// than metres.
const PLAUSIBLE_M: std::ops::Range<f32> = 0.5..2.2;
/// The same for a character alone: a fox of 79 m is one of 79 cm.
const ALONE_M: std::ops::Range<f32> = 0.03..40.0;
/// Height given to a character in another unit that is higher than long.
const UPRIGHT_M: f32 = 1.75;
/// Height given to a character in another unit that is longer than high.
const FOUR_LEGGED_M: f32 = 0.8;

/// Company of a character in the picture. It decides which sizes are plausible.
#[derive(Clone, Copy)]
pub(super) enum Among {
    /// The character is the only one.
    None,
    /// Other characters of a crowd.
    Others,
    /// A scene, whose places, seats and vehicles are made for people.
    Scene,
}

impl Among {
    pub(super) fn of(choice: ClipChoice, characters: usize) -> Self {
        match choice {
            ClipChoice::Scene => Self::Scene,
            _ if characters > 1 => Self::Others,
            _ => Self::None,
        }
    }
}

/// Returns the scale to the height asked for or, for a character in another unit than metres, to a
/// plausible height.
pub(super) fn scale(character: &Character, height_m: Option<f32>, among: Among) -> f32 {
    let own = character.size_m().max(1e-6);
    // A humanoid may hold a long sword.
    let longer_than_high = !has_roles(character)
        && character.rest_bounds().is_some_and(|b| b.high[2] - b.low[2] > own);
    let plausible_m = if matches!(among, Among::None) { ALONE_M } else { PLAUSIBLE_M };
    match height_m {
        Some(height_m) => height_m / own,
        None if plausible_m.contains(&own) => 1.0,
        None if longer_than_high => FOUR_LEGGED_M / own,
        None => UPRIGHT_M / own,
    }
}

/// Says that a character is in another unit than metres.
pub(super) fn report_scale(character: &Character, scale: f32, among: Among) {
    let (name, own_m) = (&character.name, character.size_m());
    let own = if own_m < 0.1 { format!("{:.2} mm", own_m * 1e3) } else { format!("{own_m:.2} m") };
    let (reason, setter) = match among {
        Among::None => ("which is hardly meant in metres", "--height"),
        Among::Others => ("which suits no crowd of several characters", "--height"),
        Among::Scene => ("which suits no scene of people", "height_m of its cast"),
    };
    let extent = if own_m > character.height_m() { "long" } else { "high" };
    message!(
        "\"{name}\" is {own} {extent}, {reason}; it is drawn {:.2} m {extent}, and {setter} \
         sets it",
        scale * own_m
    );
}

/// Doubts a height in metres that was asked for and that no character has.
pub(super) fn doubt_height(height_m: f32) -> Option<String> {
    let as_cm_m = height_m / 100.0;
    let hint = if PLAUSIBLE_M.contains(&as_cm_m) {
        format!("; {height_m} cm are {as_cm_m}")
    } else {
        String::new()
    };
    (!ALONE_M.contains(&height_m))
        .then(|| format!("a height of {height_m} m is hardly meant; heights are in metres{hint}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_in_centimetres_are_doubted() {
        let doubt = "a height of 180 m is hardly meant; heights are in metres; 180 cm are 1.8";
        assert_eq!(doubt_height(180.0).as_deref(), Some(doubt));
        assert!(doubt_height(1000.0).is_some_and(|doubt| doubt.ends_with("in metres")));
        assert_eq!([0.05, 0.3, 1.8, 30.0].map(doubt_height), [const { None }; 4]);
    }
}
