//! Five people follow a motion-capture stream: poses at about 30 Hz, with jitter, appended to a
//! live clip. The first person shows the stream with a delay of 0.1 s, and each other person 0.15 s
//! later than the one before.
//!
//! `cargo run --example live_clip [PICTURE.png]`

#![expect(clippy::print_stdout, reason = "an example prints its results")]
#![expect(
    clippy::disallowed_methods,
    reason = "this motion need not be identical on every machine"
)]

mod shared;

use std::error::Error;

use glam::Quat;
use populace::model::Skeleton;
use populace::{ClipPlayback, Crowd, LiveSettings, Placement, Streamed, Trs};
use populace_cast::{Look, person};

/// Returns the actor's pose: the right arm waves, the left arm swings, and the body sways.
fn actor(skeleton: &Skeleton, secs: f32) -> Result<Vec<Trs>, populace::model::Error> {
    let mut pose: Vec<Trs> = skeleton.joints().map(|joint| *skeleton.rest(joint)).collect();
    let beat = (secs * 5.0).sin();
    let rotations = [
        ("r_upper_arm", Quat::from_rotation_z(-1.0 + 1.3 * beat)),
        ("r_forearm", Quat::from_rotation_z(-0.4 + 0.4 * beat)),
        ("l_upper_arm", Quat::from_rotation_x(0.9 * beat)),
        ("spine", Quat::from_rotation_z(0.12 * beat)),
    ];
    for (joint, (_, rotation)) in
        skeleton.find_all(rotations.map(|(name, _)| name))?.into_iter().zip(rotations)
    {
        let rest = Quat::from_array(skeleton.rest(joint).rotation);
        pose[joint.index()].rotation = (rotation * rest).to_array();
    }
    Ok(pose)
}

fn main() -> Result<(), Box<dyn Error>> {
    let woman = person(&Look::woman())?;
    let mut crowd = Crowd::builder().build()?;
    let id = crowd.add_character(woman.clone())?;
    // Only rotations are streamed, so that the followers keep their proportions. The clip holds two
    // seconds; older rows are overwritten.
    let settings = LiveSettings {
        rows_per_sec: 60.0,
        secs: 2.0,
        translations: Streamed::Nothing,
        ..LiveSettings::default()
    };
    let live = crowd.character_mut(id)?.add_live_clip("Actor", &settings)?;
    let mut followers = Vec::new();
    for nth in 0..5_u8 {
        let nth = f32::from(nth);
        let member = crowd.spawn(id, Placement::at([nth * 1.1 - 2.2, 0.0, 0.0]).facing(0.2))?;
        crowd.member_mut(member)?.play(live, ClipPlayback::live(0.1 + 0.15 * nth))?;
        followers.push(member);
    }
    // Before each frame of 1/60 s, the poses that have arrived are appended. They are early or late
    // by up to 10 ms.
    let (mut poses, mut now) = (0_u16, 0.0_f32);
    for _ in 0..300 {
        loop {
            let jitter = if poses == 0 { 0.0 } else { 0.01 * (f32::from(poses) * 2.4).sin() };
            let at = f32::from(poses) / 30.0 + jitter;
            if at > now {
                break;
            }
            crowd.clip_mut(live)?.append(f64::from(at), &actor(&woman.skeleton, at)?)?;
            poses += 1;
        }
        crowd.update(1.0 / 60.0)?;
        now += 1.0 / 60.0;
    }
    for (nth, &member) in followers.iter().enumerate() {
        let shown = crowd.member(member)?.active_clips()[0].time_secs;
        println!("{nth}: shows {shown:.2} s of the stream, {:.2} s ago", now - shown);
    }
    let path = shared::output("live_clip.png");
    shared::draw(&mut crowd, &[[-2.9, -0.1, 0.4], [2.9, 2.2, 0.4]], &path)?;
    println!("{poses} poses in {now:.1} s on {}, drawn to {path}", crowd.device_info().name);
    Ok(())
}
