//! Five people on a slope reach for points at increasing distances. Arms straighten at full length,
//! and point at targets out of reach. Feet are planted on the slope.
//!
//! `cargo run --example reach [PICTURE.png]`

#![expect(clippy::print_stdout, reason = "an example prints its results")]

#[path = "shared/ramp.rs"]
mod ramp;
mod shared;

use std::error::Error;

use populace::model::math::vec3;
use populace::{ClipPlayback, Crowd, Ground, Placement, Reach, Target, Weight};
use populace_cast::{Look, person};

/// Slope of the ground along +X.
const RISE: f32 = 0.2;
/// Height of the ground at the origin, in metres.
const HEIGHT: f32 = 0.8;

fn main() -> Result<(), Box<dyn Error>> {
    let man = person(&Look::man())?;
    let joint = |name: &str| man.skeleton.find(name).ok_or(format!("no joint {name}"));
    let (hand, shoulder) = (joint("LeftHand")?, joint("LeftUpperArm")?);
    let mut crowd = Crowd::builder().build()?;
    let id = crowd.add_character(man)?;
    let idle = crowd.clip(id, "Idle")?;
    // The ground plane for the feet, and a ramp that shows it.
    let ramp = ramp::ramp(RISE)?;
    let drawn = crowd.add_character(ramp)?;
    crowd.spawn(drawn, Placement::at([0.0, HEIGHT, 0.0]))?;
    crowd.set_ground(&Ground::plane(HEIGHT, [RISE, 0.0])?)?;

    let mut targets = Vec::new();
    for nth in 0..5_u8 {
        let x = f32::from(nth) * 1.3 - 2.6;
        let member = crowd.spawn(id, Placement::at([x, HEIGHT + RISE * x, 0.0]).facing(0.3))?;
        crowd
            .member_mut(member)?
            .play(idle, ClipPlayback::looping().phase(f32::from(nth) / 5.0))?;
        crowd.member_mut(member)?.plant_feet(1.0)?;
        let far = 0.25 + 0.12 * f32::from(nth);
        let target = [0.2 + 0.5 * far, 1.35 + 0.3 * far, 0.8 * far];
        crowd.member_mut(member)?.reach(
            Reach::with(hand),
            Target::InModel(target),
            Weight::FULL,
        )?;
        crowd.member_mut(member)?.look_at(Target::InModel(target), Weight::FULL)?;
        targets.push((member, target));
    }
    for _ in 0..60 {
        crowd.update(1.0 / 60.0)?;
    }
    for (nth, (member, target)) in targets.into_iter().enumerate() {
        let joints = crowd.member_mut(member)?.model_from_joints()?;
        let distance = |from: [f32; 3]| vec3::length(vec3::sub(from, target));
        let [away, missed] = [shoulder, hand].map(|joint| distance(joints[joint.index()].origin()));
        println!(
            "{nth}: the target is {away:.2} m from the shoulder, and {:.0} mm from the hand",
            missed * 1e3
        );
    }
    let path = shared::output("reach.png");
    shared::draw(&mut crowd, &[[-3.4, -0.2, 0.0], [3.4, 3.1, 0.0]], &path)?;
    println!("on {}, drawn to {path}", crowd.device_info().name);
    Ok(())
}
