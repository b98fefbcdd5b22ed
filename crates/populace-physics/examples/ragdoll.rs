//! A row of people walks to the camera. Some are pushed over, and one has a limp arm.
//!
//! `cargo run --example ragdoll [PICTURE.png [FRAMES]]`

use std::sync::Arc;

use anyhow::{Context, Result};
use populace::character::Image;
use populace::{ClipPlayback, Crowd, Device, JointIndex, MemberId, Placement};
use populace_film::{Pixels, write_png};
use populace_physics::{RagdollPlan, Ragdolls, State};
use populace_render::{Camera, Renderer, Scene};

const DT_SECS: f32 = 1.0 / 60.0;
/// Pushes at the chest: index of the person, frame, and the change of the body's velocity in m/s.
const PUSHES: [(usize, u16, [f32; 3]); 5] = [
    (1, 30, [0.0, 0.3, -2.5]),
    (2, 60, [-0.3, 0.0, 2.0]),
    (4, 48, [0.8, 0.0, -1.8]),
    (6, 12, [0.0, 0.0, 0.0]),
    (7, 78, [0.6, 0.3, -2.2]),
];
/// Index of the person with a limp arm.
const LIMP_ARM_OF: usize = 3;

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let file = arguments.next().unwrap_or_else(|| "ragdoll.png".into());
    let frames: u16 = arguments.next().map_or(Ok(150), |frames| frames.parse())?;

    let mut renderer = Renderer::headless([1280, 720])?;
    let mut crowd = Crowd::builder().device(Device::native()).capacity(8).build()?;
    let mut people: Vec<(MemberId, Arc<RagdollPlan>)> = Vec::new();
    for (number, person) in populace_cast::cast()?.into_iter().cycle().take(8).enumerate() {
        let plan = Arc::new(RagdollPlan::from_skeleton(&person.skeleton));
        let character = crowd.add_character(person)?;
        let member = crowd.spawn(character, place(number, 0))?;
        let walk = crowd.clip(character, "Walk")?;
        crowd
            .member_mut(member)?
            .play(walk, ClipPlayback::looping().phase(0.37 * number as f32))?;
        people.push((member, plan));
    }
    crowd.update(0.0)?;

    let mut ragdolls = Ragdolls::new([0.0, -9.81, 0.0])?;
    let (member, plan) = &people[LIMP_ARM_OF];
    let arm = joint(&crowd, *member, ["LeftUpperArm", "l_upper_arm"])?;
    ragdolls.go_limp_from(&crowd, *member, plan, arm)?;
    for frame in 0..frames {
        for (number, _, speed) in PUSHES.into_iter().filter(|push| push.1 == frame) {
            let (member, plan) = &people[number];
            let chest = joint(&crowd, *member, ["Spine4", "chest"])?;
            ragdolls.go_limp(&crowd, *member, plan)?;
            ragdolls.push(*member, chest, speed.map(|v| v * plan.mass_kg()), None)?;
        }
        ragdolls.step(&mut crowd, DT_SECS)?;
        for (number, (member, _)) in people.iter().enumerate() {
            if number == LIMP_ARM_OF || !matches!(ragdolls.state(*member), State::Limp { .. }) {
                crowd.member_mut(*member)?.set_placement(place(number, frame))?;
            }
        }
        crowd.update(DT_SECS)?;
    }
    let front = place(0, frames).position()[2];
    let image = draw(&mut renderer, &mut crowd, front)?;
    Ok(write_png(&file, [image.width, image.height], Pixels::Rgba(&image.rgba))?)
}

fn draw(renderer: &mut Renderer, crowd: &mut Crowd, front: f32) -> Result<Image> {
    let framing = Camera::framing([[-4.3, 0.0, 0.0], [4.3, 1.8, front]], 16.0 / 9.0);
    let camera =
        Camera { eye: [1.0, 3.2, front + 7.2], target: [0.0, 0.4, 0.5 * front], ..framing };
    renderer.draw(crowd, &camera, &Scene::default())?;
    Ok(renderer.read_image()?)
}

/// Returns the placement of a person in a row that walks towards the camera.
fn place(number: usize, frame: u16) -> Placement {
    Placement::at([1.1 * number as f32 - 3.85, 0.0, 1.3 * DT_SECS * f32::from(frame)])
}

/// Finds a joint by its name in either of the two rigs.
fn joint(crowd: &Crowd, member: MemberId, [one, other]: [&str; 2]) -> Result<JointIndex> {
    let skeleton = &crowd.character(crowd.member(member)?.character())?.asset().skeleton;
    skeleton.find(one).or_else(|| skeleton.find(other)).context("the rig has no such joint")
}
