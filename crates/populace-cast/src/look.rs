//! What a person looks like.

/// Which skeleton a body has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rig {
    /// 25 joints, rest rotations identity, fingers as one.
    Lean,
    /// 54 joints, local Y along each joint's segment, three joints to a finger.
    Full,
}

/// How hair is worn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hair {
    /// Off the ears and the nape.
    Short,
    /// Over the ears, down to the neck.
    Long,
    /// Gathered behind the head.
    Bun,
    /// Gone from the brow up.
    Receding,
}

impl Hair {
    /// How far hair stands off the crown, as a part of the head's height.
    pub(crate) fn height(self) -> f64 {
        match self {
            Self::Short => 0.035,
            Self::Long => 0.045,
            Self::Bun => 0.03,
            Self::Receding => 0.012,
        }
    }
}

/// How far a garment reaches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// To the middle of the upper arm or to the knee.
    Short,
    /// To the wrist or the ankle.
    Long,
}

/// Linear colours.
#[derive(Clone, Debug, PartialEq)]
pub struct Colors {
    /// Face, hands and what else shows.
    pub skin: [f32; 3],
    /// Hair and eyebrows.
    pub hair: [f32; 3],
    /// Above the hips.
    pub shirt: [f32; 3],
    /// Below the hips.
    pub trousers: [f32; 3],
    /// On the feet.
    pub shoes: [f32; 3],
}

/// What a person looks like. Factors are 1 for a grown man of middling build.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// A name for people.
    pub name: String,
    /// Which skeleton.
    pub rig: Rig,
    /// From sole to crown, hair included, in metres.
    pub height_m: f64,
    /// The head's part of the height.
    pub head: f64,
    /// The legs' part of the height.
    pub legs: f64,
    /// Length of the feet.
    pub foot: f64,
    /// Breadth of the shoulders.
    pub shoulders: f64,
    /// Breadth of the hips.
    pub hips: f64,
    /// Breadth of the waist.
    pub waist: f64,
    /// Girth of arms and legs.
    pub limbs: f64,
    /// How far the belly stands out, 0 for flat, 1 for heavy.
    pub belly: f64,
    /// How far the chest stands out in front, 0 for flat.
    pub bust: f64,
    /// How far the back is bent, in radians.
    pub stoop_rad: f64,
    /// Speed of walking and running.
    pub pace: f64,
    /// How hair is worn.
    pub hair: Hair,
    /// How far sleeves reach.
    pub sleeves: Reach,
    /// How far trouser legs reach.
    pub trouser_legs: Reach,
    /// Colours.
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
/// Cloth as people wear it in the street: mostly dark or dull, a few bright.
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
    /// The same build in other clothes, with other skin and hair, a little taller or shorter;
    /// number 0 is as it was. Outfits of different builds differ too.
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

    /// A man of middling build, on the full rig.
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

    /// A woman of middling build, on the lean rig.
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

    /// A child of about eight, on the lean rig.
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

    /// An old man, bent, balding and slow, on the full rig.
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

    /// A tall woman, on the full rig.
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

    /// A heavy man, on the lean rig.
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

    /// All presets.
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
