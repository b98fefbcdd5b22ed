//! Constraints in crowds that move between devices or run on several.
#![cfg(all(feature = "opencl", not(skip_opencl)))]

use populace::{ClipPlayback, Crowd, Device, Placement, Split, Target, Weight};

use crate::feet::feet;
use crate::fixture::{Scene, character, joint};
use crate::gaze::gaze;

/// Members that walk with planted feet. Each looks at the hand of another member.
fn walkers(mut crowd: Crowd) -> (Scene, Vec<populace::MemberId>) {
    let body = crowd.add_character(character()).expect("enough capacity");
    let mut scene = Scene { crowd, body };
    let members: Vec<_> = (0..12_u8).map(|n| scene.member(at(n, 0))).collect();
    let clip = scene.clip("walk");
    for (n, &member) in members.iter().enumerate() {
        let phase = n as f32 * 0.13;
        scene
            .edit(member)
            .play(clip, ClipPlayback::looping().phase(phase))
            .expect("a clip that plays");
        scene.edit(member).plant_feet_with(&feet()).expect("feet");
        let target = Target::Joint { member: members[(n + 5) % 12], joint: joint("leftHand") };
        scene.edit(member).look_at_with(&gaze(), target, Weight::FULL).expect("a gaze");
    }
    (scene, members)
}

fn at(n: u8, frame: u16) -> Placement {
    Placement::at([f32::from(n) * 0.8, 0.0, f32::from(frame) * 0.013]).facing(f32::from(n) * 0.05)
}

fn step(
    scene: &mut Scene,
    members: &[populace::MemberId],
    frame: u16,
) -> Vec<Vec<populace::Affine>> {
    for (n, &member) in (0..).zip(members) {
        scene.edit(member).set_placement(at(n, frame)).expect("a member");
    }
    scene.update(1.0 / 60.0);
    members.iter().map(|&member| scene.edit(member).palette().expect("a palette")).collect()
}

fn crowd_on(device: Device) -> Crowd {
    Crowd::builder().device(device).capacity(16).build().expect("a crowd")
}

#[test]
fn constraints_survive_a_move_to_another_device() {
    let (mut scene, members) = walkers(crowd_on(Device::native()));
    let (mut twin, twins) = walkers(crowd_on(Device::native()));
    for frame in 0..80 {
        if frame % 20 == 10 {
            let device = if frame % 40 == 10 { Device::opencl(0) } else { Device::native() };
            scene.crowd.move_to(device).expect("a device");
        }
        assert_eq!(
            step(&mut scene, &members, frame),
            step(&mut twin, &twins, frame),
            "frame {frame}"
        );
    }
}

#[test]
fn split_crowd_keeps_planted_feet_and_gaze_targets() {
    let devices = [Device::native(), Device::opencl(0)];
    let shared = Crowd::builder().devices(devices).capacity(16).build().expect("a crowd");
    let (mut scene, members) = walkers(shared);
    let (mut twin, twins) = walkers(crowd_on(Device::native()));
    for frame in 0..60 {
        // Members change devices back and forth.
        let share = f64::from(frame % 7 + 1) / 9.0;
        scene.crowd.set_split(&Split::Fixed(vec![share, 1.0 - share])).expect("shares");
        assert_eq!(
            step(&mut scene, &members, frame),
            step(&mut twin, &twins, frame),
            "frame {frame}"
        );
    }
}
