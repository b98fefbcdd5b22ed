//! Look-at constraints.

use populace::model::math::vec3;
use populace::{Affine, ClipPlayback, Gaze, GazeLimits, MemberId, Placement, Target, Weight};

use crate::fixture::{Scene, everywhere, joint};

const LIMITS: GazeLimits = GazeLimits { yaw_rad: 1.3, up_rad: 0.7, down_rad: 0.9 };

pub(crate) fn gaze() -> Gaze {
    let chain = [("spine", 0.15), ("chest", 0.15), ("neck", 0.3), ("head", 0.4)];
    let chain = chain.map(|(name, share)| (joint(name), share)).to_vec();
    Gaze { chain, facing: [0.0, 0.0, 1.0], limits: LIMITS }
}

/// Returns the direction in model space in which a joint faces. `rest` and `now` are the
/// model-space transforms of all joints.
fn facing(rest: &[Affine], now: &[Affine], name: &str) -> [f32; 3] {
    let at = joint(name).index();
    // The rest axes are orthonormal, so the third row is +Z of model space in the joint's space.
    let own = [0, 1, 2].map(|c| rest[at].rows[2][c]);
    vec3::unit_or(now[at].transform_vector(own), [0.0; 3])
}

fn angle_deg(a: [f32; 3], b: [f32; 3]) -> f32 {
    vec3::length(vec3::cross(a, b)).atan2(vec3::dot(a, b)).to_degrees()
}

/// Returns yaw and pitch of the head relative to the hips, in radians.
fn angles(rest: &[Affine], now: &[Affine]) -> (f32, f32) {
    let hips = joint("hips").index();
    let axis = |row: usize| now[hips].transform_vector([0, 1, 2].map(|c| rest[hips].rows[row][c]));
    let [left, up, front] = [axis(0), axis(1), axis(2)].map(|v| vec3::unit_or(v, [0.0; 3]));
    let f = facing(rest, now, "head");
    let (x, y, z) = (vec3::dot(f, left), vec3::dot(f, up), vec3::dot(f, front));
    (x.atan2(z), y.atan2((x * x + z * z).sqrt()))
}

fn watcher(scene: &mut Scene) -> (MemberId, Vec<Affine>) {
    let still = scene.member(Placement::at([0.0; 3]));
    scene.update(0.0);
    let rest = scene.models(still);
    let member = scene.member(Placement::at([2.0, 0.5, 1.0]).facing(-2.0).scaled(0.8));
    let clip = scene.clip("sway");
    scene.edit(member).play(clip, ClipPlayback::looping()).expect("a clip that plays");
    (member, rest)
}

#[test]
fn head_faces_target_within_limits() {
    everywhere(|scene| {
        let (member, rest) = watcher(scene);
        let mut worst: f32 = 0.0;
        for step in 0..48u8 {
            let x = f32::from(step);
            // Yaw up to 1 rad, pitch up to 0.45 rad, distance from 0.4 m to 6.4 m.
            let (yaw, pitch, far) =
                ((x * 1.9).sin(), (x * 0.7).sin() * 0.45, 0.4 + (x * 0.37).sin().abs() * 6.0);
            scene.update(0.07);
            let head = scene.position(member, "head");
            let to = [yaw.sin() * pitch.cos(), pitch.sin(), yaw.cos() * pitch.cos()];
            let target = vec3::add_scaled(head, to, far);
            let weight = Weight::FULL.over_secs(0.0);
            scene
                .edit(member)
                .look_at_with(&gaze(), Target::InModel(target), weight)
                .expect("a gaze");
            scene.update(0.0);
            let now = scene.models(member);
            let wanted = vec3::sub(target, now[joint("head").index()].origin());
            let off = angle_deg(facing(&rest, &now, "head"), vec3::unit_or(wanted, [0.0; 3]));
            worst = worst.max(off);
        }
        println!("gaze: worst {worst} degrees");
        assert!(worst < 0.1, "the head is {worst} degrees off the target");
    });
}

#[test]
fn gaze_stays_within_limits_and_never_snaps() {
    everywhere(|scene| {
        let (member, rest) = watcher(scene);
        let mut last: Option<[f32; 3]> = None;
        let (mut turned, mut passed) = (0.0_f32, 0.0_f32);
        for step in 0..720_u16 {
            // The target circles the member twice in 12 seconds while it moves up and down.
            let x = f32::from(step) / 720.0;
            let yaw = x * 2.0 * std::f32::consts::TAU;
            let at = [yaw.sin() * 3.0, 1.6 + 3.0 * (x * 17.0).sin(), yaw.cos() * 3.0];
            let weight = Weight::FULL.over_secs(0.0);
            scene.edit(member).look_at_with(&gaze(), Target::InModel(at), weight).expect("a gaze");
            scene.update(1.0 / 60.0);
            let now = scene.models(member);
            let (yaw, pitch) = angles(&rest, &now);
            passed = passed
                .max(yaw.abs() - LIMITS.yaw_rad)
                .max(pitch - LIMITS.up_rad)
                .max(-pitch - LIMITS.down_rad);
            let f = facing(&rest, &now, "head");
            turned = turned.max(last.map_or(0.0, |last| angle_deg(last, f)));
            last = Some(f);
        }
        println!("gaze: {turned} degrees per step at most, limits exceeded by {passed} radians");
        assert!(passed < 1e-4, "the limits are exceeded by {passed} radians");
        assert!(turned < 6.0, "the head turned {turned} degrees in one step");
    });
}

#[test]
fn gaze_eases_in_between_targets_and_out() {
    everywhere(|scene| {
        let (member, rest) = watcher(scene);
        let at = |scene: &mut Scene, x: f32, weight: Weight| {
            let target = Target::InModel([x, 1.2, 1.0]);
            scene.edit(member).look_at_with(&gaze(), target, weight).expect("a gaze");
        };
        let weight = Weight::FULL.over_secs(0.5);
        let (mut last, mut turned) = (None, 0.0_f32);
        for step in 0..180_u16 {
            match step {
                10 => at(scene, 2.0, weight),
                25 => at(scene, -2.0, weight.easing_over()),
                30 => at(scene, 0.5, weight.easing_over()),
                100 => at(scene, -2.0, weight),
                130 => scene.edit(member).clear_look_at(0.5).expect("a member"),
                _ => {}
            }
            scene.update(1.0 / 60.0);
            let f = facing(&rest, &scene.models(member), "head");
            turned = turned.max(last.map_or(0.0, |last| angle_deg(last, f)));
            last = Some(f);
        }
        println!("gaze: {turned} degrees per step at most");
        assert!((1.0..9.0).contains(&turned), "the head turned {turned} degrees in one step");
        // After easing out, the pose equals one without a gaze.
        scene.update(1.0);
        let twin = scene.member(Placement::at([0.0; 3]));
        let clip = scene.clip("sway");
        scene.edit(twin).play(clip, ClipPlayback::looping()).expect("a clip that plays");
        scene.update(1.0); // 5 s and 1 s into a clip of 2 s: the same phase.
        let (now, then) = (scene.models(member), scene.models(twin));
        let apart = |name: &str| {
            crate::fixture::turn_deg(&now[joint(name).index()], &then[joint(name).index()])
        };
        assert!(
            ["spine", "chest", "neck", "head"].into_iter().all(|name| apart(name) < 0.05),
            "{}",
            apart("head")
        );
    });
}

#[test]
fn gaze_follows_a_joint_of_another_member() {
    everywhere(|scene| {
        let (member, rest) = watcher(scene);
        let other = scene.member(Placement::at([1.8, 0.7, 0.0]).facing(1.0));
        let clip = scene.clip("sway");
        scene.edit(other).play(clip, ClipPlayback::looping()).expect("a clip that plays");
        let target = Target::Joint { member: other, joint: joint("leftHand") };
        scene
            .edit(member)
            .look_at_with(&gaze(), target, Weight::FULL.over_secs(0.0))
            .expect("a gaze");
        for step in 0..20 {
            let world = scene.crowd.member(other).expect("a member").placement().world_from_model();
            let hand = if step > 0 {
                Some(world.transform_point(scene.position(other, "leftHand")))
            } else {
                None
            };
            scene.update(1.0 / 30.0);
            let now = scene.models(member);
            let world =
                scene.crowd.member(member).expect("a member").placement().world_from_model();
            let head = world.mul(&now[joint("head").index()]).origin();
            let f = vec3::unit_or(world.transform_vector(facing(&rest, &now, "head")), [0.0; 3]);
            let Some(hand) = hand else { continue };
            let off = angle_deg(f, vec3::unit_or(vec3::sub(hand, head), [0.0; 3]));
            assert!(off < 0.1, "step {step}: {off} degrees off the previous frame's hand");
        }
        // After the other member is despawned, the gaze keeps the last position of its hand.
        let world = scene.crowd.member(other).expect("a member").placement().world_from_model();
        let hand = world.transform_point(scene.position(other, "leftHand"));
        scene.crowd.despawn(other).expect("a member");
        for step in 0..8 {
            scene.update(1.0 / 30.0);
            let now = scene.models(member);
            let world =
                scene.crowd.member(member).expect("a member").placement().world_from_model();
            let head = world.mul(&now[joint("head").index()]).origin();
            let f = vec3::unit_or(world.transform_vector(facing(&rest, &now, "head")), [0.0; 3]);
            let off = angle_deg(f, vec3::unit_or(vec3::sub(hand, head), [0.0; 3]));
            assert!(off < 0.1, "step {step}: {off} degrees off the despawned member's hand");
        }
        scene.crowd.despawn(member).expect("a member");
        scene.update(1.0 / 30.0);
    });
}
