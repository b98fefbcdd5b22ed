//! Members whose speed inertializes.

use super::*;

/// Where something inertializes, a member's speed goes over in that time; interrupted or not, and
/// from the midst of a frame.
#[test]
fn the_speed_of_a_member_settles_as_its_pose_does() {
    const FRAME: f32 = 1.0 / 60.0;
    everywhere(|stage| {
        let (_, fast) = add(stage, straight("fast", 2.0));
        let (_, slow) = add(stage, straight("slow", 0.5));
        let inertialization = ClipPlayback::looping().inertialize_in_secs(0.3);
        let [once, twice] = [(); 2].map(|()| walker(stage, fast));
        stage.update(FRAME);
        stage
            .crowd
            .member_mut(once)
            .expect("a clip")
            .play(slow, inertialization.after_secs(0.11))
            .expect("a clip");
        stage.crowd.member_mut(twice).expect("a clip").play(slow, inertialization).expect("a clip");
        let place = |stage: &mut Stage| {
            [once, twice].map(|m| {
                stage
                    .crowd
                    .member_mut(m)
                    .expect("a member")
                    .moved_placement()
                    .expect("a member")
                    .position()[2]
            })
        };
        let (mut before, mut speeds, mut worst) = (place(stage), [2.0_f32; 2], 0.0_f32);
        let begun = before;
        for frame in 0..60 {
            if frame == 8 {
                stage
                    .crowd
                    .member_mut(twice)
                    .expect("a clip")
                    .play(fast, inertialization)
                    .expect("a clip");
            }
            stage.update(FRAME);
            let now = place(stage);
            for i in 0..2 {
                let speed = (now[i] - before[i]) / FRAME;
                worst = worst.max((speed - speeds[i]).abs());
                assert!((0.49..2.01).contains(&speed), "frame {frame}: {speed} m/s");
                speeds[i] = speed;
            }
            before = now;
        }
        // A quintic over 18 frames is at most 1.875 / 18 a frame; without it a frame changes all of
        // it.
        assert!(worst < 1.5 * 1.875 / 18.0 + 0.01, "{worst} m/s from one frame to the next");
        let [far, _] = [0, 1].map(|i: usize| before[i] - begun[i]);
        let wanted = 0.11 * 2.0 + 0.89 * 0.5 + 0.3 * 1.5 / 2.0;
        assert!((far - wanted).abs() < 2e-3, "{far} m is not {wanted} m");
        assert!((speeds[0] - 0.5).abs() < 1e-3 && (speeds[1] - 2.0).abs() < 1e-3, "{speeds:?}");
    });
}

/// Something that inertializes may be interrupted at any time of a frame: speeds go on from where
/// they are.
#[test]
fn what_settles_moves_members_on_until_something_else_begins_to() {
    const FRAME: f32 = 1.0 / 30.0;
    everywhere(|stage| {
        let (_, fast) = add(stage, straight("fast", 2.0));
        let (_, slow) = add(stage, straight("slow", 0.5));
        let inertialization = ClipPlayback::looping().inertialize_in_secs(0.3);
        let members = [0.0, 0.5, 0.9].map(|part: f32| (part, walker(stage, fast)));
        stage.update(FRAME);
        for (_, member) in members {
            stage
                .crowd
                .member_mut(member)
                .expect("a clip")
                .play(slow, inertialization)
                .expect("a clip");
        }
        let place = |stage: &mut Stage, member| {
            stage
                .crowd
                .member_mut(member)
                .expect("a member")
                .moved_placement()
                .expect("a member")
                .position()[2]
        };
        let mut before = members.map(|(_, member)| place(stage, member));
        for frame in 0..14 {
            for (part, member) in members.iter().filter(|_| frame == 4) {
                let later = inertialization.after_secs(part * FRAME);
                stage.crowd.member_mut(*member).expect("a clip").play(fast, later).expect("a clip");
            }
            stage.update(FRAME);
            let now = members.map(|(_, member)| place(stage, member));
            let speeds: Vec<f32> =
                now.iter().zip(before).map(|(now, before)| (now - before) / FRAME).collect();
            // Of what is left of 1.5 m/s after three frames of nine, a frame loses 0.3 m/s at most.
            let slowest = if (3..=5).contains(&frame) { 1.2 } else { 0.5 };
            assert!(
                speeds.iter().all(|v| (slowest - 0.01..2.01).contains(v)),
                "frame {frame}: {speeds:?} m/s"
            );
            before = now;
        }
    });
}

/// A layer that adds moves nobody, and what inertializes in it does not either.
#[test]
fn what_inertializes_in_a_layer_that_adds_moves_nobody() {
    everywhere(|stage| {
        let mut source =
            body::swing("surge", SECS, &[("leftUpperLeg", [1.0, 0.0, 0.0], 0.45, 0.0)]);
        let times: Vec<f32> = (0..=40_u8).map(|key| f32::from(key) / 40.0).collect();
        let surge =
            |t: &f32| [0.0, 0.0, 1.5 * t + 0.02 * (1.0 - (t * 2.0 * std::f32::consts::TAU).cos())];
        source.tracks.push(Track {
            joint: "root".into(),
            property: Property::Translation,
            interpolation: Interpolation::Linear,
            values: times.iter().flat_map(surge).collect(),
            times,
        });
        let (_, surge) = add(stage, source);
        let [(wave, _), (nod, _)] = ["wave", "nod"].map(|name| add(stage, straight(name, 1e-4)));
        let [plain, nods] = [(); 2].map(|()| walker(stage, surge));
        let adds = LayerSettings { mode: LayerMode::Additive, ..LayerSettings::default() };
        stage.crowd.member_mut(nods).expect("a layer").set_layer(1, adds, None).expect("a layer");
        for frame in 0..20 {
            if frame % 5 == 0 {
                let next = if frame % 10 == 0 { wave } else { nod };
                let inertialization = ClipPlayback::looping().on_layer(1).inertialize_in_secs(0.3);
                stage
                    .crowd
                    .member_mut(nods)
                    .expect("a clip")
                    .play(next, inertialization)
                    .expect("a clip");
            }
            stage.update(0.1);
        }
        let [a, b] = [plain, nods].map(|m| {
            stage
                .crowd
                .member_mut(m)
                .expect("a member")
                .moved_placement()
                .expect("a member")
                .position()
        });
        assert!(distance(a, b) < 1e-4, "{a:?} is not {b:?}");
    });
}
