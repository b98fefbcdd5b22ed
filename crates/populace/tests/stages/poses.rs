//! Effects of user stages on poses.

use glam::{DAffine3, DQuat, DVec3};
use populace::clip::ticks_from_secs;
use populace::model::math::quat;
use populace::{After, StageUse, Trs};

use crate::fixture::{
    BEND, JOINTS, LIFT, MEMBERS, REPORT, Scene, affine, assert_models, at, everywhere, skeleton,
    stage,
};

/// Returns stage parameters: a unit quaternion and one more number.
fn parameters(k: f32, last: f32) -> [f32; 5] {
    let [x, y, z, w] = quat::normalize_or([0.2 * k, -0.1, 0.3, 0.9], quat::identity());
    [x, y, z, w, last]
}

fn rotation_of(parameters: [f32; 5]) -> DQuat {
    let [x, y, z, w, _] = parameters.map(f64::from);
    DQuat::from_xyzw(x, y, z, w)
}

/// Computes model transforms in double precision. `after` changes each before its children use it.
fn models(locals: &[Trs], after: impl Fn(usize, DAffine3) -> DAffine3) -> Vec<DAffine3> {
    let skeleton = skeleton();
    let mut all: Vec<DAffine3> = Vec::new();
    for (joint, local) in skeleton.joints().zip(locals) {
        let own = affine(local);
        let model = skeleton.parent(joint).map_or(own, |parent| all[parent.index()] * own);
        all.push(after(all.len(), model));
    }
    all
}

/// Asserts that the members in `changed` differ from those of a crowd without stages, and that all
/// others are equal bit for bit.
#[track_caller]
fn assert_others(staged: &mut Scene, plain: &mut Scene, changed: &[usize], context: &str) {
    let (staged, plain) = (staged.bits(), plain.bits());
    for nth in 0..MEMBERS {
        assert_eq!(staged[nth] == plain[nth], !changed.contains(&nth), "{context}, member {nth}");
    }
}

#[test]
fn pose_stage_changes_chosen_joints_and_their_descendants() {
    for (devices, schedule) in everywhere() {
        let context = format!("{devices} {schedule}");
        let (mut staged, [bend, _]) = Scene::staged(devices.clone(), schedule);
        let mut plain = Scene::on(devices, schedule);
        let chosen = [at(3), at(17), at(17), at(8)];
        for nth in [1, 4] {
            let how = StageUse::on(chosen).with_values([0.01 * nth as f32, 0.0, BEND, 0.0]);
            staged.edit(staged.members[nth]).set_stage(bend, how).expect("a stage use");
        }
        // Parameters change from frame to frame.
        for frame in 0..3_u8 {
            let given = parameters(f32::from(frame), 1.1);
            staged.crowd.set_stage_parameters(bend, &given).expect("parameters");
            staged.update(0.1);
            plain.update(0.1);
            assert_others(&mut staged, &mut plain, &[1, 4], &context);
            for nth in [1, 4] {
                let mut wanted = plain.locals(nth);
                let found = staged.locals(nth);
                for joint in 0..JOINTS {
                    let is_chosen = chosen.iter().any(|c| c.index() == joint);
                    assert_eq!(
                        found[joint] == wanted[joint],
                        !is_chosen,
                        "{context}, joint {joint}"
                    );
                }
                for joint in [3, 17, 8] {
                    let local = &mut wanted[joint];
                    let turned =
                        DQuat::from_array(local.rotation.map(f64::from)) * rotation_of(given);
                    local.rotation = turned.normalize().as_quat().to_array();
                    local.translation[1] += 0.01 * nth as f32;
                    local.scale[2] *= 1.1;
                }
                assert_models(&staged.models(nth), &models(&wanted, |_, own| own), &context);
            }
        }
    }
}

/// After Pose, a rotation is one of the local transform, in the space of the parent.
#[test]
fn pose_stage_rotates_about_the_axes_of_the_parent() {
    for (devices, schedule) in everywhere() {
        let context = format!("{devices} {schedule}");
        let (mut staged, [stage, _]) = Scene::staged(devices.clone(), schedule);
        let mut plain = Scene::on(devices, schedule);
        let how = StageUse::on([at(3), at(17)]).with_values([0.0, 0.0, LIFT, 0.0]);
        staged.edit(staged.members[2]).set_stage(stage, how).expect("a stage use");
        let given = parameters(1.0, 0.0);
        staged.crowd.set_stage_parameters(stage, &given).expect("parameters");
        staged.update(0.1);
        plain.update(0.1);
        let mut wanted = plain.locals(2);
        for joint in [3, 17] {
            let local = &mut wanted[joint];
            let turned = rotation_of(given) * DQuat::from_array(local.rotation.map(f64::from));
            local.rotation = turned.normalize().as_quat().to_array();
        }
        assert_models(&staged.models(2), &models(&wanted, |_, own| own), &context);
        assert_others(&mut staged, &mut plain, &[2], &context);
    }
}

#[test]
fn transform_stage_changes_chosen_joints_and_descendants() {
    for (devices, schedule) in everywhere() {
        let context = format!("{devices} {schedule}");
        let (mut staged, [_, lift]) = Scene::staged(devices.clone(), schedule);
        let mut plain = Scene::on(devices, schedule);
        let chosen = [2, 16];
        for nth in [0, 5] {
            let how = StageUse::on(chosen.map(at)).with_values([0.0, 0.1 * nth as f32, LIFT, 0.0]);
            staged.edit(staged.members[nth]).set_stage(lift, how).expect("a stage use");
        }
        for frame in 0..3_u8 {
            let given = parameters(1.0 + f32::from(frame), 0.25 * f32::from(frame));
            staged.crowd.set_stage_parameters(lift, &given).expect("parameters");
            staged.update(0.1);
            plain.update(0.1);
            assert_others(&mut staged, &mut plain, &[0, 5], &context);
            for nth in [0, 5] {
                let lifted = |joint: usize, mut own: DAffine3| {
                    if chosen.iter().any(|c| *c as usize == joint) {
                        own.matrix3 = glam::DMat3::from_quat(rotation_of(given)) * own.matrix3;
                        own.translation += DVec3::Y * (0.25 * f64::from(frame) + 0.1 * nth as f64);
                    }
                    own
                };
                let wanted = models(&plain.locals(nth), lifted);
                assert_models(&staged.models(nth), &wanted, &context);
                assert_eq!(staged.locals(nth), plain.locals(nth), "{context}");
            }
        }
    }
}

#[test]
fn rust_and_opencl_c_give_equal_bits_on_all_schedules() {
    let run = |(devices, schedule): &(populace::Devices, _)| {
        let (mut staged, [bend, lift]) = Scene::staged(devices.clone(), *schedule);
        let report = staged.crowd.add_stage(After::Transform, stage()).expect("a stage");
        for (stage, last) in [(bend, 1.2), (lift, 0.3)] {
            staged.crowd.set_stage_parameters(stage, &parameters(1.0, last)).expect("parameters");
        }
        for (nth, member) in staged.members.clone().into_iter().enumerate().skip(1) {
            let values = |action| [0.02, 0.3, action, nth as f32];
            let how = [StageUse::on_all(), StageUse::on((3..12).map(at)), StageUse::on([at(20)])];
            for ((stage, action), how) in
                [(bend, BEND), (lift, LIFT), (report, REPORT)].into_iter().zip(how)
            {
                staged
                    .edit(member)
                    .set_stage(stage, how.with_values(values(action)))
                    .expect("a stage use");
            }
        }
        staged.update(0.3);
        staged.update(0.05);
        staged.bits()
    };
    let all = everywhere();
    let first = run(&all[0]);
    for other in &all[1..] {
        assert_eq!(run(other), first, "{} {}", other.0, other.1);
    }
}

#[test]
fn stage_gets_member_joint_and_time_even_after_days() {
    for (devices, schedule) in everywhere() {
        let context = format!("{devices} {schedule}");
        let (mut staged, [_, report]) = Scene::staged(devices, schedule);
        let mut given = [0.0; 16];
        given[15] = 4.5;
        staged.crowd.set_stage_parameters(report, &given).expect("parameters");
        let member = staged.members[4];
        let how = StageUse::on([at(13)]).with_values([0.0, 0.0, REPORT, 7.0]);
        staged.edit(member).set_stage(report, how).expect("a stage use");
        // About eleven days.
        staged.update(950_000.0);
        staged.update(0.25);
        let [a, b, c] = staged.models(4)[13].rows;
        let (sin, cos) = 1.2_f32.sin_cos();
        for (found, wanted) in a.into_iter().zip([4.0, 1.0, sin, cos]) {
            assert!((found - wanted).abs() < 1e-6, "{context}: {a:?}");
        }
        let period = ticks_from_secs(0.7);
        let phase = (ticks_from_secs(950_000.25) % period) as f64 / period as f64;
        assert!(
            (f64::from(b[0]) - phase).abs() < 1e-6,
            "{context}: {} of a cycle, not {phase}",
            b[0]
        );
        for (found, wanted) in b.into_iter().zip([b[0], 0.25, cos, sin]) {
            assert!((found - wanted).abs() < 1e-6, "{context}: {b:?}");
        }
        assert_eq!(c, [13.0, member.number() as f32, 7.0, 4.5], "{context}");
    }
}

#[test]
fn cleared_or_removed_stage_has_no_effect() {
    for (devices, schedule) in everywhere() {
        let context = format!("{devices} {schedule}");
        let (mut staged, [bend, lift]) = Scene::staged(devices.clone(), schedule);
        let mut plain = Scene::on(devices, schedule);
        staged.crowd.set_stage_parameters(bend, &parameters(1.0, 1.0)).expect("parameters");
        staged.crowd.set_stage_parameters(lift, &parameters(1.0, 1.0)).expect("parameters");
        let (first, second) = (staged.members[0], staged.members[1]);
        let how = |action| StageUse::on_all().with_values([0.1, 0.0, action, 0.0]);
        for (member, stage, action) in
            [(first, bend, BEND), (first, lift, LIFT), (second, lift, LIFT)]
        {
            staged.edit(member).set_stage(stage, how(action)).expect("a stage use");
        }
        let mut step = |staged: &mut Scene, changed: &[usize]| {
            staged.update(0.1);
            plain.update(0.1);
            assert_others(staged, &mut plain, changed, &context);
        };
        step(&mut staged, &[0, 1]);
        staged.edit(second).clear_stage(lift).expect("a stage in use");
        step(&mut staged, &[0]);
        staged.crowd.remove(lift).expect("a stage");
        assert!(
            staged
                .crowd
                .member_mut(second)
                .and_then(|mut m| m.set_stage(lift, StageUse::on_all()))
                .is_err(),
            "a removed stage can be used"
        );
        step(&mut staged, &[0]);
        staged.crowd.remove(bend).expect("a stage");
        step(&mut staged, &[]);
        // New stages take the indices of the removed ones; no member uses them yet.
        let [report, _] = staged.add_stages([After::Transform, After::Pose]);
        assert!(
            staged.crowd.set_stage_parameters(bend, &[]).is_err(),
            "a removed stage can be used"
        );
        step(&mut staged, &[]);
        staged.edit(second).set_stage(report, how(REPORT)).expect("a stage use");
        step(&mut staged, &[1]);
    }
}
