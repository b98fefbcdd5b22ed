//! Calls that are repeated each frame, as games make them.

use populace::model::math::vec3;
use populace::{
    Affine, ClipPlayback, LayerSettings, MemberId, Placement, Reach, Target, Trs, Weight,
};

use crate::body::{Stage, distance, everywhere, joint};
use crate::feet::feet;
use crate::gaze::gaze;

const FRAME_SECS: f32 = 1.0 / 60.0;
/// Frames that an ease takes.
const EASE: u8 = 30;

fn easing() -> Weight {
    Weight::FULL.over_secs(0.5)
}

/// A point in front of the left shoulder that moves by 5 mm a frame, within reach of the arm.
fn moving(frame: u8) -> [f32; 3] {
    let x = f32::from(frame) * 0.01;
    [0.35 + 0.15 * (3.0 * x).sin(), 1.3 + 0.2 * x, 0.3]
}

fn player(stage: &mut Stage) -> MemberId {
    let member = stage.member(Placement::at([2.0, 0.3, 1.0]).facing(0.7));
    let clip = stage.clip("sway");
    stage
        .crowd
        .member_mut(member)
        .expect("a clip that plays")
        .play(clip, ClipPlayback::looping())
        .expect("a clip that plays");
    member
}

/// How far the left hand is from a point of model space.
fn missed(stage: &mut Stage, member: MemberId, point: [f32; 3]) -> f32 {
    distance(stage.place(member, "leftHand"), point)
}

#[test]
fn a_moving_target_is_met_once_the_ease_is_over() {
    everywhere(|stage| {
        let [limb, in_world, chain] = [player(stage), player(stage), player(stage)];
        let world = stage.crowd.member(limb).expect("a member").placement().world_from_model();
        let arm = Reach::with(joint("leftHand")).limb(joint("leftUpperArm"), joint("leftLowerArm"));
        for frame in 0..2 * EASE {
            let point = moving(frame);
            let there = Target::Point(world.transform_point(point));
            let (shoulder, hand) = (joint("leftUpperArm"), joint("leftHand"));
            let crowd = &mut stage.crowd;
            crowd
                .member_mut(limb)
                .expect("an arm")
                .reach(arm, Target::InModel(point), easing())
                .expect("an arm");
            crowd
                .member_mut(in_world)
                .expect("an arm")
                .reach(arm, there, easing())
                .expect("an arm");
            crowd
                .member_mut(chain)
                .expect("a chain")
                .reach_with_chain(shoulder, hand, Target::InModel(point), easing())
                .expect("a chain");
            stage.update(FRAME_SECS);
            let [limb, in_world, chain] = [limb, in_world, chain].map(|m| missed(stage, m, point));
            if frame + 1 >= EASE {
                assert!(limb < 1e-3 && in_world < 1e-3, "frame {frame}: {limb} {in_world} m off");
                assert!(chain < 0.01, "frame {frame}: the chain is {chain} m off");
            } else if frame < EASE / 2 {
                assert!(limb > 0.02, "frame {frame}: the hand is there before it has eased in");
            }
        }
    });
}

#[test]
fn a_gaze_follows_points_and_directions_that_move() {
    everywhere(|stage| {
        let still = stage.member(Placement::at([0.0; 3]));
        stage.update(0.0);
        let rest = stage.models(still);
        let [to_point, to_direction] = [player(stage), player(stage)];
        let turn = stage.crowd.member(to_point).expect("a member").placement().world_from_model();
        for frame in 0..2 * EASE {
            let yaw = 0.6 - 0.02 * f32::from(frame);
            let ahead = [yaw.sin(), 0.1, yaw.cos()];
            let point = [ahead[0] * 900.0, 1.6 + ahead[1] * 900.0, ahead[2] * 900.0];
            let direction = Target::Direction(turn.transform_vector(ahead));
            let crowd = &mut stage.crowd;
            crowd
                .member_mut(to_point)
                .expect("a gaze")
                .look_at_with(&gaze(), Target::InModel(point), easing())
                .expect("a gaze");
            crowd
                .member_mut(to_direction)
                .expect("a gaze")
                .look_at_with(&gaze(), direction, easing())
                .expect("a gaze");
            stage.update(FRAME_SECS);
            if frame + 1 < EASE {
                continue;
            }
            for member in [to_point, to_direction] {
                let now = stage.models(member);
                let off = vec3::sub(facing(&rest, &now), vec3::unit_or(ahead, [0.0; 3]));
                assert!(vec3::length(off) < 3e-3, "frame {frame}: {off:?}");
            }
        }
    });
}

/// Where the head faces in model space.
fn facing(rest: &[Affine], now: &[Affine]) -> [f32; 3] {
    let head = joint("head").index();
    let own = [0, 1, 2].map(|c| rest[head].rows[2][c]);
    vec3::unit_or(now[head].transform_vector(own), [0.0; 3])
}

#[test]
fn calls_far_apart_or_told_to_ease_over_to_another_point() {
    everywhere(|stage| {
        let [late, soon] = [player(stage), player(stage)];
        let arm = Reach::with(joint("leftHand")).limb(joint("leftUpperArm"), joint("leftLowerArm"));
        let (first, second) = ([0.5, 1.2, 0.35], [0.25, 1.5, 0.4]);
        for member in [late, soon] {
            stage
                .crowd
                .member_mut(member)
                .expect("an arm")
                .reach(arm, Target::InModel(first), easing())
                .expect("an arm");
        }
        stage.update(0.6);
        stage
            .crowd
            .member_mut(soon)
            .expect("an arm")
            .reach(arm, Target::InModel(first), easing())
            .expect("an arm");
        stage.update(0.2);
        stage
            .crowd
            .member_mut(late)
            .expect("an arm")
            .reach(arm, Target::InModel(second), easing())
            .expect("an arm");
        stage
            .crowd
            .member_mut(soon)
            .expect("an arm")
            .reach(arm, Target::InModel(second), easing().easing_over())
            .expect("an arm");
        for member in [late, soon] {
            stage.update(0.0);
            assert!(missed(stage, member, first) < 1e-3, "it has jumped");
        }
        // Calls that follow go on with the ease, which then has both to go between.
        for _ in 0..EASE {
            for member in [late, soon] {
                stage
                    .crowd
                    .member_mut(member)
                    .expect("an arm")
                    .reach(arm, Target::InModel(second), easing())
                    .expect("an arm");
            }
            stage.update(FRAME_SECS);
        }
        for member in [late, soon] {
            assert!(missed(stage, member, second) < 1e-3, "the second point is not met");
        }
    });
}

/// Another weight begins another ease, from the weight that there is.
#[test]
fn a_weight_that_changes_eases_from_where_it_is() {
    everywhere(|stage| {
        let member = player(stage);
        let arm = Reach::with(joint("leftHand")).limb(joint("leftUpperArm"), joint("leftLowerArm"));
        let target = Target::InModel([0.5, 1.2, 0.35]);
        let mut last = None;
        for frame in 0..6 * EASE {
            let weight = if (frame / 20).is_multiple_of(2) {
                easing()
            } else {
                Weight::new(0.3).expect("a weight")
            };
            stage
                .crowd
                .member_mut(member)
                .expect("an arm")
                .reach(arm, target, weight)
                .expect("an arm");
            stage.update(FRAME_SECS);
            let hand = stage.place(member, "leftHand");
            let moved = last.map_or(0.0, |last| distance(last, hand));
            assert!(moved < 0.06, "frame {frame}: the hand has jumped by {moved} m");
            last = Some(hand);
        }
    });
}

/// What a member is told once, and another each frame, shows the same.
#[test]
fn calls_that_say_the_same_again_change_nothing() {
    everywhere(|stage| {
        let torch = stage.member(Placement::at([0.0; 3]));
        let [once, ever] = [player(stage), player(stage)];
        let props = [once, ever].map(|member| (stage.member(Placement::at([0.0; 3])), member));
        let walk = stage.clip("walk");
        let layered = [once, ever].map(|member| {
            let play = ClipPlayback::looping().on_layer(1).weight(0.2);
            stage
                .crowd
                .member_mut(member)
                .expect("a clip that plays")
                .blend(walk, play)
                .expect("a clip that plays")
        });
        for frame in 0..150_u8 {
            for (nth, member) in [once, ever].into_iter().enumerate() {
                // Each of these is to go on, not to begin over: looks, stands, carries and weighs,
                // then lets go.
                let (begins, ends, stops) = (frame == 0, frame == 50, frame == 90);
                let says =
                    |at: bool, from: u8, to: u8| at || (nth == 1 && (from..to).contains(&frame));
                let crowd = &mut stage.crowd;
                if says(begins, 0, 50) {
                    let target = Target::Joint { member: torch, joint: joint("head") };
                    crowd
                        .member_mut(member)
                        .expect("a gaze")
                        .look_at_with(&gaze(), target, easing())
                        .expect("a gaze");
                    crowd.member_mut(member).expect("feet").plant_feet_with(&feet()).expect("feet");
                    crowd
                        .member_mut(props[nth].0)
                        .expect("a prop")
                        .attach_to(props[nth].1, joint("leftHand"), Trs::IDENTITY)
                        .expect("a prop");
                    crowd
                        .member_mut(member)
                        .expect("a layer")
                        .set_layer(1, LayerSettings::default(), None)
                        .expect("a layer");
                    crowd
                        .member_mut(layered[nth].member())
                        .expect("a clip that plays")
                        .set_weight(layered[nth], 0.9, 0.7)
                        .expect("a clip that plays");
                }
                if says(ends, 50, 90) {
                    crowd
                        .member_mut(member)
                        .expect("a member")
                        .clear_look_at(0.4)
                        .expect("a member");
                }
                if says(stops, 90, 130) {
                    crowd.member_mut(member).expect("a member").stop(1, 0.5).expect("a member");
                }
            }
            stage.update(FRAME_SECS);
            for (a, b) in [(once, ever), (props[0].0, props[1].0)] {
                let [a, b] = [a, b].map(|member| {
                    stage.crowd.member_mut(member).expect("a palette").palette().expect("a palette")
                });
                assert!(a == b, "frame {frame}");
            }
        }
        assert_eq!(
            stage.crowd.member(ever).expect("a member").active_clips().len(),
            1,
            "the layer has faded out"
        );
    });
}
