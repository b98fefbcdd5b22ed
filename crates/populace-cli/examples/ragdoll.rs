//! A row of people walks up; some are pushed over, and one has an arm that hangs limp.
//!
//! `cargo run --example ragdoll [picture.png [seconds]]`

use std::error::Error;
use std::sync::Arc;

use populace::{Crowd, Device, JointIndex, Member, Placement, Play};
use populace_physics::{RagdollPlan, Ragdolls, State};
use populace_render::{Camera, CharacterHandle, Instance, Renderer, Scene, write_png};

const DT_SECS: f32 = 1.0 / 60.0;
/// Who is pushed at the chest, after how many seconds, and how fast that makes a whole body, in m/s.
const PUSHES: [(usize, f32, [f32; 3]); 5] = [
    (1, 0.5, [0.0, 0.3, -2.5]),
    (2, 1.0, [-0.3, 0.0, 2.0]),
    (4, 0.8, [0.8, 0.0, -1.8]),
    (6, 0.2, [0.0, 0.0, 0.0]),
    (7, 1.3, [0.6, 0.3, -2.2]),
];
const LIMP_ARM_OF: usize = 3;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let file = arguments.next().unwrap_or_else(|| "ragdoll.png".into());
    let seconds: f32 = arguments.next().map_or(Ok(2.2), |secs| secs.parse())?;

    let mut renderer = Renderer::headless([1280, 720])?;
    let mut crowd = Crowd::builder().device(Device::native()).capacity(8).build()?;
    let mut ragdolls = Ragdolls::new([0.0, -9.81, 0.0])?;
    let mut handles: Vec<CharacterHandle> = Vec::new();
    let mut people: Vec<(Member, Arc<RagdollPlan>)> = Vec::new();
    for (number, person) in populace_cast::cast()?.into_iter().cycle().take(8).enumerate() {
        handles.push(renderer.add_character(&person, &|_| false)?);
        let plan = Arc::new(RagdollPlan::from_skeleton(&person.skeleton));
        let character = crowd.add_character(person)?;
        let member = crowd.spawn(character, place(number, 0.0))?;
        crowd.play(member, crowd.clip(character, "Walk")?, Play::looping().phase(0.37 * number as f32))?;
        people.push((member, plan));
    }
    crowd.update(0.0)?;

    let (member, plan) = &people[LIMP_ARM_OF];
    ragdolls.go_limp_from(
        &crowd,
        *member,
        plan,
        joint(&crowd, *member, &["LeftUpperArm", "l_upper_arm"])?,
    )?;
    for frame in 0..(seconds / DT_SECS) as usize {
        let now_secs = frame as f32 * DT_SECS;
        for (number, at_secs, [x, y, z]) in
            PUSHES.into_iter().filter(|push| frame == (push.1 / DT_SECS) as usize)
        {
            let (member, plan) = &people[number];
            ragdolls.go_limp(&crowd, *member, plan)?;
            let impulse_ns = [x, y, z].map(|speed| speed * plan.mass_kg());
            ragdolls.push(*member, joint(&crowd, *member, &["Spine4", "chest"])?, impulse_ns, None)?;
            eprintln!("{at_secs:.1} s: number {number} is pushed with {impulse_ns:.0?} Ns");
        }
        ragdolls.step(&mut crowd, DT_SECS)?;
        for (number, (member, _)) in people.iter().enumerate() {
            let falls = PUSHES.iter().any(|push| push.0 == number);
            if !falls || !matches!(ragdolls.state(*member), State::Limp { .. }) {
                crowd.place(*member, place(number, now_secs))?;
            }
        }
        crowd.update(DT_SECS)?;
    }

    renderer.take_palettes(&mut crowd)?;
    let drawn = crowd.instances().map(|i| Instance {
        character: handles[i.character.index()],
        world_from_model: i.world_from_model,
        palette_first: i.palette_first,
        tint: [1.0; 3],
    });
    let corners = [[-4.3, 0.0, 0.0], [4.3, 1.8, 1.3 * seconds]];
    let eye = [1.0, 3.2, 1.3 * seconds + 7.2];
    let camera = Camera { eye, target: [0.0, 0.4, 0.6 * seconds], ..Camera::framing(corners, 16.0 / 9.0) };
    renderer.draw(&Scene { camera, ..Scene::default() }, &drawn.collect::<Vec<_>>())?;
    Ok(write_png(&file, &renderer.read_image()?)?)
}

/// Side by side, walking towards the camera.
fn place(number: usize, secs: f32) -> Placement {
    Placement::at([1.1 * number as f32 - 3.85, 0.0, 1.3 * secs])
}

/// The first of these joints that the member has.
fn joint(crowd: &Crowd, member: Member, names: &[&str]) -> Result<JointIndex, Box<dyn Error>> {
    let skeleton = &crowd.character(crowd.character_of(member)?)?.skeleton;
    names.iter().find_map(|name| skeleton.find(name)).ok_or_else(|| format!("none of {names:?}").into())
}
