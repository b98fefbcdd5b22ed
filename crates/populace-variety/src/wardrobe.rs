//! Colours and options that a character can choose from.

use populace_character::{Character, Region, RegionFinder};
use populace_device::MemberLook;

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
    /// Mean colour of each region by its number; `None` for what it lacks.
    colors: [Option<[f32; 3]>; Region::COUNT],
    /// Regions with a texture, by their number.
    painted: [bool; Region::COUNT],
    /// Numbers of the options of each group.
    groups: Vec<(String, Vec<usize>)>,
}

impl Wardrobe {
    pub(crate) fn of(character: &Character) -> Self {
        let finder = RegionFinder::new(character);
        let mut sums = [([0.0_f64; 3], 0.0_f64); Region::COUNT];
        let mut painted = [false; Region::COUNT];
        for (number, part) in character.parts.iter().enumerate() {
            let material = part.material.map(|material| &character.materials[material]);
            let base = material.map_or([1.0; 4], |material| material.base_color);
            let is_painted = material.is_some_and(|m| m.base_color_texture.is_some());
            for (vertex, region) in finder.regions(number, &part.mesh).into_iter().enumerate() {
                let (sum, count) = &mut sums[usize::from(region.number())];
                let paint = part.mesh.colors.get(vertex).copied().unwrap_or([1.0; 4]);
                (0..3).for_each(|c| sum[c] += f64::from(base[c] * paint[c]));
                *count += 1.0;
                painted[usize::from(region.number())] |= is_painted;
            }
        }
        let colors = sums.map(|(sum, count)| {
            (count > 0.0).then(|| sum.map(|c| populace_model::convert::single(c / count)))
        });
        let mut groups: Vec<(String, Vec<usize>)> = Vec::new();
        for (number, option) in character.options().iter().enumerate() {
            match groups.iter_mut().find(|(name, _)| *name == option.group) {
                Some((_, numbers)) => numbers.push(number),
                None => groups.push((option.group.clone(), vec![number])),
            }
        }
        Self { colors, painted, groups }
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
            look = match self.colors[usize::from(region.number())] {
                Some(_) if self.painted[usize::from(region.number())] => {
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
