//! Stages that leave what no joint can be.

use populace::{After, StageUse, Target, Weight};
use populace::{Gaze, GazeLimits};

use crate::rig::{STRAY, Swaying, at, everywhere, stage};

/// Lets the second member look at the first.
fn look(crowd: &mut Swaying) {
    let gaze = Gaze {
        chain: vec![(at(1), 0.5), (at(2), 0.5)],
        facing: [0.0, 0.0, 1.0],
        limits: GazeLimits { yaw_rad: 1.0, up_rad: 0.5, down_rad: 0.5 },
    };
    let target = Target::Joint { member: crowd.members[0], joint: at(20) };
    let weight = Weight::new(1.0).expect("a weight");
    crowd
        .crowd
        .member_mut(crowd.members[1])
        .expect("a gaze")
        .look_at_with(&gaze, target, weight)
        .expect("a gaze");
}

#[test]
fn what_is_no_number_reaches_nobody() {
    for (devices, schedule) in everywhere() {
        for after in [After::Pose, After::Transform] {
            for (what, bad) in
                [("no number", [0.0, 0.0]), ("infinite", [1.0, 0.0]), ("large", [-2e9, 1.0])]
            {
                let what = format!("{devices} {schedule}, {after:?}, {what}");
                let mut plain = Swaying::on(devices.clone(), schedule);
                let mut staged = Swaying::on(devices.clone(), schedule);
                let stray = staged.crowd.add_stage(after, stage()).expect("a stage");
                let first = staged.members[0];
                let how = StageUse::on_all().with_values([bad[0], bad[1], STRAY, 0.0]);
                staged
                    .crowd
                    .member_mut(first)
                    .expect("a use")
                    .set_stage(stray, how)
                    .expect("a use");
                for crowd in [&mut plain, &mut staged] {
                    look(crowd);
                    crowd.update(0.6);
                    crowd.update(0.6);
                }
                // Not even the joints themselves: they stay as they were.
                assert_eq!(staged.bits(), plain.bits(), "{what}");
            }
        }
    }
}

#[test]
fn sizes_that_grow_past_all_numbers_reach_no_other_member() {
    for (devices, schedule) in everywhere() {
        let what = format!("{devices} {schedule}");
        let mut staged = Swaying::on(devices.clone(), schedule);
        let mut plain = Swaying::on(devices, schedule);
        let bend = staged.crowd.add_stage(After::Pose, stage()).expect("a stage");
        let huge = [0.0, 0.0, 0.0, 1.0, 9e8];
        staged.crowd.set_stage_parameters(bend, &huge).expect("parameters");
        let first = staged.members[0];
        staged
            .crowd
            .member_mut(first)
            .expect("a use")
            .set_stage(bend, StageUse::on_all())
            .expect("a use");
        look(&mut staged);
        for _ in 0..3 {
            staged.update(0.6);
            plain.update(0.6);
        }
        let (staged, plain) = (staged.bits(), plain.bits());
        let finite = |bits: &[u32]| bits.iter().all(|bits| f32::from_bits(*bits).is_finite());
        assert!(!finite(&staged[0]), "{what}: the test tests nothing");
        // Who looks there may turn, yet stays whole; nobody else knows.
        assert!(finite(&staged[1]), "{what}");
        assert_eq!(staged[2..], plain[2..], "{what}");
    }
}
