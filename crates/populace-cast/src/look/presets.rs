//! The presets: people of different age, sex and build.

use super::outfits::{BROWN, DARK, LIGHT, OLIVE, PALE, TAN};
use super::{Bag, Bottom, Colors, Extra, Face, Glasses, Hair, Hat, Look, Reach, Rig, Top};

const BLACK_HAIR: [f32; 3] = [0.014, 0.010, 0.009];
const GREY_HAIR: [f32; 3] = [0.52, 0.50, 0.47];

impl Face {
    /// Returns an adult man's face.
    pub(super) fn man() -> Self {
        Self {
            jaw: 1.04,
            chin: 1.0,
            smile: 0.7,
            lips: 0.8,
            nose_length: 1.0,
            nose_width: 1.0,
            nose_hump: 0.1,
            brow: 0.86,
            ears: 1.0,
            eyes: 1.0,
            open: 1.0,
            lashes: 0.0,
            iris: [0.075, 0.032, 0.014],
            lip_color: [0.84, 0.60, 0.58],
        }
    }

    /// Returns an adult woman's face.
    fn woman() -> Self {
        Self {
            jaw: 0.94,
            chin: 0.85,
            smile: 0.7,
            lips: 1.2,
            nose_length: 0.88,
            nose_width: 0.90,
            nose_hump: -0.3,
            brow: 0.72,
            ears: 0.92,
            eyes: 1.06,
            open: 1.08,
            lashes: 1.0,
            iris: [0.10, 0.17, 0.08],
            lip_color: [0.86, 0.44, 0.46],
        }
    }

    /// Returns a child's face.
    fn child() -> Self {
        Self {
            jaw: 1.0,
            chin: 0.4,
            smile: 0.9,
            lips: 0.9,
            nose_length: 0.68,
            nose_width: 0.88,
            nose_hump: -0.9,
            brow: 0.62,
            ears: 1.0,
            eyes: 1.14,
            open: 1.12,
            lashes: 0.4,
            iris: [0.075, 0.032, 0.014],
            lip_color: [0.90, 0.56, 0.54],
        }
    }
}

/// Returns colours of skin and hair, with the clothes of a set of [`Colors::dressed`].
fn colors(skin: [f32; 3], hair: [f32; 3], set: usize) -> Colors {
    Colors { skin, hair, ..Colors::plain() }.dressed(set)
}

impl Look {
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
            face: Face::man(),
            hair: Hair::Short,
            hat: None,
            glasses: None,
            bag: None,
            spare: vec![
                Extra::Hair(Hair::SidePart),
                Extra::Hair(Hair::Receding),
                Extra::Hat(Hat::Cap),
                Extra::Glasses(Glasses::Square),
                Extra::Bag(Bag::Backpack),
            ],
            top: Top::Jacket,
            sleeves: Reach::Long,
            bottom: Bottom::Trousers,
            colors: colors(LIGHT, [0.05, 0.025, 0.012], 6),
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
            face: Face::woman(),
            hair: Hair::Long,
            bag: Some(Bag::Shoulder),
            spare: vec![
                Extra::Hair(Hair::Bob),
                Extra::Hair(Hair::Ponytail),
                Extra::Hat(Hat::SunHat),
                Extra::Glasses(Glasses::Sun),
            ],
            top: Top::Tee,
            sleeves: Reach::Short,
            colors: colors(PALE, [0.16, 0.07, 0.025], 0),
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
            face: Face::child(),
            bag: Some(Bag::Backpack),
            spare: vec![
                Extra::Hair(Hair::Bob),
                Extra::Hair(Hair::SidePart),
                Extra::Hat(Hat::Beanie),
                Extra::Glasses(Glasses::Round),
            ],
            top: Top::Striped,
            sleeves: Reach::Short,
            bottom: Bottom::Shorts,
            colors: colors(TAN, BLACK_HAIR, 5),
            ..Self::man()
        }
    }

    /// Returns an old man with a bent back, a receding hairline and a slow gait, on the full rig.
    #[must_use]
    pub fn old_man() -> Self {
        let mut face = Face::man();
        (face.ears, face.nose_length, face.nose_width) = (1.16, 1.12, 1.12);
        (face.open, face.lips, face.eyes, face.brow) = (0.82, 0.5, 0.95, 1.15);
        Self {
            name: "old man".into(),
            height_m: 1.68,
            shoulders: 0.95,
            waist: 1.08,
            limbs: 0.9,
            belly: 0.45,
            stoop_rad: 0.30,
            pace: 0.78,
            face,
            hair: Hair::Receding,
            glasses: Some(Glasses::Round),
            spare: vec![
                Extra::Hair(Hair::SidePart),
                Extra::Hair(Hair::Short),
                Extra::Hat(Hat::Cap),
            ],
            top: Top::Shirt,
            colors: colors(PALE, GREY_HAIR, 10),
            ..Self::man()
        }
    }

    /// Returns a tall woman, on the full rig.
    #[must_use]
    pub fn tall_woman() -> Self {
        let mut face = Face::woman();
        (face.nose_width, face.lips, face.iris) = (1.15, 1.5, [0.045, 0.02, 0.010]);
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
            face,
            hair: Hair::Bun,
            bag: None,
            spare: vec![
                Extra::Hair(Hair::Headscarf),
                Extra::Hair(Hair::Curly),
                Extra::Glasses(Glasses::Square),
                Extra::Bag(Bag::Shoulder),
            ],
            top: Top::Blouse,
            bottom: Bottom::Dress,
            colors: colors(DARK, BLACK_HAIR, 7),
            ..Self::woman()
        }
    }

    /// Returns a heavy man, on the lean rig.
    #[must_use]
    pub fn heavy_man() -> Self {
        let mut face = Face::man();
        (face.jaw, face.nose_width, face.lips, face.smile) = (1.13, 1.2, 1.1, 0.8);
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
            face,
            hair: Hair::Curly,
            spare: vec![
                Extra::Hair(Hair::Short),
                Extra::Hair(Hair::SidePart),
                Extra::Glasses(Glasses::Round),
                Extra::Bag(Bag::Shoulder),
            ],
            top: Top::Hoodie,
            colors: colors(BROWN, BLACK_HAIR, 3),
            ..Self::man()
        }
    }

    /// Returns a girl of about ten years, on the full rig.
    #[must_use]
    pub fn girl() -> Self {
        let mut face = Face::child();
        (face.lashes, face.iris) = (0.8, [0.10, 0.19, 0.30]);
        Self {
            name: "girl".into(),
            rig: Rig::Full,
            height_m: 1.36,
            head: 1.22,
            legs: 0.97,
            limbs: 0.86,
            shoulders: 0.90,
            belly: 0.1,
            face,
            hair: Hair::Ponytail,
            bag: None,
            spare: vec![
                Extra::Hair(Hair::Bob),
                Extra::Hair(Hair::Long),
                Extra::Hat(Hat::SunHat),
                Extra::Glasses(Glasses::Round),
                Extra::Bag(Bag::Shoulder),
            ],
            top: Top::Blouse,
            bottom: Bottom::Dress,
            colors: colors(LIGHT, [0.36, 0.21, 0.075], 9),
            ..Self::child()
        }
    }

    /// Returns an old woman with a bent back and a slow gait, on the lean rig.
    #[must_use]
    pub fn old_woman() -> Self {
        let mut face = Face::woman();
        (face.ears, face.nose_length, face.nose_hump) = (1.08, 1.02, 0.3);
        (face.open, face.lips, face.eyes, face.lashes) = (0.88, 0.7, 0.98, 0.3);
        Self {
            name: "old woman".into(),
            height_m: 1.56,
            hips: 1.12,
            waist: 1.06,
            limbs: 0.94,
            belly: 0.35,
            bust: 0.8,
            stoop_rad: 0.22,
            pace: 0.8,
            face,
            hair: Hair::Bob,
            spare: vec![
                Extra::Hair(Hair::Bun),
                Extra::Hair(Hair::Headscarf),
                Extra::Glasses(Glasses::Round),
            ],
            top: Top::Sweater,
            sleeves: Reach::Long,
            bottom: Bottom::Skirt,
            colors: colors(OLIVE, GREY_HAIR, 11),
            ..Self::woman()
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
            Self::girl(),
            Self::old_woman(),
        ]
    }
}
