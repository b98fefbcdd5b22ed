//! Three people swing an arm outwards, then raise it: the first with a cut, the second with a
//! crossfade, the third with an inertialized transition.
//!
//! Beads mark the path of each hand, 60 per second: dark before the transition, red after it. Only
//! the third path has no corner.
//!
//! `cargo run --example inertialize [PICTURE.png]`

#![expect(clippy::print_stdout, reason = "an example prints its results")]

#[path = "shared/bead.rs"]
mod bead;
mod shared;

use std::error::Error;

use glam::{Quat, Vec3};
use populace::clip::Clip;
use populace::model::{ClipSource, Interpolation, Property, Skeleton, Track};
use populace::{ClipPlayback, Crowd, Placement};
use populace_cast::{Look, person};

const FRAME_SECS: f32 = 1.0 / 60.0;
/// Number of frames until the transition.
const SWING: u8 = 14;
/// Number of frames until the picture.
const FRAMES: u8 = 38;
/// Length of the transition.
const SECS: f32 = 0.3;

/// Creates a clip that rotates the right arm from one rotation to another in 0.6 s.
fn clip(
    skeleton: &Skeleton,
    name: &str,
    from: Quat,
    to: Quat,
) -> Result<Clip, populace::clip::Error> {
    let track = Track {
        joint: "r_upper_arm".into(),
        property: Property::Rotation,
        interpolation: Interpolation::Linear,
        times: vec![0.0, 0.6],
        values: [from, to].map(|rotation| rotation.to_array()).concat(),
    };
    Clip::new(ClipSource { name: name.into(), tracks: vec![track] }, skeleton)
}

/// Creates two clips: one swings the arm outwards at shoulder height, the other holds it up.
fn clips(skeleton: &Skeleton) -> Result<[Clip; 2], populace::clip::Error> {
    let (level, up) = (Quat::from_rotation_z(-0.7), Quat::from_rotation_z(-2.0));
    let [front, side] = [1.7, -0.9].map(|yaw| Quat::from_rotation_y(yaw) * level);
    Ok([clip(skeleton, "Swing", front, side)?, clip(skeleton, "Up", up, up)?])
}

/// Returns the largest change of a hand's velocity between two frames after the transition, in
/// metres per second.
fn largest_change(trail: &[[f32; 3]]) -> f32 {
    let step = |frame: usize| Vec3::from(trail[frame]) - Vec3::from(trail[frame - 1]);
    let changes =
        (usize::from(SWING)..trail.len()).map(|frame| (step(frame) - step(frame - 1)).length());
    changes.fold(0.0, f32::max) / FRAME_SECS
}

fn main() -> Result<(), Box<dyn Error>> {
    let woman = person(&Look::woman())?;
    let skeleton = &woman.skeleton;
    let hand = skeleton.find("r_hand").ok_or("no joint r_hand")?;
    let [swing, up] = clips(skeleton)?;

    let mut crowd = Crowd::builder().build()?;
    let id = crowd.add_character(woman)?;
    let (swing, up) = (
        crowd.character_mut(id)?.add_clip(&swing.into())?,
        crowd.character_mut(id)?.add_clip(&up.into())?,
    );
    let before = bead::bead("before", 0.016, [0.05, 0.05, 0.08, 1.0])?;
    let after = bead::bead("after", 0.016, [0.75, 0.05, 0.04, 1.0])?;
    let marks = [crowd.add_character(before)?, crowd.add_character(after)?];
    let kinds = [
        ("cut", ClipPlayback::looping()),
        ("crossfaded", ClipPlayback::looping().fade_in_secs(SECS)),
        ("inertialized", ClipPlayback::looping().inertialize_in_secs(SECS)),
    ];
    let mut members = Vec::new();
    for (nth, (name, play)) in kinds.into_iter().enumerate() {
        let place = Placement::at([nth as f32 * 1.6 - 1.6, 0.0, 0.0]).facing(0.3);
        let member = crowd.spawn(id, place)?;
        crowd.member_mut(member)?.play(swing, ClipPlayback::once())?;
        members.push((name, play, member, place));
    }
    let mut trails = vec![Vec::new(); members.len()];
    for frame in 0..FRAMES {
        for (_, play, member, _) in members.iter().filter(|_| frame == SWING) {
            crowd.member_mut(*member)?.play(up, *play)?;
        }
        crowd.update(FRAME_SECS)?;
        for ((_, _, member, place), trail) in members.iter().zip(&mut trails) {
            let joint = crowd.member_mut(*member)?.model_from_joints()?[hand.index()];
            trail.push(place.world_from_model().mul(&joint).origin());
        }
    }
    for ((name, ..), trail) in members.iter().zip(&trails) {
        let change = largest_change(trail);
        println!("{name}: the hand changes its speed by up to {change:.1} m/s from frame to frame");
        for (frame, at) in trail.iter().enumerate() {
            crowd.spawn(marks[usize::from(frame >= usize::from(SWING))], Placement::at(*at))?;
        }
    }
    crowd.update(0.0)?;
    let path = shared::output("inertialize.png");
    shared::draw(&mut crowd, &[[-2.6, -0.1, 0.4], [2.6, 2.2, 0.4]], &path)?;
    println!("all three on {}, drawn to {path}", crowd.device_info().name);
    Ok(())
}
