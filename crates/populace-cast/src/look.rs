//! Appearance and build of a person.

/// Skeleton of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rig {
    /// 25 joints with identity rest rotations, and one joint for four fingers.
    Lean,
    /// 54 joints with local Y along each joint's segment, and three joints for each finger.
    Full,
}

/// Hair style.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hair {
    /// Short hair that leaves the ears and the nape free.
    Short,
    /// Long hair over the ears, down to the neck.
    Long,
    /// Hair gathered at the back of the head.
    Bun,
    /// Receding hairline.
    Receding,
}

impl Hair {
    /// Returns the thickness of the hair at the crown, as a fraction of the head's height.
    pub(crate) fn height(self) -> f64 {
        match self {
            Self::Short => 0.035,
            Self::Long => 0.045,
            Self::Bun => 0.03,
            Self::Receding => 0.012,
        }
    }
}

/// Length of sleeves or trouser legs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// To the middle of the upper arm, or to the knee.
    Short,
    /// To the wrist, or to the ankle.
    Long,
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
    /// Clothes below the hips.
    pub trousers: [f32; 3],
    /// Shoes.
    pub shoes: [f32; 3],
}

/// Parameters of a person. Factors are relative to an adult man of average build.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// Name of the character, for display.
    pub name: String,
    /// Skeleton.
    pub rig: Rig,
    /// Height in metres from sole to crown, including hair.
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
    /// Hair style.
    pub hair: Hair,
    /// Length of the sleeves.
    pub sleeves: Reach,
    /// Length of the trouser legs.
    pub trouser_legs: Reach,
    /// Colours of skin, hair and clothes.
    pub colors: Colors,
}

const PALE: [f32; 3] = [0.78, 0.50, 0.38];
const LIGHT: [f32; 3] = [0.68, 0.40, 0.27];
const TAN: [f32; 3] = [0.46, 0.24, 0.14];
const BROWN: [f32; 3] = [0.22, 0.10, 0.055];
const DARK: [f32; 3] = [0.11, 0.05, 0.03];

const SKINS: [[f32; 3]; 5] = [PALE, LIGHT, TAN, BROWN, DARK];
const HAIRS: [[f32; 3]; 5] = [
    [0.02, 0.012, 0.01],
    [0.06, 0.03, 0.015],
    [0.16, 0.07, 0.025],
    [0.33, 0.19, 0.07],
    [0.2, 0.05, 0.02],
];
/// Typical street wear: mostly dark or dull colours, a few bright ones.
const SHIRTS: [[f32; 3]; 9] = [
    [0.55, 0.53, 0.48],
    [0.05, 0.06, 0.10],
    [0.30, 0.05, 0.06],
    [0.10, 0.20, 0.30],
    [0.60, 0.33, 0.08],
    [0.16, 0.15, 0.15],
    [0.20, 0.28, 0.17],
    [0.42, 0.25, 0.33],
    [0.08, 0.30, 0.32],
];
const TROUSERS: [[f32; 3]; 5] = [
    [0.04, 0.06, 0.12],
    [0.05, 0.05, 0.055],
    [0.24, 0.19, 0.12],
    [0.12, 0.13, 0.15],
    [0.09, 0.06, 0.045],
];

impl Look {
    /// Returns the same build with other colours of clothes, skin and hair, and a slightly
    /// different height. Number 0 is `self` unchanged. The same number gives builds with names of
    /// different lengths different outfits.
    #[must_use]
    pub fn in_outfit(&self, number: usize) -> Self {
        let mut look = self.clone();
        if number > 0 {
            let pick = |count: usize, stride: usize| (number * stride + self.name.len()) % count;
            look.name = format!("{} {}", self.name, number + 1);
            look.height_m *= [1.0, 0.97, 1.025, 0.985, 1.015][pick(5, 1)];
            look.colors.skin = SKINS[pick(SKINS.len(), 2)];
            if self.hair != Hair::Receding {
                look.colors.hair = HAIRS[pick(HAIRS.len(), 3)];
            }
            look.colors.shirt = SHIRTS[pick(SHIRTS.len(), 5)];
            look.colors.trousers = TROUSERS[pick(TROUSERS.len(), 2)];
        }
        look
    }

    /// Returns a man of average build, on the full rig.
    #[must_use]
    pub fn man() -> Self {
        Self {
            name: "man".into(),
            rig: Rig::Full,
            height_m: 1.78,
            head: 1.0,
            legs: 1.0,
            foot: 1.0,
            shoulders: 1.0,
            hips: 1.0,
            waist: 1.0,
            limbs: 1.0,
            belly: 0.1,
            bust: 0.0,
            stoop_rad: 0.0,
            pace: 1.0,
            hair: Hair::Short,
            sleeves: Reach::Short,
            trouser_legs: Reach::Long,
            colors: Colors {
                skin: LIGHT,
                hair: [0.045, 0.022, 0.012],
                shirt: [0.07, 0.19, 0.36],
                trousers: [0.10, 0.095, 0.085],
                shoes: [0.035, 0.025, 0.02],
            },
        }
    }

    /// Returns a woman of average build, on the lean rig.
    #[must_use]
    pub fn woman() -> Self {
        Self {
            name: "woman".into(),
            rig: Rig::Lean,
            height_m: 1.67,
            shoulders: 0.9,
            hips: 1.04,
            waist: 0.86,
            limbs: 0.88,
            foot: 0.93,
            belly: 0.0,
            bust: 1.0,
            hair: Hair::Long,
            colors: Colors {
                skin: PALE,
                hair: [0.16, 0.07, 0.025],
                shirt: [0.52, 0.09, 0.10],
                trousers: [0.045, 0.07, 0.16],
                shoes: [0.25, 0.22, 0.2],
            },
            ..Self::man()
        }
    }

    /// Returns a child of about eight years, on the lean rig.
    #[must_use]
    pub fn child() -> Self {
        Self {
            name: "child".into(),
            rig: Rig::Lean,
            height_m: 1.26,
            head: 1.28,
            legs: 0.95,
            foot: 1.04,
            shoulders: 0.93,
            hips: 0.96,
            waist: 0.98,
            limbs: 0.92,
            belly: 0.15,
            trouser_legs: Reach::Short,
            colors: Colors {
                skin: TAN,
                hair: [0.02, 0.012, 0.01],
                shirt: [0.75, 0.50, 0.06],
                trousers: [0.07, 0.16, 0.12],
                shoes: [0.5, 0.08, 0.06],
            },
            ..Self::man()
        }
    }

    /// Returns an old man with a bent back, a receding hairline and a slow gait, on the full rig.
    #[must_use]
    pub fn old_man() -> Self {
        Self {
            name: "old man".into(),
            height_m: 1.68,
            shoulders: 0.95,
            waist: 1.08,
            limbs: 0.9,
            belly: 0.45,
            stoop_rad: 0.30,
            pace: 0.78,
            hair: Hair::Receding,
            sleeves: Reach::Long,
            colors: Colors {
                skin: PALE,
                hair: [0.55, 0.53, 0.5],
                shirt: [0.20, 0.24, 0.14],
                trousers: [0.22, 0.17, 0.11],
                shoes: [0.06, 0.035, 0.02],
            },
            ..Self::man()
        }
    }

    /// Returns a tall woman, on the full rig.
    #[must_use]
    pub fn tall_woman() -> Self {
        Self {
            name: "tall woman".into(),
            rig: Rig::Full,
            height_m: 1.83,
            head: 0.94,
            legs: 1.03,
            limbs: 0.84,
            hips: 0.98,
            waist: 0.82,
            bust: 0.7,
            hair: Hair::Bun,
            sleeves: Reach::Long,
            colors: Colors {
                skin: DARK,
                hair: [0.012, 0.009, 0.008],
                shirt: [0.62, 0.60, 0.55],
                trousers: [0.16, 0.03, 0.10],
                shoes: [0.02, 0.02, 0.025],
            },
            ..Self::woman()
        }
    }

    /// Returns a heavy man, on the lean rig.
    #[must_use]
    pub fn heavy_man() -> Self {
        Self {
            name: "heavy man".into(),
            rig: Rig::Lean,
            height_m: 1.75,
            shoulders: 1.07,
            hips: 1.12,
            waist: 1.34,
            limbs: 1.2,
            belly: 1.0,
            bust: 0.25,
            pace: 0.94,
            colors: Colors {
                skin: BROWN,
                hair: [0.012, 0.01, 0.01],
                shirt: [0.10, 0.30, 0.17],
                trousers: [0.13, 0.14, 0.17],
                shoes: [0.04, 0.04, 0.045],
            },
            ..Self::man()
        }
    }

    /// Returns all presets.
    #[must_use]
    pub fn presets() -> Vec<Self> {
        vec![
            Self::woman(),
            Self::man(),
            Self::child(),
            Self::old_man(),
            Self::tall_woman(),
            Self::heavy_man(),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outfits_differ_between_numbers_and_builds() {
        let looks: Vec<Look> = (0..5)
            .flat_map(|n| Look::presets().into_iter().map(move |look| look.in_outfit(n)))
            .collect();
        for (index, a) in looks.iter().enumerate() {
            for b in &looks[..index] {
                assert_ne!(a.name, b.name);
                let same = a.rig == b.rig && a.hair == b.hair && a.height_m == b.height_m;
                assert!(!same || a.colors != b.colors, "{} and {} are clones", a.name, b.name);
            }
        }
        assert_eq!(Look::man().in_outfit(0), Look::man());
    }
}
