//! People: what a body looks like and wears.

use crate::random::Random;
use crate::shape::{CHILDHOOD_ENDS, Phenotype};
use crate::surface::srgb;

/// How far down the sleeves of a top go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sleeves {
    /// To the middle of the upper arm.
    Short,
    /// To the wrist.
    Long,
}

/// The opening of a top at the neck.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Neckline {
    /// Round and close.
    Round,
    /// A notch in front.
    Vee,
}

/// Clothes of the legs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bottom {
    /// Trousers to the ankle.
    Trousers,
    /// Shorts to above the knee.
    Shorts,
    /// A skirt to above the knee.
    Skirt,
}

/// A cut of hair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Haircut {
    /// A few millimetres everywhere.
    Cropped,
    /// Short at the sides, fuller on top.
    Short,
    /// A few centimetres everywhere.
    Full,
    /// To the chin, over the ears.
    Bob,
    /// Over the back of the shoulders.
    Long,
    /// Tied back.
    Ponytail,
    /// Tied up.
    Bun,
    /// Round and curly.
    Curly,
}

/// Clothes and their colours. Colours are sRGB.
#[derive(Clone, Debug, PartialEq)]
pub struct Outfit {
    /// Sleeves of the top.
    pub sleeves: Sleeves,
    /// Neckline of the top.
    pub neckline: Neckline,
    /// Clothes of the legs.
    pub bottom: Bottom,
    /// Colour of the top.
    pub top_color: [u8; 3],
    /// Colour of trousers, shorts or skirt.
    pub bottom_color: [u8; 3],
    /// Colour of the shoes.
    pub shoe_color: [u8; 3],
    /// Colour of the soles.
    pub sole_color: [u8; 3],
}

/// Hair, skin and eyes. Colours are sRGB.
#[derive(Clone, Debug, PartialEq)]
pub struct Features {
    /// The cut of the hair.
    pub haircut: Haircut,
    /// True with a beard.
    pub beard: bool,
    /// Colour of the hair, the brows and the beard.
    pub hair_color: [u8; 3],
    /// Colour of the skin.
    pub skin_color: [u8; 3],
    /// Colour of the irises.
    pub eye_color: [u8; 3],
}

/// A dressed person to build with [`BodySystem::character`](crate::BodySystem::character).
#[derive(Clone, Debug, PartialEq)]
pub struct Person {
    /// Name of the character.
    pub name: String,
    /// Shape of the body.
    pub body: Phenotype,
    /// Hair, skin and eyes.
    pub features: Features,
    /// Clothes.
    pub outfit: Outfit,
    /// Seed of small irregularities, such as strands of hair.
    pub seed: u64,
}

const TOPS: [[u8; 3]; 16] = [
    [232, 229, 222],
    [38, 42, 52],
    [118, 30, 38],
    [46, 84, 124],
    [96, 116, 84],
    [196, 148, 62],
    [150, 152, 156],
    [58, 98, 92],
    [172, 92, 66],
    [92, 74, 112],
    [206, 184, 150],
    [30, 58, 48],
    [168, 112, 124],
    [86, 130, 160],
    [60, 60, 62],
    [214, 204, 96],
];
const BOTTOMS: [[u8; 3]; 8] = [
    [44, 58, 86],
    [66, 84, 116],
    [38, 38, 42],
    [120, 102, 78],
    [76, 72, 66],
    [30, 36, 52],
    [96, 98, 102],
    [70, 52, 42],
];
const SHOES: [([u8; 3], [u8; 3]); 6] = [
    ([226, 224, 218], [206, 200, 190]),
    ([34, 32, 32], [20, 20, 20]),
    ([88, 56, 36], [46, 32, 24]),
    ([72, 78, 88], [216, 212, 204]),
    ([44, 52, 74], [220, 218, 212]),
    ([128, 96, 66], [70, 52, 38]),
];
const DARK_HAIR: [[u8; 3]; 3] = [[22, 18, 17], [36, 26, 21], [50, 35, 26]];
const ANY_HAIR: [[u8; 3]; 7] = [
    [36, 26, 21],
    [58, 40, 28],
    [84, 58, 36],
    [126, 92, 54],
    [172, 136, 84],
    [110, 54, 30],
    [26, 22, 21],
];
const GREY_HAIR: [[u8; 3]; 3] = [[120, 116, 112], [160, 156, 150], [196, 192, 186]];
const DARK_EYES: [[u8; 3]; 2] = [[52, 32, 20], [72, 46, 28]];
const ANY_EYES: [[u8; 3]; 5] =
    [[72, 46, 28], [96, 116, 132], [74, 104, 128], [92, 100, 68], [110, 80, 46]];

/// Local targets that change a face or a build, by their two ends.
const DETAILS: [[&str; 2]; 16] = [
    ["nose/nose-scale-horiz-decr", "nose/nose-scale-horiz-incr"],
    ["nose/nose-scale-vert-decr", "nose/nose-scale-vert-incr"],
    ["nose/nose-hump-decr", "nose/nose-hump-incr"],
    ["nose/nose-point-down", "nose/nose-point-up"],
    ["nose/nose-volume-decr", "nose/nose-volume-incr"],
    ["chin/chin-width-decr", "chin/chin-width-incr"],
    ["chin/chin-height-decr", "chin/chin-height-incr"],
    ["chin/chin-prominent-decr", "chin/chin-prominent-incr"],
    ["mouth/mouth-scale-horiz-decr", "mouth/mouth-scale-horiz-incr"],
    ["mouth/mouth-upperlip-height-decr", "mouth/mouth-upperlip-height-incr"],
    ["mouth/mouth-lowerlip-height-decr", "mouth/mouth-lowerlip-height-incr"],
    ["head/head-fat-decr", "head/head-fat-incr"],
    ["head/head-scale-horiz-decr", "head/head-scale-horiz-incr"],
    ["forehead/forehead-trans-backward", "forehead/forehead-trans-forward"],
    ["torso/torso-scale-horiz-decr", "torso/torso-scale-horiz-incr"],
    ["hip/hip-scale-horiz-decr", "hip/hip-scale-horiz-incr"],
];

impl Person {
    /// Draws person `index` of a seed. The same numbers give the same person.
    #[must_use]
    pub fn random(seed: u64, index: u32) -> Self {
        let mut random = Random::new(seed, u64::from(index));
        let female = random.chance(0.5);
        let body = random_body(female, &mut random);
        let features = random_features(female, &body, &mut random);
        let outfit = random_outfit(female, &mut random);
        let kind = match (body.age, female) {
            (..CHILDHOOD_ENDS, true) => "girl",
            (..CHILDHOOD_ENDS, false) => "boy",
            (_, true) => "woman",
            (_, false) => "man",
        };
        let name = format!("{kind}-{:03}", u64::from(index) + 1);
        Self { name, body, features, outfit, seed: seed ^ u64::from(index) }
    }
}

fn random_body(female: bool, random: &mut Random) -> Phenotype {
    let age = match random.unit() {
        ..0.14 => random.between(0.2, 0.33),
        ..0.22 => random.between(CHILDHOOD_ENDS, 0.48),
        ..0.80 => random.between(0.5, 0.7),
        _ => random.between(0.72, 0.95),
    };
    let mut ancestry = [0.04 + random.unit(), 0.04 + random.unit(), 0.04 + random.unit()];
    // Most people have one main ancestry.
    ancestry[*random.pick(&[0, 1, 2])] += 2.5;
    let spread = |random: &mut Random, half: f32| 0.5 + (random.middling() - 0.5) * 2.0 * half;
    let detail = |random: &mut Random| {
        let [low, high] = *random.pick(&DETAILS);
        let way = random.between(-0.6, 0.6);
        (if way < 0.0 { low } else { high }.to_owned(), way.abs())
    };
    Phenotype {
        gender: if female { random.between(0.0, 0.12) } else { random.between(0.88, 1.0) },
        age,
        muscle: spread(random, 0.4) + if female { -0.03 } else { 0.06 },
        weight: spread(random, 0.45) + 0.02,
        height: spread(random, 0.2) - if female { 0.03 } else { 0.0 },
        proportions: random.between(0.45, 0.95),
        ancestry,
        details: (0..7).map(|_| detail(random)).collect(),
    }
}

/// Mixes skin colours of the three ancestries.
fn skin_color(ancestry: [f32; 3], random: &mut Random) -> [u8; 3] {
    let tones = [[92.0, 58.0, 42.0], [222.0, 176.0, 140.0], [230.0, 184.0, 160.0]];
    let sum: f32 = ancestry.iter().sum();
    let (lighter, warmer) = (random.between(0.88, 1.06), random.between(-4.0, 6.0));
    std::array::from_fn(|channel| {
        let mixed: f32 = tones.iter().zip(ancestry).map(|(tone, part)| tone[channel] * part).sum();
        let warmth = [warmer, 0.0, -warmer][channel];
        byte(mixed / sum * lighter + warmth)
    })
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it is clamped")]
fn byte(value: f32) -> u8 {
    value.round().clamp(0.0, 255.0) as u8
}

fn random_features(female: bool, body: &Phenotype, random: &mut Random) -> Features {
    use Haircut::{Bob, Bun, Cropped, Curly, Full, Long, Ponytail, Short};
    let sum: f32 = body.ancestry.iter().sum();
    let [african, _, caucasian] = body.ancestry.map(|part| part / sum);
    let haircut = match (female, african > 0.5) {
        (true, true) => *random.pick(&[Curly, Curly, Bun, Cropped, Ponytail, Bob]),
        (true, false) => *random.pick(&[Bob, Long, Long, Ponytail, Ponytail, Bun, Full]),
        (false, true) => *random.pick(&[Cropped, Cropped, Curly, Short]),
        (false, false) => *random.pick(&[Short, Short, Short, Full, Cropped]),
    };
    let young: &[_] = if caucasian > 0.5 { &ANY_HAIR } else { &DARK_HAIR };
    let grey = random.chance((body.age - 0.6) * 3.0);
    let hair_color = *random.pick(if grey { &GREY_HAIR } else { young });
    let eyes: &[_] = if caucasian > 0.5 { &ANY_EYES } else { &DARK_EYES };
    Features {
        haircut,
        beard: !female && body.age > 0.5 && random.chance(0.3),
        hair_color,
        skin_color: skin_color(body.ancestry, random),
        eye_color: *random.pick(eyes),
    }
}

fn random_outfit(female: bool, random: &mut Random) -> Outfit {
    let bottom = match random.unit() {
        part if female && part < 0.3 => Bottom::Skirt,
        part if part < 0.45 && part > 0.3 => Bottom::Shorts,
        _ => Bottom::Trousers,
    };
    let bottom_color = *random.pick(&BOTTOMS);
    // A top as dark as what is beneath it would hide where one ends.
    let apart = |color: &[u8; 3]| (srgb(*color) - srgb(bottom_color)).abs().max_element() > 0.06;
    let tops: Vec<_> = TOPS.iter().copied().filter(apart).collect();
    let (shoe_color, sole_color) = *random.pick(&SHOES);
    Outfit {
        sleeves: if random.chance(0.5) { Sleeves::Short } else { Sleeves::Long },
        neckline: if random.chance(0.3) { Neckline::Vee } else { Neckline::Round },
        bottom,
        top_color: *random.pick(&tops),
        bottom_color,
        shoe_color,
        sole_color,
    }
}
