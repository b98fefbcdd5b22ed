//! The street: everything that people do there happens, and can be saved and restored.
#![allow(clippy::unwrap_used, reason = "a scene that cannot be made fails the test")]

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::Vec2;
use populace::{Affine, Crowd, Device, MemberId};
use populace_locomotion::GaitSpace;
use populace_scene::{Behaviours, Counts, Person, Stage, StreetSettings, street};

const SECS: f32 = 1.0 / 30.0;

struct Street {
    crowd: Crowd,
    behaviours: Behaviours,
}

impl Street {
    fn new(members: usize, seed: u64) -> Self {
        let plan = street(StreetSettings { members, seed });
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
        let prepare = |character| Ok(Arc::new(character));
        let stage = Stage::new(&mut crowd, &plan, &BTreeMap::new(), &prepare).unwrap();
        let behaviours = Behaviours::new(&mut crowd, &plan, &stage, &people, gaits).unwrap();
        Self { crowd, behaviours }
    }

    fn frame(&mut self) {
        self.behaviours.advance(&mut self.crowd, SECS).unwrap();
        self.crowd.update(SECS).unwrap();
    }
}

/// Everything that can be seen of a frame: placements and palettes.
fn seen(crowd: &mut Crowd) -> Vec<u32> {
    let mut bits = Vec::new();
    for member in crowd.members() {
        let placement = member.placement().world_from_model();
        bits.extend(placement.rows.as_flattened().iter().map(|value| value.to_bits()));
    }
    let mut palettes = |_, palette: &[Affine]| {
        let values = palette.iter().flat_map(|matrix| matrix.rows.as_flattened());
        bits.extend(values.map(|value| value.to_bits()));
    };
    crowd.palettes(&mut palettes).unwrap();
    bits
}

#[test]
fn everything_happens_ten_times_in_a_minute() {
    let mut street = Street::new(600, 7);
    (0..1800).for_each(|_| street.frame());
    let counts = street.behaviours.counts();
    let Counts { looked_in, looked_both_ways, crossed, talked, sat, .. } = counts;
    let Counts { drove_off, got_out, fell, got_up, phoned, texted, .. } = counts;
    let Counts { leaned, pointed, carried, .. } = counts;
    let all = [
        looked_in,
        looked_both_ways,
        crossed,
        talked,
        sat,
        drove_off,
        got_out,
        fell,
        got_up,
        phoned,
        texted,
        leaned,
        pointed,
        carried,
    ];
    assert!(all.iter().all(|count| *count >= 10), "{counts:?}");
}

/// Everything that people do in the street is under way in the first frame, and nobody stands in
/// somebody else.
#[test]
fn a_street_begins_in_the_middle() {
    let street = Street::new(500, 7);
    let Counts { looked_in, talked, sat, crossed, leaned, .. } = street.behaviours.counts();
    assert_eq!([looked_in, talked, sat, crossed, leaned], [0; 5], "what has begun is not counted");
    let mut places = Vec::new();
    for member in street.behaviours.people() {
        let view = street.crowd.member(member).unwrap();
        if view.attached_to().is_none() {
            let [x, _, z] = view.placement().position();
            places.push([x, z]);
        }
    }
    let near = |a: &[f32; 2]| {
        let off = |b: &&[f32; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) < 0.35;
        places.iter().filter(off).count() > 1
    };
    let overlapping = places.iter().filter(|at| near(at)).count();
    assert_eq!(overlapping, 0, "people who begin within others");
    let on_road = places.iter().filter(|at| at[1].abs() < 5.0).count();
    assert!(on_road >= 5, "{on_road} people cross at the beginning");
    let at_fronts = places.iter().filter(|at| at[1].abs() > 11.5).count();
    assert!(at_fronts >= 20, "{at_fronts} people are at windows and walls");
}

#[test]
fn a_saved_scene_goes_on_as_it_would_have() {
    let mut street = Street::new(260, 3);
    // Until somebody lies on the ground.
    while street.behaviours.counts().fell == 0 {
        street.frame();
    }
    (0..15).for_each(|_| street.frame());
    let saved = (street.crowd.snapshot().unwrap(), street.behaviours.clone());
    let run = |street: &mut Street| -> Vec<Vec<u32>> {
        (0..60)
            .map(|_| {
                street.frame();
                seen(&mut street.crowd)
            })
            .collect()
    };
    let uninterrupted = run(&mut street);
    street.crowd.restore(&saved.0).unwrap();
    street.behaviours = saved.1;
    assert!(run(&mut street) == uninterrupted, "a frame differs after the restore");
}

#[test]
fn equal_seeds_give_equal_frames_and_others_do_not() {
    let run = |seed| {
        let mut street = Street::new(120, seed);
        (0..240).for_each(|_| street.frame());
        seen(&mut street.crowd)
    };
    let first = run(1);
    assert!(first == run(1), "two runs of one seed differ");
    assert!(first != run(2), "two seeds give the same frame");
}

/// Who telephones or reads holds a phone, from the first frame on; it comes and goes with what they
/// do.
#[test]
fn phones_are_in_the_hands_of_people_who_use_them() {
    let mut street = Street::new(400, 7);
    let phones = |street: &Street| -> Vec<_> {
        let is_phone = |id| street.crowd.character(id).unwrap().asset().name == "phone";
        let held = street.crowd.members().filter(|member| is_phone(member.character()));
        held.map(|phone| phone.attached_to().expect("a phone in a hand").0).collect()
    };
    let first = phones(&street);
    assert!((10..150).contains(&first.len()), "{} phones at the beginning", first.len());
    (0..600).for_each(|_| street.frame());
    let later = phones(&street);
    assert!((10..150).contains(&later.len()), "{} phones later", later.len());
    let kept = later.iter().filter(|owner| first.contains(owner)).count();
    assert!(kept < first.len(), "everybody has kept the phone");
    let people: Vec<_> = street.behaviours.people().collect();
    assert!(later.iter().all(|owner| people.contains(owner)));
}

/// Returns the ends of a vehicle's door in the world as `[x, z]`, if it is open.
fn open_door(crowd: &mut Crowd, vehicle: MemberId) -> Option<[Vec2; 2]> {
    let view = crowd.member(vehicle).unwrap();
    let world = view.placement().world_from_model();
    let asset = Arc::clone(crowd.character(view.character()).unwrap().asset());
    let joint = asset.skeleton.find("Door")?;
    let door = crowd.member_mut(vehicle).unwrap().model_from_joints().unwrap()[joint.index()];
    let is_open = door.rows[0][2].abs() > 0.1;
    let ends = [[0.0; 3], [0.0, 0.0, -0.95]].map(|end| {
        let [x, _, z] = world.transform_point(door.transform_point(end));
        Vec2::new(x, z)
    });
    is_open.then_some(ends)
}

/// Doors swing clear of who opens them, of who gets in, and of who has got out.
#[test]
fn doors_pass_through_nobody() {
    let mut street = Street::new(200, 7);
    let people: Vec<_> = street.behaviours.people().collect();
    let vehicles: Vec<_> = street.behaviours.vehicles().collect();
    let (mut nearest, mut doors) = (f32::MAX, 0);
    for _ in 0..900 {
        street.frame();
        let at = |member: &MemberId| {
            let view = street.crowd.member(*member).unwrap();
            let [x, _, z] = view.placement().position();
            view.attached_to().is_none().then_some(Vec2::new(x, z))
        };
        // Nobody else comes near a vehicle on the road.
        let walkers: Vec<_> = people.iter().filter_map(at).collect();
        for vehicle in &vehicles {
            let middle = street.crowd.member(*vehicle).unwrap().placement().position();
            let middle = Vec2::new(middle[0], middle[2]);
            let near = walkers.iter().filter(|at| at.distance(middle) < 3.0);
            let beside: Vec<_> = near.filter(|at| at.y.abs() < middle.y.abs()).collect();
            if beside.is_empty() {
                continue;
            }
            let Some([hinge, edge]) = open_door(&mut street.crowd, *vehicle) else { continue };
            doors += 1;
            for at in beside {
                let along = edge - hinge;
                let part = ((*at - hinge).dot(along) / along.length_squared()).clamp(0.0, 1.0);
                nearest = nearest.min(at.distance(hinge + along * part));
            }
        }
    }
    assert!(doors > 100, "doors are open in {doors} frames");
    assert!(nearest > 0.25, "somebody is {nearest:.2} m from a door");
}

#[test]
fn nobody_walks_into_a_house_and_nobody_sinks() {
    let mut street = Street::new(200, 5);
    for _ in 0..900 {
        street.frame();
    }
    for member in street.behaviours.people() {
        let view = street.crowd.member(member).unwrap();
        if view.attached_to().is_some() {
            continue;
        }
        let [x, y, z] = view.placement().position();
        assert!(z.abs() < 12.5, "{member:?} is in a house at {x}, {z}");
        assert!((-0.2..=0.05).contains(&y), "{member:?} stands at a height of {y}");
        let is_on_road = z.abs() < 5.0;
        assert!(!is_on_road || y < -0.02, "{member:?} floats over the road: {y}");
    }
}
