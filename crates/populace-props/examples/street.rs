//! Draws a street of all props, with people beside them for scale.
//!
//! `cargo run -p populace-props --example street [FOLDER [VIEW...]]`

#![expect(clippy::print_stdout, reason = "an example prints its results")]

use std::error::Error;
use std::f32::consts::{FRAC_PI_2, PI};

use populace::character::Character;
use populace::{ClipPlayback, Crowd, Device, MemberLook, Placement};
use populace_film::{Pixels, write_png};
use populace_props as props;
use populace_props::{Crossing, CrossingKind, Lamp, RoadPlan};
use populace_render::{Camera, Preset, Renderer, Scene};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

const SIZE: [u32; 2] = [1120, 630];

/// Name, eye and target of each picture.
const VIEWS: [(&str, [f32; 3], [f32; 3]); 13] = [
    ("car", [-4.6, 1.6, 5.0], [-8.6, 0.6, 1.7]),
    ("rear", [-15.0, 1.8, 5.2], [-9.4, 0.5, 1.7]),
    ("door", [-17.5, 1.7, 2.2], [-16.0, 0.6, -2.3]),
    ("cars", [5.0, 2.4, 2.5], [13.0, 0.6, 0.0]),
    ("street", [-21.0, 2.2, 3.6], [10.0, 2.6, -2.5]),
    ("shops", [-14.0, 1.65, -1.0], [-17.0, 2.0, -7.6]),
    ("across", [-10.0, 1.7, 6.4], [-6.0, 3.6, -8.0]),
    ("crossing", [-6.5, 1.9, 5.6], [1.0, 0.8, -3.5]),
    ("bench", [7.5, 1.6, -1.2], [11.5, 0.9, -5.0]),
    ("tree", [-3.0, 1.7, 0.4], [-8.0, 3.2, -4.2]),
    ("lights", [-0.5, 1.9, -1.0], [2.6, 2.2, -4.2]),
    ("top", [-26.0, 17.0, 15.0], [0.0, 1.0, -1.0]),
    ("side", [16.0, 1.8, 2.0], [4.0, 2.4, 7.5]),
];

struct Street {
    crowd: Crowd,
}

impl Street {
    fn put(&mut self, what: Character, places: &[([f32; 3], f32)]) -> Result<()> {
        let triangles: usize = what.parts.iter().map(|part| part.mesh.indices.len() / 3).sum();
        println!("{}: {triangles} triangles", what.name);
        let id = self.crowd.add_character(what)?;
        for (at, yaw) in places {
            self.crowd.spawn(id, Placement::at(*at).facing(*yaw))?;
        }
        Ok(())
    }

    fn light(
        &mut self,
        what: Character,
        lit: Lamp,
        all: &[Lamp],
        at: [f32; 3],
        yaw: f32,
    ) -> Result<()> {
        let mut look = MemberLook::PLAIN;
        for lamp in all.iter().filter(|lamp| **lamp != lit) {
            look = look.without_option(lamp.option_in(&what).ok_or("no such lamp")?);
        }
        let id = self.crowd.add_character(what)?;
        let member = self.crowd.spawn(id, Placement::at(at).facing(yaw))?;
        self.crowd.member_mut(member)?.set_look(look);
        Ok(())
    }

    fn houses(&mut self, front: f32) -> Result<()> {
        for side in [-1.0, 1.0_f32] {
            let (mut x, mut seed) = (-30.0, if side < 0.0 { 0 } else { 40 });
            while x < 30.0 {
                let width = 6.0 + 0.9 * (seed % 4) as f32;
                let shop = props::shopfront(seed, width)?;
                let yaw = if side < 0.0 { 0.0 } else { PI };
                self.put(shop.character, &[([x + 0.5 * width, 0.0, side * front], yaw)])?;
                x += width;
                seed += 1;
            }
        }
        Ok(())
    }

    fn people(&mut self) -> Result<()> {
        let places = [
            (-16.9, -6.55, PI),
            (-13.0, -6.5, 2.8),
            (-9.0, -6.3, 2.6),
            (-4.0, -5.3, 1.5),
            (0.4, -2.2, 0.2),
            (-0.8, 1.0, PI),
            (12.9, -4.5, 0.6),
            (3.2, -4.9, 0.0),
        ];
        for (person, (x, z, yaw)) in populace_cast::cast()?.into_iter().zip(places) {
            let id = self.crowd.add_character(person)?;
            let on_road = f32::abs(z) < 3.25;
            let y = if on_road { -props::KERB_M } else { 0.0 };
            let clip = self.crowd.clip(id, if on_road { "Walk" } else { "Idle" })?;
            let member = self.crowd.spawn(id, Placement::at([x, y, z]).facing(yaw))?;
            self.crowd.member_mut(member)?.play(clip, ClipPlayback::looping())?;
        }
        Ok(())
    }

    fn furniture(&mut self) -> Result<()> {
        self.put(props::bench()?.character, &[([11.5, 0.0, -4.6], 0.0), ([-9.0, 0.0, 4.6], PI)])?;
        for (seed, x) in [(0, -8.0), (1, 7.5), (2, 17.0), (3, -18.0)] {
            let mirrored = ([x + 3.0, 0.0, 4.4], 1.0);
            self.put(props::tree(seed)?, &[([x, 0.0, -4.4], 0.0), mirrored])?;
        }
        let lamps = [-23.0, -12.5, 4.6, 14.5].map(|x| ([x, 0.0, -3.8], 0.0));
        self.put(props::street_lamp()?, &lamps)?;
        let bollards = [-4.2, -5.4, -6.6, 4.2, 5.6].map(|x| ([x, 0.0, -3.7], 0.0));
        self.put(props::bollard()?, &bollards)?;
        self.put(props::bin()?, &[([9.6, 0.0, -4.4], 0.0), ([-14.0, 0.0, 4.2], 0.0)])?;
        self.put(props::planter(1)?, &[([-2.0, 0.0, -6.6], 0.0)])?;
        self.put(props::planter(2)?, &[([14.0, 0.0, -4.5], 0.0)])?;
        let table = props::cafe_table()?.character;
        self.put(table, &[([9.0, 0.0, -6.2], 0.3), ([6.8, 0.0, -6.1], -0.2)])
    }

    fn cars(&mut self) -> Result<()> {
        use props::CarKind::{Hatchback, Saloon, Van};
        let places = [
            (Hatchback, 0, -9.0, 1.7, FRAC_PI_2, false),
            (Saloon, 1, 9.0, -1.7, -FRAC_PI_2, false),
            (Van, 2, 16.0, 1.7, FRAC_PI_2, false),
            (Saloon, 3, -16.0, -2.3, -FRAC_PI_2, true),
        ];
        for (kind, seed, x, z, yaw, opens) in places {
            let car = props::car(kind, seed)?.character;
            let triangles: usize = car.parts.iter().map(|p| p.mesh.indices.len() / 3).sum();
            println!("{kind:?}: {triangles} triangles");
            let id = self.crowd.add_character(car)?;
            let at = Placement::at([x, -props::KERB_M, z]).facing(yaw);
            let member = self.crowd.spawn(id, at)?;
            if opens {
                let clip = self.crowd.clip(id, "Door_Open")?;
                self.crowd.member_mut(member)?.play(clip, ClipPlayback::once())?;
            }
        }
        Ok(())
    }

    fn lights(&mut self) -> Result<()> {
        let (cars, people) = (Lamp::OF_CARS, Lamp::OF_PEOPLE);
        self.light(props::traffic_light()?, Lamp::Red, &cars, [-3.4, 0.0, 3.6], -FRAC_PI_2)?;
        self.light(props::traffic_light()?, Lamp::Green, &cars, [3.4, 0.0, -3.6], FRAC_PI_2)?;
        self.light(props::walk_light()?, Lamp::Walk, &people, [2.4, 0.0, -4.7], 0.0)?;
        self.light(props::walk_light()?, Lamp::Stop, &people, [-2.4, 0.0, 4.7], PI)
    }
}

fn main() -> Result<()> {
    let mut args = std::env::args().skip(1);
    let folder = args.next().unwrap_or_else(|| ".".into());
    let wanted: Vec<String> = args.collect();
    let mut street = Street { crowd: Crowd::builder().device(Device::native()).build()? };
    let plan = RoadPlan {
        crossings: vec![
            Crossing { x_m: 0.0, width_m: 4.0, kind: CrossingKind::Signals },
            Crossing { x_m: 22.0, width_m: 4.0, kind: CrossingKind::Zebra },
        ],
        length_m: 64.0,
        ..RoadPlan::default()
    };
    let road = props::road(&plan)?;
    street.houses(road.front_m())?;
    street.put(road.character, &[([0.0; 3], 0.0)])?;
    street.furniture()?;
    street.lights()?;
    street.people()?;
    street.cars()?;
    street.crowd.update(1.0)?;
    let mut scene: Scene = Preset::Day.scene();
    if let Some(ground) = &mut scene.ground {
        ground.height_m = -0.4;
    }
    let mut renderer = Renderer::headless(SIZE)?;
    for (name, eye, target) in VIEWS {
        if !wanted.is_empty() && !wanted.iter().any(|w| w == name) {
            continue;
        }
        let camera = Camera { eye, target, far: 800.0, ..Camera::default() };
        let drawn = renderer.draw(&mut street.crowd, &camera, &scene)?;
        let image = renderer.read_image()?;
        let path = format!("{folder}/{name}.png");
        write_png(&path, SIZE, Pixels::Rgba(&image.rgba))?;
        println!("{path}: {} triangles", drawn.triangles);
    }
    Ok(())
}
