//! Draws a place with people of synthetic trajectories:
//! `cargo run --release --example place -- PICTURE.png`.

use std::error::Error;
use std::fmt::Write;
use std::path::Path;

use populace::{Crowd, Device, Placement};
use populace_film::{Pixels, write_png};
use populace_locomotion::GaitSpace;
use populace_render::{Camera, Ground, Renderer, Scene};
use populace_scene::{Motions, Person, PlaceModel, PlaceSettings, Replay};
use populace_trajectory::{PlaceChange, Polygon, ReadSettings, Recording};

const FRAMES_PER_SEC: f32 = 25.0;

fn main() -> Result<(), Box<dyn Error>> {
    let file = std::env::args().nth(1).unwrap_or_else(|| "place.png".into());
    let recording = recording()?;
    let mut crowd = Crowd::builder().device(Device::native()).capacity(200).build()?;
    let (mut characters, mut gaits) = (Vec::new(), Vec::new());
    for character in populace_cast::cast()? {
        characters.push(crowd.add_character(character)?);
        gaits.push(GaitSpace::of(&mut crowd, characters[characters.len() - 1])?);
    }
    let person = |i| Person { character: characters[i % characters.len()], scale: 1.0, look: None };
    let people: Vec<_> = (0..recording.agents.len()).map(person).collect();
    let mut replay =
        Replay::new(&recording, Motions::new(&recording), &people, gaits, recording.secs()[0])?;
    let model = PlaceModel::new(&recording, &PlaceSettings::default());
    for part in model.parts {
        let place = crowd.add_character(part.character)?;
        crowd.spawn(place, Placement::at([0.0; 3]))?;
    }
    for _ in 0..200 {
        replay.advance(&mut crowd, 1.0 / FRAMES_PER_SEC)?;
        crowd.update(1.0 / FRAMES_PER_SEC)?;
    }
    let mut renderer = Renderer::headless([1280, 720])?;
    let framing = Camera::framing([[0.0, 0.0, -8.0], [14.0, 1.8, 0.0]], 1280.0 / 720.0);
    let camera = Camera { eye: [6.0, 8.5, 9.5], target: [7.0, 0.0, -3.7], ..framing };
    let mut scene = Scene::default();
    scene.ground = scene.ground.map(|ground| Ground { height_m: -0.15, ..ground });
    renderer.draw(&mut crowd, &camera, &scene)?;
    let image = renderer.read_image()?;
    Ok(write_png(&file, [image.width, image.height], Pixels::Rgba(&image.rgba))?)
}

/// Returns people who walk through a room with a niche, two pillars and a courtyard.
fn recording() -> Result<Recording, Box<dyn Error>> {
    let mut text = String::from("# framerate: 25\n# id frame x/m y/m z/m\n");
    for agent in 0..40_u16 {
        let (lane, start) = (0.6 + 0.4 * f32::from(agent % 5), 25 * (agent / 5));
        for frame in 0..260_u16 {
            let x = -0.5 + 0.05 * f32::from(frame);
            writeln!(text, "{} {} {x} {lane} 1.7", agent + 1, frame + start)?;
        }
    }
    let settings = ReadSettings::default();
    let mut recording = populace_trajectory::parse(Path::new("room.txt"), text.into(), &settings)?;
    let outline = vec![
        [0.0, 0.0],
        [12.0, 0.0],
        [12.0, 3.0],
        [14.0, 3.0],
        [14.0, 6.0],
        [12.0, 8.0],
        [4.0, 8.0],
        [4.0, 6.0],
        [0.0, 6.0],
    ];
    let square = |[x, y]: [f64; 2], side: f64| {
        vec![[x, y], [x + side, y], [x + side, y + side], [x, y + side]]
    };
    let walkable =
        vec![Polygon { outline, holes: vec![square([8.0, 4.0], 2.4), square([2.0, 4.2], 0.5)] }];
    recording.place.changes = vec![PlaceChange { from_secs: 0.0, walkable }];
    let obstacle = Polygon { outline: square([5.6, 4.0], 0.7), holes: Vec::new() };
    recording.place.obstacles = vec![obstacle];
    Ok(recording)
}
