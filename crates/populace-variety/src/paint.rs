//! The colours that a character's regions have, and members in one colour.

use populace_character::{Character, Region, RegionFinder};
use populace_device::MemberLook;

/// Shades of a colour for clothes, from top to toe.
const SHADES: [(Region, f32); 4] =
    [(Region::Top, 1.0), (Region::Trousers, 0.45), (Region::Shoes, 0.2), (Region::Accessory, 0.7)];
/// Light that textures keep of a colour, on average.
const TEXTURE: f32 = 0.5;

/// The colours of a character's regions.
pub(crate) struct Paint {
    /// Mean colour of each region by its number; `None` for what it lacks.
    pub(crate) colors: [Option<[f32; 3]>; Region::COUNT],
    /// Regions with a texture, by their number.
    pub(crate) painted: [bool; Region::COUNT],
}

impl Paint {
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
        Self { colors, painted }
    }
}

/// Dresses members of one character in a colour that says something, such as their speed.
pub struct Dye(Paint);

impl Dye {
    /// Finds the clothes of a character.
    #[must_use]
    pub fn of(character: &Character) -> Self {
        Self(Paint::of(character))
    }

    /// Returns a look with clothes in shades of a linear colour. A character without regions that
    /// are clothes takes it all over.
    #[must_use]
    pub fn dyed(&self, look: MemberLook, color: [f32; 3]) -> MemberLook {
        let has = |region: &Region| self.0.colors[usize::from(region.number())].is_some();
        if !SHADES.iter().any(|(region, _)| has(region)) {
            return Region::ALL.iter().fold(look, |look, region| self.tinted(look, *region, color));
        }
        let shaded = |look, (region, shade): &(Region, f32)| {
            self.tinted(look, *region, color.map(|channel| channel * shade))
        };
        SHADES.iter().fold(look, shaded)
    }

    fn tinted(&self, look: MemberLook, region: Region, color: [f32; 3]) -> MemberLook {
        let Some(mean) = self.0.colors[usize::from(region.number())] else { return look };
        let textured = self.0.painted[usize::from(region.number())];
        let own = |channel: usize| if textured { TEXTURE } else { mean[channel].max(1e-3) };
        look.tinted(region, [0, 1, 2].map(|channel| color[channel] / own(channel)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clothes_take_the_colour_and_skin_keeps_its_own() {
        let person = populace_cast::cast().expect("people").remove(0);
        let (dye, paint) = (Dye::of(&person), Paint::of(&person));
        let red = [0.6, 0.05, 0.05];
        let look = dye.dyed(MemberLook::PLAIN, red);
        let base = paint.colors[usize::from(Region::Top.number())].expect("a top");
        let shown: Vec<f32> =
            look.tint(Region::Top).iter().zip(base).map(|(tint, base)| tint * base).collect();
        for (shown, wanted) in shown.iter().zip(red) {
            assert!((shown - wanted).abs() < 0.03, "{shown} is not {wanted}");
        }
        assert_eq!(look.tint(Region::Skin), [1.0; 3]);
        assert_ne!(look.tint(Region::Trousers), [1.0; 3]);
    }
}
