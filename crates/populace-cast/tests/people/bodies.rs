//! Properties of bodies at rest.

use std::collections::HashMap;

use populace_cast::{Bottom, Look, Rig, cast, person};

use crate::people;
use crate::skinning::{Surface, models};

#[test]
fn every_surface_is_closed_and_faces_outwards() {
    for character in people() {
        let surface = Surface::welded(character);
        let mut edges: HashMap<(usize, usize), i32> = HashMap::new();
        let mut volume = 0.0;
        for t in &surface.triangles {
            for i in 0..3 {
                *edges.entry((t[i], t[(i + 1) % 3])).or_default() += 1;
            }
            let [a, b, c] = t.map(|v| surface.rest[v]);
            volume += a.dot(b.cross(c)) / 6.0;
            assert!((b - a).cross(c - a).length() > 2e-8, "{}: a sliver at {a}", character.name);
        }
        for (&(a, b), &count) in &edges {
            let back = edges.get(&(b, a)).copied().unwrap_or(0);
            assert_eq!(
                (count, back),
                (1, 1),
                "{}: the edge at {}",
                character.name,
                surface.rest[a]
            );
        }
        // Bodies have about the density of water. The body mass index of an average adult is about
        // 22 kg/m2.
        let mass_index = 1000.0 * volume / f64::from(character.height_m()).powi(2);
        assert!(
            (14.0..45.0).contains(&mass_index),
            "{} has a body mass index of {mass_index}",
            character.name
        );
    }
}

#[test]
fn sizes_weights_and_materials_are_in_bounds() {
    assert!(people().len() >= 6);
    for (character, look) in people().iter().zip(Look::presets()) {
        let off = f64::from(character.height_m()) - look.height_m;
        assert!(off.abs() < 0.012, "{} is {off} m too tall", character.name);
        assert!(character.parts.len() <= 9, "{}: {} parts", character.name, character.parts.len());
        for part in &character.parts {
            assert_eq!(part.mesh.influences.per_vertex, 4);
            for weights in part.mesh.influences.weights.chunks(4) {
                assert!(
                    (weights.iter().sum::<f32>() - 1.0).abs() < 1e-5
                        && weights.iter().all(|w| *w >= 0.0)
                );
            }
        }
        let dress = look.bottom == Bottom::Dress;
        for name in ["Skin", "Hair", "Eyes", "Top", "Trousers", "Shoes"] {
            let users = |m: usize| character.parts.iter().filter(|p| p.material == Some(m)).count();
            let material = character.materials.iter().position(|m| m.name == name);
            let wanted = (name != "Trousers" || !dress).then_some(1);
            assert_eq!(material.map(users), wanted, "{}: material {name}", character.name);
        }
        for (material, at) in character.materials.iter().zip(0..) {
            let regions = ["Skin", "Hair", "Eyes", "Top", "Trousers", "Shoes", "Accessory"];
            let region = material.name.split(' ').next().unwrap();
            assert!(regions.contains(&region), "{}", material.name);
            assert_eq!(character.parts[at].material, Some(at));
        }
    }
}

#[test]
fn soles_are_on_the_ground_and_toes_and_nose_point_forward() {
    for character in people() {
        let surface = Surface::welded(character);
        let skinned = surface.skinned(&models(character, None));
        let far =
            surface.rest.iter().zip(&skinned).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
        assert!(far < 1e-5, "{}: rest moves vertices by {far}", character.name);
        for side in [-1.0, 1.0] {
            let own = || surface.rest.iter().filter(|p| p.x * side > 0.01 && p.y < 0.15);
            let lowest = own().map(|p| p.y).fold(1.0, f64::min);
            assert!(lowest.abs() < 1e-4, "{}: a sole at {lowest}", character.name);
            let ends = own().fold((0.0_f64, 0.0_f64), |(b, f), p| (b.min(p.z), f.max(p.z)));
            assert!(
                ends.1 > -1.8 * ends.0,
                "{}: a foot from {} to {}",
                character.name,
                ends.0,
                ends.1
            );
        }
        let height = f64::from(character.height_m());
        let skin = Surface::of_parts(character, |part| part.material == Some(0));
        let head = skin.rest.iter().filter(|p| p.y > 0.88 * height && p.y < 0.94 * height);
        let nose = head.max_by(|a, b| a.z.total_cmp(&b.z)).unwrap();
        assert!(nose.x.abs() < 1e-6 && nose.z > 0.0, "{}: the nose is at {nose}", character.name);
    }
}

#[test]
fn rigs_differ_in_spine_names_rest_rotations_and_fingers() {
    let rig = |wanted: Rig| {
        let looks = Look::presets();
        people().iter().zip(looks).filter(move |(_, l)| l.rig == wanted).map(|(c, _)| &c.skeleton)
    };
    assert!(rig(Rig::Lean).count() >= 3 && rig(Rig::Full).count() >= 3);
    let (lean, full) = (rig(Rig::Lean).next().unwrap(), rig(Rig::Full).next().unwrap());
    assert_eq!((lean.joint_count(), full.joint_count()), (25, 54));
    assert!(lean.joints().all(|j| full.find(lean.name(j)).is_none()), "rigs share joint names");
    let rotated = |s: &populace_model::Skeleton| {
        s.joints().filter(|&j| s.rest(j).rotation[3].abs() < 0.999).count()
    };
    assert_eq!(rotated(lean), 0);
    assert!(rotated(full) > 12, "{} joints are rotated at rest", rotated(full));
    let named = |s: &populace_model::Skeleton, word: &str| {
        s.joints().filter(|&j| s.name(j).to_lowercase().contains(word)).count()
    };
    assert_eq!((named(lean, "spine"), named(full, "spine")), (1, 4));
    assert_eq!((named(lean, "index"), named(full, "index")), (0, 6));
}

#[test]
fn looks_with_numbers_that_are_not_finite_are_refused() {
    let spoil: [fn(&mut Look); 10] = [
        |look| look.height_m = f64::NAN,
        |look| look.head = f64::INFINITY,
        |look| look.limbs = f64::NAN,
        |look| look.belly = f64::NAN,
        |look| look.face.nose_length = f64::NAN,
        |look| look.face.jaw = f64::INFINITY,
        |look| look.face.eyes = f64::NAN,
        |look| look.face.brow = f64::NAN,
        |look| look.colors.under[0] = f32::NAN,
        |look| look.face.iris[1] = f32::INFINITY,
    ];
    for (at, spoil) in spoil.into_iter().enumerate() {
        let mut look = Look::man();
        spoil(&mut look);
        assert!(person(&look).is_err(), "number {at} is accepted");
    }
}

#[test]
fn equal_looks_give_equal_data() {
    for (a, b) in people().iter().zip(&cast().unwrap()) {
        assert_eq!(a.skeleton, b.skeleton);
        assert_eq!(a.palette, b.palette);
        assert_eq!(a.parts, b.parts);
        for (a, b) in a.clips.iter().zip(&b.clips) {
            assert_eq!(a.source(), b.source());
        }
    }
}
