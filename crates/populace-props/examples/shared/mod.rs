//! A stage for props, shared by the examples.

use std::error::Error;

use populace::character::Character;
use populace::{CharacterId, ClipPlayback, Crowd, Device, MemberLook, Placement};
use populace_film::{Pixels, write_png};
use populace_props::Lamp;
use populace_render::{Camera, Renderer, Scene};

pub(crate) type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// A position in metres and a heading in radians.
pub(crate) type Place = ([f32; 3], f32);

/// The name of a picture, and where its camera and the camera's target are, in metres.
pub(crate) type View = (&'static str, [f32; 3], [f32; 3]);

const SIZE: [u32; 2] = [1120, 630];

pub(crate) struct Stage {
    pub(crate) crowd: Crowd,
}

impl Stage {
    pub(crate) fn new() -> Result<Self> {
        Ok(Self { crowd: Crowd::builder().device(Device::native()).build()? })
    }

    /// Puts a thing at places, and prints how many triangles it has.
    pub(crate) fn put(&mut self, what: Character, places: &[Place]) -> Result<CharacterId> {
        let triangles: usize = what.parts.iter().map(|part| part.mesh.indices.len() / 3).sum();
        println!("{}: {triangles} triangles", what.name);
        let id = self.crowd.add_character(what)?;
        for (at, yaw) in places {
            self.crowd.spawn(id, Placement::at(*at).facing(*yaw))?;
        }
        Ok(id)
    }

    /// Puts a light of which one lamp is lit.
    #[allow(dead_code, reason = "not all examples have lights")]
    pub(crate) fn light(
        &mut self,
        light: Character,
        lit: Lamp,
        all: &[Lamp],
        (at, yaw): Place,
    ) -> Result<()> {
        let mut look = MemberLook::PLAIN;
        for lamp in all.iter().filter(|lamp| **lamp != lit) {
            look = look.without_option(lamp.option_in(&light).ok_or("no such lamp")?);
        }
        let id = self.crowd.add_character(light)?;
        let member = self.crowd.spawn(id, Placement::at(at).facing(yaw))?;
        self.crowd.member_mut(member)?.set_look(look);
        Ok(())
    }

    /// Puts one of the built-in people at each place, with a clip.
    pub(crate) fn people(&mut self, places: &[(Place, &str)]) -> Result<()> {
        let cast = populace_cast::cast()?;
        for (person, ((at, yaw), clip)) in cast.into_iter().cycle().zip(places) {
            let id = self.crowd.add_character(person)?;
            let clip = self.crowd.clip(id, clip)?;
            let member = self.crowd.spawn(id, Placement::at(*at).facing(*yaw))?;
            self.crowd.member_mut(member)?.play(clip, ClipPlayback::looping())?;
        }
        Ok(())
    }

    /// Draws the views that the arguments name, or all, into the folder that the first one names.
    pub(crate) fn draw(&mut self, views: &[View], scene: &Scene) -> Result<()> {
        let mut args = std::env::args().skip(1);
        let folder = args.next().unwrap_or_else(|| ".".into());
        let wanted: Vec<String> = args.collect();
        let mut renderer = Renderer::headless(SIZE)?;
        self.crowd.update(1.0)?;
        for (name, eye, target) in views {
            if !wanted.is_empty() && !wanted.iter().any(|w| w == name) {
                continue;
            }
            let camera = Camera { eye: *eye, target: *target, far: 800.0, ..Camera::default() };
            renderer.draw(&mut self.crowd, &camera, scene)?;
            let image = renderer.read_image()?;
            let path = format!("{folder}/{name}.png");
            write_png(&path, SIZE, Pixels::Rgba(&image.rgba))?;
            println!("{path}");
        }
        Ok(())
    }
}
