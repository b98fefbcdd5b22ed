//! Crowds whose members have controls, moved from device to device or shared by several.
#![cfg(all(feature = "opencl", not(skip_opencl)))]

use populace::{ClipPlayback, Crowd, Device, Placement, Split, Target, Weight};

use crate::body::{Stage, character, joint};
use crate::feet::feet;
use crate::gaze::gaze;

/// Members that walk on planted feet, each looking at the hand of the one before it.
fn walkers(mut crowd: Crowd) -> (Stage, Vec<populace::MemberId>) {
    let body = crowd.add_character(character()).expect("room");
    let mut stage = Stage { crowd, body };
    let members: Vec<_> = (0..12_u8).map(|n| stage.member(at(n, 0))).collect();
    let clip = stage.clip("walk");
    for (n, &member) in members.iter().enumerate() {
        let phase = n as f32 * 0.13;
        stage
            .crowd
            .member_mut(member)
            .expect("a clip that plays")
            .play(clip, ClipPlayback::looping().phase(phase))
            .expect("a clip that plays");
        stage.crowd.member_mut(member).expect("feet").plant_feet_with(&feet()).expect("feet");
        let target = Target::Joint { member: members[(n + 5) % 12], joint: joint("leftHand") };
        stage
            .crowd
            .member_mut(member)
            .expect("a gaze")
            .look_at_with(&gaze(), target, Weight::FULL)
            .expect("a gaze");
    }
    (stage, members)
}

fn at(n: u8, frame: u16) -> Placement {
    Placement::at([f32::from(n) * 0.8, 0.0, f32::from(frame) * 0.013]).facing(f32::from(n) * 0.05)
}

fn step(
    stage: &mut Stage,
    members: &[populace::MemberId],
    frame: u16,
) -> Vec<Vec<populace::Affine>> {
    for (n, &member) in (0..).zip(members) {
        stage
            .crowd
            .member_mut(member)
            .expect("a member")
            .set_placement(at(n, frame))
            .expect("a member");
    }
    stage.update(1.0 / 60.0);
    members
        .iter()
        .map(|&member| {
            stage.crowd.member_mut(member).expect("a palette").palette().expect("a palette")
        })
        .collect()
}

fn alone(device: Device) -> Crowd {
    Crowd::builder().device(device).capacity(16).build().expect("a crowd")
}

#[test]
fn a_crowd_that_moves_goes_on_as_one_that_stayed() {
    let (mut stage, members) = walkers(alone(Device::native()));
    let (mut twin, twins) = walkers(alone(Device::native()));
    for frame in 0..80 {
        if frame % 20 == 10 {
            let device = if frame % 40 == 10 { Device::opencl(0) } else { Device::native() };
            stage.crowd.move_to(device).expect("a device");
        }
        assert_eq!(
            step(&mut stage, &members, frame),
            step(&mut twin, &twins, frame),
            "frame {frame}"
        );
    }
}

#[test]
fn members_of_several_devices_keep_their_feet_and_see_each_other() {
    let devices = [Device::native(), Device::opencl(0)];
    let shared = Crowd::builder().devices(devices).capacity(16).build().expect("a crowd");
    let (mut stage, members) = walkers(shared);
    let (mut twin, twins) = walkers(alone(Device::native()));
    for frame in 0..60 {
        // Members change over to and fro.
        let share = f64::from(frame % 7 + 1) / 9.0;
        stage.crowd.set_split(&Split::Fixed(vec![share, 1.0 - share])).expect("shares");
        assert_eq!(
            step(&mut stage, &members, frame),
            step(&mut twin, &twins, frame),
            "frame {frame}"
        );
    }
}
