//! Properties of the clips in which people get up from the ground.

use glam::{DAffine3, DQuat, DVec3};
use populace_cast::{Bottom, Look};
use populace_character::Character;
use populace_clip::Clip;

use crate::people;
use crate::skinning::{Surface, models, times};

/// The clips, with the directions of head and of chest in which the person lies at the start.
const CLIPS: [(&str, [DVec3; 2]); 4] = [
    ("GetUp_Back", [DVec3::NEG_Z, DVec3::Y]),
    ("GetUp_Front", [DVec3::Z, DVec3::NEG_Y]),
    ("GetUp_Left", [DVec3::Z, DVec3::NEG_X]),
    ("GetUp_Right", [DVec3::Z, DVec3::X]),
];
/// Deepest sinking into the ground in metres, of bodies in trousers and in skirts, which give way.
const SUNK_M: [f64; 2] = [0.025, 0.07];
/// Largest gap between body and ground in metres.
const GAP_M: f64 = 0.01;

fn clip<'a>(character: &'a Character, name: &str) -> &'a Clip {
    character.clips.iter().find(|clip| clip.name() == name).unwrap()
}

/// Returns the transforms of the full rig's joint, or of the lean rig's.
fn joint(character: &Character, pose: &[DAffine3], names: [&str; 2]) -> DAffine3 {
    let skeleton = &character.skeleton;
    let found = names.iter().find_map(|name| skeleton.find(name)).unwrap();
    pose[found.index()]
}

#[test]
fn bodies_rest_on_the_ground_throughout() {
    for (character, look) in people().iter().zip(Look::presets()) {
        let surface = Surface::bare(character);
        let skirt = matches!(look.bottom, Bottom::Skirt | Bottom::Dress);
        let sunk = SUNK_M[usize::from(skirt)];
        for (name, _) in CLIPS {
            let clip = clip(character, name);
            for secs in times(clip) {
                let skinned = surface.skinned(&models(character, Some((clip, secs))));
                let low = skinned.iter().map(|p| p.y).fold(f64::MAX, f64::min);
                assert!(
                    low > -sunk && low < GAP_M,
                    "{} {name} at {secs:.2} s: lowest at {low:.4}",
                    character.name
                );
            }
        }
    }
}

#[test]
fn knees_and_elbows_bend_as_they_should() {
    let limbs = [
        (["Thigh", "Shin", "Foot"], ["upper_leg", "lower_leg", "foot"]),
        (["UpperArm", "Forearm", "Hand"], ["upper_arm", "forearm", "hand"]),
    ];
    for character in people() {
        let rest = models(character, None);
        for (name, _) in CLIPS {
            let clip = clip(character, name);
            for (side, letter) in [("Left", "l"), ("Right", "r")] {
                for (full, lean) in limbs {
                    let names: [[String; 2]; 3] = std::array::from_fn(|i| {
                        [format!("{side}{}", full[i]), format!("{letter}_{}", lean[i])]
                    });
                    let three = |pose: &[DAffine3]| {
                        [0, 1, 2].map(|i| joint(character, pose, [&names[i][0], &names[i][1]]))
                    };
                    let at_rest = three(&rest);
                    let mut worst = (1.0, 0.0);
                    for secs in times(clip) {
                        let now = three(&models(character, Some((clip, secs))));
                        // From rest to the pose, of the upper joint.
                        let turn = DQuat::from_mat3(&now[0].matrix3)
                            * DQuat::from_mat3(&at_rest[0].matrix3).inverse();
                        let [a, b, c] = now.map(|joint| joint.translation);
                        let (upper, lower) = ((b - a).normalize(), (c - b).normalize());
                        // Shins bend backwards, forearms forwards.
                        let way = if full[0] == "Thigh" { -1.0 } else { 1.0 };
                        let bend = lower - upper * lower.dot(upper);
                        let bent = bend.dot(turn * DVec3::Z) * way;
                        if bent < worst.0 {
                            worst = (bent, secs);
                        }
                    }
                    assert!(
                        worst.0 > -0.05,
                        "{} {name}: {} bends the wrong way by {worst:.3?}",
                        character.name,
                        names[1][0]
                    );
                }
            }
        }
    }
}

#[test]
fn motions_start_lying_and_end_in_the_idle() {
    for character in people() {
        let idle = models(character, Some((clip(character, "Idle"), 0.0)));
        let rest = models(character, None);
        for (name, [head, chest]) in CLIPS {
            let clip = clip(character, name);
            let end = models(character, Some((clip, f64::from(clip.duration_secs()))));
            for (own, wanted) in end.iter().zip(&idle) {
                assert!(own.abs_diff_eq(*wanted, 1e-5), "{} {name}", character.name);
            }
            let start = models(character, Some((clip, 0.0)));
            let hips = ["Pelvis", "hips"];
            let turn = DQuat::from_mat3(&joint(character, &start, hips).matrix3)
                * DQuat::from_mat3(&joint(character, &rest, hips).matrix3).inverse();
            assert!((turn * DVec3::Y).dot(head) > 0.95, "{} {name}", character.name);
            assert!((turn * DVec3::Z).dot(chest) > 0.95, "{} {name}", character.name);
            let at = joint(character, &start, hips).translation;
            assert!(at.y < 0.16 * f64::from(character.height_m()) && at.x.abs() < 0.15, "{at}");
            let head = joint(character, &start, ["Head", "head"]).translation;
            assert!(head.y < 0.15 * f64::from(character.height_m()), "{name}: head at {head}");
        }
    }
}

/// Parts that bear weight, by clip, and from when to when in seconds.
const BEARING: [(&str, [&str; 2], [f64; 2]); 9] = [
    ("GetUp_Back", ["LeftFoot", "l_foot"], [1.5, 3.6]),
    ("GetUp_Back", ["RightToes", "r_toe"], [1.55, 3.6]),
    ("GetUp_Back", ["RightHand", "r_hand"], [1.05, 1.5]),
    ("GetUp_Front", ["LeftHand", "l_hand"], [0.6, 1.85]),
    ("GetUp_Front", ["RightHand", "r_hand"], [0.6, 1.85]),
    ("GetUp_Front", ["RightFoot", "r_foot"], [1.95, 3.6]),
    ("GetUp_Left", ["RightHand", "r_hand"], [0.0, 2.05]),
    ("GetUp_Left", ["RightFoot", "r_foot"], [2.15, 3.8]),
    ("GetUp_Right", ["LeftHand", "l_hand"], [0.0, 2.05]),
];

#[test]
fn hands_and_feet_that_bear_weight_stay() {
    for character in people() {
        for (name, part, [from, to]) in BEARING {
            let clip = clip(character, name);
            let at = |secs: f64| {
                let pose = models(character, Some((clip, secs)));
                joint(character, &pose, part).translation
            };
            let first = at(from);
            let moved = times(clip)
                .into_iter()
                .filter(|secs| (from..to).contains(secs))
                .map(|secs| (at(secs).distance(first), secs))
                .fold((0.0, 0.0), |a, b| if a.0 > b.0 { a } else { b });
            assert!(moved.0 < 0.02, "{} {name}: {} moves by {moved:.3?}", character.name, part[0]);
        }
    }
}

#[test]
fn no_joint_jumps() {
    for character in people() {
        for (name, _) in CLIPS {
            let clip = clip(character, name);
            let poses: Vec<_> = times(clip)
                .into_iter()
                .map(|secs| (secs, models(character, Some((clip, secs)))))
                .collect();
            for pair in poses.windows(2) {
                let [(from, before), (to, now)] = [&pair[0], &pair[1]];
                let moved =
                    before.iter().zip(now).map(|(a, b)| a.translation.distance(b.translation));
                let speed = moved.fold(0.0, f64::max) / (to - from);
                assert!(speed < 4.5, "{} {name} at {from:.2} s: {speed:.1} m/s", character.name);
            }
        }
    }
}
