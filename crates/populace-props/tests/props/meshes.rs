//! Meshes: normals, winding, budgets and seeds.

use std::collections::{BTreeMap, HashMap};

use glam::DVec3;
use populace_character::{Character, MAX_OPTIONS};
use populace_props::{CarKind, car, helmet, planter, shield, shopfront, tree};

use crate::all;
use crate::rays::triangles;

#[test]
fn normals_are_unit_vectors_on_the_side_from_which_triangles_are_seen() {
    for (name, character, _) in all() {
        for ([a, b, c], normals, material) in triangles(&character) {
            let area = (b - a).cross(c - a);
            assert!(area.length() > 1e-10, "{name}, {material}: a triangle without area at {a}");
            for normal in normals {
                assert!((normal.length() - 1.0).abs() < 1e-4, "{name}, {material}: {normal}");
                let facing = normal.dot(area.normalize());
                assert!(facing > 0.05, "{name}, {material}: {facing} at {a}");
            }
        }
    }
}

/// Returns six times the volume of each closed surface of a character: of triangles of a material
/// that touch, in which each edge has a second one. `None` if these do not run in opposite ways.
fn closed_volumes(character: &Character) -> Vec<(String, Option<f64>)> {
    let mut by_material: BTreeMap<&str, Vec<[DVec3; 3]>> = BTreeMap::new();
    for (points, _, material) in triangles(character) {
        by_material.entry(material).or_default().push(points);
    }
    // The sum turns -0 into 0.
    let key = |p: DVec3| ((p * 2e4).round() + DVec3::ZERO).to_array().map(f64::to_bits);
    let mut volumes = Vec::new();
    for (material, points) in by_material {
        let mut group: Vec<usize> = (0..points.len()).collect();
        let mut first = HashMap::new();
        for (index, corners) in points.iter().enumerate() {
            for corner in corners {
                let other = *first.entry(key(*corner)).or_insert(index);
                let [a, b] = [root(&mut group, index), root(&mut group, other)];
                group[a] = b;
            }
        }
        // Of each edge, how often it occurs, and how much more often forwards.
        let mut edges: BTreeMap<usize, HashMap<_, [i32; 2]>> = BTreeMap::new();
        let mut volume: BTreeMap<usize, f64> = BTreeMap::new();
        for (index, [a, b, c]) in points.iter().enumerate() {
            let of = root(&mut group, index);
            *volume.entry(of).or_default() += a.dot(b.cross(*c));
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let [from, to] = [key(*from), key(*to)];
                let forwards = from < to;
                let edge = if forwards { (from, to) } else { (to, from) };
                let [count, sum] = edges.entry(of).or_default().entry(edge).or_default();
                *count += 1;
                *sum += if forwards { 1 } else { -1 };
            }
        }
        for (of, edges) in edges {
            if edges.values().all(|[count, _]| count % 2 == 0) {
                let agrees = edges.values().all(|[_, sum]| *sum == 0);
                volumes.push((material.to_owned(), agrees.then_some(volume[&of])));
            }
        }
    }
    volumes
}

fn root(group: &mut [usize], mut index: usize) -> usize {
    while group[index] != index {
        group[index] = group[group[index]];
        index = group[index];
    }
    index
}

#[test]
fn closed_surfaces_face_outwards() {
    let mut count = 0;
    for (name, character, _) in all() {
        for (material, volume) in closed_volumes(&character) {
            let volume =
                volume.unwrap_or_else(|| panic!("{name}: {material} has faces inside out"));
            assert!(volume > -1e-9, "{name}: a surface of {material} is inside out ({volume})");
            count += 1;
        }
    }
    assert!(count > 2000, "only {count} closed surfaces");
}

#[test]
fn budgets_of_triangles_are_kept() {
    for (name, character, most) in all() {
        let count: usize = character.parts.iter().map(|part| part.mesh.indices.len() / 3).sum();
        assert!(count <= most, "{name} has {count} triangles, more than {most}");
    }
}

#[test]
fn skeletons_know_how_far_their_vertices_reach() {
    for (name, character, _) in all() {
        let reach = character.skeleton.reach_m().iter().copied().fold(0.0, f32::max);
        let bounds = character.rest_bounds().expect("meshes");
        let half =
            (0..3).map(|axis| bounds.high[axis] - bounds.low[axis]).fold(0.0, f32::max) / 2.0;
        assert!(reach > 0.9 * half, "{name} reaches {reach} m of {half} m");
        assert!(character.options().len() <= MAX_OPTIONS);
    }
}

#[test]
fn equal_seeds_give_equal_data_and_others_differ() {
    type Make = fn(u64) -> Character;
    let makers: [(&str, Make); 6] = [
        ("shopfront", |seed| shopfront(seed, 7.0).unwrap().character),
        ("tree", |seed| tree(seed).unwrap()),
        ("planter", |seed| planter(seed).unwrap()),
        ("shield", |seed| shield(seed).unwrap()),
        ("helmet", |seed| helmet(seed).unwrap()),
        ("car", |seed| car(CarKind::Saloon, seed).unwrap().character),
    ];
    for (name, make) in makers {
        let (one, same) = (make(5), make(5));
        assert!(one.parts == same.parts && one.materials == same.materials, "{name}");
        let others = (6..12).map(make);
        let differs =
            |other: &Character| other.parts != one.parts || other.materials != one.materials;
        assert!(others.into_iter().any(|other| differs(&other)), "{name}");
    }
}

#[test]
fn seeds_near_each_other_give_houses_of_all_kinds() {
    let mut signs = BTreeMap::new();
    for seed in 0..40 {
        let house = shopfront(seed, 7.0).unwrap().character;
        let wall = house.materials.iter().find(|m| m.name == "Top wall").expect("a wall");
        *signs.entry(wall.base_color.map(f32::to_bits)).or_insert(0) += 1;
    }
    assert!(signs.len() >= 12, "only {} walls", signs.len());
    assert!(signs.values().all(|count| *count <= 8), "{signs:?}");
}

#[test]
fn materials_are_those_of_files_too() {
    for (name, character, _) in all() {
        for material in &character.materials {
            let in_range = material.base_color.iter().all(|c| (0.0..=1.0).contains(c));
            assert!(in_range, "{name}: {} is {:?}", material.name, material.base_color);
            assert!(!material.name.is_empty());
        }
    }
}
