//! Properties of all clips.

use glam::DVec3;
use populace_clip::Clip;

use crate::people;
use crate::skinning::{Surface, models, times};

/// Names of the clips, in their order.
const NAMES: [&str; 33] = [
    "Idle",
    "Idle_Shift",
    "Walk",
    "Run",
    "GetUp_Back",
    "GetUp_Front",
    "GetUp_Left",
    "GetUp_Right",
    "Idle_Look",
    "Look_In",
    "Lean",
    "Sit",
    "Drive",
    "Talk",
    "Talk_Listen",
    "Phone",
    "Text",
    "Wave",
    "Clap",
    "Cheer",
    "Carry",
    "Push",
    "Shield",
    "Spear",
    "Sit_Down",
    "Stand_Up",
    "Point",
    "Open_Door",
    "Get_In",
    "Get_Out",
    "Spear_Thrust",
    "Hit",
    "Push_Away",
];
/// Start of the names of clips on the ground, which play once.
const GROUND: &str = "GetUp_";

/// Returns whether a clip loops, by its place among the names.
fn loops(clip: &Clip) -> bool {
    let at = NAMES.iter().position(|name| *name == clip.name()).unwrap();
    at < 4 || (8..24).contains(&at)
}

#[test]
fn clips_are_complete_loop_and_meet_their_error_bound() {
    for character in people() {
        let names: Vec<_> = character.clips.iter().map(|c| c.name()).collect();
        assert_eq!(names, NAMES);
        for clip in &character.clips {
            for track in clip.source().tracks.iter().filter(|_| loops(clip)) {
                assert_eq!(track.value(0), track.value(track.times.len() - 1), "{}", track.joint);
            }
            let stats = clip.stats();
            assert!(stats.error_bound_m <= stats.tolerance_m, "{} {stats:?}", clip.name());
        }
    }
}

#[test]
fn no_triangle_stretches_or_collapses() {
    for character in people() {
        let surface = Surface::welded(character);
        for clip in &character.clips {
            let mut worst = [(1.0, DVec3::ZERO, 0.0); 2];
            for secs in times(clip) {
                let skinned = surface.skinned(&models(character, Some((clip, secs))));
                for t in &surface.triangles {
                    for i in 0..3 {
                        let (a, b) = (t[i], t[(i + 1) % 3]);
                        let rest = surface.rest[a].distance(surface.rest[b]);
                        let now = skinned[a].distance(skinned[b]);
                        let grown = (now - 0.004).max(0.0) / rest;
                        if grown > worst[0].0 {
                            worst[0] = (grown, surface.rest[a], secs);
                        }
                        let shrunk = (now + 0.002) / rest;
                        if shrunk < worst[1].0 {
                            worst[1] = (shrunk, surface.rest[a], secs);
                        }
                    }
                }
            }
            let wide = usize::from(!NAMES[..4].contains(&clip.name()));
            let fits = worst[0].0 < STRETCH[wide] && worst[1].0 > SHRINK[wide];
            assert!(
                fits,
                "{} {}: an edge grows or shrinks: {worst:.3?}",
                character.name,
                clip.name()
            );
        }
    }
}

/// Largest length of an edge, relative to rest, after 4 mm are subtracted: of standing and gaits, and
/// of clips on the ground, on seats and with raised arms, where joints bend as far as they can and
/// skirts spread.
const STRETCH: [f64; 2] = [2.6, 6.0];
/// Smallest length of an edge, relative to rest, after 2 mm are added.
const SHRINK: [f64; 2] = [0.15, 0.02];

#[test]
fn elbows_and_knees_keep_their_girth() {
    for character in people() {
        let surface = Surface::welded(character);
        let full = character.skeleton.joint_count() == 54;
        let hinges = if full {
            [["LeftUpperArm", "LeftForearm"], ["LeftThigh", "LeftShin"]]
        } else {
            [["l_upper_arm", "l_forearm"], ["l_upper_leg", "l_lower_leg"]]
        };
        for [upper, lower] in hinges {
            let ring: Vec<usize> = (0..surface.rest.len())
                .filter(|&v| surface.weight(v, upper) > 0.2 && surface.weight(v, lower) > 0.2)
                .collect();
            assert!(ring.len() >= 12, "{upper} and {lower} share {} vertices", ring.len());
            let joint = character.skeleton.find(lower).unwrap().index();
            let rest = models(character, None)[joint].translation;
            for clip in character.clips.iter().filter(|clip| !clip.name().starts_with(GROUND)) {
                for secs in times(clip) {
                    let pose = models(character, Some((clip, secs)));
                    let skinned = surface.skinned(&pose);
                    let mean = |points: &[DVec3], from: DVec3| {
                        ring.iter().map(|&v| points[v].distance(from)).sum::<f64>()
                            / ring.len() as f64
                    };
                    let kept = mean(&skinned, pose[joint].translation) / mean(&surface.rest, rest);
                    assert!(
                        (0.7..1.15).contains(&kept),
                        "{} {} {secs}: {lower} keeps {kept}",
                        character.name,
                        clip.name()
                    );
                    for &v in &ring {
                        let kept = skinned[v].distance(pose[joint].translation)
                            / surface.rest[v].distance(rest);
                        assert!(
                            kept > 0.5,
                            "{} {} {secs}: {lower} collapses to {kept}",
                            character.name,
                            clip.name()
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn fingers_move_in_every_clip() {
    for character in people() {
        let tips = if character.skeleton.joint_count() == 54 {
            ["LeftIndex2", "RightLittle1"]
        } else {
            ["l_fingers", "r_thumb"]
        };
        for clip in &character.clips {
            for name in tips {
                let track = clip.source().tracks.iter().find(|t| t.joint == name).unwrap();
                let first = track.value(0);
                let least = (0..track.times.len())
                    .map(|k| {
                        track.value(k).iter().zip(first).map(|(a, b)| a * b).sum::<f32>().abs()
                    })
                    .fold(1.0, f32::min);
                assert!(least < 0.9999, "{} {} {name} does not move", character.name, clip.name());
            }
        }
    }
}
