//! Regions by the names of materials.

use super::Region;

/// Words that begin the names of materials by region, as the built-in people have them.
const FIRST: [(&str, Region); 7] = [
    ("skin", Region::Skin),
    ("hair", Region::Hair),
    ("top", Region::Top),
    ("trousers", Region::Trousers),
    ("shoes", Region::Shoes),
    ("accessory", Region::Accessory),
    ("eyes", Region::Other),
];

/// Words of regions in the singular, where there is one. The first region of which a name has a
/// word is the material's.
const WORDS: [(Region, &[&str]); 7] = [
    (
        Region::Accessory,
        &[
            "accessory",
            "accessories",
            "backpack",
            "bag",
            "bandana",
            "belt",
            "bracelet",
            "cap",
            "earring",
            "eyewear",
            "glasses",
            "glove",
            "goggles",
            "hat",
            "headphone",
            "headset",
            "headwear",
            "helmet",
            "jewelry",
            "mask",
            "necklace",
            "scarf",
            "strap",
            "sunglasses",
            "tie",
            "watch",
        ],
    ),
    (
        Region::Other,
        &[
            "cornea", "eye", "eyeball", "iris", "lens", "pupil", "sclera", "teeth", "tongue",
            "tooth",
        ],
    ),
    (
        Region::Hair,
        &[
            "beard",
            "brow",
            "eyebrow",
            "eyelash",
            "hair",
            "haircut",
            "lash",
            "moustache",
            "mustache",
        ],
    ),
    (
        Region::Shoes,
        &[
            "boot", "footwear", "heel", "sandal", "shoe", "slipper", "sneaker", "sock", "sole",
            "trainer",
        ],
    ),
    (
        Region::Trousers,
        &[
            "bottom",
            "jeans",
            "leg",
            "legging",
            "pant",
            "short",
            "skirt",
            "slacks",
            "tights",
            "trouser",
            "underpant",
        ],
    ),
    (
        Region::Top,
        &[
            "armor", "armour", "blouse", "cardigan", "chest", "cloth", "clothes", "clothing",
            "coat", "dress", "hoodie", "jacket", "jumper", "outfit", "overall", "pullover", "robe",
            "shirt", "sleeve", "suit", "sweater", "top", "torso", "tunic", "uniform", "vest",
        ],
    ),
    (
        Region::Skin,
        &[
            "arm", "body", "face", "finger", "flesh", "foot", "feet", "hand", "head", "lip",
            "mouth", "nail", "neck", "skin",
        ],
    ),
];

/// Least length of a word that may end a longer one. Shorter ones end too many others.
const ENDING: usize = 4;

/// Words that end with one of a region and mean something else.
const OTHERS: [&str; 14] = [
    "surface",
    "interface",
    "chair",
    "wheel",
    "console",
    "flash",
    "splash",
    "clearcoat",
    "wardrobe",
    "strobe",
    "harvest",
    "address",
    "bulkhead",
    "bottleneck",
];

/// See [`Region::of_material`].
pub(super) fn region(name: &str) -> Option<Region> {
    let tokens = tokens(name);
    let first = tokens.first()?;
    if let Some((_, region)) = FIRST.iter().find(|(word, _)| word == first) {
        return Some(*region);
    }
    let tells = |words: &[&str]| tokens.iter().any(|t| words.iter().any(|w| matches(t, w)));
    WORDS.iter().find(|(_, words)| tells(words)).map(|(region, _)| *region)
}

/// Returns whether a token is a word or its plural, or ends with it.
fn matches(token: &str, word: &str) -> bool {
    let single = token.strip_suffix('s').unwrap_or(token);
    let ends = |t: &str| {
        word.len() >= ENDING && t.ends_with(word) && !OTHERS.iter().any(|other| t.ends_with(other))
    };
    [token, single].iter().any(|t| *t == word || ends(t))
}

/// Splits a name where letters stop and where a small letter meets a capital one. The tokens are in
/// small letters.
fn tokens(name: &str) -> Vec<String> {
    let mut tokens: Vec<String> = vec![String::new()];
    let mut was_small = false;
    for letter in name.chars() {
        if !letter.is_alphabetic() || (was_small && letter.is_uppercase()) {
            tokens.push(String::new());
        }
        was_small = letter.is_lowercase();
        if let Some(token) = tokens.last_mut().filter(|_| letter.is_alphabetic()) {
            token.extend(letter.to_lowercase());
        }
    }
    tokens.retain(|token| !token.is_empty());
    tokens
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_common_exporters_tell_regions() {
        for (name, region) in [
            ("Skin", Region::Skin),
            ("Skin: legs", Region::Skin),
            ("Ch03_Body", Region::Skin),
            ("Wolf3D_Skin", Region::Skin),
            ("Wolf3D_Outfit_Top", Region::Top),
            ("Wolf3D_Outfit_Bottom", Region::Trousers),
            ("Wolf3D_Outfit_Footwear", Region::Shoes),
            ("Wolf3D_Headwear", Region::Accessory),
            ("Wolf3D_Teeth", Region::Other),
            ("Eyes", Region::Other),
            ("eye white", Region::Other),
            ("eyebrows", Region::Hair),
            ("Hair_Long", Region::Hair),
            ("TShirt.001", Region::Top),
            ("bodyShirt", Region::Top),
            ("Sunglasses", Region::Accessory),
            ("BlueJeans", Region::Trousers),
            ("Trousers legs", Region::Trousers),
            ("Boots-Sole", Region::Shoes),
            ("Accessory:hair pin", Region::Accessory),
            ("longhair", Region::Hair),
            ("highheels", Region::Shoes),
            ("raincoat", Region::Top),
        ] {
            assert_eq!(region_of(name), Some(region), "{name}");
        }
    }

    #[test]
    fn other_names_tell_none() {
        for name in ["", "42", "Material.001", "atlas", "Stopwords", "alpha_body_mat2x"] {
            let told = region_of(name);
            let wanted = (name == "alpha_body_mat2x").then_some(Region::Skin);
            assert_eq!(told, wanted, "{name}");
        }
        for name in ["standardSurface1", "aiStandardSurface1", "Wheelchair", "wheels", "Console"] {
            assert_eq!(region_of(name), None, "{name}");
        }
    }

    fn region_of(name: &str) -> Option<Region> {
        Region::of_material(name)
    }
}
