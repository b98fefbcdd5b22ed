//! Draws a built-in person on the parts of a course, from the side at the height of the knees:
//! `cargo run --release --example course -- [PICTURE.png]`.

use std::error::Error;

use populace::character::Image;
use populace::{Crowd, Device, Ground, MemberId, Placement};
use populace_film::{Pixels, write_png};
use populace_locomotion::{GaitSpace, Goal, WalkerSettings, Walkers};
use populace_render::{Camera, Renderer, Scene};

const SECS: f32 = 1.0 / 60.0;
/// Size of each frame in pixels, and the frames of a part.
const SIZE: [u32; 2] = [120, 160];
const FRAMES: u16 = 9;

/// A part of the course: its velocity `[x, z]` and heading at a time, the time of its first frame,
/// and the time between frames, all in seconds.
struct Part {
    tell: fn(f32) -> ([f32; 2], Option<f32>),
    from_secs: f32,
    every_secs: f32,
    stairs: bool,
}

const PARTS: [Part; 7] = [
    Part { tell: |_| ([0.0, 0.4], None), from_secs: 3.0, every_secs: 0.22, stairs: false },
    Part { tell: |_| ([0.0, 1.3], None), from_secs: 3.0, every_secs: 0.11, stairs: false },
    Part { tell: |_| ([0.0, 3.5], None), from_secs: 4.0, every_secs: 0.07, stairs: false },
    Part {
        tell: |secs| ([0.0, if secs < 2.0 { 1.3 } else { 0.0 }], None),
        from_secs: 2.0,
        every_secs: 0.2,
        stairs: false,
    },
    Part {
        tell: |secs| ([0.0; 2], Some(if secs < 0.5 { 0.0 } else { 2.4 })),
        from_secs: 0.5,
        every_secs: 0.2,
        stairs: false,
    },
    Part { tell: |_| ([0.0, -0.7], Some(0.0)), from_secs: 3.0, every_secs: 0.15, stairs: false },
    Part { tell: |_| ([0.0, 1.3], None), from_secs: 2.5, every_secs: 0.17, stairs: true },
];

fn main() -> Result<(), Box<dyn Error>> {
    let file = std::env::args().nth(1).unwrap_or_else(|| "course.png".into());
    let width = SIZE[0] * u32::from(FRAMES);
    let mut strip = Image { width, height: 0, rgba: Vec::new() };
    let mut renderer = Renderer::headless(SIZE)?;
    for part in &PARTS {
        let frames = walk(part, &mut renderer)?;
        for row in 0..SIZE[1] as usize {
            let bytes = 4 * SIZE[0] as usize;
            for frame in &frames {
                strip.rgba.extend(&frame.rgba[row * bytes..(row + 1) * bytes]);
            }
        }
        strip.height += SIZE[1];
    }
    Ok(write_png(&file, [strip.width, strip.height], Pixels::Rgba(&strip.rgba))?)
}

/// Walks a part of the course and returns its frames.
fn walk(part: &Part, renderer: &mut Renderer) -> Result<Vec<Image>, Box<dyn Error>> {
    let mut crowd = Crowd::builder().device(Device::native()).capacity(1).build()?;
    let id = crowd.add_character(populace_cast::person(&populace_cast::Look::man())?)?;
    let [idle, walk, run] = ["Idle", "Walk", "Run"].map(|name| crowd.clip(id, name));
    let gaits = GaitSpace::new(&mut crowd, id, idle?, &[walk?, run?])?;
    let mut walkers = Walkers::new(WalkerSettings::default())?;
    walkers.add_gaits(gaits);
    if part.stairs {
        let ground = stairs()?;
        crowd.set_ground(&ground)?;
        walkers.set_ground(ground);
    }
    let member = crowd.spawn(id, Placement::at([0.0; 3]))?;
    walkers.add(&mut crowd, member)?;
    let mut frames = Vec::new();
    let mut secs = 0.0;
    while frames.len() < usize::from(FRAMES) {
        let (velocity, facing) = (part.tell)(secs);
        walkers.set_goal(member, Goal::Velocity(velocity))?;
        walkers.set_facing(member, facing)?;
        walkers.update(&mut crowd, SECS)?;
        crowd.update(SECS)?;
        secs += SECS;
        if secs >= part.from_secs + part.every_secs * frames.len() as f32 {
            frames.push(draw(&mut crowd, member, renderer)?);
        }
    }
    Ok(frames)
}

fn draw(
    crowd: &mut Crowd,
    member: MemberId,
    renderer: &mut Renderer,
) -> Result<Image, Box<dyn Error>> {
    let [x, y, z] = crowd.member(member)?.placement().position();
    let framing = Camera::framing([[-1.0, 0.0, -1.0], [1.0, 1.8, 1.0]], 0.75);
    let camera = Camera { eye: [x + 3.3, y + 0.5, z], target: [x, y + 0.85, z], ..framing };
    renderer.draw(crowd, &camera, &Scene::default())?;
    Ok(renderer.read_image()?)
}

/// Returns treads of 30 cm with a rise of 15 cm, from 1 m on.
fn stairs() -> Result<Ground, Box<dyn Error>> {
    let height = |row: u16| {
        let z = -3.0 + 0.05 * f32::from(row);
        0.15 * ((z - 1.0) / 0.3).ceil().clamp(0.0, 12.0)
    };
    let heights = (0..400).flat_map(|row| [height(row); 2]).collect();
    Ok(Ground::height_field([-10.0, -3.0], 0.05, 2, heights).map_err(populace::Error::from)?)
}
