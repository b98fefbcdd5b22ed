//! Look-at.

use populace::model::math::vec3;
use populace::{Affine, ClipPlayback, Gaze, GazeLimits, MemberId, Placement, Target, Weight};

use crate::body::{Stage, everywhere, joint};

const LIMITS: GazeLimits = GazeLimits { yaw_rad: 1.3, up_rad: 0.7, down_rad: 0.9 };

pub(crate) fn gaze() -> Gaze {
    let chain = [("spine", 0.15), ("chest", 0.15), ("neck", 0.3), ("head", 0.4)];
    let chain = chain.map(|(name, share)| (joint(name), share)).to_vec();
    Gaze { chain, facing: [0.0, 0.0, 1.0], limits: LIMITS }
}

/// Where a joint faces in model space, of all joints at rest and now.
fn facing(rest: &[Affine], now: &[Affine], name: &str) -> [f32; 3] {
    let at = joint(name).index();
    // Axes are at right angles and of length 1, so rows of the rest times +Z give +Z in the joint's
    // space.
    let own = [0, 1, 2].map(|c| rest[at].rows[2][c]);
    vec3::unit_or(now[at].transform_vector(own), [0.0; 3])
}

fn angle_deg(a: [f32; 3], b: [f32; 3]) -> f32 {
    vec3::length(vec3::cross(a, b)).atan2(vec3::dot(a, b)).to_degrees()
}

/// Yaw and pitch from the front of the hips, in radians.
fn angles(rest: &[Affine], now: &[Affine]) -> (f32, f32) {
    let hips = joint("hips").index();
    let axis = |row: usize| now[hips].transform_vector([0, 1, 2].map(|c| rest[hips].rows[row][c]));
    let [left, up, front] = [axis(0), axis(1), axis(2)].map(|v| vec3::unit_or(v, [0.0; 3]));
    let f = facing(rest, now, "head");
    let (x, y, z) = (vec3::dot(f, left), vec3::dot(f, up), vec3::dot(f, front));
    (x.atan2(z), y.atan2((x * x + z * z).sqrt()))
}

fn watcher(stage: &mut Stage) -> (MemberId, Vec<Affine>) {
    let still = stage.member(Placement::at([0.0; 3]));
    stage.update(0.0);
    let rest = stage.models(still);
    let member = stage.member(Placement::at([2.0, 0.5, 1.0]).facing(-2.0).scaled(0.8));
    let clip = stage.clip("sway");
    stage
        .crowd
        .member_mut(member)
        .expect("a clip that plays")
        .play(clip, ClipPlayback::looping())
        .expect("a clip that plays");
    (member, rest)
}

#[test]
fn the_head_faces_its_target_within_the_limits() {
    everywhere(|stage| {
        let (member, rest) = watcher(stage);
        let mut worst: f32 = 0.0;
        for step in 0..48u8 {
            let x = f32::from(step);
            // Within a radian to either side and half of one up and down, near and far.
            let (yaw, pitch, far) =
                ((x * 1.9).sin(), (x * 0.7).sin() * 0.45, 0.4 + (x * 0.37).sin().abs() * 6.0);
            stage.update(0.07);
            let head = stage.place(member, "head");
            let to = [yaw.sin() * pitch.cos(), pitch.sin(), yaw.cos() * pitch.cos()];
            let target = vec3::add_scaled(head, to, far);
            let weight = Weight::FULL.over_secs(0.0);
            stage
                .crowd
                .member_mut(member)
                .expect("a gaze")
                .look_at_with(&gaze(), Target::InModel(target), weight)
                .expect("a gaze");
            stage.update(0.0);
            let now = stage.models(member);
            let wanted = vec3::sub(target, now[joint("head").index()].origin());
            let off = angle_deg(facing(&rest, &now, "head"), vec3::unit_or(wanted, [0.0; 3]));
            worst = worst.max(off);
        }
        println!("gaze: worst {worst} degrees");
        assert!(worst < 0.1, "{worst} degrees beside the target");
    });
}

#[test]
fn limits_are_never_passed_and_the_gaze_never_snaps() {
    everywhere(|stage| {
        let (member, rest) = watcher(stage);
        let mut last: Option<[f32; 3]> = None;
        let (mut turned, mut passed) = (0.0_f32, 0.0_f32);
        for step in 0..720_u16 {
            // Twice around the member, up and down all the while, in 12 seconds.
            let x = f32::from(step) / 720.0;
            let yaw = x * 2.0 * std::f32::consts::TAU;
            let at = [yaw.sin() * 3.0, 1.6 + 3.0 * (x * 17.0).sin(), yaw.cos() * 3.0];
            let weight = Weight::FULL.over_secs(0.0);
            stage
                .crowd
                .member_mut(member)
                .expect("a gaze")
                .look_at_with(&gaze(), Target::InModel(at), weight)
                .expect("a gaze");
            stage.update(1.0 / 60.0);
            let now = stage.models(member);
            let (yaw, pitch) = angles(&rest, &now);
            passed = passed
                .max(yaw.abs() - LIMITS.yaw_rad)
                .max(pitch - LIMITS.up_rad)
                .max(-pitch - LIMITS.down_rad);
            let f = facing(&rest, &now, "head");
            turned = turned.max(last.map_or(0.0, |last| angle_deg(last, f)));
            last = Some(f);
        }
        println!("gaze: {turned} degrees in a step at most, limits passed by {passed} radians");
        assert!(passed < 1e-4, "limits are passed by {passed} radians");
        assert!(turned < 6.0, "{turned} degrees in one step");
    });
}

#[test]
fn a_gaze_eases_in_over_and_out() {
    everywhere(|stage| {
        let (member, rest) = watcher(stage);
        let at = |stage: &mut Stage, x: f32, weight: Weight| {
            let target = Target::InModel([x, 1.2, 1.0]);
            stage
                .crowd
                .member_mut(member)
                .expect("a gaze")
                .look_at_with(&gaze(), target, weight)
                .expect("a gaze");
        };
        let weight = Weight::FULL.over_secs(0.5);
        let (mut last, mut turned) = (None, 0.0_f32);
        for step in 0..180_u16 {
            match step {
                10 => at(stage, 2.0, weight),
                25 => at(stage, -2.0, weight.easing_over()),
                30 => at(stage, 0.5, weight.easing_over()),
                100 => at(stage, -2.0, weight),
                130 => stage
                    .crowd
                    .member_mut(member)
                    .expect("a member")
                    .clear_look_at(0.5)
                    .expect("a member"),
                _ => {}
            }
            stage.update(1.0 / 60.0);
            let f = facing(&rest, &stage.models(member), "head");
            turned = turned.max(last.map_or(0.0, |last| angle_deg(last, f)));
            last = Some(f);
        }
        println!("gaze: {turned} degrees in a step at most");
        assert!((1.0..9.0).contains(&turned), "{turned} degrees in one step");
        // Once it has eased out, all is as if it had never looked.
        stage.update(1.0);
        let twin = stage.member(Placement::at([0.0; 3]));
        let clip = stage.clip("sway");
        stage
            .crowd
            .member_mut(twin)
            .expect("a clip that plays")
            .play(clip, ClipPlayback::looping())
            .expect("a clip that plays");
        stage.update(1.0); // five seconds of a clip of two on the one, one second on the other
        let (now, then) = (stage.models(member), stage.models(twin));
        let apart = |name: &str| {
            crate::body::turn_deg(&now[joint(name).index()], &then[joint(name).index()])
        };
        assert!(
            ["spine", "chest", "neck", "head"].into_iter().all(|name| apart(name) < 0.05),
            "{}",
            apart("head")
        );
    });
}

#[test]
fn a_member_looks_at_anothers_hand() {
    everywhere(|stage| {
        let (member, rest) = watcher(stage);
        let other = stage.member(Placement::at([1.8, 0.7, 0.0]).facing(1.0));
        let clip = stage.clip("sway");
        stage
            .crowd
            .member_mut(other)
            .expect("a clip that plays")
            .play(clip, ClipPlayback::looping())
            .expect("a clip that plays");
        let target = Target::Joint { member: other, joint: joint("leftHand") };
        stage
            .crowd
            .member_mut(member)
            .expect("a gaze")
            .look_at_with(&gaze(), target, Weight::FULL.over_secs(0.0))
            .expect("a gaze");
        for step in 0..20 {
            let world = stage.crowd.member(other).expect("a member").placement().world_from_model();
            let hand = if step > 0 {
                Some(world.transform_point(stage.place(other, "leftHand")))
            } else {
                None
            };
            stage.update(1.0 / 30.0);
            let now = stage.models(member);
            let world =
                stage.crowd.member(member).expect("a member").placement().world_from_model();
            let head = world.mul(&now[joint("head").index()]).origin();
            let f = vec3::unit_or(world.transform_vector(facing(&rest, &now, "head")), [0.0; 3]);
            let Some(hand) = hand else { continue };
            let off = angle_deg(f, vec3::unit_or(vec3::sub(hand, head), [0.0; 3]));
            assert!(off < 0.1, "step {step}: {off} degrees beside the hand of the frame before");
        }
        // It goes on to look where the other was, once that has left.
        stage.crowd.despawn(other).expect("a member");
        stage.update(1.0 / 30.0);
        stage.crowd.despawn(member).expect("a member");
        stage.update(1.0 / 30.0);
    });
}
