//! Stages whose output is not finite or too large.

use populace::{After, StageUse, Target, Weight};
use populace::{Gaze, GazeLimits};

use crate::fixture::{DIVIDE, Scene, at, everywhere};

/// Makes the second member look at the first.
fn look(crowd: &mut Scene) {
    let gaze = Gaze {
        chain: vec![(at(1), 0.5), (at(2), 0.5)],
        facing: [0.0, 0.0, 1.0],
        limits: GazeLimits { yaw_rad: 1.0, up_rad: 0.5, down_rad: 0.5 },
    };
    let target = Target::Joint { member: crowd.members[0], joint: at(20) };
    let weight = Weight::new(1.0).expect("a weight");
    crowd.edit(crowd.members[1]).look_at_with(&gaze, target, weight).expect("a gaze");
}

#[test]
fn invalid_stage_output_is_discarded() {
    for (devices, schedule) in everywhere() {
        for (nth, after) in [After::Pose, After::Transform].into_iter().enumerate() {
            for (kind, bad) in
                [("NaN", [0.0, 0.0]), ("infinite", [1.0, 0.0]), ("large", [-2e9, 1.0])]
            {
                let context = format!("{devices} {schedule}, {after:?}, {kind}");
                let mut plain = Scene::on(devices.clone(), schedule);
                let (mut staged, stages) = Scene::staged(devices.clone(), schedule);
                let first = staged.members[0];
                let how = StageUse::on_all().with_values([bad[0], bad[1], DIVIDE, 0.0]);
                staged.edit(first).set_stage(stages[nth], how).expect("a stage use");
                for crowd in [&mut plain, &mut staged] {
                    look(crowd);
                    crowd.update(0.6);
                    crowd.update(0.6);
                }
                // The joints themselves keep their values too.
                assert_eq!(staged.bits(), plain.bits(), "{context}");
            }
        }
    }
}

#[test]
fn overflowing_scale_reaches_no_other_member() {
    for (devices, schedule) in everywhere() {
        let context = format!("{devices} {schedule}");
        let (mut staged, [bend, _]) = Scene::staged(devices.clone(), schedule);
        let mut plain = Scene::on(devices, schedule);
        let huge = [0.0, 0.0, 0.0, 1.0, 9e8];
        staged.crowd.set_stage_parameters(bend, &huge).expect("parameters");
        let first = staged.members[0];
        staged.edit(first).set_stage(bend, StageUse::on_all()).expect("a stage use");
        look(&mut staged);
        for _ in 0..3 {
            staged.update(0.6);
            plain.update(0.6);
        }
        let (staged, plain) = (staged.bits(), plain.bits());
        let finite = |bits: &[u32]| bits.iter().all(|bits| f32::from_bits(*bits).is_finite());
        assert!(!finite(&staged[0]), "{context}: the scale did not overflow");
        // The member that looks there may turn but stays finite; all others are unchanged.
        assert!(finite(&staged[1]), "{context}");
        assert_eq!(staged[2..], plain[2..], "{context}");
    }
}
