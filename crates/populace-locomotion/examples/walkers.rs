//! People walk along paths of their own, around each other. Draws a picture of them, or one of a
//! film at a time in seconds: `cargo run --release --example walkers -- [PICTURE.png [SECONDS]]`.

use std::error::Error;
use std::sync::Arc;

use populace::{Crowd, Device, Placement};
use populace_film::{Pixels, write_png};
use populace_locomotion::avoidance::{Avoidance, AvoidanceSettings};
use populace_locomotion::{GaitSpace, Goal, Path, WalkerSettings, Walkers};
use populace_render::{Camera, Renderer, Scene};

const FRAMES_PER_SEC: u16 = 60;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let file = arguments.next().unwrap_or_else(|| "walkers.png".into());
    let secs: f32 = arguments.next().map_or(Ok(8.0), |secs| secs.parse())?;

    let mut crowd = Crowd::builder().device(Device::native()).capacity(100).build()?;
    let mut walkers = Walkers::new(WalkerSettings::default())?;
    walkers.set_avoidance(Some(Avoidance::new(AvoidanceSettings::default())?));
    let mut characters = Vec::new();
    for character in populace_cast::cast()? {
        let id = crowd.add_character(character)?;
        let [idle, walk, run] = ["Idle", "Walk", "Run"].map(|name| crowd.clip(id, name));
        walkers.add_gaits(GaitSpace::new(&mut crowd, id, idle?, &[walk?, run?])?);
        characters.push(id);
    }
    // Two streams that meet, each of eight rows of five.
    for number in 0..80_u16 {
        let (row, column) = (f32::from(number / 10), f32::from(number % 5));
        let side = if number % 10 < 5 { 1.0 } else { -1.0 };
        let at = [side * (4.0 + 1.3 * row), 1.2 * (column - 2.0)];
        let character = characters[usize::from(number) % characters.len()];
        let facing = -side * std::f32::consts::FRAC_PI_2;
        let member = crowd.spawn(character, Placement::at([at[0], 0.0, at[1]]).facing(facing))?;
        walkers.add(&mut crowd, member)?;
        walkers.set_speed(member, 1.0 + 0.05 * f32::from(number % 9))?;
        let path = Path::new(&[at, [-side * 20.0, at[1]]])?;
        walkers.set_goal(member, Goal::Path(Arc::new(path)))?;
    }
    let frames = (0_u32..).take_while(|frame| *frame as f32 <= secs * f32::from(FRAMES_PER_SEC));
    for _ in frames {
        walkers.update(&mut crowd, 1.0 / f32::from(FRAMES_PER_SEC))?;
        crowd.update(1.0 / f32::from(FRAMES_PER_SEC))?;
    }
    let mut renderer = Renderer::headless([1280, 480])?;
    let framing = Camera::framing([[-6.0, 0.0, -3.0], [6.0, 1.8, 3.0]], 1280.0 / 480.0);
    let camera = Camera { eye: [0.0, 4.5, 11.0], target: [0.0, 0.6, 0.0], ..framing };
    renderer.draw(&mut crowd, &camera, &Scene::default())?;
    let image = renderer.read_image()?;
    Ok(write_png(&file, [image.width, image.height], Pixels::Rgba(&image.rgba))?)
}
