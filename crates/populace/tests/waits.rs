//! Frames in which everything changes never make the host wait for the device. Alone in its
//! process: waits are counted over all devices of one.
#![expect(
    clippy::disallowed_methods,
    reason = "tests have no need of the same bits on every machine"
)]
#![cfg(feature = "opencl")]
#![expect(
    clippy::expect_used,
    dead_code,
    reason = "a test that cannot go on fails; bodies are shared with others"
)]

#[path = "controls/body.rs"]
mod body;

use body::{joint, stage};
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

/// All sway or walk in a layer above, by a parameter.
fn run_machines(stage: &mut body::Stage, clips: [ClipId; 2], members: &[MemberId]) {
    let sways = StateMachine::new()
        .parameter("swap", 0.0)
        .state("sway", clips[0], StatePlayback::looping())
        .state("walk", clips[1], StatePlayback::looping())
        .transition("sway", "walk", 0.1, &[Condition::above("swap", 0.5)])
        .transition("walk", "sway", 0.1, &[Condition::below("swap", 0.5)]);
    let sways = stage.crowd.add_machine(&sways).expect("a machine");
    for &member in members {
        stage
            .crowd
            .member_mut(member)
            .expect("slots")
            .play_machine(sways, MachinePlayback::new().on_layer(1))
            .expect("slots");
    }
}

/// Changes all that one member can be told.
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
        .expect("a machine that runs")
        .set_parameter("swap", (x * 0.1).sin())
        .expect("a machine that runs");
    crowd
        .member_mut(member)
        .expect("a place")
        .set_placement(Placement::at([(nth % 20) as f32, 0.0, x * 0.001]))
        .expect("a place");
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

fn frames(stage: &mut body::Stage) {
    let clips = ["sway", "walk"].map(|name| stage.clip(name));
    let members: Vec<_> =
        (0..20_u8).map(|n| stage.member(Placement::at([f32::from(n), 0.0, 0.0]))).collect();
    let hats: Vec<_> = members.iter().map(|_| stage.member(Placement::at([0.0; 3]))).collect();
    run_machines(stage, clips, &members);
    let mut watch = None;
    let mut waited = 0;
    for frame in 0..60_usize {
        if frame == 10 {
            // All has grown as far as it will.
            waited = stage.crowd.host_waits();
        }
        for (n, &member) in members.iter().enumerate() {
            change_all(&mut stage.crowd, member, clips[(frame + n) % 2], frame * 20 + n);
            let crowd = &mut stage.crowd;
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
            watch = Some(
                stage
                    .crowd
                    .member_mut(members[7])
                    .expect("a joint")
                    .watch_joint(joint("leftHand"))
                    .expect("a joint"),
            );
        }
        stage.update(1.0 / 60.0);
        if let Some(watch) = watch {
            stage.crowd.readback(watch).expect("a device");
        }
    }
    assert_eq!(stage.crowd.host_waits(), waited, "{:?}: the host waited", stage.crowd.schedule());
    stage.crowd.finish().expect("a device");
    let opencl = stage.crowd.device_name().starts_with("OpenCL");
    assert_eq!(stage.crowd.host_waits(), waited + u64::from(opencl), "an explicit wait is counted");
    stage
        .crowd
        .member_mut(members[0])
        .expect("a machine that runs")
        .machine_state(1)
        .expect("a machine that runs");
    assert_eq!(
        stage.crowd.host_waits(),
        waited + 2 * u64::from(opencl),
        "and so is asking for a state"
    );
    let watch = watch.expect("it was made");
    let seen = stage.crowd.readback(watch).expect("a device").expect("it has come by now");
    let world = stage.crowd.member(members[7]).expect("a member").placement().world_from_model();
    let hand = world.transform_point(stage.place(members[7], "leftHand"));
    assert!(body::distance(seen.world_from_joint.origin(), hand) < 1e-5, "{seen:?} {hand:?}");
    assert!((seen.at_secs - 1.0).abs() < 1e-3, "{seen:?}");
    stage.crowd.unwatch(watch);
    assert_eq!(stage.crowd.readback(watch).expect("a device"), None);
}

#[cfg_attr(skip_opencl, ignore = "POPULACE_SKIP names opencl")]
#[test]
fn no_frame_waits_for_the_device() {
    for schedule in [Schedule::Staged, Schedule::FusedWide, Schedule::FusedGrouped] {
        frames(&mut stage(Device::opencl(0), schedule));
    }
    frames(&mut stage(Device::native(), Schedule::Fused));
}
