//! Skeletons with the joint names of each known naming.

use super::*;
use crate::{JointSource, Trs};

/// Builds a skeleton from one line per joint, indented by two spaces per level.
fn skeleton(tree: &str) -> Skeleton {
    let mut path: Vec<usize> = Vec::new();
    let mut joints = Vec::new();
    for line in tree.lines().filter(|line| !line.trim().is_empty()) {
        path.truncate((line.len() - line.trim_start().len()) / 2);
        let mut rest = Trs::IDENTITY;
        rest.translation[1] = 0.1;
        joints.push(JointSource { name: line.trim().into(), parent: path.last().copied(), rest });
        path.push(joints.len() - 1);
    }
    Skeleton::new(&joints).unwrap()
}

/// Builds a body from one chain per line, with joints separated by spaces. The first joint is one
/// of an earlier line or new. `@` stands for either side, written as in `sides`.
fn body(chains: &[&str], sides: [&str; 2]) -> Skeleton {
    let mut names: Vec<String> = Vec::new();
    let mut joints: Vec<JointSource> = Vec::new();
    for chain in chains {
        for side in if chain.contains('@') { &sides[..] } else { &[""] } {
            let mut parent = None;
            for name in chain.replace('@', side).split(' ') {
                let known = names.iter().position(|n| n == name);
                parent = Some(known.unwrap_or_else(|| {
                    names.push(name.into());
                    joints.push(JointSource { name: name.into(), parent, rest: Trs::IDENTITY });
                    joints.len() - 1
                }));
            }
        }
    }
    Skeleton::new(&joints).unwrap()
}

fn found(skeleton: &Skeleton, naming: &str, count: usize, some: &[(Role, &str)]) {
    let map = RoleMap::detect(skeleton).unwrap_or_else(|| panic!("{naming} is not found"));
    let all: Vec<_> =
        map.iter().map(|(role, joint)| format!("{role}: {}", skeleton.name(joint))).collect();
    assert_eq!((map.naming(), all.len()), (naming, count), "{all:#?}");
    for (role, name) in some {
        assert_eq!(map.joint(*role).map(|j| skeleton.name(j)), Some(*name), "{role}");
    }
}

const L: Side = Side::Left;
const R: Side = Side::Right;

#[test]
fn vrm() {
    let fingers = "@Hand @ThumbMetacarpal @ThumbProximal @ThumbDistal";
    let index = "@Hand @IndexProximal @IndexIntermediate @IndexDistal";
    let chains = [
        "root hips spine chest upperChest neck head",
        "upperChest @Shoulder @UpperArm @LowerArm @Hand",
        "head @Eye",
        fingers,
        index,
        "hips @UpperLeg @LowerLeg @Foot @Toes",
    ];
    let some = [
        (Role::Hand(R), "rightHand"),
        (Role::Finger(L, Finger::Thumb, Phalanx::First), "leftThumbMetacarpal"),
    ];
    found(&body(&chains, ["left", "right"]), "VRM", 6 + 2 * 15, &some);
}

#[test]
fn vroid_studio() {
    let chains = [
        "Root J_Bip_C_Hips J_Bip_C_Spine J_Bip_C_Chest J_Bip_C_UpperChest J_Bip_C_Neck \
         J_Bip_C_Head",
        "J_Bip_C_UpperChest J_Bip_@_Shoulder J_Bip_@_UpperArm J_Bip_@_LowerArm J_Bip_@_Hand \
         J_Bip_@_Little1",
        "J_Bip_C_Head J_Adj_@_FaceEye",
        "J_Bip_C_Hips J_Bip_@_UpperLeg J_Bip_@_LowerLeg J_Bip_@_Foot J_Bip_@_ToeBase",
    ];
    found(&body(&chains, ["L", "R"]), "VRM", 6 + 2 * 10, &[(Role::Eye(L), "J_Adj_L_FaceEye")]);
}

#[test]
fn mixamo() {
    let chains = [
        "mixamorig:Hips mixamorig:Spine mixamorig:Spine1 mixamorig:Spine2 mixamorig:Neck \
         mixamorig:Head mixamorig:HeadTop_End",
        "mixamorig:Spine2 mixamorig:@Shoulder mixamorig:@Arm mixamorig:@ForeArm mixamorig:@Hand \
         mixamorig:@HandPinky1",
        "mixamorig:@Hand mixamorig:@HandThumb1 mixamorig:@HandThumb2 mixamorig:@HandThumb3 \
         mixamorig:@HandThumb4",
        "mixamorig:Hips mixamorig:@UpLeg mixamorig:@Leg mixamorig:@Foot mixamorig:@ToeBase \
         mixamorig:@Toe_End",
    ];
    let some = [(Role::UpperChest, "mixamorig:Spine2"), (Role::LowerLeg(R), "mixamorig:RightLeg")];
    found(&body(&chains, ["Left", "Right"]), "Mixamo", 6 + 2 * 12, &some);
}

#[test]
fn unreal_4_and_5() {
    let four = [
        "root pelvis spine_01 spine_02 spine_03 neck_01 head",
        "spine_03 clavicle_@ upperarm_@ lowerarm_@ hand_@ index_01_@ index_02_@ index_03_@",
        "upperarm_@ upperarm_twist_01_@",
        "pelvis thigh_@ calf_@ foot_@ ball_@",
        "root ik_foot_root ik_foot_@",
    ];
    found(
        &body(&four, ["l", "r"]),
        "Unreal",
        6 + 2 * 11,
        &[(Role::Foot(L), "foot_l"), (Role::UpperChest, "spine_03")],
    );
    let five = [
        "root pelvis spine_01 spine_02 spine_03 spine_04 spine_05 neck_01 neck_02 head",
        "spine_05 clavicle_@ upperarm_@ lowerarm_@ hand_@ index_metacarpal_@ index_01_@",
        "pelvis thigh_@ calf_@ foot_@ ball_@",
    ];
    found(&body(&five, ["l", "r"]), "Unreal", 6 + 2 * 9, &[(Role::UpperChest, "spine_05")]);
}

#[test]
fn kaykit() {
    let chains = [
        "root hips spine chest head",
        "chest upperarm@ lowerarm@ wrist@ hand@ handslot@",
        "hips upperleg@ lowerleg@ foot@ toes@",
        "root control-toe-roll@ control-heel-roll@ IK-foot@",
    ];
    found(
        &body(&chains, [".l", ".r"]),
        "KayKit",
        4 + 2 * 7,
        &[(Role::Hand(R), "hand.r"), (Role::Foot(L), "foot.l")],
    );
}

#[test]
fn rigify() {
    let chains = [
        "root DEF-spine DEF-spine.001 DEF-spine.002 DEF-spine.003 DEF-spine.004 DEF-spine.005 \
         DEF-spine.006",
        "DEF-spine.003 DEF-shoulder@ DEF-upper_arm@ DEF-forearm@ DEF-hand@ DEF-f_pinky.01@ \
         DEF-f_pinky.02@",
        "DEF-hand@ DEF-thumb.01@",
        "DEF-spine DEF-thigh@ DEF-shin@ DEF-foot@ DEF-toe@",
    ];
    let some = [
        (Role::Hips, "DEF-spine"),
        (Role::Head, "DEF-spine.006"),
        (Role::UpperArm(L), "DEF-upper_arm.L"),
    ];
    found(&body(&chains, [".L", ".R"]), "Rigify", 6 + 2 * 11, &some);
}

#[test]
fn quaternius() {
    let tree = "
Bone
  Foot.L
  Foot.R
  Body
    Hips
      Abdomen
        Torso
          Neck
            Head
          Shoulder.L
            UpperArm.L
              LowerArm.L
                Palm2.L
                  Middle1.L
                Palm1.L
                  Index.L
                Thumb.L
          Shoulder.R
            UpperArm.R
              LowerArm.R
                Palm2.R
                Palm1.R
    UpperLeg.L
      LowerLeg.L
    UpperLeg.R
      LowerLeg.R
";
    let skeleton = skeleton(tree);
    let some = [
        (Role::Hips, "Body"),
        (Role::Spine, "Hips"),
        (Role::UpperChest, "Torso"),
        (Role::Foot(L), "Foot.L"),
    ];
    found(&skeleton, "Quaternius", 6 + 2 * 7 + 3, &some);
    let map = RoleMap::detect(&skeleton).unwrap();
    let palms: Vec<_> = map.followers().iter().map(|(_, joint)| skeleton.name(*joint)).collect();
    assert_eq!(palms, ["Palm1.L", "Palm1.R"]);
}

#[test]
fn cmu() {
    let chains = [
        "Hips LowerBack Spine Spine1 Neck Neck1 Head",
        "Spine1 @Shoulder @Arm @ForeArm @Hand @FingerBase @HandIndex1",
    ];
    let mut chains = chains.to_vec();
    chains.extend([
        "Hips LHipJoint LeftUpLeg LeftLeg LeftFoot LeftToeBase",
        "Hips RHipJoint RightUpLeg RightLeg RightFoot RightToeBase",
    ]);
    let some = [(Role::Spine, "LowerBack"), (Role::UpperLeg(R), "RightUpLeg")];
    found(&body(&chains, ["Left", "Right"]), "CMU", 6 + 2 * 9, &some);
}

#[test]
fn animals_and_things_are_not_humanoid() {
    let fox =
        ["root hips spine neck head", "hips @Leg01 @Leg02 @Foot", "spine @UpperArm @ForeArm @Hand"];
    assert_eq!(RoleMap::detect(&body(&fox, ["Left", "Right"])), None);
    assert_eq!(RoleMap::detect(&skeleton("hips\n  spine\n    head")), None);
}

/// Joints of a body without any known name.
fn odd() -> Skeleton {
    body(&["a hip belly", "hip thigh@ shin@ sole@"], ["_1", "_2"])
}

const ODD: [(Role, &str); 7] = [
    (Role::Hips, "hip"),
    (Role::UpperLeg(L), "thigh_1"),
    (Role::LowerLeg(L), "shin_1"),
    (Role::Foot(L), "sole_1"),
    (Role::UpperLeg(R), "thigh_2"),
    (Role::LowerLeg(R), "shin_2"),
    (Role::Foot(R), "sole_2"),
];

#[test]
fn role_map_from_names_is_checked() {
    let skeleton = odd();
    assert_eq!(RoleMap::detect(&skeleton), None);
    let map = RoleMap::from_names(&skeleton, &ODD).unwrap();
    assert_eq!((map.naming(), map.iter().count()), ("given", 7));
    let refused = |at: usize, with: (Role, &'static str), words: &str| {
        let mut names = ODD.to_vec();
        names[at] = with;
        let error = RoleMap::from_names(&skeleton, &names).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    };
    refused(0, (Role::Hips, "hop"), "role hips: the skeleton has no joint \"hop\"");
    refused(1, (Role::UpperLeg(L), "hip"), "joint \"hip\" is hips already");
    refused(1, (Role::UpperLeg(R), "thigh_1"), "both \"thigh_1\" and \"thigh_2\" are given");
    refused(
        2,
        (Role::LowerLeg(L), "belly"),
        "joint \"belly\" is not below \"thigh_1\", which is leftUpperLeg",
    );
    refused(0, (Role::Spine, "belly"), "role hips: no joint is given");
    refused(3, (Role::Foot(L), "a"), "is not below");
    // A foot may be detached.
    let mut names = ODD;
    names[3].1 = "belly";
    RoleMap::from_names(&skeleton, &names).unwrap();
}

#[test]
fn roles_display_their_vrm_names() {
    let names = [
        (Role::UpperChest, "upperChest"),
        (Role::Eye(R), "rightEye"),
        (Role::UpperArm(L), "leftUpperArm"),
        (Role::Finger(L, Finger::Thumb, Phalanx::First), "leftThumbMetacarpal"),
        (Role::Finger(R, Finger::Ring, Phalanx::Second), "rightRingIntermediate"),
    ];
    for (role, name) in names {
        assert_eq!(role.to_string(), name);
    }
}
