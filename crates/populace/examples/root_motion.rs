//! Two rows of people walk, then run, moved by the root motion of their clips. The program places
//! them only at the start, and at the end reads where the first of them is.
//!
//! `cargo run --example root_motion [PICTURE.png]`

#![expect(clippy::print_stdout, reason = "an example prints its results")]

mod shared;

use std::error::Error;
use std::sync::Arc;

use populace::{ClipPlayback, Crowd, MotionSettings, Placement};
use populace_cast::{Look, person};

/// Number of frames between the starts of two people.
const GAP_FRAMES: u16 = 38;
/// Number of frames that each walks.
const WALK_FRAMES: u16 = 150;

fn main() -> Result<(), Box<dyn Error>> {
    let (woman, man) = (person(&Look::woman())?, person(&Look::man())?);
    let mut crowd = Crowd::builder().build()?;
    let ids = [crowd.add_character(woman)?, crowd.add_character(man)?];
    let mut people = Vec::new();
    for (&id, x) in ids.iter().zip([-4.5, -4.0]) {
        let mut moving = |name: &str| -> Result<_, Box<dyn Error>> {
            let clip = crowd.clip(id, name)?;
            let (_, plain) = crowd
                .character(id)?
                .clips()
                .into_iter()
                .find(|(known, _)| *known == clip)
                .ok_or("a clip")?;
            // These clips walk in place; their planted feet give the speed.
            let moving = plain.with_root_motion(&MotionSettings::default())?;
            Ok(crowd.character_mut(id)?.add_clip(&Arc::new(moving))?)
        };
        let (walk, run) = (moving("Walk")?, moving("Run")?);
        for nth in 0..7_u16 {
            let member = crowd.spawn(id, Placement::at([x, 0.0, -2.5 * (x + 4.5)]).facing(1.5))?;
            crowd.member_mut(member)?.start_root_motion()?;
            let start_frame = nth * GAP_FRAMES;
            crowd
                .member_mut(member)?
                .play(walk, ClipPlayback::looping().after_secs(f32::from(start_frame) / 60.0))?;
            people.push((member, run, start_frame + WALK_FRAMES));
        }
    }
    for frame in 0..250_u16 {
        for &(member, run, _) in people.iter().filter(|(_, _, run_frame)| *run_frame == frame) {
            crowd.member_mut(member)?.crossfade(run, 0.5)?;
        }
        crowd.update(1.0 / 60.0)?;
    }
    // Shadows cover the last known positions, so let the device finish before the drawn frame.
    crowd.finish()?;
    crowd.update(0.0)?;
    let first = people[0].0;
    let (from, now) = (
        crowd.member(first)?.placement().position(),
        crowd.member_mut(first)?.moved_placement()?.position(),
    );
    let metres = (now[0] - from[0]).hypot(now[2] - from[2]);
    println!("the first was placed once, and has moved {metres:.2} m");
    let path = shared::output("root_motion.png");
    shared::draw(&mut crowd, &[[-5.2, -0.3, 1.5], [4.4, 2.0, 0.0]], &path)?;
    println!("on {}, drawn to {path}", crowd.device_info().name);
    Ok(())
}
