//! Appearance and build of a person.

mod face;
mod options;
mod outfits;
mod presets;

pub use face::Face;
pub use options::{Bag, Extra, Glasses, Hair, Hat};

/// Skeleton of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rig {
    /// 25 joints with identity rest rotations, and one joint for four fingers.
    Lean,
    /// 54 joints with local Y along each joint's segment, and three joints for each finger.
    Full,
}

/// Length of sleeves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// To the middle of the upper arm.
    Short,
    /// To the wrist.
    Long,
}

/// Clothes above the hips.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Top {
    /// T-shirt, worn over the trousers.
    Tee,
    /// T-shirt with a broad stripe of another colour across the chest.
    Striped,
    /// Top with a neckline that shows the collar bones, tucked in.
    Blouse,
    /// Shirt with a folded collar, tucked in.
    Shirt,
    /// Sweater with a raised neckline.
    Sweater,
    /// Sweater with a hood that lies on the back.
    Hoodie,
    /// Open jacket with lapels over a shirt of another colour. Its sleeves are always long.
    Jacket,
}

/// Clothes below the hips.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bottom {
    /// Trousers to the ankles.
    Trousers,
    /// Trousers to the knees.
    Shorts,
    /// Skirt to the knees.
    Skirt,
    /// Skirt in the colour of the top, for a dress.
    Dress,
}

/// Colours of skin, hair and clothes, as linear RGB from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Colors {
    /// Skin.
    pub skin: [f32; 3],
    /// Hair and eyebrows.
    pub hair: [f32; 3],
    /// Clothes above the hips.
    pub shirt: [f32; 3],
    /// Colour of the shirt under an open jacket, and of stripes.
    pub under: [f32; 3],
    /// Clothes below the hips.
    pub trousers: [f32; 3],
    /// Shoes.
    pub shoes: [f32; 3],
    /// Hats and headscarves.
    pub accessory: [f32; 3],
    /// Bags.
    pub bag: [f32; 3],
}

/// Parameters of a person. Factors are relative to an adult man of average build.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// Name of the character, for display.
    pub name: String,
    /// Skeleton.
    pub rig: Rig,
    /// Height in metres from sole to crown, with hair of usual thickness and no hat.
    pub height_m: f64,
    /// Factor of the head's fraction of the height.
    pub head: f64,
    /// Factor of the legs' fraction of the height.
    pub legs: f64,
    /// Factor of the length of the feet.
    pub foot: f64,
    /// Factor of the breadth of the shoulders.
    pub shoulders: f64,
    /// Factor of the breadth of the hips.
    pub hips: f64,
    /// Factor of the breadth of the waist.
    pub waist: f64,
    /// Factor of the girth of arms and legs.
    pub limbs: f64,
    /// Size of the belly, 0 (flat) to 1 (heavy).
    pub belly: f64,
    /// Size of the bust, 0 (flat) to 1.
    pub bust: f64,
    /// Angle in radians by which the back is bent forward.
    pub stoop_rad: f64,
    /// Factor of the walking and running speed.
    pub pace: f64,
    /// Face.
    pub face: Face,
    /// Hair cut, or a headscarf over the hair.
    pub hair: Hair,
    /// Hat that is worn.
    pub hat: Option<Hat>,
    /// Glasses that are worn.
    pub glasses: Option<Glasses>,
    /// Bag that is worn.
    pub bag: Option<Bag>,
    /// Options that the person may wear instead.
    pub spare: Vec<Extra>,
    /// Clothes above the hips.
    pub top: Top,
    /// Length of the sleeves.
    pub sleeves: Reach,
    /// Clothes below the hips.
    pub bottom: Bottom,
    /// Colours of skin, hair and clothes.
    pub colors: Colors,
}

impl Look {
    /// Returns what the person wears on joints: hair first.
    pub(crate) fn worn(&self) -> Vec<Extra> {
        let mut worn = vec![Extra::Hair(self.hair)];
        worn.extend(self.hat.map(Extra::Hat));
        worn.extend(self.glasses.map(Extra::Glasses));
        worn.extend(self.bag.map(Extra::Bag));
        worn
    }

    /// Returns the look that stands for all that have its joints and clips: the same build, in
    /// plain clothes, with a skirt or without, and in the thickest hair that it has.
    pub(crate) fn build(&self) -> Self {
        let extras = self.worn().into_iter().chain(self.spare.iter().copied());
        let cuts = extras.filter_map(|e| if let Extra::Hair(cut) = e { Some(cut) } else { None });
        Self {
            name: String::new(),
            face: Face::man(),
            hair: cuts.max_by_key(|cut| cut.bulk()).unwrap_or(self.hair),
            hat: None,
            glasses: None,
            bag: None,
            spare: Vec::new(),
            top: Top::Sweater,
            sleeves: Reach::Long,
            // Hands lie on skirts, which spread over the thighs.
            bottom: match self.bottom {
                Bottom::Skirt | Bottom::Dress => Bottom::Skirt,
                Bottom::Trousers | Bottom::Shorts => Bottom::Trousers,
            },
            colors: Colors::plain(),
            ..self.clone()
        }
    }

    /// Returns the names of the options' parts that the person wears. All other options of
    /// [`person_with_options`](crate::person_with_options) are hidden by default.
    #[must_use]
    pub fn worn_parts(&self) -> Vec<String> {
        self.worn().into_iter().map(Extra::part_name).collect()
    }

    /// Returns the second colour of the top, relative to the first.
    pub(crate) fn under_paint(&self) -> [f64; 3] {
        ratio(self.colors.under, self.colors.shirt)
    }

    /// Returns the colour of the soles relative to the shoes: dark leather under dark shoes, white
    /// rubber under coloured ones and brown rubber under white ones.
    pub(crate) fn sole_paint(&self) -> [f64; 3] {
        let [r, g, b] = self.colors.shoes;
        match r.max(g).max(b) {
            dark if dark < 0.08 => [0.45; 3],
            light if light > 0.5 => ratio([0.26, 0.16, 0.085], self.colors.shoes),
            _ => ratio([0.60, 0.58, 0.54], self.colors.shoes),
        }
    }
}

/// Returns the factors from one colour to another, limited so that tinted members stay in range.
fn ratio(to: [f32; 3], from: [f32; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i: usize| (f64::from(to[i]) / f64::from(from[i]).max(1e-3)).clamp(0.0, 12.0))
}

#[cfg(test)]
mod tests;
