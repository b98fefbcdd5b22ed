//! The street: everything that people do there happens, and can be saved and restored.

use populace::{Crowd, Device};
use populace_locomotion::GaitSpace;
use populace_scene::{Behaviours, Person, StreetSettings, street};

const SECS: f32 = 1.0 / 30.0;

struct Street {
    crowd: Crowd,
    behaviours: Behaviours,
}

impl Street {
    fn new(members: usize) -> Self {
        let plan = street(StreetSettings { members, seed: 7 });
        let mut crowd = Crowd::builder()
            .device(Device::native())
            .capacity(members + 400)
            .slots_per_member(8)
            .build()
            .unwrap();
        let mut gaits = Vec::new();
        let mut characters = Vec::new();
        for character in populace_cast::cast().unwrap() {
            let id = crowd.add_character(character).unwrap();
            gaits.push(GaitSpace::of(&mut crowd, id).unwrap());
            characters.push(id);
        }
        let person = |nth: usize| Person {
            character: characters[nth % characters.len()],
            scale: 1.0,
            look: None,
        };
        let people = vec![(0..members).map(person).collect()];
        let models = [];
        let behaviours = Behaviours::new(&mut crowd, &plan, &people, gaits, &models).unwrap();
        Self { crowd, behaviours }
    }

    fn frame(&mut self) {
        self.behaviours.advance(&mut self.crowd, SECS).unwrap();
        self.crowd.update(SECS).unwrap();
    }
}

#[test]
fn everything_happens_ten_times_in_a_minute() {
    let mut street = Street::new(500);
    let start = std::time::Instant::now();
    let mut behave = 0.0;
    for _ in 0..1800 {
        let s = std::time::Instant::now();
        street.behaviours.advance(&mut street.crowd, SECS).unwrap();
        behave += s.elapsed().as_secs_f64();
        street.crowd.update(SECS).unwrap();
    }
    println!("{:?} {:?} behave {:.2} ms", street.behaviours.counts(), start.elapsed(), behave / 1.8);
}
