//! Constraint calls that are repeated each frame, as games make them.

use populace::model::math::vec3;
use populace::{
    Affine, ClipPlayback, LayerSettings, MemberId, Placement, Reach, Target, Trs, Weight,
};

use crate::feet::feet;
use crate::fixture::{Scene, distance, everywhere, joint};
use crate::gaze::gaze;

const FRAME_SECS: f32 = 1.0 / 60.0;
/// Duration of an ease in frames.
const EASE: u8 = 30;

fn easing() -> Weight {
    Weight::FULL.over_secs(0.5)
}

/// A point in front of the left shoulder that moves by about 5 mm a frame, within reach of the arm.
fn moving(frame: u8) -> [f32; 3] {
    let x = f32::from(frame) * 0.01;
    [0.35 + 0.15 * (3.0 * x).sin(), 1.3 + 0.2 * x, 0.3]
}

fn playing_member(scene: &mut Scene) -> MemberId {
    let member = scene.member(Placement::at([2.0, 0.3, 1.0]).facing(0.7));
    let clip = scene.clip("sway");
    scene.edit(member).play(clip, ClipPlayback::looping()).expect("a clip that plays");
    member
}

/// Returns the distance in metres of the left hand from a point in model space.
fn miss_distance(scene: &mut Scene, member: MemberId, point: [f32; 3]) -> f32 {
    distance(scene.position(member, "leftHand"), point)
}

#[test]
fn moving_target_is_met_after_the_ease() {
    everywhere(|scene| {
        let [limb, in_world, chain] =
            [playing_member(scene), playing_member(scene), playing_member(scene)];
        let world = scene.crowd.member(limb).expect("a member").placement().world_from_model();
        let arm = Reach::with(joint("leftHand")).limb(joint("leftUpperArm"), joint("leftLowerArm"));
        for frame in 0..2 * EASE {
            let point = moving(frame);
            let there = Target::Point(world.transform_point(point));
            let (shoulder, hand) = (joint("leftUpperArm"), joint("leftHand"));
            scene.edit(limb).reach(arm, Target::InModel(point), easing()).expect("an arm");
            scene.edit(in_world).reach(arm, there, easing()).expect("an arm");
            scene
                .edit(chain)
                .reach_with_chain(shoulder, hand, Target::InModel(point), easing())
                .expect("a chain");
            scene.update(FRAME_SECS);
            let [limb, in_world, chain] =
                [limb, in_world, chain].map(|m| miss_distance(scene, m, point));
            if frame + 1 >= EASE {
                assert!(
                    limb < 1e-3 && in_world < 1e-3,
                    "frame {frame}: {limb} and {in_world} m off"
                );
                assert!(chain < 0.01, "frame {frame}: the chain is {chain} m off");
            } else if frame < EASE / 2 {
                assert!(
                    limb > 0.02,
                    "frame {frame}: the hand is at the target before the ease is over"
                );
            }
        }
    });
}

#[test]
fn gaze_follows_moving_points_and_directions() {
    everywhere(|scene| {
        let still = scene.member(Placement::at([0.0; 3]));
        scene.update(0.0);
        let rest = scene.models(still);
        let [to_point, to_direction] = [playing_member(scene), playing_member(scene)];
        let turn = scene.crowd.member(to_point).expect("a member").placement().world_from_model();
        for frame in 0..2 * EASE {
            let yaw = 0.6 - 0.02 * f32::from(frame);
            let ahead = [yaw.sin(), 0.1, yaw.cos()];
            let point = [ahead[0] * 900.0, 1.6 + ahead[1] * 900.0, ahead[2] * 900.0];
            let direction = Target::Direction(turn.transform_vector(ahead));
            scene
                .edit(to_point)
                .look_at_with(&gaze(), Target::InModel(point), easing())
                .expect("a gaze");
            scene.edit(to_direction).look_at_with(&gaze(), direction, easing()).expect("a gaze");
            scene.update(FRAME_SECS);
            if frame + 1 < EASE {
                continue;
            }
            for member in [to_point, to_direction] {
                let now = scene.models(member);
                let off = vec3::sub(facing(&rest, &now), vec3::unit_or(ahead, [0.0; 3]));
                assert!(vec3::length(off) < 3e-3, "frame {frame}: {off:?}");
            }
        }
    });
}

/// Returns the direction in model space in which the head faces.
fn facing(rest: &[Affine], now: &[Affine]) -> [f32; 3] {
    let head = joint("head").index();
    let own = [0, 1, 2].map(|c| rest[head].rows[2][c]);
    vec3::unit_or(now[head].transform_vector(own), [0.0; 3])
}

#[test]
fn late_or_easing_calls_ease_to_the_new_target() {
    everywhere(|scene| {
        let [late, soon] = [playing_member(scene), playing_member(scene)];
        let arm = Reach::with(joint("leftHand")).limb(joint("leftUpperArm"), joint("leftLowerArm"));
        let (first, second) = ([0.5, 1.2, 0.35], [0.25, 1.5, 0.4]);
        for member in [late, soon] {
            scene.edit(member).reach(arm, Target::InModel(first), easing()).expect("an arm");
        }
        scene.update(0.6);
        scene.edit(soon).reach(arm, Target::InModel(first), easing()).expect("an arm");
        scene.update(0.2);
        scene.edit(late).reach(arm, Target::InModel(second), easing()).expect("an arm");
        scene
            .edit(soon)
            .reach(arm, Target::InModel(second), easing().easing_over())
            .expect("an arm");
        for member in [late, soon] {
            scene.update(0.0);
            assert!(miss_distance(scene, member, first) < 1e-3, "the hand jumped");
        }
        // Further calls with the second point continue the ease from the first.
        for _ in 0..EASE {
            for member in [late, soon] {
                scene.edit(member).reach(arm, Target::InModel(second), easing()).expect("an arm");
            }
            scene.update(FRAME_SECS);
        }
        for member in [late, soon] {
            assert!(
                miss_distance(scene, member, second) < 1e-3,
                "the hand is not at the second point"
            );
        }
    });
}

/// A new weight starts a new ease from the current weight.
#[test]
fn changed_weight_eases_from_the_current_weight() {
    everywhere(|scene| {
        let member = playing_member(scene);
        let arm = Reach::with(joint("leftHand")).limb(joint("leftUpperArm"), joint("leftLowerArm"));
        let target = Target::InModel([0.5, 1.2, 0.35]);
        let mut last = None;
        for frame in 0..6 * EASE {
            let weight = if (frame / 20).is_multiple_of(2) {
                easing()
            } else {
                Weight::new(0.3).expect("a weight")
            };
            scene.edit(member).reach(arm, target, weight).expect("an arm");
            scene.update(FRAME_SECS);
            let hand = scene.position(member, "leftHand");
            let step = last.map_or(0.0, |last| distance(last, hand));
            assert!(step < 0.06, "frame {frame}: the hand jumped by {step} m");
            last = Some(hand);
        }
    });
}

/// A member that gets each call once and a member that gets it every frame show the same pose.
#[test]
fn repeated_equal_calls_change_nothing() {
    everywhere(|scene| {
        let torch = scene.member(Placement::at([0.0; 3]));
        let [once, each_frame] = [playing_member(scene), playing_member(scene)];
        let attachments =
            [once, each_frame].map(|member| (scene.member(Placement::at([0.0; 3])), member));
        let walk = scene.clip("walk");
        let layered = [once, each_frame].map(|member| {
            let play = ClipPlayback::looping().on_layer(1).weight(0.2);
            scene.edit(member).blend(walk, play).expect("a clip that plays")
        });
        for frame in 0..150_u8 {
            for (nth, member) in [once, each_frame].into_iter().enumerate() {
                // Repeated calls must continue, not restart, the constraints, the attachment and
                // the fades.
                let (begins, ends, stops) = (frame == 0, frame == 50, frame == 90);
                let is_called =
                    |at: bool, from: u8, to: u8| at || (nth == 1 && (from..to).contains(&frame));
                if is_called(begins, 0, 50) {
                    let target = Target::Joint { member: torch, joint: joint("head") };
                    scene.edit(member).look_at_with(&gaze(), target, easing()).expect("a gaze");
                    scene.edit(member).plant_feet_with(&feet()).expect("feet");
                    scene
                        .edit(attachments[nth].0)
                        .attach_to(attachments[nth].1, joint("leftHand"), Trs::IDENTITY)
                        .expect("an attachment");
                    scene
                        .edit(member)
                        .set_layer(1, LayerSettings::default(), None)
                        .expect("a layer");
                    scene
                        .edit(layered[nth].member())
                        .set_weight(layered[nth], 0.9, 0.7)
                        .expect("a clip that plays");
                }
                if is_called(ends, 50, 90) {
                    scene.edit(member).clear_look_at(0.4).expect("a member");
                }
                if is_called(stops, 90, 130) {
                    scene.edit(member).stop(1, 0.5).expect("a member");
                }
            }
            scene.update(FRAME_SECS);
            for (a, b) in [(once, each_frame), (attachments[0].0, attachments[1].0)] {
                let [a, b] = [a, b].map(|member| scene.edit(member).palette().expect("a palette"));
                assert!(a == b, "poses differ in frame {frame}");
            }
        }
        assert_eq!(
            scene.crowd.member(each_frame).expect("a member").active_clips().len(),
            1,
            "the clip on layer 1 has not faded out"
        );
    });
}
