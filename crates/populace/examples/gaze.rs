//! Nine people in a row look at the head of a woman who walks past. Their heads follow her within
//! the limits of the neck.
//!
//! `cargo run --example gaze [PICTURE.png]`

#![expect(clippy::print_stdout, reason = "an example prints its results")]

mod shared;

use std::error::Error;

use populace::{ClipPlayback, Crowd, Placement, Target, Weight};
use populace_cast::{Look, person};

fn main() -> Result<(), Box<dyn Error>> {
    let woman = person(&Look::woman())?;
    let head = woman.skeleton.find("head").ok_or("no joint head")?;
    let mut crowd = Crowd::builder().build()?;
    let id = crowd.add_character(woman)?;
    let (idle, walk) = (crowd.clip(id, "Idle")?, crowd.clip(id, "Walk")?);

    let passer =
        crowd.spawn(id, Placement::at([-3.0, 0.0, 1.6]).facing(std::f32::consts::FRAC_PI_2))?;
    crowd.member_mut(passer)?.play(walk, ClipPlayback::looping())?;
    let mut row = Vec::new();
    for nth in 0..9_u8 {
        let member = crowd.spawn(id, Placement::at([f32::from(nth) * 0.75 - 3.0, 0.0, 0.0]))?;
        crowd
            .member_mut(member)?
            .play(idle, ClipPlayback::looping().phase(f32::from(nth) / 9.0))?;
        // The look-at weight fades in over a different time for each.
        let weight = Weight::new(1.0)?.over_secs(0.3 + 0.1 * f32::from(nth));
        crowd.member_mut(member)?.look_at(Target::Joint { member: passer, joint: head }, weight)?;
        row.push(member);
    }
    for frame in 0..120_u8 {
        let x = f32::from(frame) / 60.0 * 1.4 - 3.0;
        crowd
            .member_mut(passer)?
            .set_placement(Placement::at([x, 0.0, 1.6]).facing(std::f32::consts::FRAC_PI_2))?;
        crowd.update(1.0 / 60.0)?;
    }
    for (nth, &member) in row.iter().enumerate() {
        let facing = crowd.member_mut(member)?.model_from_joints()?[head.index()];
        // Rest rotations of these people are upright, so the third column is the facing direction.
        let (x, z) = (facing.rows[0][2], facing.rows[2][2]);
        println!("{nth}: the head is turned by {:.0} degrees", x.atan2(z).to_degrees());
    }
    let path = shared::output("gaze.png");
    shared::draw(&mut crowd, &[[-3.2, -0.3, 1.6], [3.2, 1.9, 0.0]], &path)?;
    println!("on {}, drawn to {path}", crowd.device_info().name);
    Ok(())
}
