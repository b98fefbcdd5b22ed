//! Things that people hold and wear.

use std::collections::BTreeMap;

use populace::character::Character;
use populace::{CharacterId, Crowd};

use super::Prepare;
use crate::Error;

/// The kinds of things that people hold and wear.
pub const THING_KINDS: [&str; 5] = ["box", "helmet", "phone", "shield", "spear"];

/// The thing that people carry with both hands.
pub(crate) const PARCEL: &str = "box";

/// The thing that people telephone with and read.
pub(crate) const PHONE: &str = "phone";

/// Number of different shields and helmets.
const VARIANTS: u64 = 4;

/// Where a thing is held or worn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Bearer {
    Head,
    LeftHand,
    RightHand,
}

impl Bearer {
    /// Returns where a thing of a kind, or of a file, is held or worn.
    pub(crate) fn of(thing: &str) -> Self {
        match thing {
            "helmet" => Self::Head,
            "shield" => Self::LeftHand,
            _ => Self::RightHand,
        }
    }

    /// Its name in errors.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Head => "head",
            Self::LeftHand => "left hand",
            Self::RightHand => "right hand",
        }
    }
}

/// Brings the things of a kind into a crowd, those that vary in some variants.
pub(super) fn things(
    crowd: &mut Crowd,
    kind: &str,
    files: &BTreeMap<String, Character>,
    prepare: &Prepare<'_>,
) -> Result<Vec<CharacterId>, Error> {
    let mut all = Vec::new();
    for seed in 0..VARIANTS {
        let thing = match (kind, seed) {
            ("shield", _) => populace_props::shield(seed),
            ("helmet", _) => populace_props::helmet(seed),
            ("spear", 0) => populace_props::spear(),
            ("phone", 0) => populace_props::phone(),
            ("box", 0) => populace_props::box_parcel(),
            ("spear" | "phone" | "box", _) => break,
            (file, 0) => match files.get(file) {
                Some(character) => Ok(character.clone()),
                None => {
                    let kinds = THING_KINDS.map(str::to_owned);
                    return Err(Error::unknown("kind of thing to hold", file, kinds.iter()));
                }
            },
            _ => break,
        };
        let thing =
            prepare(thing.map_err(populace::Error::from)?).map_err(populace::Error::from)?;
        all.push(crowd.add_character(thing)?);
    }
    Ok(all)
}
