//! Joint names split into the side and the rest.

use super::Side;

/// A joint's name in lower case, without separators, prefixes and the side.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Name {
    pub(super) side: Option<Side>,
    pub(super) key: String,
}

impl Name {
    /// Parses a joint's name. `drop` lists the prefix words of a naming, which are removed.
    pub(super) fn of(joint: &str, drop: &[&str]) -> Self {
        let mut words = name_words(joint);
        let dropped = words.iter().take_while(|word| drop.contains(&word.as_str())).count();
        if dropped < words.len() {
            words.drain(..dropped);
        }
        let mut side = None;
        if let Some(at) = words.iter().position(|word| side_of(word).is_some())
            && words.len() > 1
        {
            side = side_of(&words.remove(at));
        } else if let Some((first, rest)) =
            words.first().and_then(|word| Some((word, without_side_prefix(word)?)))
        {
            side = side_of(&first[..first.len() - rest.len()]);
            words[0] = rest;
        }
        Self { side, key: words.concat() }
    }
}

/// Returns the rest of a word that starts with its side, such as "leftupperarm".
fn without_side_prefix(word: &str) -> Option<String> {
    let rest = word.strip_prefix("left").or_else(|| word.strip_prefix("right"))?;
    (!rest.is_empty()).then(|| rest.to_owned())
}

fn side_of(word: &str) -> Option<Side> {
    match word {
        "l" | "left" => Some(Side::Left),
        "r" | "right" => Some(Side::Right),
        _ => None,
    }
}

/// Splits the name of a joint into lower-case words, at anything but letters and digits, and before
/// capitals that follow a lower-case letter or digit or precede a lower-case letter, as in
/// "upperLeg" and "LHipJoint". The body's name before it, as in "mixamorig:Hips" and
/// "Armature|Hips", is left out.
#[must_use]
pub fn name_words(joint: &str) -> Vec<String> {
    let bare = joint.rsplit([':', '|']).next().unwrap_or(joint);
    let mut words = vec![String::new()];
    let letters: Vec<char> = bare.chars().collect();
    for (at, &letter) in letters.iter().enumerate() {
        let before = at.checked_sub(1).map(|at| letters[at]);
        let after = letters.get(at + 1);
        let capital = letter.is_uppercase()
            && before.is_some_and(|b| !b.is_uppercase() || after.is_some_and(|a| a.is_lowercase()));
        let parts = !letter.is_alphanumeric();
        if (parts || capital) && words.last().is_some_and(|word| !word.is_empty()) {
            words.push(String::new());
        }
        if let Some(word) = words.last_mut().filter(|_| !parts) {
            word.extend(letter.to_lowercase());
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_and_prefixes_are_removed() {
        let left = |joint: &str, drop: &[&str], key: &str| {
            assert_eq!(
                Name::of(joint, drop),
                Name { side: Some(Side::Left), key: key.into() },
                "{joint}"
            );
        };
        left("mixamorig:LeftUpLeg", &[], "upleg");
        left("DEF-upper_arm.L", &["def"], "upperarm");
        left("thigh_l", &[], "thigh");
        left("J_Bip_L_UpperArm", &["j", "bip"], "upperarm");
        left("LHipJoint", &[], "hipjoint");
        left("leftupperarm", &[], "upperarm");
        left("LeftHandThumb1", &[], "handthumb1");
        let middle = |joint: &str, key: &str| {
            assert_eq!(Name::of(joint, &["def"]), Name { side: None, key: key.into() }, "{joint}");
        };
        middle("DEF-spine.001", "spine001");
        middle("spine_01", "spine01");
        middle("upperChest", "upperchest");
        middle("L", "l");
        middle("", "");
        middle("def", "def");
        middle("IK-foot", "ikfoot");
    }
}
