//! Properties of what people do in streets and stands: poses at the ends, seats, cars, hands.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3};
use populace_cast::{
    Bottom, CAR_FLOOR_M, CAR_SEAT_M, DOOR_HANDLE_M, LEAN_WALL_M, Look, PUSH_BAR, Rig, SEAT_BACK_M,
    SEAT_HEIGHT_M, STEERING_WHEEL_M, STEERING_WHEEL_RADIUS_M, STEERING_WHEEL_TILT_RAD, Side, grip,
    option_of, person,
};
use populace_character::Character;
use populace_clip::Clip;

use crate::people;
use crate::skinning::{Surface, models, times};

/// Clips that play once, and those in whose first poses they begin and end.
const ENDS: [(&str, &str, &str); 8] = [
    ("Sit_Down", "Idle", "Sit"),
    ("Stand_Up", "Sit", "Idle"),
    ("Point", "Idle", "Idle"),
    ("Open_Door", "Idle", "Idle"),
    ("Spear_Thrust", "Idle", "Idle"),
    ("Hit", "Idle", "Idle"),
    ("Push_Away", "Idle", "Idle"),
    ("Get_In", "Idle", ""),
];
/// Least height in metres of a person whose feet reach the ground from a seat.
const ADULT_M: f64 = 1.5;

pub(crate) fn clip<'a>(character: &'a Character, name: &str) -> &'a Clip {
    character.clips.iter().find(|clip| clip.name() == name).unwrap()
}

fn at(character: &Character, name: &str, secs: f64) -> Vec<DAffine3> {
    models(character, Some((clip(character, name), secs)))
}

fn last(character: &Character, name: &str) -> Vec<DAffine3> {
    at(character, name, f64::from(clip(character, name).duration_secs()))
}

/// Returns the index of a joint by its name on the full rig or on the lean one.
pub(crate) fn joint(character: &Character, names: [&str; 2]) -> usize {
    names.iter().find_map(|name| character.skeleton.find(name)).unwrap().index()
}

/// Returns where a prop in a hand is.
pub(crate) fn prop(character: &Character, pose: &[DAffine3], side: Side) -> DAffine3 {
    let (joint, trs) = grip(character, side).unwrap();
    let rotation = DQuat::from_array(trs.rotation.map(f64::from));
    let translation = DVec3::from(trs.translation.map(f64::from));
    pose[joint.index()] * DAffine3::from_rotation_translation(rotation, translation)
}

fn assert_equal(own: &[DAffine3], wanted: &[DAffine3], what: &str) {
    for (own, wanted) in own.iter().zip(wanted) {
        let apart = own.translation.distance(wanted.translation);
        assert!(apart < 1e-3, "{what}: a joint is {apart} m off");
        let turned = own.matrix3.abs_diff_eq(wanted.matrix3, 2e-3);
        assert!(turned, "{what}: a joint is turned");
    }
}

fn point(at: [f32; 3]) -> DVec3 {
    DVec3::from(at.map(f64::from))
}

#[test]
fn clips_begin_and_end_in_the_poses_of_others() {
    for character in people() {
        for (name, begin, end) in ENDS {
            let first = at(character, name, 0.0);
            assert_equal(&first, &at(character, begin, 0.0), &format!("{name} begins"));
            if !end.is_empty() {
                let wanted = at(character, end, 0.0);
                assert_equal(&last(character, name), &wanted, &format!("{name} ends"));
            }
        }
        let idle = at(character, "Idle", 0.0);
        assert_equal(&last(character, "Get_Out"), &idle, "Get_Out ends");
    }
}

#[test]
fn people_get_in_to_where_they_drive() {
    let [x, _, z] = CAR_SEAT_M.map(f64::from);
    let turn = DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2);
    let car = DAffine3::from_rotation_translation(turn, DVec3::new(x, 0.0, z));
    for character in people() {
        let driving: Vec<_> = at(character, "Drive", 0.0).iter().map(|m| car * *m).collect();
        assert_equal(&last(character, "Get_In"), &driving, "Get_In ends");
        assert_equal(&at(character, "Get_Out", 0.0), &driving, "Get_Out begins");
    }
}

#[test]
fn heads_pass_under_the_edge_of_the_roof() {
    for character in people() {
        let surface = Surface::bare(character);
        for name in ["Get_In", "Get_Out"] {
            let clip = clip(character, name);
            for secs in times(clip) {
                let skinned = surface.skinned(&models(character, Some((clip, secs))));
                let edge = skinned.iter().filter(|p| (p.z - 0.60).abs() < 0.03);
                let top = edge.map(|p| p.y).fold(0.0, f64::max);
                assert!(top < 1.35, "{} {name} at {secs:.2} s: {top:.3}", character.name);
            }
        }
    }
}

#[test]
fn seated_people_rest_on_the_seat_and_adults_on_their_feet() {
    for (character, look) in people().iter().zip(Look::presets()) {
        let surface = Surface::bare(character);
        let sit = clip(character, "Sit");
        let idle = at(character, "Idle", 0.0);
        let (height, back) = (f64::from(SEAT_HEIGHT_M), f64::from(SEAT_BACK_M));
        for secs in times(sit).into_iter().step_by(8) {
            let pose = models(character, Some((sit, secs)));
            let skinned = surface.skinned(&pose);
            let seat = skinned.iter().filter(|p| (p.z + back).abs() < 0.12);
            let low = seat.map(|p| p.y).fold(f64::MAX, f64::min);
            let skirt = matches!(look.bottom, Bottom::Skirt | Bottom::Dress);
            let fits = (low - height).abs() < 0.03 || skirt && low < height;
            assert!(fits, "{}: the rump is at {low:.3}", character.name);
            let ground = skinned.iter().map(|p| p.y).fold(f64::MAX, f64::min);
            assert!(ground > -0.002, "{}: {ground}", character.name);
            let feet = [["LeftFoot", "l_foot"], ["RightFoot", "r_foot"]];
            for foot in feet.map(|names| joint(character, names)) {
                let moved = pose[foot].translation.distance(idle[foot].translation);
                let stays = moved < 1e-3 || look.height_m < ADULT_M;
                assert!(stays, "{}: a foot moved by {moved:.4}", character.name);
            }
        }
    }
}

#[test]
fn feet_of_adults_stay_while_they_sit_down_and_stand_up() {
    let adults = people().iter().filter(|c| f64::from(c.height_m()) > ADULT_M);
    for character in adults {
        let idle = at(character, "Idle", 0.0);
        for name in ["Sit_Down", "Stand_Up"] {
            let clip = clip(character, name);
            for secs in times(clip) {
                let pose = models(character, Some((clip, secs)));
                for names in [["LeftToes", "l_toe"], ["RightFoot", "r_foot"]] {
                    let foot = joint(character, names);
                    let moved = pose[foot].translation.distance(idle[foot].translation);
                    assert!(moved < 4e-3, "{} {name} at {secs:.2}: {moved:.4}", character.name);
                }
            }
        }
    }
}

#[test]
fn nobody_sinks_into_the_ground() {
    for character in people() {
        let surface = Surface::bare(character);
        let clips = character.clips.iter().skip(8).filter(|clip| clip.name() != "Drive");
        for clip in clips {
            for secs in times(clip).into_iter().step_by(3) {
                let skinned = surface.skinned(&models(character, Some((clip, secs))));
                let low = skinned.iter().map(|p| p.y).fold(f64::MAX, f64::min);
                let name = clip.name();
                assert!(low > -0.02, "{} {name} at {secs:.2} s: {low:.3}", character.name);
            }
        }
    }
}

#[test]
fn drivers_hold_the_wheel_with_their_heels_on_the_floor() {
    let centre = point(STEERING_WHEEL_M);
    let axis = DQuat::from_rotation_x(f64::from(STEERING_WHEEL_TILT_RAD)) * DVec3::Z;
    for character in people() {
        let drive = clip(character, "Drive");
        let surface = Surface::bare(character);
        for secs in times(drive) {
            let pose = models(character, Some((drive, secs)));
            for side in [Side::Left, Side::Right] {
                let from = prop(character, &pose, side).translation - centre;
                let up = from.dot(axis);
                let flat = (from - axis * up).length() - f64::from(STEERING_WHEEL_RADIUS_M);
                let off = up.hypot(flat);
                assert!(off < 0.02, "{} at {secs:.2} s: {off:.3} off", character.name);
            }
        }
        let skinned = surface.skinned(&at(character, "Drive", 0.0));
        let low = skinned.iter().map(|p| p.y).fold(f64::MAX, f64::min);
        let floor = f64::from(CAR_FLOOR_M);
        assert!((low - floor).abs() < 0.012, "{}: lowest at {low:.3}", character.name);
    }
}

#[test]
fn palms_meet_eight_times_while_people_clap() {
    for character in people() {
        let clap = clip(character, "Clap");
        let h = f64::from(character.height_m());
        let hands = [
            [["LeftHand", "l_hand"], ["LeftMiddle1", "l_fingers"]],
            [["RightHand", "r_hand"], ["RightMiddle1", "r_fingers"]],
        ];
        let hands = hands.map(|hand| hand.map(|names| joint(character, names)));
        let apart = |secs: f64| {
            let pose = models(character, Some((clap, secs)));
            let [left, right] = hands.map(|[wrist, knuckle]| {
                0.25 * pose[wrist].translation + 0.75 * pose[knuckle].translation
            });
            left.distance(right) / h
        };
        for number in 0..8 {
            let (meet, open) =
                (apart(0.3 * f64::from(number)), apart(0.3 * f64::from(number) + 0.15));
            assert!((0.018..0.034).contains(&meet), "{} {number}: {meet:.4}", character.name);
            assert!(open > 0.07, "{} {number}: {open:.4}", character.name);
        }
    }
}

#[test]
fn a_hand_is_at_the_ear_and_not_in_the_head_in_phone() {
    for character in people() {
        let surface = Surface::bare(character);
        let phone = clip(character, "Phone");
        let of = |names: &[&str]| -> Vec<usize> {
            let skeleton = &character.skeleton;
            let names: Vec<_> = names.iter().filter(|n| skeleton.find(n).is_some()).collect();
            let weight = |v: usize| names.iter().map(|n| surface.weight(v, n)).sum::<f64>();
            (0..surface.rest.len()).filter(|&v| weight(v) > 0.6).collect()
        };
        let head = of(&["Head", "head"]);
        let hand = of(&["RightHand", "r_hand", "RightIndex1", "RightIndex2", "r_fingers"]);
        let (mut deepest, mut nearest) = (0.0_f64, f64::MAX);
        for secs in times(phone).into_iter().step_by(4) {
            let skinned = surface.skinned(&models(character, Some((phone, secs))));
            let inside = head.iter().map(|&v| skinned[v]).sum::<DVec3>() / head.len() as f64;
            for &v in &hand {
                let p = skinned[v];
                let near = head
                    .iter()
                    .map(|&u| skinned[u])
                    .min_by(|a, b| a.distance_squared(p).total_cmp(&b.distance_squared(p)));
                let near = near.unwrap();
                deepest = deepest.max(near.distance(inside) - p.distance(inside));
                nearest = nearest.min(near.distance(p));
            }
        }
        assert!(deepest < 0.012, "{}: {deepest:.4} m in the head", character.name);
        assert!(nearest < 0.03, "{}: {nearest:.4} m from the head", character.name);
    }
}

#[test]
fn hands_reach_bars_and_handles_and_backs_the_wall() {
    for character in people() {
        let h = f64::from(character.height_m());
        let [up, ahead] = PUSH_BAR.map(|part| f64::from(part) * h);
        for secs in times(clip(character, "Push")) {
            let pose = at(character, "Push", secs);
            for side in [Side::Left, Side::Right] {
                let hand = prop(character, &pose, side).translation;
                let off = (hand.y - up).hypot(hand.z - ahead);
                assert!(off < 0.03, "{} Push at {secs:.2}: {off:.3}", character.name);
            }
        }
        let hand = prop(character, &at(character, "Open_Door", 0.9), Side::Right).translation;
        let off = hand.distance(point(DOOR_HANDLE_M));
        assert!(off < 0.03, "{} Open_Door: {off:.3}", character.name);
        let surface = Surface::of_parts(character, |p| option_of(&p.node_name).is_none());
        for secs in times(clip(character, "Lean")).into_iter().step_by(6) {
            let skinned = surface.skinned(&at(character, "Lean", secs));
            let back = -skinned.iter().map(|p| p.z).fold(f64::MAX, f64::min);
            let off = back - f64::from(LEAN_WALL_M);
            assert!(off.abs() < 0.035, "{} Lean at {secs:.2}: {off:.3}", character.name);
        }
    }
}

#[test]
fn spears_and_shields_point_forward() {
    for character in people() {
        for secs in times(clip(character, "Spear")) {
            let tip = prop(character, &at(character, "Spear", secs), Side::Right).matrix3.y_axis;
            let ready = tip.y > 0.45 && tip.z > 0.45 && tip.x.abs() < 0.3;
            assert!(ready, "{} Spear at {secs:.2}: {tip:.2}", character.name);
        }
        let tip = prop(character, &at(character, "Spear_Thrust", 0.8), Side::Right).matrix3.y_axis;
        assert!(tip.z > 0.95, "{} Spear_Thrust: {tip:.2}", character.name);
        for secs in times(clip(character, "Shield")) {
            let shield = prop(character, &at(character, "Shield", secs), Side::Left);
            let (up, face) = (shield.matrix3.y_axis, shield.matrix3.z_axis);
            let held = up.y > 0.9 && face.z > 0.9;
            assert!(held, "{} Shield at {secs:.2}: {up:.2} {face:.2}", character.name);
        }
    }
}

#[test]
fn no_joint_is_too_fast() {
    for character in people() {
        for clip in character.clips.iter().skip(8) {
            let poses: Vec<_> = times(clip)
                .into_iter()
                .map(|secs| (secs, models(character, Some((clip, secs)))))
                .collect();
            for pair in poses.windows(2) {
                let [(from, before), (to, now)] = [&pair[0], &pair[1]];
                let moved =
                    before.iter().zip(now).map(|(a, b)| a.translation.distance(b.translation));
                let speed = moved.fold(0.0, f64::max) / (to - from);
                let name = clip.name();
                assert!(speed < 7.0, "{} {name} at {from:.2} s: {speed:.1} m/s", character.name);
            }
        }
    }
}

#[test]
fn both_rigs_move_alike() {
    let rigs = [Rig::Full, Rig::Lean].map(|rig| person(&Look { rig, ..Look::man() }).unwrap());
    let pairs = [
        ["LeftHand", "l_hand"],
        ["RightHand", "r_hand"],
        ["LeftFoot", "l_foot"],
        ["RightFoot", "r_foot"],
        ["Pelvis", "hips"],
        ["Head", "head"],
    ];
    for (clip, other) in rigs[0].clips.iter().zip(&rigs[1].clips).skip(8) {
        for secs in times(clip).into_iter().step_by(4) {
            let full = models(&rigs[0], Some((clip, secs)));
            let lean = models(&rigs[1], Some((other, secs)));
            for names in pairs {
                let [a, b] = [(&full, &rigs[0]), (&lean, &rigs[1])]
                    .map(|(pose, person)| pose[joint(person, names)].translation);
                let apart = a.distance(b);
                let what = (clip.name(), names[0]);
                assert!(apart < 0.05, "{what:?} at {secs:.2} s: {apart:.3} m apart");
            }
        }
    }
}

#[test]
fn outfits_of_a_build_share_their_clips() {
    let presets = Look::presets().len();
    let people = populace_cast::people(3).unwrap();
    let looks = |n| Look::presets().into_iter().map(move |look| look.in_outfit(n));
    let skirts: Vec<bool> = (0..3)
        .flat_map(looks)
        .map(|look| matches!(look.bottom, Bottom::Skirt | Bottom::Dress))
        .collect();
    for (number, person) in people.iter().enumerate() {
        // Hands lie elsewhere on skirts.
        let alike = |other: &usize| other % presets == number % presets;
        let same = (0..=number).filter(alike).find(|other| skirts[*other] == skirts[number]);
        let first = &people[same.unwrap()];
        let rests = |c: &Character| c.skeleton.rest_models();
        assert!(rests(person) == rests(first), "{}", person.name);
        assert_eq!(person.skeleton.reach_m(), first.skeleton.reach_m(), "{}", person.name);
        for (own, shared) in person.clips.iter().zip(&first.clips) {
            assert!(Arc::ptr_eq(own, shared), "{} {}", person.name, own.name());
        }
    }
    let [a, b] = [0, 1].map(|number| &people[number].clips[0]);
    assert!(!Arc::ptr_eq(a, b), "builds share a clip");
}

#[test]
fn small_children_sit_and_drive_too() {
    let child = person(&Look { height_m: 1.1, ..Look::child() }).unwrap();
    let low = |name: &str| {
        let skinned = Surface::bare(&child).skinned(&at(&child, name, 0.0));
        skinned.iter().map(|p| p.y).fold(f64::MAX, f64::min)
    };
    assert!(low("Sit") > 0.05, "feet at {}", low("Sit"));
    assert!((low("Drive") - f64::from(CAR_FLOOR_M)).abs() < 0.02, "feet at {}", low("Drive"));
    let wheel = prop(&child, &at(&child, "Drive", 0.0), Side::Left).translation;
    let rim = wheel.distance(point(STEERING_WHEEL_M)) - f64::from(STEERING_WHEEL_RADIUS_M);
    assert!(rim.abs() < 0.03, "a hand is {rim} m from the wheel");
}
