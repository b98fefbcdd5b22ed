//! Colours and options that a character can choose from.

use populace_character::{Character, Region};
use populace_device::MemberLook;

use crate::paint::Paint;
use crate::palettes::{
    ACCESSORIES, DARK_HAIRS, DARK_SKINS, HAIRS, PAINTED_CLOTHES, PAINTED_HAIRS, PAINTED_SKINS,
    SHOES, SKINS, TOPS, TROUSERS,
};

/// The group of options of which one is always shown.
const HAIR: &str = "hair";
/// Hair with a lighter mean and less colour than this is grey, and stays grey.
const GREY: f32 = 0.2;

/// A character's regions and options.
pub(crate) struct Wardrobe {
    paint: Paint,
    /// Numbers of the options of each group.
    groups: Vec<(String, Vec<usize>)>,
}

impl Wardrobe {
    pub(crate) fn of(character: &Character) -> Self {
        let mut groups: Vec<(String, Vec<usize>)> = Vec::new();
        for (number, option) in character.options().iter().enumerate() {
            match groups.iter_mut().find(|(name, _)| *name == option.group) {
                Some((_, numbers)) => numbers.push(number),
                None => groups.push((option.group.clone(), vec![number])),
            }
        }
        Self { paint: Paint::of(character), groups }
    }

    /// Returns a random look. `worn` is the share of members that wear an option of a group.
    pub(crate) fn look(&self, random: &mut fastrand::Rng, worn: f32) -> MemberLook {
        let skin = random.usize(..SKINS.len());
        let hairs = if skin >= DARK_SKINS { DARK_HAIRS } else { HAIRS.len() };
        let hair = random.usize(..hairs);
        let mut look = MemberLook::PLAIN;
        for (region, color, factors) in [
            (Region::Skin, SKINS[skin], &PAINTED_SKINS[..]),
            (Region::Hair, HAIRS[hair], &PAINTED_HAIRS),
            (Region::Top, TOPS[random.usize(..TOPS.len())], &PAINTED_CLOTHES),
            (Region::Trousers, TROUSERS[random.usize(..TROUSERS.len())], &PAINTED_CLOTHES),
            (Region::Shoes, SHOES[random.usize(..SHOES.len())], &PAINTED_CLOTHES),
            (Region::Accessory, ACCESSORIES[random.usize(..ACCESSORIES.len())], &PAINTED_CLOTHES),
        ] {
            let factor = factors[random.usize(..factors.len())];
            let shade = 0.9 + 0.2 * random.f32();
            look = match self.paint.colors[usize::from(region.number())] {
                Some(_) if self.paint.painted[usize::from(region.number())] => {
                    look.tinted(region, factor)
                }
                Some(base) if region == Region::Hair && is_grey(base) => {
                    look.tinted(region, [shade; 3])
                }
                Some(base) => {
                    look.tinted(region, [0, 1, 2].map(|c| shade * color[c] / base[c].max(1e-3)))
                }
                None => look,
            };
        }
        for (group, numbers) in &self.groups {
            let shown = random.usize(..numbers.len());
            let is_worn = random.f32() < worn || group == HAIR;
            for (number, option) in numbers.iter().enumerate() {
                if number != shown || !is_worn {
                    look = look.without_option(*option);
                }
            }
        }
        look
    }
}

fn is_grey(color: [f32; 3]) -> bool {
    let [low, high] = [f32::min, f32::max].map(|of| color.into_iter().reduce(of).unwrap_or(0.0));
    low > GREY && high - low < GREY
}
