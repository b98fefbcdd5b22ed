//! Invalid input is refused or harmless.

#![expect(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "tests print measurements and panic on errors"
)]

mod common;

use std::sync::Arc;

use common::{DT, Stage, chain};
use populace::{Crowd, Device, JointIndex, Placement};
use populace_physics::{Error, RagdollPlan, Ragdolls, State};

#[test]
fn degenerate_skeletons_fall_and_stay_finite() {
    let still = [0.0; 3];
    let bone = [0.0, 0.4, 0.0];
    for steps in [
        vec![still],
        vec![bone],
        vec![still; 5],
        vec![bone, still, bone, still, bone],
        vec![[1e-6; 3]; 3],
    ] {
        let mut stage = Stage::new(chain(&steps), None, Placement::at([0.0, 1.0, 0.0]));
        stage.go_limp();
        let first = stage.plan.bodies()[0].joint();
        stage.ragdolls.push(stage.member, first, [1.0, 0.0, 0.0], None).unwrap();
        stage.frames(120);
        let positions = stage.positions();
        let (bodies, low) = (stage.plan.bodies().len(), positions[first.index()][1]);
        println!("{} joints: {bodies} bodies, the first at {low} m", steps.len());
        assert!(positions.iter().flatten().all(|v| v.is_finite()) && low < 1.0);
        stage.ragdolls.get_up(&mut stage.crowd, stage.member, 0.1).unwrap();
        stage.frames(10);
        assert_eq!(stage.ragdolls.state(stage.member), State::Animated);
    }
}

#[test]
fn non_finite_and_negative_numbers_are_refused() {
    let bad = |result: Result<(), Error>| {
        assert!(matches!(result, Err(Error::BadValue { .. })), "{result:?}")
    };
    assert!(matches!(Ragdolls::new([0.0, f32::NAN, 0.0]).err(), Some(Error::BadValue { .. })));
    let mut stage = Stage::walking_man();
    let hips = stage.joint("Pelvis");
    stage.go_limp();
    bad(stage.ragdolls.push(stage.member, hips, [f32::INFINITY, 0.0, 0.0], None));
    bad(stage.ragdolls.push(stage.member, hips, [1.0; 3], Some([f32::NAN; 3])));
    bad(stage.ragdolls.step(&mut stage.crowd, -1.0));
    bad(stage.ragdolls.step(&mut stage.crowd, f32::NAN));
    bad(stage.ragdolls.get_up(&mut stage.crowd, stage.member, -0.1));
    bad(stage.ragdolls.add_box([0.0; 3], [1.0, 0.0, 1.0], 0.0));
    bad(stage.ragdolls.set_floor(f32::NAN));
    stage.frames(30);
    stage.ragdolls.push(stage.member, hips, [1e30, 0.0, 0.0], None).unwrap();
    stage.frames(30);
    assert!(
        stage.positions().iter().flatten().all(|v| v.is_finite()),
        "a huge push keeps all joints finite"
    );
}

#[test]
fn mismatched_members_and_plans_are_refused() {
    let mut stage = Stage::walking_man();
    let hips = stage.joint("Pelvis");
    let push = stage.ragdolls.push(stage.member, hips, [1.0; 3], None);
    assert_eq!(push, Err(Error::NotLimp));
    let other = Arc::new(RagdollPlan::from_skeleton(&chain(&[[0.0; 3]; 3]).skeleton));
    let refused = stage.ragdolls.go_limp(&stage.crowd, stage.member, &other);
    assert_eq!(refused, Err(Error::WrongPlan { plan: 3, member: 54 }));
    let refused =
        stage.ragdolls.go_limp_from(&stage.crowd, stage.member, &stage.plan, JointIndex(99));
    assert_eq!(refused, Err(Error::NoBody { joint: 99 }));
    let mut elsewhere = Crowd::builder().device(Device::native()).capacity(1).build().unwrap();
    let character = elsewhere.add_character(chain(&[[0.0; 3]])).unwrap();
    let foreign_member = elsewhere.spawn(character, Placement::at([0.0; 3])).unwrap();
    let refused = stage.ragdolls.go_limp(&stage.crowd, foreign_member, &stage.plan);
    let unknown = populace::Error::UnknownId { what: "member", index: 0 };
    assert_eq!(refused, Err(Error::Crowd(unknown)));
}

#[test]
fn long_and_empty_frames_are_harmless() {
    let mut stage = Stage::walking_man();
    stage.go_limp();
    for dt in [DT, 0.0, DT, 0.0, 1000.0, DT, 1e-6, DT] {
        stage.ragdolls.step(&mut stage.crowd, dt).unwrap();
        stage.crowd.update(dt).unwrap();
    }
    assert!(stage.positions().iter().flatten().all(|v| v.is_finite() && v.abs() < 50.0));
}
