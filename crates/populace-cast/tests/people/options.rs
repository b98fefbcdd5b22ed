//! Properties of options: hair cuts, hats, glasses and bags that members can hide or swap.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::OnceLock;

use populace_cast::{Look, option_of, people as outfits, person, person_with_options};
use populace_character::{Character, Part};

use crate::skinning::Surface;

/// Returns the number of triangles of a part.
fn triangles(part: &Part) -> usize {
    part.mesh.indices.len() / 3
}

/// Returns all people in all options, in several outfits.
fn dressed() -> &'static [(Look, Character)] {
    static DRESSED: OnceLock<Vec<(Look, Character)>> = OnceLock::new();
    DRESSED.get_or_init(|| {
        let outfits = |n| Look::presets().into_iter().map(move |look| look.in_outfit(n));
        let looks = (0..6).flat_map(outfits);
        looks.map(|look| (look.clone(), person_with_options(&look).unwrap())).collect()
    })
}

#[test]
fn whatever_is_worn_together_stays_under_6000_triangles() {
    for (look, character) in dressed() {
        let mut largest: BTreeMap<&str, usize> = BTreeMap::new();
        let mut always = 0;
        for part in &character.parts {
            match option_of(&part.node_name) {
                None => always += triangles(part),
                Some((group, _)) => {
                    let size = largest.entry(group).or_default();
                    *size = triangles(part).max(*size);
                }
            }
        }
        let most = always + largest.values().sum::<usize>();
        assert!(most < 6000, "{}: {most} triangles, {always} without options", look.name);
    }
}

#[test]
fn people_wear_one_of_each_group_and_always_hair() {
    for (look, full) in dressed() {
        let plain = person(look).unwrap();
        let names = |character: &Character| -> Vec<String> {
            let names = character.parts.iter().map(|part| part.node_name.clone());
            names.filter(|name| option_of(name).is_some()).collect()
        };
        let (worn, all) = (names(&plain), names(full));
        assert_eq!(worn, look.worn_parts(), "{}", look.name);
        assert!(all.starts_with(&worn), "{}: worn options are not first", look.name);
        let unique: BTreeSet<&String> = all.iter().collect();
        assert!(unique.len() == all.len() && all.len() <= 24, "{}: {all:?}", look.name);
        let groups: Vec<&str> = worn.iter().map(|name| option_of(name).unwrap().0).collect();
        let once: BTreeSet<&&str> = groups.iter().collect();
        assert!(once.len() == groups.len() && groups.contains(&"hair"), "{}: {worn:?}", look.name);
        let hairs = all.iter().filter(|name| option_of(name).unwrap().0 == "hair").count();
        assert!(hairs >= 3, "{} has {hairs} cuts to choose from", look.name);
        assert_eq!(plain.skeleton.joint_count(), full.skeleton.joint_count());
        for (a, b) in plain.clips.iter().zip(&full.clips) {
            assert_eq!(a.source(), b.source(), "{}: options change a clip", look.name);
        }
    }
}

#[test]
fn eight_cuts_hats_glasses_and_bags_occur() {
    let seen: BTreeSet<String> = dressed()
        .iter()
        .flat_map(|(_, character)| character.parts.iter().map(|part| part.node_name.clone()))
        .collect();
    let cuts =
        ["short", "side_part", "receding", "curly", "bob", "long", "bun", "ponytail", "headscarf"];
    for cut in cuts {
        assert!(seen.contains(&format!("Option:hair:{cut}")), "nobody has {cut} hair");
    }
    for other in ["hat:cap", "hat:beanie", "hat:sun_hat", "glasses:round", "glasses:square"] {
        assert!(seen.contains(&format!("Option:{other}")), "nobody has {other}");
    }
    for other in ["glasses:sun", "bag:backpack", "bag:shoulder"] {
        assert!(seen.contains(&format!("Option:{other}")), "nobody has {other}");
    }
}

#[test]
fn every_option_is_closed_and_faces_outwards() {
    for (look, character) in dressed() {
        let options = character.parts.iter().filter(|part| option_of(&part.node_name).is_some());
        for option in options {
            let name = format!("{} {}", look.name, option.node_name);
            let surface = Surface::of_parts(character, |part| part.node_name == option.node_name);
            let mut edges: HashMap<(usize, usize), i32> = HashMap::new();
            let mut volume = 0.0;
            for t in &surface.triangles {
                for i in 0..3 {
                    *edges.entry((t[i], t[(i + 1) % 3])).or_default() += 1;
                }
                let [a, b, c] = t.map(|v| surface.rest[v]);
                volume += a.dot(b.cross(c)) / 6.0;
            }
            assert!(volume > 0.0, "{name} has a volume of {volume} m3");
            for (&(a, b), &count) in &edges {
                let back = edges.get(&(b, a)).copied().unwrap_or(0);
                assert_eq!((count, back), (1, 1), "{name}: the edge at {}", surface.rest[a]);
            }
        }
    }
}

#[test]
fn hats_and_glasses_move_with_the_head() {
    for (look, character) in dressed() {
        let head = if character.skeleton.joint_count() == 54 { "Head" } else { "head" };
        for part in &character.parts {
            if !matches!(option_of(&part.node_name), Some(("hat" | "glasses", _))) {
                continue;
            }
            let surface = Surface::of_parts(character, |p| p.node_name == part.node_name);
            let least =
                (0..surface.rest.len()).map(|v| surface.weight(v, head)).fold(1.0, f64::min);
            assert!(least > 0.99, "{} {}: {least}", look.name, part.node_name);
        }
    }
}

#[test]
fn neighbours_in_a_crowd_differ_in_heads_and_upper_bodies() {
    let all: Vec<Look> = (0..5)
        .flat_map(|n| Look::presets().into_iter().map(move |look| look.in_outfit(n)))
        .collect();
    assert_eq!(outfits(1).unwrap().len(), Look::presets().len());
    for (index, a) in all.iter().enumerate() {
        for b in &all[..index] {
            let same = a.hair == b.hair && a.top == b.top && a.colors.shirt == b.colors.shirt;
            assert!(!same, "{} and {} look the same from the waist up", a.name, b.name);
        }
    }
    let noses: BTreeSet<u64> = all.iter().map(|look| look.face.nose_length.to_bits()).collect();
    assert!(noses.len() > 20, "{} lengths of noses", noses.len());
}
