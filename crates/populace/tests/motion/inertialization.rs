//! Root motion during inertialization.

use super::*;

/// During inertialization a member's speed changes smoothly to the new clip's, interrupted or not,
/// and also from the middle of a frame.
#[test]
fn member_speed_inertializes_like_its_pose() {
    const FRAME: f32 = 1.0 / 60.0;
    everywhere(|scene| {
        let (_, fast) = add(scene, straight("fast", 2.0));
        let (_, slow) = add(scene, straight("slow", 0.5));
        let inertialization = ClipPlayback::looping().inertialize_in_secs(0.3);
        let [once, twice] = [(); 2].map(|()| walker(scene, fast));
        scene.update(FRAME);
        scene.edit(once).play(slow, inertialization.after_secs(0.11)).expect("a clip");
        scene.edit(twice).play(slow, inertialization).expect("a clip");
        let position = |scene: &mut Scene| {
            [once, twice].map(|m| scene.edit(m).moved_placement().expect("a member").position()[2])
        };
        let (mut before, mut speeds, mut worst) = (position(scene), [2.0_f32; 2], 0.0_f32);
        let start = before;
        for frame in 0..60 {
            if frame == 8 {
                scene.edit(twice).play(fast, inertialization).expect("a clip");
            }
            scene.update(FRAME);
            let now = position(scene);
            for i in 0..2 {
                let speed = (now[i] - before[i]) / FRAME;
                worst = worst.max((speed - speeds[i]).abs());
                assert!((0.49..2.01).contains(&speed), "frame {frame}: {speed} m/s");
                speeds[i] = speed;
            }
            before = now;
        }
        // A quintic over 18 frames changes by at most 1.875 / 18 per frame; a cut changes the speed
        // in one frame.
        assert!(worst < 1.5 * 1.875 / 18.0 + 0.01, "the speed changed by {worst} m/s in a frame");
        let [far, _] = [0, 1].map(|i: usize| before[i] - start[i]);
        let wanted = 0.11 * 2.0 + 0.89 * 0.5 + 0.3 * 1.5 / 2.0;
        assert!((far - wanted).abs() < 2e-3, "moved {far} m instead of {wanted} m");
        assert!((speeds[0] - 0.5).abs() < 1e-3 && (speeds[1] - 2.0).abs() < 1e-3, "{speeds:?}");
    });
}

/// Inertialization may be interrupted at any time within a frame. Speeds are continuous.
#[test]
fn interrupted_inertialization_keeps_speeds_continuous() {
    const FRAME: f32 = 1.0 / 30.0;
    everywhere(|scene| {
        let (_, fast) = add(scene, straight("fast", 2.0));
        let (_, slow) = add(scene, straight("slow", 0.5));
        let inertialization = ClipPlayback::looping().inertialize_in_secs(0.3);
        let members = [0.0, 0.5, 0.9].map(|part: f32| (part, walker(scene, fast)));
        scene.update(FRAME);
        for (_, member) in members {
            scene.edit(member).play(slow, inertialization).expect("a clip");
        }
        let position = |scene: &mut Scene, member| {
            scene.edit(member).moved_placement().expect("a member").position()[2]
        };
        let mut before = members.map(|(_, member)| position(scene, member));
        for frame in 0..14 {
            for (part, member) in members.iter().filter(|_| frame == 4) {
                let later = inertialization.after_secs(part * FRAME);
                scene.edit(*member).play(fast, later).expect("a clip");
            }
            scene.update(FRAME);
            let now = members.map(|(_, member)| position(scene, member));
            let speeds: Vec<f32> =
                now.iter().zip(before).map(|(now, before)| (now - before) / FRAME).collect();
            // After three of nine frames, the rest of the 1.5 m/s decays by at most 0.3 m/s per
            // frame.
            let slowest = if (3..=5).contains(&frame) { 1.2 } else { 0.5 };
            assert!(
                speeds.iter().all(|v| (slowest - 0.01..2.01).contains(v)),
                "frame {frame}: {speeds:?} m/s"
            );
            before = now;
        }
    });
}

/// An additive layer moves no member, not even while a clip on it inertializes.
#[test]
fn inertialization_on_an_additive_layer_moves_no_member() {
    everywhere(|scene| {
        let mut source =
            fixture::swing("surge", SECS, &[("leftUpperLeg", [1.0, 0.0, 0.0], 0.45, 0.0)]);
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
        let (_, surge) = add(scene, source);
        let [(wave, _), (nod, _)] = ["wave", "nod"].map(|name| add(scene, straight(name, 1e-4)));
        let [plain, nods] = [(); 2].map(|()| walker(scene, surge));
        let adds = LayerSettings { mode: LayerMode::Additive, ..LayerSettings::default() };
        scene.edit(nods).set_layer(1, adds, None).expect("a layer");
        for frame in 0..20 {
            if frame % 5 == 0 {
                let next = if frame % 10 == 0 { wave } else { nod };
                let inertialization = ClipPlayback::looping().on_layer(1).inertialize_in_secs(0.3);
                scene.edit(nods).play(next, inertialization).expect("a clip");
            }
            scene.update(0.1);
        }
        let [a, b] =
            [plain, nods].map(|m| scene.edit(m).moved_placement().expect("a member").position());
        assert!(distance(a, b) < 1e-4, "{a:?} differs from {b:?}");
    });
}
