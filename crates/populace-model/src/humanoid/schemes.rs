//! Joint names of widespread rigs.

use super::{Finger, Phalanx, Role, Side};
use crate::role::{FINGERS, PHALANGES};

/// The joint names of one kind of rig, without sides, separators and capitals. If a role has
/// several names, the first one found counts.
pub(super) struct Scheme {
    pub(super) name: &'static str,
    /// Prefix words of all names.
    pub(super) drop: &'static [&'static str],
    /// Names of each role. Roles of the left side stand for both sides.
    pub(super) names: &'static [(Role, &'static [&'static str])],
    fingers: Option<Fingers>,
    /// Further joints that follow the joint of their role.
    pub(super) also: &'static [(Role, &'static [&'static str])],
}

/// Names of fingers, thumb first, and the suffixes of their joints, for thumbs and for other
/// fingers.
struct Fingers {
    names: [&'static str; 5],
    thumb: [&'static str; 3],
    others: [&'static str; 3],
}

const L: Side = Side::Left;
const NUMBERED: [&str; 3] = ["1", "2", "3"];
const PADDED: [&str; 3] = ["01", "02", "03"];

impl Scheme {
    /// Returns the names of a role's joint.
    pub(super) fn names_of(&self, role: Role) -> Vec<String> {
        let listed = self.names.iter().find(|(known, _)| *known == role.on(L));
        let mut names: Vec<String> =
            listed.into_iter().flat_map(|(_, n)| *n).map(|&n| n.to_owned()).collect();
        if let (Role::Finger(_, finger, phalanx), Some(fingers)) = (role, &self.fingers) {
            let place = FINGERS.iter().zip(fingers.names).find(|(known, _)| **known == finger);
            let ends = if finger == Finger::Thumb { fingers.thumb } else { fingers.others };
            let end = PHALANGES.iter().zip(ends).find(|(known, _)| **known == phalanx);
            if let (Some((_, name)), Some((_, end))) = (place, end) {
                names.push(format!("{name}{end}"));
            }
        }
        names
    }
}

/// All schemes. If several find the same number of roles, the first counts.
pub(super) const ALL: [Scheme; 8] =
    [KAYKIT, VRM, MIXAMO, UNREAL, RIGIFY, QUATERNIUS, CMU, POPULACE];

/// KayKit characters: few joints, with control joints beside them.
const KAYKIT: Scheme = Scheme {
    name: "KayKit",
    drop: &[],
    names: &[
        (Role::Hips, &["hips"]),
        (Role::Spine, &["spine"]),
        (Role::Chest, &["chest"]),
        (Role::Head, &["head"]),
        (Role::UpperArm(L), &["upperarm"]),
        (Role::LowerArm(L), &["lowerarm"]),
        // The wrist hardly moves in KayKit's clips, the hand does.
        (Role::Hand(L), &["hand", "wrist"]),
        (Role::UpperLeg(L), &["upperleg"]),
        (Role::LowerLeg(L), &["lowerleg"]),
        (Role::Foot(L), &["foot"]),
        (Role::Toes(L), &["toes"]),
    ],
    fingers: None,
    also: &[],
};

/// VRM 1.0 and 0.x by bone names, and the names of VRoid Studio.
const VRM: Scheme = Scheme {
    name: "VRM",
    drop: &["j", "bip", "adj", "c"],
    names: &[
        (Role::Hips, &["hips"]),
        (Role::Spine, &["spine"]),
        (Role::Chest, &["chest"]),
        (Role::UpperChest, &["upperchest"]),
        (Role::Neck, &["neck"]),
        (Role::Head, &["head"]),
        (Role::Jaw, &["jaw"]),
        (Role::Eye(L), &["eye", "faceeye"]),
        (Role::Shoulder(L), &["shoulder"]),
        (Role::UpperArm(L), &["upperarm"]),
        (Role::LowerArm(L), &["lowerarm"]),
        (Role::Hand(L), &["hand"]),
        (Role::UpperLeg(L), &["upperleg"]),
        (Role::LowerLeg(L), &["lowerleg"]),
        (Role::Foot(L), &["foot"]),
        (Role::Toes(L), &["toes", "toebase"]),
        (Role::Finger(L, Finger::Thumb, Phalanx::First), &["thumb1"]),
        (Role::Finger(L, Finger::Thumb, Phalanx::Second), &["thumb2"]),
        (Role::Finger(L, Finger::Thumb, Phalanx::Third), &["thumb3"]),
        (Role::Finger(L, Finger::Index, Phalanx::First), &["index1"]),
        (Role::Finger(L, Finger::Index, Phalanx::Second), &["index2"]),
        (Role::Finger(L, Finger::Index, Phalanx::Third), &["index3"]),
        (Role::Finger(L, Finger::Middle, Phalanx::First), &["middle1"]),
        (Role::Finger(L, Finger::Middle, Phalanx::Second), &["middle2"]),
        (Role::Finger(L, Finger::Middle, Phalanx::Third), &["middle3"]),
        (Role::Finger(L, Finger::Ring, Phalanx::First), &["ring1"]),
        (Role::Finger(L, Finger::Ring, Phalanx::Second), &["ring2"]),
        (Role::Finger(L, Finger::Ring, Phalanx::Third), &["ring3"]),
        (Role::Finger(L, Finger::Little, Phalanx::First), &["little1"]),
        (Role::Finger(L, Finger::Little, Phalanx::Second), &["little2"]),
        (Role::Finger(L, Finger::Little, Phalanx::Third), &["little3"]),
    ],
    fingers: Some(Fingers {
        names: ["thumb", "index", "middle", "ring", "little"],
        thumb: ["metacarpal", "proximal", "distal"],
        others: ["proximal", "intermediate", "distal"],
    }),
    also: &[],
};

const MIXAMO: Scheme = Scheme {
    name: "Mixamo",
    drop: &["mixamorig"],
    names: &[
        (Role::Hips, &["hips"]),
        (Role::Spine, &["spine"]),
        (Role::Chest, &["spine1"]),
        (Role::UpperChest, &["spine2"]),
        (Role::Neck, &["neck"]),
        (Role::Head, &["head"]),
        (Role::Eye(L), &["eye"]),
        (Role::Shoulder(L), &["shoulder"]),
        (Role::UpperArm(L), &["arm"]),
        (Role::LowerArm(L), &["forearm"]),
        (Role::Hand(L), &["hand"]),
        (Role::UpperLeg(L), &["upleg"]),
        (Role::LowerLeg(L), &["leg"]),
        (Role::Foot(L), &["foot"]),
        (Role::Toes(L), &["toebase"]),
    ],
    fingers: Some(Fingers {
        names: ["handthumb", "handindex", "handmiddle", "handring", "handpinky"],
        thumb: NUMBERED,
        others: NUMBERED,
    }),
    also: &[],
};

/// The mannequins of Unreal 4 and 5; the latter has five joints in the back.
const UNREAL: Scheme = Scheme {
    name: "Unreal",
    drop: &[],
    names: &[
        (Role::Hips, &["pelvis"]),
        (Role::Spine, &["spine01"]),
        (Role::Chest, &["spine02"]),
        (Role::UpperChest, &["spine05", "spine03"]),
        (Role::Neck, &["neck01"]),
        (Role::Head, &["head"]),
        (Role::Shoulder(L), &["clavicle"]),
        (Role::UpperArm(L), &["upperarm"]),
        (Role::LowerArm(L), &["lowerarm"]),
        (Role::Hand(L), &["hand"]),
        (Role::UpperLeg(L), &["thigh"]),
        (Role::LowerLeg(L), &["calf"]),
        (Role::Foot(L), &["foot"]),
        (Role::Toes(L), &["ball"]),
    ],
    fingers: Some(Fingers {
        names: ["thumb", "index", "middle", "ring", "pinky"],
        thumb: PADDED,
        others: PADDED,
    }),
    also: &[],
};

/// The deform joints of Blender's Rigify, and rigs named after them.
const RIGIFY: Scheme = Scheme {
    name: "Rigify",
    drop: &["def", "org"],
    names: &[
        (Role::Hips, &["hips", "spine"]),
        (Role::Spine, &["spine001"]),
        (Role::Chest, &["spine002"]),
        (Role::UpperChest, &["spine003"]),
        (Role::Neck, &["neck", "spine004"]),
        (Role::Head, &["head", "spine006"]),
        (Role::Jaw, &["jaw"]),
        (Role::Eye(L), &["eye"]),
        (Role::Shoulder(L), &["shoulder"]),
        (Role::UpperArm(L), &["upperarm"]),
        (Role::LowerArm(L), &["forearm"]),
        (Role::Hand(L), &["hand"]),
        (Role::UpperLeg(L), &["thigh"]),
        (Role::LowerLeg(L), &["shin"]),
        (Role::Foot(L), &["foot"]),
        (Role::Toes(L), &["toe"]),
    ],
    fingers: Some(Fingers {
        names: ["thumb", "findex", "fmiddle", "fring", "fpinky"],
        thumb: PADDED,
        others: PADDED,
    }),
    also: &[],
};

/// Characters by Quaternius. The feet of some are IK targets, and palms have a bone for each
/// finger.
const QUATERNIUS: Scheme = Scheme {
    name: "Quaternius",
    drop: &[],
    names: &[
        (Role::Hips, &["body", "hips", "root", "pelvis"]),
        (Role::Spine, &["hips", "lowerspine", "abdomen", "spine"]),
        (Role::Chest, &["abdomen", "upperspine", "torso", "chest"]),
        (Role::UpperChest, &["torso"]),
        (Role::Neck, &["neck"]),
        (Role::Head, &["head"]),
        (Role::Shoulder(L), &["shoulder"]),
        (Role::UpperArm(L), &["upperarm"]),
        (Role::LowerArm(L), &["lowerarm"]),
        (Role::Hand(L), &["palm2", "palm", "hand", "wrist", "fist"]),
        (Role::UpperLeg(L), &["upperleg"]),
        (Role::LowerLeg(L), &["lowerleg"]),
        (Role::Foot(L), &["foot"]),
        (Role::Toes(L), &["toes", "toe"]),
        (Role::Finger(L, Finger::Thumb, Phalanx::Second), &["thumb", "thumb1"]),
        (Role::Finger(L, Finger::Thumb, Phalanx::Third), &["thumb2"]),
        (Role::Finger(L, Finger::Index, Phalanx::First), &["index", "index1"]),
        (Role::Finger(L, Finger::Index, Phalanx::Second), &["index2"]),
        (Role::Finger(L, Finger::Middle, Phalanx::First), &["middle", "middle1"]),
        (Role::Finger(L, Finger::Middle, Phalanx::Second), &["middle2"]),
        (Role::Finger(L, Finger::Ring, Phalanx::First), &["ring", "ring1"]),
        (Role::Finger(L, Finger::Ring, Phalanx::Second), &["ring2"]),
    ],
    fingers: None,
    also: &[(Role::Hand(L), &["palm1", "palm3"])],
};

/// BVH files of the CMU motion capture database.
const CMU: Scheme = Scheme {
    name: "CMU",
    drop: &[],
    names: &[
        (Role::Hips, &["hips"]),
        (Role::Spine, &["lowerback"]),
        (Role::Chest, &["spine"]),
        (Role::UpperChest, &["spine1"]),
        (Role::Neck, &["neck"]),
        (Role::Head, &["head"]),
        (Role::Shoulder(L), &["shoulder"]),
        (Role::UpperArm(L), &["arm"]),
        (Role::LowerArm(L), &["forearm"]),
        (Role::Hand(L), &["hand"]),
        (Role::UpperLeg(L), &["upleg"]),
        (Role::LowerLeg(L), &["leg"]),
        (Role::Foot(L), &["foot"]),
        (Role::Toes(L), &["toebase"]),
        (Role::Finger(L, Finger::Thumb, Phalanx::First), &["thumb"]),
        (Role::Finger(L, Finger::Index, Phalanx::First), &["fingerbase"]),
        (Role::Finger(L, Finger::Index, Phalanx::Second), &["handfinger1"]),
    ],
    fingers: None,
    also: &[],
};

/// The procedural people of this project, on either of their rigs.
const POPULACE: Scheme = Scheme {
    name: "Populace",
    drop: &[],
    names: &[
        (Role::Hips, &["pelvis", "hips"]),
        (Role::Spine, &["spine1", "spine"]),
        (Role::Chest, &["spine2", "chest"]),
        (Role::UpperChest, &["spine4"]),
        (Role::Neck, &["neck1", "neck"]),
        (Role::Head, &["head"]),
        (Role::Shoulder(L), &["clavicle", "shoulder"]),
        (Role::UpperArm(L), &["upperarm"]),
        (Role::LowerArm(L), &["forearm"]),
        (Role::Hand(L), &["hand"]),
        (Role::UpperLeg(L), &["thigh", "upperleg"]),
        (Role::LowerLeg(L), &["shin", "lowerleg"]),
        (Role::Foot(L), &["foot"]),
        (Role::Toes(L), &["toes", "toe"]),
    ],
    fingers: Some(Fingers {
        names: ["thumb", "index", "middle", "ring", "little"],
        thumb: NUMBERED,
        others: NUMBERED,
    }),
    also: &[],
};
