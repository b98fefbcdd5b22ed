//! Invalid input is refused or harmless.

#![expect(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "tests print measurements and panic on errors"
)]

mod common;

use std::sync::Arc;

use common::{DT, Scene, chain};
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
        let mut scene = Scene::new(chain(&steps), None, Placement::at([0.0, 1.0, 0.0]));
        scene.go_limp();
        let first = scene.plan.bodies()[0].joint();
        scene.ragdolls.push(scene.member, first, [1.0, 0.0, 0.0], None).unwrap();
        scene.frames(120);
        let positions = scene.positions();
        let (bodies, low) = (scene.plan.bodies().len(), positions[first.index()][1]);
        println!("{} joints: {bodies} bodies, the first at {low} m", steps.len());
        assert!(positions.iter().flatten().all(|v| v.is_finite()) && low < 1.0);
        scene.ragdolls.get_up(&mut scene.crowd, scene.member, 0.1).unwrap();
        scene.frames(10);
        assert_eq!(scene.ragdolls.state(scene.member), State::Animated);
    }
}

#[test]
fn numbers_out_of_range_are_refused() {
    let bad = |result: Result<(), Error>| {
        assert!(matches!(result, Err(Error::BadValue { .. })), "{result:?}")
    };
    for gravity in [f32::NAN, -1e30, 1001.0] {
        bad(Ragdolls::new([0.0, gravity, 0.0]).map(|_| ()));
    }
    let mut scene = Scene::walking_man();
    let hips = scene.joint("Pelvis");
    scene.go_limp();
    bad(scene.ragdolls.push(scene.member, hips, [f32::INFINITY, 0.0, 0.0], None));
    bad(scene.ragdolls.push(scene.member, hips, [0.0, 0.0, -1e30], None));
    bad(scene.ragdolls.push(scene.member, hips, [1.0; 3], Some([f32::NAN; 3])));
    bad(scene.ragdolls.step(&mut scene.crowd, -1.0));
    bad(scene.ragdolls.step(&mut scene.crowd, f32::NAN));
    bad(scene.ragdolls.get_up(&mut scene.crowd, scene.member, -0.1));
    bad(scene.ragdolls.add_box([0.0; 3], [1.0, 0.0, 1.0], 0.0));
    bad(scene.ragdolls.set_floor(f32::NAN));
    scene.frames(30);
    scene.ragdolls.push(scene.member, hips, [1e7, 0.0, 0.0], None).unwrap();
    scene.frames(30);
    assert!(
        scene.positions().iter().flatten().all(|v| v.is_finite()),
        "a huge push keeps all joints finite"
    );
    assert!(scene.ragdolls.energy_j(scene.member).unwrap().is_finite());
}

#[test]
fn mismatched_members_and_plans_are_refused() {
    let mut scene = Scene::walking_man();
    let hips = scene.joint("Pelvis");
    let push = scene.ragdolls.push(scene.member, hips, [1.0; 3], None);
    assert_eq!(push, Err(Error::NotLimp));
    let other = Arc::new(RagdollPlan::from_skeleton(&chain(&[[0.0; 3]; 3]).skeleton));
    let refused = scene.ragdolls.go_limp(&scene.crowd, scene.member, &other);
    assert_eq!(refused, Err(Error::WrongPlan { plan: 3, member: 54 }));
    let refused =
        scene.ragdolls.go_limp_from(&scene.crowd, scene.member, &scene.plan, JointIndex(99));
    assert_eq!(refused, Err(Error::NoBody { joint: 99 }));
    let mut elsewhere = Crowd::builder().device(Device::native()).capacity(1).build().unwrap();
    let character = elsewhere.add_character(chain(&[[0.0; 3]])).unwrap();
    let foreign_member = elsewhere.spawn(character, Placement::at([0.0; 3])).unwrap();
    let refused = scene.ragdolls.go_limp(&scene.crowd, foreign_member, &scene.plan);
    let unknown = populace::Error::UnknownId { what: populace::IdKind::Member, index: 0 };
    assert_eq!(refused, Err(Error::Crowd(unknown)));
}

#[test]
fn long_and_empty_frames_are_harmless() {
    let mut scene = Scene::walking_man();
    scene.go_limp();
    for dt in [DT, 0.0, DT, 0.0, 1000.0, DT, 1e-6, DT] {
        scene.ragdolls.step(&mut scene.crowd, dt).unwrap();
        scene.crowd.update(dt).unwrap();
    }
    assert!(scene.positions().iter().flatten().all(|v| v.is_finite() && v.abs() < 50.0));
}
