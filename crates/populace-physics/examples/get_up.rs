//! Four people are pushed over, lie on the ground, and get up: from the back, the front, and the
//! right and the left side.
//!
//! `cargo run --example get_up [PICTURE.png [FRAMES]]`

use std::sync::Arc;

use anyhow::{Context, Result};
use populace::{ClipPlayback, Crowd, Device, Placement};
use populace_cast::{Look, person};
use populace_film::{Pixels, write_png};
use populace_physics::{GetUp, RagdollPlan, Ragdolls};
use populace_render::{Camera, Renderer, Scene};

const DT_SECS: f32 = 1.0 / 60.0;
/// The frame at which all get up.
const UP_AT: u16 = 180;

/// People and the pushes at their chests: direction in degrees from +Z to +X, and the change of the
/// body's velocity in m/s.
fn people() -> [(Look, f32, f32); 4] {
    [
        (Look::man(), 180.0, 3.0),
        (Look::woman(), 0.0, 1.5),
        (Look::old_man(), 240.0, 2.0),
        (Look::tall_woman(), 120.0, 2.0),
    ]
}

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let file = arguments.next().unwrap_or_else(|| "get_up.png".into());
    let frames: u16 = arguments.next().map_or(Ok(300), |frames| frames.parse())?;

    let mut renderer = Renderer::headless([1280, 480])?;
    let mut crowd = Crowd::builder().device(Device::native()).capacity(4).build()?;
    let mut ragdolls = Ragdolls::new([0.0, -9.81, 0.0])?;
    let mut members = Vec::new();
    for (number, (look, _, _)) in people().iter().enumerate() {
        let character = crowd.add_character(person(look)?)?;
        let member = crowd.spawn(character, Placement::at([2.2 * number as f32, 0.0, 0.0]))?;
        let idle = crowd.clip(character, "Idle")?;
        crowd.member_mut(member)?.play(idle, ClipPlayback::looping())?;
        members.push((member, GetUp::find(&crowd, character)));
    }
    crowd.update(0.3)?;
    for ((member, _), (_, degrees, speed)) in members.iter().zip(people()) {
        let character = crowd.member(*member)?.character();
        let skeleton = &crowd.character(character)?.asset().skeleton;
        let chest = skeleton.find("Spine4").or_else(|| skeleton.find("chest"));
        let plan = Arc::new(RagdollPlan::from_skeleton(skeleton));
        let (sin, cos) = degrees.to_radians().sin_cos();
        let impulse = [sin, 0.0, cos].map(|v| v * speed * plan.mass_kg());
        ragdolls.go_limp(&crowd, *member, &plan)?;
        ragdolls.push(*member, chest.context("no chest")?, impulse, None)?;
    }
    for frame in 0..frames {
        if frame == UP_AT {
            for (member, get_up) in &members {
                ragdolls.get_up_with(&mut crowd, *member, get_up)?;
            }
        }
        ragdolls.step(&mut crowd, DT_SECS)?;
        crowd.update(DT_SECS)?;
    }
    let framing = Camera::framing([[-1.0, 0.0, -1.0], [8.0, 1.8, 1.0]], 1280.0 / 480.0);
    let camera = Camera { eye: [3.5, 2.2, 6.8], target: [3.5, 0.6, 0.0], ..framing };
    renderer.draw(&mut crowd, &camera, &Scene::default())?;
    let image = renderer.read_image()?;
    Ok(write_png(&file, [image.width, image.height], Pixels::Rgba(&image.rgba))?)
}
