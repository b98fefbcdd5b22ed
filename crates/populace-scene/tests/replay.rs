//! People who follow trajectories, on the native device.

#![expect(clippy::unwrap_used, reason = "tests panic on errors")]

use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::Path;
use std::sync::{Arc, OnceLock};

use populace::character::Character;
use populace::{Affine, Crowd, Device};
use populace_cast::Look;
use populace_locomotion::{GaitSpace, SkateMeter};
use populace_scene::{Error, Motions, Person, Replay};
use populace_trajectory::{ReadSettings, Recording, parse};

const FPS: u32 = 25;
const FRAME_SECS: f32 = 1.0 / FPS as f32;

/// An agent: id, first frame, last frame, start in metres, velocity in metres per second.
type Walk = (u32, u32, u32, [f64; 2], [f64; 2]);

/// Returns a recording of heads that sway, 25 rows in a second.
fn recording(agents: &[Walk], sway_m: f64) -> Recording {
    let mut text = "# framerate: 25 fps\n# id frame x/m y/m z/m\n".to_owned();
    for (id, first, last, at, velocity) in agents {
        for frame in *first..=*last {
            let secs = f64::from(frame - first) / f64::from(FPS);
            let speed = velocity[0].hypot(velocity[1]).max(1e-9);
            let aside = sway_m * (TAU * 0.95 * secs).sin() / speed;
            let x = at[0] + velocity[0] * secs - velocity[1] * aside;
            let y = at[1] + velocity[1] * secs + velocity[0] * aside;
            writeln!(text, "{id} {frame} {x:.5} {y:.5} 1.7").unwrap();
        }
    }
    parse(Path::new("walk.txt"), text.into_bytes(), &ReadSettings::default()).unwrap()
}

fn man() -> Arc<Character> {
    static MAN: OnceLock<Arc<Character>> = OnceLock::new();
    Arc::clone(MAN.get_or_init(|| Arc::new(populace_cast::person(&Look::man()).unwrap())))
}

/// Returns a crowd and a replay at the first time of a recording.
fn stage(recording: &Recording) -> (Crowd, Replay) {
    let device = Device::Native { threads: 1 };
    let mut crowd = Crowd::builder().device(device).capacity(8).build().unwrap();
    let character = crowd.add_character(man()).unwrap();
    let gaits = GaitSpace::of(&mut crowd, character).unwrap();
    let people = vec![Person { character, scale: 1.0, look: None }; recording.agents.len()];
    let motions = Motions::new(recording);
    let replay =
        Replay::new(recording, motions, &people, vec![gaits], recording.secs()[0]).unwrap();
    (crowd, replay)
}

#[test]
fn people_fade_in_and_out_but_not_at_the_ends_of_the_recording() {
    let data =
        recording(&[(1, 0, 100, [0.0; 2], [1.0, 0.0]), (2, 25, 75, [0.0, 3.0], [1.0, 0.0])], 0.0);
    let (mut crowd, mut replay) = stage(&data);
    let mut seen = vec![Vec::new(); 2];
    step(&mut crowd, &mut replay, 0.0);
    for _ in 0..=98 {
        for (agent, member) in replay.present() {
            let shown = crowd.member(member).unwrap().look().opacity();
            assert!((shown - replay.opacity(agent)).abs() < 0.02, "{agent}: {shown}");
            seen[agent].push(shown);
        }
        step(&mut crowd, &mut replay, FRAME_SECS);
    }
    assert!(seen[0].iter().all(|shown| *shown == 1.0), "{:?}", seen[0]);
    let [first, last] = [seen[1][0], seen[1][seen[1].len() - 1]];
    assert!(first < 0.5 && last < 0.5 && seen[1][25] == 1.0, "{:?}", seen[1]);
    assert!(seen[1][..8].windows(2).all(|pair| pair[1] > pair[0]), "{:?}", seen[1]);
}

fn step(crowd: &mut Crowd, replay: &mut Replay, secs: f32) {
    replay.advance(crowd, secs).unwrap();
    crowd.update(secs).unwrap();
}

fn palettes(crowd: &mut Crowd) -> Vec<u32> {
    let mut bits = Vec::new();
    let mut read = |_, palette: &[Affine]| {
        bits.extend(palette.iter().flat_map(|m| m.rows.as_flattened()).map(|v| v.to_bits()));
    };
    crowd.palettes(&mut read).unwrap();
    bits
}

#[test]
fn sway_is_found_and_the_path_without_it_is_kept() {
    let swaying = recording(&[(1, 0, 250, [0.0; 2], [1.3, 0.0])], 0.03);
    let (mut crowd, mut replay) = stage(&swaying);
    assert!((0.01..0.03).contains(&replay.motions().sway_m), "{}", replay.motions().sway_m);
    assert!(replay.motions().cutoff_hz == 0.5);
    step(&mut crowd, &mut replay, 0.0);
    for frame in 1..=250_u16 {
        step(&mut crowd, &mut replay, FRAME_SECS);
        let (_, member) = replay.present().next().unwrap();
        let [x, _, z] = crowd.member(member).unwrap().placement().position();
        let secs = f32::from(frame) * FRAME_SECS;
        // The ends see half of a filter.
        if (25..225).contains(&frame) {
            assert!((x - 1.3 * secs).abs() < 0.01 && z.abs() < 0.006, "{frame}: {x} {z}");
        }
    }
    let error = replay.position_error();
    assert!(error.max_m < 1e-3 && (0.02..0.04).contains(&error.max_raw_m), "{error:?}");
    let steady = recording(&[(1, 0, 250, [0.0; 2], [1.3, 0.0])], 0.0);
    assert!(Motions::new(&steady).cutoff_hz == 1.0);
}

#[test]
fn the_plan_lies_on_the_ground_and_people_face_the_way_they_go() {
    let north = recording(&[(1, 0, 100, [2.0, 5.0], [0.0, 1.2])], 0.0);
    let (mut crowd, mut replay) = stage(&north);
    step(&mut crowd, &mut replay, 0.0);
    let (_, member) = replay.present().next().unwrap();
    let placement = crowd.member(member).unwrap().placement();
    let [x, y, z] = placement.position();
    assert!((x - 2.0).abs() < 1e-3 && y == 0.0 && (z + 5.0).abs() < 0.02, "{x} {y} {z}");
    let ahead = placement.world_from_model().transform_point([0.0, 0.0, 1.0]);
    assert!((ahead[2] - z + 1.0).abs() < 1e-3, "{ahead:?}");
}

#[test]
fn people_who_jump_are_elsewhere_at_once_with_their_feet() {
    let [here, there] = [[0.0; 2], [10.0, 5.0]];
    let walk = [(1, 0, 50, here, [1.3, 0.0]), (1, 51, 100, there, [0.0, 1.3])];
    let data = recording(&walk, 0.0);
    let (mut crowd, mut replay) = stage(&data);
    assert_eq!(replay.motions().peak(), 1);
    step(&mut crowd, &mut replay, 0.0);
    for frame in 1..100_u16 {
        step(&mut crowd, &mut replay, FRAME_SECS);
        let people: Vec<_> = replay.present().collect();
        let [(agent, member)] = people[..] else { panic!("{frame}: {} people", people.len()) };
        let [dx, dy] = match frame {
            0..=50 => [1.3 * FRAME_SECS * f32::from(frame), 0.0],
            _ => [10.0, 5.0 + 1.3 * FRAME_SECS * f32::from(frame - 51)],
        };
        let mut view = crowd.member_mut(member).unwrap();
        assert_eq!((replay.opacity(agent), view.look().opacity()), (1.0, 1.0), "{frame}");
        let [x, _, z] = view.placement().position();
        assert!((x - dx).hypot(z + dy) < 0.05, "{frame}: {x} {z}, not {dx} {}", -dy);
        let joints = view.model_from_joints().unwrap();
        let reach = |joint: &Affine| {
            let [x, _, z] = joint.transform_point([0.0; 3]);
            x.hypot(z)
        };
        let reach_m = joints.iter().map(reach).fold(0.0, f32::max);
        assert!(reach_m < 0.8, "{frame}: a joint is {reach_m} m away");
    }
}

#[test]
fn people_come_and_leave_as_in_the_data() {
    let data = recording(
        &[
            (7, 0, 50, [0.0; 2], [1.0, 0.0]),
            (8, 25, 100, [0.0, 3.0], [1.0, 0.0]),
            (9, 60, 100, [0.0, 6.0], [0.0; 2]),
        ],
        0.0,
    );
    let (mut crowd, mut replay) = stage(&data);
    step(&mut crowd, &mut replay, 0.0);
    for frame in 1..=110_u16 {
        step(&mut crowd, &mut replay, FRAME_SECS);
        let mut present: Vec<usize> = replay.present().map(|(agent, _)| agent).collect();
        present.sort_unstable();
        let there =
            [(0..=50).contains(&frame), (25..=100).contains(&frame), (60..=100).contains(&frame)];
        let expected: Vec<usize> = (0..3).filter(|agent| there[*agent]).collect();
        // Sums of frame lengths are a little off the rows' times.
        if ![25, 50, 51, 60, 100, 101].contains(&frame) {
            assert_eq!(present, expected, "{frame}");
        }
        assert_eq!(crowd.member_count(), present.len());
    }
}

#[test]
fn feet_hold_while_people_walk_turn_and_stop() {
    let mut text = "# framerate: 25 fps\n# id frame x/m y/m z/m\n".to_owned();
    let mut at = [0.0, 0.0];
    for frame in 0..500 {
        let secs = f64::from(frame) / 25.0;
        let speed = if (8.0..12.0).contains(&secs) { 0.0 } else { 1.2 };
        let angle = 0.4 * secs;
        at = [at[0] + speed * angle.cos() / 25.0, at[1] + speed * angle.sin() / 25.0];
        writeln!(text, "1 {frame} {:.4} {:.4} 1.7", at[0], at[1]).unwrap();
    }
    let data = parse(Path::new("t.txt"), text.into_bytes(), &ReadSettings::default()).unwrap();
    let (mut crowd, mut replay) = stage(&data);
    let mut meter = SkateMeter::new();
    step(&mut crowd, &mut replay, 0.0);
    for _ in 1..490 {
        step(&mut crowd, &mut replay, FRAME_SECS);
        let (_, member) = replay.present().next().unwrap();
        meter.sample(&mut crowd, member, FRAME_SECS).unwrap();
    }
    let skate = meter.skate().unwrap();
    assert!(skate.mean_m_per_sec < 0.02 && skate.p95_m_per_sec < 0.08, "{skate:?}");
}

#[test]
fn a_clone_and_a_snapshot_go_on_as_the_original() {
    let data =
        recording(&[(1, 0, 120, [0.0; 2], [1.2, 0.3]), (2, 40, 120, [0.0, 3.0], [0.6, 0.0])], 0.02);
    let (mut crowd, mut replay) = stage(&data);
    step(&mut crowd, &mut replay, 0.0);
    for _ in 0..30 {
        step(&mut crowd, &mut replay, FRAME_SECS);
    }
    let (kept, snapshot) = (replay.clone(), crowd.snapshot().unwrap());
    let run = |mut replay: Replay, crowd: &mut Crowd| -> Vec<Vec<u32>> {
        let mut frame = |_| {
            step(crowd, &mut replay, FRAME_SECS);
            palettes(crowd)
        };
        (0..40).map(&mut frame).collect()
    };
    let first = run(replay, &mut crowd);
    crowd.restore(&snapshot).unwrap();
    let again = run(kept, &mut crowd);
    let differs = first.iter().zip(&again).position(|(a, b)| a != b);
    assert_eq!(
        differs,
        None,
        "{:?}",
        [&first, &again].map(|frames| frames[differs.unwrap_or(0)].len())
    );
}

#[test]
fn vehicles_are_not_played_by_people() {
    let text =
        "id,frame,x,y,kind\n1,0,0,0,pedestrian\n2,0,9,9,car\n1,1,0.1,0,pedestrian\n2,1,9,9,car";
    let settings = ReadSettings { fps: Some(10.0), ..ReadSettings::default() };
    let data = parse(Path::new("street.csv"), text.into(), &settings).unwrap();
    assert_eq!(data.agents.len(), 2);
    let (mut crowd, mut replay) = stage(&data);
    step(&mut crowd, &mut replay, 0.0);
    assert_eq!(replay.present().map(|(agent, _)| agent).collect::<Vec<_>>(), [0]);
    assert_eq!(replay.motions().agents[1].secs().count(), 0);
}

#[test]
fn there_is_one_person_for_each_agent() {
    let data = recording(&[(1, 0, 10, [0.0; 2], [1.0, 0.0])], 0.0);
    let wrong = Replay::new(&data, Motions::new(&data), &[], Vec::new(), 0.0);
    assert!(matches!(wrong, Err(Error::UnequalLengths { people: 0, agents: 1 })), "{wrong:?}");
}

/// Returns a recording of people who go along x at 1 m/s, each at an elevation by the time.
fn at_elevations(elevations: &[fn(f64) -> f64]) -> Recording {
    let mut text = "id,t,x,y,z\n".to_owned();
    for (id, elevation) in elevations.iter().enumerate() {
        for tenth in 0..=80 {
            let secs = f64::from(tenth) / 10.0;
            writeln!(text, "{id},{secs},{secs},{},{}", 2 * id, elevation(secs)).unwrap();
        }
    }
    parse(Path::new("floors.csv"), text.into_bytes(), &ReadSettings::default()).unwrap()
}

/// Returns the lowest joint of a member, in metres of the world.
fn lowest_joint_m(crowd: &mut Crowd, member: populace::MemberId) -> f32 {
    let mut view = crowd.member_mut(member).unwrap();
    let world_from_model = view.placement().world_from_model();
    let joints = view.model_from_joints().unwrap();
    let heights = joints.iter().map(|joint| world_from_model.transform_point(joint.origin())[1]);
    heights.fold(f32::INFINITY, f32::min)
}

#[test]
fn people_stand_at_their_own_elevation_with_feet_that_hold() {
    // Two floors, a slope, a floor with one wrong row, and a floor below.
    let data = at_elevations(&[
        |_| 0.0,
        |_| 3.0,
        |secs| 0.1 * secs,
        |secs| if secs == 4.0 { -1.0 } else { 0.0 },
        |_| -0.5,
    ]);
    let (mut crowd, mut replay) = stage(&data);
    assert!(replay.floor_m() == 0.0, "{}", replay.floor_m());
    let plane = populace::Ground::plane(replay.floor_m(), [0.0; 2]).unwrap();
    crowd.set_ground(&plane).unwrap();
    let mut meters = vec![SkateMeter::new(); 5];
    let mut lowest = vec![f32::INFINITY; 5];
    step(&mut crowd, &mut replay, 0.0);
    for _ in 0..190 {
        step(&mut crowd, &mut replay, FRAME_SECS);
        let present: Vec<_> = replay.present().collect();
        for (agent, member) in present {
            meters[agent].sample(&mut crowd, member, FRAME_SECS).unwrap();
            let own = crowd.member(member).unwrap().placement().position()[1];
            lowest[agent] = lowest[agent].min(lowest_joint_m(&mut crowd, member) - own);
        }
    }
    for (agent, (meter, lowest)) in meters.iter().zip(&lowest).enumerate() {
        let skate = meter.skate().unwrap();
        assert!(skate.mean_m_per_sec < 0.03, "{agent}: {skate:?}");
        // People who sink to a floor below have their feet there.
        assert!(lowest.abs() < 0.05, "{agent}: {lowest} m");
    }
}

#[test]
fn elevations_count_as_distances_from_the_data() {
    let error = |elevation: fn(f64) -> f64| stage(&at_elevations(&[elevation])).1.position_error();
    let level = error(|_| 3.0);
    assert!(level.max_raw_m < 0.01, "{level:?}");
    let wrong = error(|secs| if secs == 4.0 { -1.0 } else { 0.0 });
    assert!((0.5..1.0).contains(&wrong.max_raw_m), "{wrong:?}");
}

#[test]
fn people_with_one_row_are_seen() {
    let data =
        recording(&[(1, 0, 100, [0.0; 2], [1.0, 0.0]), (2, 50, 50, [0.0, 3.0], [0.0; 2])], 0.0);
    let (mut crowd, mut replay) = stage(&data);
    step(&mut crowd, &mut replay, 0.0);
    let mut seen = 0;
    for _ in 0..98 {
        step(&mut crowd, &mut replay, FRAME_SECS);
        for (_, member) in replay.present().filter(|(agent, _)| *agent == 1) {
            assert!(crowd.member(member).unwrap().look().opacity() == 1.0);
            seen += 1;
        }
    }
    assert!((1..=2).contains(&seen), "{seen} frames");
}
