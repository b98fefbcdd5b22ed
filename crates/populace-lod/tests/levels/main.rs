//! Levels of the built-in people, held to what they promise.

#![expect(clippy::unwrap_used, reason = "a failed call fails the test")]

mod geometry;
mod walls;

use geometry::{Point, distance_to_triangle, dot, normal};
use populace_character::{Character, CharacterSource, Influences, Mesh, PaletteEntry, Part};
use populace_lod::{levels_of, with_levels};
use populace_model::{Affine, JointIndex, JointSource, Skeleton, Trs};

fn man() -> Character {
    populace_cast::cast().unwrap().remove(1)
}

fn triangles(meshes: &[Mesh]) -> usize {
    meshes.iter().map(|mesh| mesh.indices.len() / 3).sum()
}

#[test]
fn levels_have_ever_fewer_triangles_and_growing_errors() {
    let man = man();
    let own: usize = man.parts.iter().map(|part| part.mesh.indices.len() / 3).sum();
    let levels = levels_of(&man);
    let counts: Vec<usize> = levels.iter().map(|level| triangles(&level.meshes)).collect();
    assert!(levels.len() >= 5, "{counts:?}");
    assert!(counts[0] < own && counts.is_sorted_by(|a, b| a > b), "{counts:?}");
    assert!(counts.last().is_some_and(|last| *last < own / 60), "{counts:?}");
    assert!(levels.is_sorted_by(|a, b| a.error_m < b.error_m));
}

/// Returns the man in other units.
fn man_times(scale: f32) -> Character {
    let man = man();
    let mut source = CharacterSource::clone(&man);
    let joint = |joint: JointIndex| {
        let rest = man.skeleton.rest(joint);
        JointSource {
            name: man.skeleton.name(joint).into(),
            parent: man.skeleton.parent(joint).map(JointIndex::index),
            rest: Trs { translation: rest.translation.map(|x| x * scale), ..*rest },
        }
    };
    source.skeleton = Skeleton::new(&man.skeleton.joints().map(joint).collect::<Vec<_>>()).unwrap();
    for entry in &mut source.palette {
        entry.joint_from_bind.rows.iter_mut().for_each(|row| row[3] *= scale);
    }
    for place in source.parts.iter_mut().flat_map(|part| &mut part.mesh.positions) {
        *place = place.map(|x| x * scale);
    }
    source.clips.clear();
    Character::new(source).unwrap()
}

/// Returns the man with meshes whose bind space is mirrored; at rest he is the same.
fn man_mirrored() -> Character {
    let mut source = CharacterSource::clone(&man());
    for row in source.palette.iter_mut().flat_map(|entry| &mut entry.joint_from_bind.rows) {
        row[0] = -row[0];
    }
    for mesh in source.parts.iter_mut().map(|part| &mut part.mesh) {
        mesh.positions.iter_mut().chain(&mut mesh.normals).for_each(|v| v[0] = -v[0]);
        mesh.indices.as_chunks_mut::<3>().0.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
    Character::new(source).unwrap()
}

#[test]
fn mirrored_meshes_have_mirrored_levels() {
    let (man, mirrored) = (man(), man_mirrored());
    assert!(mirrored.is_mirrored(0) && !man.is_mirrored(0));
    let corners = |mesh: &Mesh, x: f32, order: [usize; 3]| -> Vec<[[f32; 3]; 3]> {
        let place = |index: u32| mesh.positions[index as usize];
        let mirror = |[px, y, z]: [f32; 3]| [x * px, y, z];
        let triangles = mesh.indices.as_chunks::<3>().0.iter();
        let mut all: Vec<_> = triangles.map(|t| order.map(|at| mirror(place(t[at])))).collect();
        // The order of triangles and of their corners does not matter.
        all.iter_mut().for_each(|t| {
            let first = (0..3).min_by(|a, b| t[*a].partial_cmp(&t[*b]).unwrap()).unwrap();
            t.rotate_left(first);
        });
        all.sort_by(|a, b| a.partial_cmp(b).unwrap());
        all
    };
    for (level, other) in levels_of(&man).iter().zip(levels_of(&mirrored)) {
        for (mesh, other) in level.meshes.iter().zip(&other.meshes) {
            assert!(corners(mesh, 1.0, [0, 1, 2]) == corners(other, -1.0, [0, 2, 1]));
        }
    }
}

#[test]
fn levels_do_not_depend_on_the_unit() {
    let shape = |scale: f32| -> Vec<(f32, usize)> {
        let levels = levels_of(&man_times(scale));
        levels.iter().map(|level| (level.error_m / scale, triangles(&level.meshes))).collect()
    };
    let own = shape(1.0);
    assert_eq!((shape(64.0), shape(1.0 / 64.0)), (own.clone(), own));
}

#[test]
fn most_vertices_lie_within_the_error_of_each_level() {
    let man = man();
    for level in levels_of(&man) {
        let mut surface: Vec<[Point; 3]> = Vec::new();
        for mesh in &level.meshes {
            // The built-in people are bound in model space, so positions are those at rest.
            let at = |index: &u32| mesh.positions[*index as usize].map(f64::from);
            let corners = mesh.indices.as_chunks::<3>().0;
            surface.extend(corners.iter().map(|[a, b, c]| [at(a), at(b), at(c)]));
        }
        let mut far: Vec<f64> = Vec::new();
        for point in (0..man.parts.len()).flat_map(|part| man.rest_positions(part)).step_by(7) {
            let point = point.map(f64::from);
            let nearest = surface.iter().map(|triangle| distance_to_triangle(point, *triangle));
            far.push(nearest.fold(f64::INFINITY, f64::min));
        }
        far.sort_by(f64::total_cmp);
        // Quadrics estimate distances, and pieces smaller than the error vanish whole.
        let most = far[far.len() * 3 / 4];
        assert!(most <= f64::from(level.error_m), "{most} m, not {} m", level.error_m);
    }
}

#[test]
fn weights_keep_their_sum_and_far_levels_have_one_joint_per_vertex() {
    let levels = levels_of(&man());
    for mesh in levels.iter().flat_map(|level| &level.meshes) {
        for weights in mesh.influences.weights.chunks(mesh.influences.per_vertex) {
            assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-4, "{weights:?}");
            assert!(weights.is_sorted_by(|a, b| a >= b), "the strongest come first: {weights:?}");
        }
    }
    let last = levels.last().unwrap();
    let single = |weights: &[f32]| weights[1..].iter().all(|weight| *weight == 0.0);
    assert!(last.meshes.iter().all(|m| m.influences.weights.chunks(4).all(single)));
}

/// Returns the mean over a mesh's surface of the cosine between triangles and the normals of their
/// corners.
fn agreement(mesh: &Mesh) -> f64 {
    let (mut sum, mut surface) = (0.0, 0.0);
    for triangle in mesh.indices.as_chunks::<3>().0 {
        let out = normal(triangle.map(|index| mesh.positions[index as usize].map(f64::from)));
        let of_corner = |index: u32| dot(mesh.normals[index as usize].map(f64::from), out);
        sum += triangle.map(of_corner).iter().sum::<f64>() / 3.0;
        surface += dot(out, out).sqrt();
    }
    sum / surface
}

#[test]
fn normals_of_levels_stand_for_the_surface_around_them() {
    let man = man();
    let named = |name: &str| {
        man.parts.iter().position(|p| man.materials[p.material.unwrap()].name == name).unwrap()
    };
    let (trousers, levels) = (named("Trousers"), levels_of(&man));
    let unit = |n: &[f32; 3]| (n.iter().map(|x| x * x).sum::<f32>() - 1.0).abs() < 1e-4;
    assert!(levels.iter().flat_map(|l| &l.meshes).all(|mesh| mesh.normals.iter().all(unit)));
    // The hems' own normals, which point down, would leave 0.82.
    for level in levels.iter().filter(|level| level.error_m < 0.02) {
        let agreement = agreement(&level.meshes[trousers]);
        assert!(agreement > 0.86, "{agreement} at {} m", level.error_m);
    }
}

#[test]
fn levels_are_the_same_each_time_and_pass_the_checks_of_characters() {
    let (first, second) = (with_levels(man()).unwrap(), with_levels(man()).unwrap());
    assert_eq!(first.levels(), second.levels());
}

#[test]
fn far_levels_leave_out_fingers_then_hands_and_keep_arms_and_legs() {
    let man = man();
    let counts: Vec<usize> = levels_of(&man).iter().map(|level| level.joint_count).collect();
    assert!(counts.is_sorted_by(|finer, coarser| finer >= coarser), "{counts:?}");
    assert_eq!(counts[0], man.skeleton.joint_count(), "{counts:?}");
    let (last, joints) = (*counts.last().unwrap(), &man.skeleton);
    assert!(last < joints.joint_count() / 2, "{counts:?}");
    for name in ["forearm", "foot", "head"] {
        let has = |joint: JointIndex| joints.name(joint).to_lowercase().contains(name);
        assert!(joints.joints().take(last).any(has), "{name} is missing of {last}");
    }
}

#[test]
fn reduced_character_has_few_triangles_and_keeps_small_parts() {
    let man = man();
    let all = |c: &Character| c.parts.iter().map(|p| p.mesh.indices.len() / 3).sum::<usize>();
    let before = all(&man);
    let wanted = before / 2;
    let reduced = populace_lod::reduced(&man, wanted, 0.02).unwrap();
    assert!(all(&reduced) <= wanted, "{} of {before}", all(&reduced));
    assert!(all(&reduced) > wanted / 2, "{} of {before} is too few", all(&reduced));
    let (low, high) = (man.rest_bounds().unwrap(), reduced.rest_bounds().unwrap());
    assert!((0..3).all(|axis| (low.high[axis] - high.high[axis]).abs() < 0.03), "{high:?}");
    let careful = populace_lod::reduced(&man, 1, 1e-9).unwrap();
    assert_eq!(all(&careful), before, "the error is bounded");
}

/// Returns a square of 1,800 triangles that lies on the ground, in waves of `wave_m`.
fn plate(side_m: f32, wave_m: f32) -> Character {
    const SIDE: u16 = 31;
    let place = |at: u16| f32::from(at) * side_m / f32::from(SIDE - 1);
    let at = |z: u16, x: u16| u32::from(z * SIDE + x);
    let corners: Vec<(u16, u16)> = (0..SIDE).flat_map(|z| (0..SIDE).map(move |x| (z, x))).collect();
    let squares = corners.iter().filter(|(z, x)| *z + 1 < SIDE && *x + 1 < SIDE);
    let two = |&(z, x): &(u16, u16)| {
        [at(z, x), at(z + 1, x), at(z, x + 1), at(z, x + 1), at(z + 1, x), at(z + 1, x + 1)]
    };
    let position = |&(z, x): &(u16, u16)| [place(x), wave_m * f32::from(x % 3), place(z)];
    let mesh = Mesh {
        positions: corners.iter().map(position).collect(),
        normals: vec![[0.0, 1.0, 0.0]; corners.len()],
        uvs: Vec::new(),
        colors: Vec::new(),
        influences: Influences {
            per_vertex: 4,
            entries: vec![0; 4 * corners.len()],
            weights: [1.0, 0.0, 0.0, 0.0].repeat(corners.len()),
        },
        indices: squares.flat_map(two).collect(),
    };
    let joint = JointSource { name: "plate".into(), parent: None, rest: Trs::IDENTITY };
    let node_name = joint.name.clone();
    Character::new(CharacterSource {
        name: joint.name.clone(),
        skeleton: Skeleton::new(&[joint]).unwrap(),
        palette: vec![PaletteEntry { joint: JointIndex(0), joint_from_bind: Affine::IDENTITY }],
        parts: vec![Part { node: 0, node_name, primitive: 0, material: None, mesh }],
        materials: Vec::new(),
        images: Vec::new(),
        skins: Vec::new(),
        clips: Vec::new(),
    })
    .unwrap()
}

#[test]
fn flat_things_have_levels_by_their_longest_side() {
    for wave_m in [0.0, 1e-5] {
        let plate = with_levels(plate(2.0, wave_m)).unwrap();
        let first = &plate.levels()[0];
        assert!((0.001..0.01).contains(&first.error_m), "{} m", first.error_m);
        assert!(triangles(&first.meshes) < 200, "{}", triangles(&first.meshes));
    }
    assert!(levels_of(&plate(0.0, 0.0)).is_empty(), "no error suits a point");
}

#[test]
fn reduction_ends_for_flat_things_and_without_limits() {
    for plate in [plate(2.0, 0.0), plate(2.0, 1e-5), plate(0.0, 0.0)] {
        for error_m in [0.01, f32::INFINITY, f32::NAN] {
            let reduced = populace_lod::reduced(&plate, 0, error_m).unwrap();
            let [before, after] = [&plate, &reduced].map(|c| c.parts[0].mesh.indices.len());
            assert!(after < before / 8 || plate.size_m() == 0.0 || error_m.is_nan(), "{after}");
        }
    }
}
