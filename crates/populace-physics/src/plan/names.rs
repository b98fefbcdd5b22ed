//! What names tell, where they tell anything: geometry decides the rest.

/// Things that a body carries, and joints that only steer others. Their subtrees stay with the body
/// that they hang on.
const PROPS: &[&str] = &[
    "sword", "shield", "cape", "weapon", "prop", "helmet", "hat", "axe", "staff", "wand", "book",
    "dagger", "gun", "bow", "control", "ctrl", "pole", "target",
];

/// Joints along a bone: never bodies of their own.
const HELPERS: &[&str] = &["twist", "roll", "helper"];

/// Joints that lie within the chest, unless the name means the arm itself.
const GIRDLE: &[&str] = &["shoulder", "clavicle", "collar"];

/// What a name says about a limb's joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Word {
    Knee,
    Elbow,
    Hip,
    Shoulder,
    Ankle,
    Wrist,
}

/// The words of a name, lower case: they end at whatever is no letter, and before a capital.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut after_small = false;
    for c in name.chars() {
        if !c.is_alphabetic() || after_small && c.is_uppercase() {
            words.push(String::new());
        }
        after_small = c.is_lowercase();
        if let Some(word) = words.last_mut().filter(|_| c.is_alphabetic()) {
            word.extend(c.to_lowercase());
        }
    }
    words
}

pub(super) fn is_prop(name: &str) -> bool {
    let is_prop =
        |word: String| word == "ik" || word.ends_with("slot") || PROPS.contains(&word.as_str());
    name.contains("IK") || words(name).into_iter().any(is_prop)
}

pub(super) fn is_helper(name: &str) -> bool {
    let lower = name.to_lowercase();
    HELPERS.iter().any(|word| lower.contains(word))
}

pub(super) fn is_girdle(name: &str) -> bool {
    let lower = name.to_lowercase();
    GIRDLE.iter().any(|word| lower.contains(word))
}

/// What the joint at the head of a body is, if its name says so in one of the usual ways.
pub(super) fn word(name: &str) -> Option<Word> {
    let letters: String = name.to_lowercase().chars().filter(char::is_ascii_alphabetic).collect();
    let has = |words: &[&str]| words.iter().any(|word| letters.contains(word));
    let found = if has(&["lowerleg", "shin", "calf", "knee"]) {
        Word::Knee
    } else if has(&["forearm", "lowerarm", "elbow"]) {
        Word::Elbow
    } else if has(&["thigh", "upperleg", "upleg"]) {
        Word::Hip
    } else if has(&["upperarm"]) {
        Word::Shoulder
    } else if has(&["foot", "ankle"]) {
        Word::Ankle
    } else if has(&["hand", "wrist", "palm"]) {
        Word::Wrist
    } else {
        return None;
    };
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_several_makers_are_understood() {
        for (name, expected) in [
            ("lowerarm.l", Some(Word::Elbow)),
            ("DEF-shin.R", Some(Word::Knee)),
            ("mixamorig:LeftUpLeg", Some(Word::Hip)),
            ("LeftForearm", Some(Word::Elbow)),
            ("hips", None),
            ("node7", None),
        ] {
            assert_eq!(word(name), expected, "{name}");
        }
        for name in ["kneeIK.l", "handslot.r", "1H_Sword", "Knight_Cape", "PoleTarget.L"] {
            assert!(is_prop(name), "{name}");
        }
        assert!(!is_prop("spike") && is_helper("UpperArmTwist_L"));
    }
}
