//! Frames in which everything changes never make the host wait for the device. The test has a
//! process of its own, because waits are counted over all devices of a process.
#![expect(
    clippy::disallowed_methods,
    reason = "tests need not give the same bits on every machine"
)]
#![cfg(feature = "opencl")]
#![expect(
    clippy::expect_used,
    dead_code,
    reason = "a failed call fails the test; not every test uses the whole fixture"
)]

#[path = "controls/fixture.rs"]
mod fixture;

use fixture::{joint, scene};
use populace::model::math::quat;
use populace::{
    ClipId, ClipPlayback, Condition, Crowd, Device, Feet, Foot, JointOverride, LayerSettings,
    MachinePlayback, MemberId, Placement, Reach, Schedule, Space, StateMachine, StatePlayback,
    Target, Trs, Weight,
};

fn feet() -> Feet {
    let foot = |side: &str| Foot {
        hip: joint(&format!("{side}UpperLeg")),
        knee: joint(&format!("{side}LowerLeg")),
        ankle: joint(&format!("{side}Foot")),
    };
    Feet { pelvis: joint("hips"), feet: vec![foot("left"), foot("right")], weight: 1.0 }
}

/// Runs a machine on layer 1 of each member. It sways or walks, by the parameter "swap".
fn run_machines(scene: &mut fixture::Scene, clips: [ClipId; 2], members: &[MemberId]) {
    let machine = StateMachine::new()
        .parameter("swap", 0.0)
        .state("sway", clips[0], StatePlayback::looping())
        .state("walk", clips[1], StatePlayback::looping())
        .transition("sway", "walk", 0.1, &[Condition::above("swap", 0.5)])
        .transition("walk", "sway", 0.1, &[Condition::below("swap", 0.5)]);
    let machine = scene.crowd.add_machine(&machine).expect("a machine");
    for &member in members {
        scene
            .edit(member)
            .play_machine(machine, MachinePlayback::new().on_layer(1))
            .expect("slots");
    }
}

/// Changes every setting of a member.
fn change_all(crowd: &mut Crowd, member: MemberId, clip: ClipId, nth: usize) {
    let x = nth as f32;
    crowd
        .member_mut(member)
        .expect("a clip")
        .play(clip, ClipPlayback::looping().fade_in_secs(0.2))
        .expect("a clip");
    crowd
        .member_mut(member)
        .expect("a layer")
        .set_layer(1, LayerSettings::default(), None)
        .expect("a layer");
    crowd
        .member_mut(member)
        .expect("a running machine")
        .set_parameter("swap", (x * 0.1).sin())
        .expect("a running machine");
    crowd
        .member_mut(member)
        .expect("a placement")
        .set_placement(Placement::at([(nth % 20) as f32, 0.0, x * 0.001]))
        .expect("a placement");
    crowd.member_mut(member).expect("a member").start_root_motion().expect("a member");
    let target = Target::Point([x.sin(), 1.2, 1.0]);
    crowd
        .member_mut(member)
        .expect("a limb")
        .reach(Reach::with(joint("leftHand")), target, Weight::FULL)
        .expect("a limb");
    crowd.member_mut(member).expect("feet").plant_feet_with(&feet()).expect("feet");
    let transform = Trs { rotation: quat::identity(), ..Trs::IDENTITY };
    let o = JointOverride { joint: joint("head"), space: Space::Local, transform, weight: 0.5 };
    crowd.member_mut(member).expect("an override").override_joints(&[o]).expect("an override");
}

fn assert_no_waits(scene: &mut fixture::Scene) {
    let clips = ["sway", "walk"].map(|name| scene.clip(name));
    let members: Vec<_> =
        (0..20_u8).map(|n| scene.member(Placement::at([f32::from(n), 0.0, 0.0]))).collect();
    let hats: Vec<_> = members.iter().map(|_| scene.member(Placement::at([0.0; 3]))).collect();
    run_machines(scene, clips, &members);
    let mut watch = None;
    let mut waits = 0;
    for frame in 0..60_usize {
        if frame == 10 {
            // All buffers have their final size by now.
            waits = scene.crowd.device_info().host_waits;
        }
        for (n, &member) in members.iter().enumerate() {
            change_all(&mut scene.crowd, member, clips[(frame + n) % 2], frame * 20 + n);
            let crowd = &mut scene.crowd;
            let to = if frame % 2 == 0 { "head" } else { "leftHand" };
            crowd
                .member_mut(hats[n])
                .expect("a hat")
                .attach_to(member, joint(to), Trs::IDENTITY)
                .expect("a hat");
            if (frame + n) % 5 == 0 {
                crowd.member_mut(hats[n]).expect("a hat").detach().expect("a hat");
            }
        }
        if frame == 2 {
            watch = Some(scene.edit(members[7]).watch_joint(joint("leftHand")).expect("a joint"));
        }
        scene.update(1.0 / 60.0);
        if let Some(watch) = watch {
            scene.crowd.readback(watch).expect("a device");
        }
    }
    assert_eq!(
        scene.crowd.device_info().host_waits,
        waits,
        "{:?}: the host waited",
        scene.crowd.device_info().schedule
    );
    // Devices that are behind skip readbacks; this one is idle before the last frame.
    scene.crowd.finish().expect("a device");
    scene.update(1.0 / 60.0);
    let opencl = scene.crowd.device_info().name.starts_with("OpenCL");
    assert_eq!(
        scene.crowd.device_info().host_waits,
        waits + u64::from(opencl),
        "an explicit wait was not counted"
    );
    scene.edit(members[0]).machine_state(1).expect("a running machine");
    assert_eq!(
        scene.crowd.device_info().host_waits,
        waits + 2 * u64::from(opencl),
        "reading a machine's state was not counted"
    );
    let watch = watch.expect("a watch");
    let seen = scene.crowd.readback(watch).expect("a device").expect("a readback");
    let world = scene.crowd.member(members[7]).expect("a member").placement().world_from_model();
    let hand = world.transform_point(scene.position(members[7], "leftHand"));
    assert!(fixture::distance(seen.world_from_joint.origin(), hand) < 1e-5, "{seen:?} {hand:?}");
    assert!((seen.at_secs - 61.0 / 60.0).abs() < 1e-3, "{seen:?}");
    scene.edit(members[7]).unwatch_joint(watch);
    assert_eq!(scene.crowd.readback(watch).expect("a device"), None);
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn frames_never_wait_for_the_device() {
    for schedule in [Schedule::Staged, Schedule::FusedWide, Schedule::FusedGrouped] {
        assert_no_waits(&mut scene(Device::opencl(0), schedule));
    }
    assert_no_waits(&mut scene(Device::native(), Schedule::Fused));
}
