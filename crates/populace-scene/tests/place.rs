//! Places of recordings as meshes: areas, normals, gaps and doors.
#![expect(clippy::unwrap_used, reason = "a step that fails fails the test")]

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use populace::character::{Character, Mesh};
use populace_scene::{PlaceModel, PlacePart, PlaceSettings, PlaceWarning};
use populace_trajectory::{PlaceChange, Polygon, ReadSettings, Recording};

type Ring = Vec<[f64; 2]>;

/// Height of walls in metres.
const HEIGHT: f64 = 0.6;

/// Returns a recording of people who walk straight, each from a point to another in 100 rows, and of
/// somebody who stands there before and after.
fn recording(ways: &[[[f64; 2]; 2]], walkable: Vec<Polygon>) -> Recording {
    let mut text = String::from("# framerate: 25\n# id frame x/m y/m z/m\n");
    text += "1 0 2 2 1.7\n1 200 2 2 1.7\n";
    for (agent, [from, to]) in ways.iter().enumerate() {
        for frame in 0..100 {
            let at = [0, 1].map(|i| from[i] + (to[i] - from[i]) * f64::from(frame) / 99.0);
            writeln!(text, "{} {} {} {} 1.7", agent + 2, frame + 50, at[0], at[1]).unwrap();
        }
    }
    let settings = ReadSettings::default();
    let mut recording =
        populace_trajectory::parse(Path::new("test.txt"), text.into(), &settings).unwrap();
    recording.place.changes = vec![PlaceChange { from_secs: 0.0, walkable }];
    recording
}

/// Returns a recording of somebody who walks far from any wall.
fn still(walkable: Vec<Polygon>) -> Recording {
    recording(&[[[2.0, 2.0], [2.5, 2.0]]], walkable)
}

fn built(recording: &Recording) -> std::sync::Arc<Character> {
    let model = PlaceModel::new(recording, &PlaceSettings::default());
    assert_eq!(model.warnings, []);
    model.parts[0].character.clone()
}

fn rectangle([x0, y0]: [f64; 2], [x1, y1]: [f64; 2]) -> Ring {
    vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]]
}

fn polygon(outline: Ring, holes: Vec<Ring>) -> Polygon {
    Polygon { outline, holes }
}

/// A room of 6 by 5 m with a niche of 1 by 2 m, and a hole of 1 by 1 m: 31 m².
fn room() -> Polygon {
    let mut outline = rectangle([0.0, 0.0], [6.0, 5.0]);
    outline.splice(2..2, [[6.0, 2.0], [7.0, 2.0], [7.0, 4.0], [6.0, 4.0]]);
    polygon(outline, vec![rectangle([4.0, 3.0], [5.0, 4.0])])
}

fn mesh<'a>(character: &'a Character, name: &str) -> Option<&'a Mesh> {
    character.parts.iter().find(|part| part.node_name == name).map(|part| &part.mesh)
}

fn corners(mesh: &Mesh) -> impl Iterator<Item = [[f64; 3]; 3]> {
    let at = |i: u32| mesh.positions[i as usize].map(f64::from);
    mesh.indices.chunks_exact(3).map(move |c| [at(c[0]), at(c[1]), at(c[2])])
}

fn twice_area([a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    let [u, v] = [b, c].map(|p| [0, 1, 2].map(|i| p[i] - a[i]));
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

/// Returns the area of the faces that look along an axis.
fn facing(mesh: &Mesh, axis: [f64; 3]) -> f64 {
    let along = |t| 0.5 * twice_area(t).iter().zip(axis).map(|(a, b)| a * b).sum::<f64>();
    corners(mesh).map(|t| along(t).max(0.0)).sum()
}

fn floor_area(character: &Character) -> f64 {
    facing(mesh(character, "floor").unwrap(), [0.0, 1.0, 0.0])
}

#[test]
fn floor_is_as_large_as_the_walkable_area() {
    assert!((floor_area(&built(&still(vec![room()]))) - 31.0).abs() < 1e-4);
}

#[test]
fn rings_may_run_either_way() {
    let reversed = |ring: &Ring| ring.iter().rev().copied().collect::<Ring>();
    let room = room();
    let turned = polygon(reversed(&room.outline), room.holes.iter().map(reversed).collect());
    let [a, b] = [room, turned].map(|p| built(&still(vec![p])));
    for name in ["floor", "wall", "edge"] {
        for axis in [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]] {
            let [a, b] = [&a, &b].map(|c| facing(mesh(c, name).unwrap(), axis));
            assert!((a - b).abs() < 1e-4, "{name} along {axis:?}: {a} and {b}");
        }
    }
}

#[test]
fn overlapping_and_touching_areas_are_one_floor() {
    let areas = vec![
        polygon(rectangle([0.0, 0.0], [4.0, 4.0]), vec![]),
        polygon(rectangle([2.0, 1.0], [6.0, 3.0]), vec![]),
        polygon(rectangle([6.0, 0.0], [8.0, 4.0]), vec![]),
    ];
    let character = built(&still(areas));
    assert!((floor_area(&character) - 28.0).abs() < 1e-4);
    // No wall stands where areas meet: inner sides look along +X over 4 m at x = 0 and two parts of
    // 1 m at x = 6, outer ones of 0.1 m more at each end.
    let wall = facing(mesh(&character, "wall").unwrap(), [1.0, 0.0, 0.0]) / HEIGHT;
    assert!(wall < 4.0 + 2.0 + 2.0 + 4.2 + 0.4, "{wall}");
}

#[test]
fn normals_agree_with_the_winding_and_look_up_or_aside() {
    let mut recording = recording(&[[[-1.0, 1.0], [7.5, 3.0]]], vec![room()]);
    recording.place.obstacles = vec![polygon(rectangle([1.0, 3.0], [1.5, 4.0]), vec![])];
    let character = built(&recording);
    for part in &character.parts {
        let mesh = &part.mesh;
        for (indices, corners) in mesh.indices.chunks_exact(3).zip(corners(mesh)) {
            let across = twice_area(corners);
            for index in indices {
                let normal = mesh.normals[*index as usize].map(f64::from);
                let along: f64 = (0..3).map(|i| normal[i] * across[i]).sum();
                let length = across.iter().map(|v| v * v).sum::<f64>().sqrt();
                assert!(along > 0.999 * length, "{}: {normal:?}", part.node_name);
                assert!(normal[1] > -1e-6, "{} looks down", part.node_name);
            }
        }
    }
    let wall = mesh(&character, "wall").unwrap();
    // Inside of the room, a wall looks at the room: the first one stands at z = 0 and looks to -Z.
    let looks = corners(wall)
        .any(|t| t.iter().all(|p| p[2].abs() < 1e-6 && p[0] < 6.1) && twice_area(t)[2] < -1e-3);
    assert!(looks);
}

/// Returns the edges, as places in millimetres, that do not have as many triangles on one side as on
/// the other.
fn open_edges(character: &Character, names: &[&str]) -> Vec<[[i64; 3]; 2]> {
    let mut sides: BTreeMap<[[i64; 3]; 2], i32> = BTreeMap::new();
    for name in names {
        for triangle in mesh(character, name).into_iter().flat_map(corners) {
            #[expect(clippy::cast_possible_truncation, reason = "places within kilometres")]
            let at = triangle.map(|p| p.map(|v| (v * 1000.0).round() as i64));
            for (a, b) in [(at[0], at[1]), (at[1], at[2]), (at[2], at[0])] {
                *sides.entry(if a < b { [a, b] } else { [b, a] }).or_default() +=
                    if a < b { 1 } else { -1 };
            }
        }
    }
    sides.into_iter().filter(|(_, count)| *count != 0).map(|(edge, _)| edge).collect()
}

#[test]
fn walls_floor_and_edges_have_no_cracks() {
    let small = polygon(rectangle([0.0, 0.0], [9.0, 9.0]), vec![rectangle([5.0, 5.0], [8.0, 8.0])]);
    for area in [room(), small] {
        for ways in [&[[[2.0, 2.0], [2.5, 2.0]]][..], &[[[-1.0, 1.3], [3.0, 9.7]]]] {
            let character = built(&recording(ways, vec![area.clone()]));
            let open = open_edges(&character, &["floor", "wall", "edge"]);
            // The floor has no underside.
            let bottom = |edge: &[[i64; 3]; 2]| edge.iter().all(|p| p[1] == -150);
            let others: Vec<_> = open.iter().filter(|edge| !bottom(edge)).collect();
            assert_eq!(others, Vec::<&[[i64; 3]; 2]>::new());
            assert!(!open.is_empty());
        }
    }
}

/// Returns the length of the first room's wall that looks to the inside along +X at x = 0.
fn left_wall(character: &Character) -> f64 {
    let wall = mesh(character, "wall").unwrap();
    let inner = corners(wall).filter(|t| t.iter().all(|p| p[0].abs() < 1e-6));
    inner.map(|t| 0.5 * twice_area(t)[0].max(0.0)).sum::<f64>() / HEIGHT
}

#[test]
fn doors_are_where_people_pass() {
    let closed = built(&still(vec![room()]));
    assert!((left_wall(&closed) - 5.0).abs() < 1e-4);
    assert!(mesh(&closed, "post").is_none());
    // Across the wall, from a point near it inside, and to such a point.
    for way in [[[-2.0, 2.5], [3.0, 2.5]], [[0.4, 2.5], [3.0, 2.5]], [[3.0, 2.5], [0.4, 2.5]]] {
        let character = built(&recording(&[way], vec![room()]));
        assert!((left_wall(&character) - 3.9).abs() < 0.01, "{way:?}: {}", left_wall(&character));
        assert!((floor_area(&character) - 31.0 - 0.11).abs() < 0.01, "there is floor in the door");
        assert_eq!(mesh(&character, "post").unwrap().positions.len(), 40, "two posts");
    }
    let without = PlaceSettings { doors: false, ..PlaceSettings::default() };
    let model = PlaceModel::new(&recording(&[[[-2.0, 2.5], [3.0, 2.5]]], vec![room()]), &without);
    assert!((left_wall(&model.parts[0].character) - 5.0).abs() < 1e-4);
}

#[test]
fn neighbours_share_a_door_and_corners_end_it() {
    let ways: Vec<_> = [0.3, 1.2, 2.0, 2.9].map(|y| [[-1.0, y], [3.0, y]]).to_vec();
    let character = built(&recording(&ways, vec![room()]));
    assert!((left_wall(&character) - (5.0 - 3.45)).abs() < 0.01, "{}", left_wall(&character));
    assert_eq!(mesh(&character, "post").unwrap().positions.len(), 40);
}

#[test]
fn leaning_over_a_wall_makes_no_door() {
    let outline = rectangle([0.0, 0.0], [6.0, 5.0]);
    let mut text = String::from("# framerate: 25\n# id frame x/m y/m z/m\n");
    for frame in 0..100 {
        let y = 1.0 + 0.03 * f64::from(frame);
        let x = if (40..60).contains(&frame) { -0.1 } else { 0.2 };
        writeln!(text, "1 {frame} {x} {y} 1.7").unwrap();
    }
    let settings = ReadSettings::default();
    let mut recording =
        populace_trajectory::parse(Path::new("test.txt"), text.into(), &settings).unwrap();
    let walkable = vec![polygon(outline, vec![])];
    recording.place.changes = vec![PlaceChange { from_secs: 0.0, walkable }];
    assert!((left_wall(&built(&recording)) - 5.0).abs() < 1e-4);
}

#[test]
fn changes_are_parts_of_their_own() {
    let mut recording = still(vec![room()]);
    let walkable = vec![polygon(rectangle([0.0, 0.0], [4.0, 4.0]), vec![])];
    recording.place.changes.push(PlaceChange { from_secs: 2.0, walkable });
    let model = PlaceModel::new(&recording, &PlaceSettings::default());
    let parts: Vec<_> =
        model.parts.iter().map(|part| (part.from_secs, floor_area(&part.character))).collect();
    assert!(parts.len() == 2 && parts[0].0 == 0.0 && parts[1].0 == 2.0);
    assert!((parts[0].1 - 31.0).abs() < 1e-4 && (parts[1].1 - 16.0).abs() < 1e-4, "{parts:?}");
    recording.place.changes.clear();
    assert!(PlaceModel::new(&recording, &PlaceSettings::default()).parts.is_empty());
}

#[test]
fn degenerate_rings_are_left_out_with_a_warning() {
    let good = polygon(rectangle([0.0, 0.0], [4.0, 4.0]), vec![]);
    let line = polygon(vec![[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]], vec![]);
    let far = polygon(rectangle([0.0, 0.0], [1e300, 4.0]), vec![]);
    let hollow = polygon(vec![[f64::NAN, 0.0], [1.0, 0.0], [0.0, 1.0]], vec![]);
    let empty = polygon(vec![], vec![vec![], vec![[1.0, 1.0]]]);
    let model = PlaceModel::new(
        &still(vec![line, good, far, hollow, empty]),
        &PlaceSettings { wall_height_m: f64::NAN, ..PlaceSettings::default() },
    );
    let expected = [
        PlaceWarning::EmptyRing { what: "an outline" },
        PlaceWarning::FarRing { what: "an outline" },
    ];
    assert_eq!(model.warnings, expected);
    assert!((floor_area(&model.parts[0].character) - 16.0).abs() < 1e-4);
}

#[test]
fn a_buildable_place_is_built_without_a_test_of_its_rings() {
    let line = polygon(vec![[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]], vec![]);
    let far = polygon(rectangle([6.0, 0.0], [1e300, f64::INFINITY]), vec![]);
    let hollow = polygon(vec![[f64::NAN, 0.0], [1.0, 0.0], [0.0, 1.0]], vec![]);
    let mut recording = still(vec![room(), line]);
    let settings = PlaceSettings::default();
    let facts = |model: &PlaceModel| {
        let vertices = |part: &PlacePart| {
            let parts = part.character.parts.iter();
            parts.map(|part| part.mesh.positions.clone()).collect::<Vec<_>>()
        };
        model.parts.iter().map(vertices).collect::<Vec<_>>()
    };
    let expected = PlaceModel::new(&recording, &settings);
    let untested = PlaceModel::of_buildable(&recording, &settings);
    assert_eq!((facts(&untested), untested.warnings), (facts(&expected), vec![]));
    assert_eq!(expected.warnings, [PlaceWarning::EmptyRing { what: "an outline" }]);
    recording.place.obstacles = vec![far, hollow];
    assert_eq!(PlaceModel::of_buildable(&recording, &settings).parts.len(), 1);
}

#[test]
fn odd_rings_are_built_without_harm() {
    let bow_tie = vec![[0.0, 0.0], [4.0, 4.0], [4.0, 0.0], [0.0, 4.0]];
    let spike = vec![[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [9.0, 4.0], [4.0, 4.0], [0.0, 4.0]];
    let repeated = vec![[0.0, 0.0], [0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [4.0, 4.0], [0.0, 0.0]];
    let mut seed = 7_u32;
    let mut random = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(seed >> 16) / 65_536.0 * 6.0
    };
    let wild = (0..30).map(|_| (0..12).map(|_| [random(), random()]).collect::<Ring>());
    for ring in [bow_tie, spike, repeated].into_iter().chain(wild.collect::<Vec<_>>()) {
        let mut recording =
            recording(&[[[-1.0, 1.0], [7.0, 3.0]]], vec![polygon(ring.clone(), vec![])]);
        recording.place.obstacles = vec![polygon(ring.clone(), vec![ring])];
        let model = PlaceModel::new(&recording, &PlaceSettings::default());
        assert_eq!(model.parts.len(), 1);
        assert!(floor_area(&model.parts[0].character) > 0.1);
    }
}

#[test]
fn a_place_reaches_as_far_as_its_corners() {
    let room = polygon(rectangle([10.0, 0.0], [30.0, 20.0]), vec![]);
    let model = PlaceModel::new(&still(vec![room]), &PlaceSettings::default());
    let reach = model.parts[0].character.skeleton.reach_m()[0];
    assert!((36.0..37.0).contains(&reach), "{reach}");
}
