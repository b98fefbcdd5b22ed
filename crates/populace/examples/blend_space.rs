//! Seven people at seven speeds, from standing to running, with three clips.
//!
//! A blend space mixes the two clips around each speed. It keeps them in phase, so that their feet
//! touch the ground at the same time.
//!
//! `cargo run --example blend_space [PICTURE.png]`

#![expect(clippy::print_stdout, reason = "an example prints its results")]

mod shared;

use std::error::Error;

use populace::{BlendSpace, BlendSpacePlayback, Crowd, Placement};
use populace_cast::{Look, person};

fn main() -> Result<(), Box<dyn Error>> {
    let man = person(&Look::man())?;
    let mut crowd = Crowd::builder().build()?;
    let id = crowd.add_character(man)?;
    // Each clip is a sample at its own ground speed.
    let mut samples = Vec::new();
    for (clip, motion) in crowd.character(id)?.clips() {
        let speed_m_per_sec = motion.stats().ground_speed_m_per_sec.unwrap_or(0.0).max(0.0);
        if ["Idle", "Walk", "Run"].contains(&motion.name()) {
            println!("{}: sample at {speed_m_per_sec:.2} m/s", motion.name());
            samples.push((clip, speed_m_per_sec));
        }
    }
    let gait = crowd.add_blend_space(BlendSpace::line(&samples)?)?;

    // All begin standing, and change to their speed within a second.
    let mut members = Vec::new();
    for nth in 0..7_u8 {
        let place = Placement::at([f32::from(nth) * 1.2 - 3.6, 0.0, 0.0])
            .facing(std::f32::consts::FRAC_PI_2);
        let member = crowd.spawn(id, place)?;
        crowd.member_mut(member)?.play_blend_space(gait, 0.0, BlendSpacePlayback::new())?;
        crowd.member_mut(member)?.set_blend_parameter(f32::from(nth) * 0.5, 1.0)?;
        members.push(member);
    }
    for _ in 0..72 {
        crowd.update(1.0 / 60.0)?;
    }
    let clips = crowd.character(id)?.clips();
    for (nth, member) in (0..7_u8).zip(members) {
        let name =
            |clip| clips.iter().find(|(id, _)| *id == clip).map_or("", |(_, clip)| clip.name());
        let playing = crowd.member(member)?.active_clips();
        let shares: Vec<_> =
            playing.iter().map(|p| format!("{} {:.0} %", name(p.clip), p.weight * 100.0)).collect();
        println!("{:.1} m/s: {}", f32::from(nth) * 0.5, shares.join(", "));
    }
    let path = shared::output("blend_space.png");
    shared::draw(&mut crowd, &[[-4.2, 0.0, 0.0], [4.2, 1.9, 0.0]], &path)?;
    println!("drawn to {path}");
    Ok(())
}
