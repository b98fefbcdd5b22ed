//! Ragdolls give the same bits on every device and schedule, through falling and getting up.
#![expect(clippy::expect_used, reason = "a failing step fails the test")]

use std::sync::Arc;

use populace::{ClipPlayback, Crowd, Device, Placement, Schedule};
use populace_cast::{Look, person};
use populace_physics::{RagdollPlan, Ragdolls, State};

const DT: f32 = 1.0 / 60.0;

/// Simulates a man who walks, falls and walks on. Returns the bits of his palettes and the heights
/// of his hips, sampled every nine frames.
fn fall(device: Device, schedule: Schedule) -> (Vec<u32>, Vec<f32>) {
    let man = person(&Look::man()).expect("a man");
    let hips = man.skeleton.find("Pelvis").expect("hips");
    let mut crowd =
        Crowd::builder().device(device).schedule(schedule).capacity(2).build().expect("a crowd");
    let id = crowd.add_character(man).expect("room");
    let walk = crowd.clip(id, "Walk").expect("a walk");
    let member = crowd.spawn(id, Placement::at([1.0, 0.0, 2.0]).facing(0.4)).expect("room");
    crowd
        .member_mut(member)
        .expect("a clip")
        .play(walk, ClipPlayback::looping().phase(0.3))
        .expect("a clip");
    let plan = Arc::new(RagdollPlan::from_skeleton(
        &crowd.character(id).expect("a character").asset().skeleton,
    ));
    let mut ragdolls = Ragdolls::new([0.0, -9.81, 0.0]).expect("gravity");
    let (mut bits, mut heights) = (Vec::new(), Vec::new());
    for frame in 0..270_u16 {
        match frame {
            10 => {
                ragdolls.go_limp(&crowd, member, &plan).expect("a member");
                ragdolls.push(member, hips, [40.0, 0.0, -90.0], None).expect("a limp member");
            }
            180 => ragdolls.get_up(&mut crowd, member, 1.0).expect("a limp member"),
            _ => {}
        }
        ragdolls.step(&mut crowd, DT).expect("a step");
        crowd.update(DT).expect("a frame");
        if frame % 9 == 0 {
            let palette =
                crowd.member_mut(member).expect("a palette").palette().expect("a palette");
            bits.extend(palette.iter().flat_map(|m| m.rows).flatten().map(f32::to_bits));
            heights.push(
                crowd.member_mut(member).expect("joints").model_from_joints().expect("joints")
                    [hips.index()]
                .origin()[1],
            );
        }
    }
    assert_eq!(ragdolls.state(member), State::Animated);
    (bits, heights)
}

#[test]
fn ragdolls_are_identical_on_every_device_and_schedule() {
    let (wanted, heights) = fall(Device::native(), Schedule::Fused);
    let (walking, lying, up) = (heights[0], heights[19], heights[29]);
    assert!(walking > 0.8 && lying < 0.4 && (up - walking).abs() < 0.1, "{heights:?}");
    assert!(fall(Device::native(), Schedule::Staged).0 == wanted, "native, staged");
    #[cfg(not(skip_opencl))]
    for schedule in [Schedule::Staged, Schedule::FusedWide, Schedule::FusedGrouped] {
        assert!(fall(Device::opencl(0), schedule).0 == wanted, "OpenCL, {schedule}");
    }
}
