//! Properties of gaits: contact of the feet with the ground, and published joint angles.

use glam::{DAffine3, DVec3};
use populace_character::Character;
use populace_clip::Clip;

use crate::people;
use crate::skinning::{Surface, models, times};

/// Returns the names of the hip, knee, ankle and toe joints, left and right.
fn legs(character: &Character) -> [[&'static str; 4]; 2] {
    if character.skeleton.joint_count() == 54 {
        [
            ["LeftThigh", "LeftShin", "LeftFoot", "LeftToes"],
            ["RightThigh", "RightShin", "RightFoot", "RightToes"],
        ]
    } else {
        [
            ["l_upper_leg", "l_lower_leg", "l_foot", "l_toe"],
            ["r_upper_leg", "r_lower_leg", "r_foot", "r_toe"],
        ]
    }
}

fn clip<'a>(character: &'a Character, name: &str) -> &'a Clip {
    character.clips.iter().find(|c| c.name() == name).unwrap()
}

/// Returns time in seconds and skinned vertices at all [`times`] of a clip.
fn frames(character: &Character, surface: &Surface<'_>, clip: &Clip) -> Vec<(f64, Vec<DVec3>)> {
    times(clip)
        .into_iter()
        .map(|t| (t, surface.skinned(&models(character, Some((clip, t))))))
        .collect()
}

#[test]
fn planted_feet_do_not_slide() {
    for character in people() {
        let surface = Surface::welded(character);
        for name in ["Walk", "Run", "Idle", "Idle_Shift"] {
            let clip = clip(character, name);
            let speed = f64::from(clip.stats().ground_speed_m_per_sec.unwrap());
            let frames = frames(character, &surface, clip);
            for [_, _, foot, toes] in legs(character) {
                let own: Vec<usize> = (0..surface.rest.len())
                    .filter(|&v| surface.weight(v, foot) + surface.weight(v, toes) > 0.99)
                    .collect();
                let mut slide = DVec3::ZERO;
                let mut steps = 0;
                for pair in frames.windows(2) {
                    let secs = pair[1].0 - pair[0].0;
                    let on_ground = |v: &&usize| pair.iter().all(|(_, p)| p[**v].y < 0.002);
                    let offsets: Vec<DVec3> = own
                        .iter()
                        .filter(on_ground)
                        .map(|&v| pair[1].1[v] - pair[0].1[v] + DVec3::Z * speed * secs)
                        .collect();
                    if !offsets.is_empty() {
                        steps += 1;
                        slide += offsets.iter().sum::<DVec3>() / offsets.len() as f64;
                    }
                }
                assert!(
                    steps >= frames.len() / 4,
                    "{} {name}: {foot} is on the ground {steps} times",
                    character.name
                );
                assert!(
                    slide.length() < 0.01,
                    "{} {name}: {foot} slides by {slide}",
                    character.name
                );
            }
        }
    }
}

#[test]
fn walk_keeps_ground_contact_and_run_has_a_flight_phase() {
    for character in people() {
        let surface = Surface::welded(character);
        for name in ["Walk", "Run", "Idle", "Idle_Shift"] {
            let lowest: Vec<f64> = frames(character, &surface, clip(character, name))
                .iter()
                .map(|(_, points)| points.iter().map(|p| p.y).fold(f64::INFINITY, f64::min))
                .collect();
            let least = lowest.iter().copied().fold(f64::INFINITY, f64::min);
            let most = lowest.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let sunk = if name == "Run" { -0.010 } else { -0.005 };
            assert!(least > sunk, "{} {name} sinks to {least}", character.name);
            let fits = if name == "Run" { (0.015..0.15).contains(&most) } else { most < 0.005 };
            assert!(fits, "{} {name} rises to {most}", character.name);
        }
    }
}

/// Returns the angles of the left leg in degrees: thigh from the vertical, positive forward, and
/// flexion of the knee.
fn leg_angles(character: &Character, clip: &Clip, secs: f64) -> [f64; 2] {
    let pose = models(character, Some((clip, secs)));
    let [hip, knee, ankle, _] = legs(character)[0]
        .map(|name| pose[character.skeleton.find(name).unwrap().index()].translation);
    let (thigh, shin) = (knee - hip, ankle - knee);
    [thigh.z.atan2(-thigh.y).to_degrees(), thigh.angle_between(shin).to_degrees()]
}

#[test]
fn leg_angles_match_published_ranges() {
    for character in people() {
        let walk = clip(character, "Walk");
        let secs = f64::from(walk.duration_secs());
        let angles: Vec<[f64; 2]> =
            (0..100).map(|i| leg_angles(character, walk, secs * f64::from(i) / 100.0)).collect();
        let most =
            |of: usize| (0..100).max_by(|&a, &b| angles[a][of].total_cmp(&angles[b][of])).unwrap();
        let least =
            |of: usize| (0..100).min_by(|&a, &b| angles[a][of].total_cmp(&angles[b][of])).unwrap();
        // In normal walking the flexion of the knee has its maximum of about 60 degrees in early
        // swing. The thigh is farthest back at push-off and has a range of about 40 degrees.
        // Sources: see src/motion/gait.rs.
        let name = &character.name;
        assert!(
            (67..80).contains(&most(1)) && (50.0..72.0).contains(&angles[most(1)][1]),
            "{name}: the knee bends by {:.0} at {}",
            angles[most(1)][1],
            most(1)
        );
        assert!((40..67).contains(&least(0)), "{name}: the thigh is back at {}", least(0));
        let range = angles[most(0)][0] - angles[least(0)][0];
        assert!((29.0..52.0).contains(&range), "{name}: the thigh swings over {range:.0}");
        assert!(angles[0][1] < 15.0, "{name}: the knee strikes at {:.0}", angles[0][1]);
        assert!(
            angles[27][1] < 22.0,
            "{name}: in mid-stance the knee is bent by {:.0}",
            angles[27][1]
        );
    }
}

#[test]
fn arms_swing_against_legs_and_chest_against_pelvis() {
    for character in people() {
        let full = character.skeleton.joint_count() == 54;
        let [hand, pelvis, chest] =
            if full { ["LeftHand", "Pelvis", "Spine4"] } else { ["l_hand", "hips", "chest"] };
        for name in ["Walk", "Run"] {
            let clip = clip(character, name);
            let rest = models(character, None);
            // The strike of the left heel.
            let pose = models(character, Some((clip, 0.0)));
            let at = |models: &[DAffine3], name: &str| {
                models[character.skeleton.find(name).unwrap().index()]
            };
            let other = if full { "RightHand" } else { "r_hand" };
            assert!(
                at(&pose, hand).translation.z < at(&pose, other).translation.z - 0.1,
                "{}",
                character.name
            );
            let yaw = |joint: &str| {
                let rotation = at(&pose, joint).matrix3 * at(&rest, joint).matrix3.transpose();
                (rotation * DVec3::Z).x
            };
            assert!(
                yaw(pelvis) < -0.04 && yaw(chest) > 0.04,
                "{} {} {}",
                character.name,
                yaw(pelvis),
                yaw(chest)
            );
        }
    }
}
