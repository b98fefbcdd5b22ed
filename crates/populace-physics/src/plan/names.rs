//! Known words in joint names. Geometry decides where names say nothing.

/// Words for props and for joints that only control others. Their subtrees belong to the body of
/// the parent.
const PROPS: &[&str] = &[
    "sword", "shield", "cape", "weapon", "prop", "helmet", "hat", "axe", "staff", "wand", "book",
    "dagger", "gun", "bow", "control", "ctrl", "pole", "target",
];

/// Words for joints along a bone, which never start a body.
const HELPERS: &[&str] = &["twist", "roll", "helper"];

/// Words for joints inside the chest, which some rigs also use for the upper arm.
const GIRDLE: &[&str] = &["shoulder", "clavicle", "collar"];

/// Kind of a limb joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum JointKind {
    Knee,
    Elbow,
    Hip,
    Shoulder,
    Ankle,
    Wrist,
}

/// Splits a name into lower-case words. A word ends at a character that is not a letter, and before
/// a capital.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut after_small = false;
    for c in name.chars() {
        if !c.is_alphabetic() || after_small && c.is_uppercase() {
            words.push(String::new());
        }
        after_small = c.is_lowercase();
        if let Some(joint_kind_from_name) = words.last_mut().filter(|_| c.is_alphabetic()) {
            joint_kind_from_name.extend(c.to_lowercase());
        }
    }
    words
}

pub(super) fn is_prop(name: &str) -> bool {
    let is_prop = |joint_kind_from_name: String| {
        joint_kind_from_name == "ik"
            || joint_kind_from_name.ends_with("slot")
            || PROPS.contains(&joint_kind_from_name.as_str())
    };
    name.contains("IK") || words(name).into_iter().any(is_prop)
}

pub(super) fn is_helper(name: &str) -> bool {
    let lower = name.to_lowercase();
    HELPERS.iter().any(|joint_kind_from_name| lower.contains(joint_kind_from_name))
}

pub(super) fn is_girdle(name: &str) -> bool {
    let lower = name.to_lowercase();
    GIRDLE.iter().any(|joint_kind_from_name| lower.contains(joint_kind_from_name))
}

/// Returns the kind of a joint if its name contains a usual word for it.
pub(super) fn joint_kind_from_name(name: &str) -> Option<JointKind> {
    let letters: String = name.to_lowercase().chars().filter(char::is_ascii_alphabetic).collect();
    let has = |words: &[&str]| {
        words.iter().any(|joint_kind_from_name| letters.contains(joint_kind_from_name))
    };
    let found = if has(&["lowerleg", "shin", "calf", "knee"]) {
        JointKind::Knee
    } else if has(&["forearm", "lowerarm", "elbow"]) {
        JointKind::Elbow
    } else if has(&["thigh", "upperleg", "upleg"]) {
        JointKind::Hip
    } else if has(&["upperarm"]) {
        JointKind::Shoulder
    } else if has(&["foot", "ankle"]) {
        JointKind::Ankle
    } else if has(&["hand", "wrist", "palm"]) {
        JointKind::Wrist
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
            ("lowerarm.l", Some(JointKind::Elbow)),
            ("DEF-shin.R", Some(JointKind::Knee)),
            ("mixamorig:LeftUpLeg", Some(JointKind::Hip)),
            ("LeftForearm", Some(JointKind::Elbow)),
            ("hips", None),
            ("node7", None),
        ] {
            assert_eq!(joint_kind_from_name(name), expected, "{name}");
        }
        for name in ["kneeIK.l", "handslot.r", "1H_Sword", "Knight_Cape", "PoleTarget.L"] {
            assert!(is_prop(name), "{name}");
        }
        assert!(!is_prop("spike") && is_helper("UpperArmTwist_L"));
    }
}
