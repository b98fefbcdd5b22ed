//! Nobody passes a wall, and avoidance does nothing to those who are alone.

use std::sync::Arc;

use glam::Vec2;
use populace::Placement;
use populace_locomotion::avoidance::{Avoidance, AvoidanceSettings, Obstacle};
use populace_locomotion::{Goal, Path};

use crate::fixture::{RADIUS_M, Town};

/// A room with a niche, and a pillar in it.
const ROOM: [[f32; 2]; 6] =
    [[0.0, 0.0], [14.0, 0.0], [14.0, 6.0], [9.0, 6.0], [9.0, 12.0], [0.0, 12.0]];
const PILLAR: [[f32; 2]; 4] = [[4.0, 4.0], [5.5, 4.0], [5.5, 5.5], [4.0, 5.5]];

fn is_inside(outline: &[[f32; 2]], [x, z]: [f32; 2]) -> bool {
    let edges = outline.iter().zip(outline.iter().cycle().skip(1));
    let crossed = edges.filter(|(a, b)| {
        (a[1] > z) != (b[1] > z) && x < a[0] + (z - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
    });
    crossed.count() % 2 == 1
}

fn distance(outline: &[[f32; 2]], at: [f32; 2]) -> f32 {
    let edges = outline.iter().zip(outline.iter().cycle().skip(1));
    let to_edge = edges.map(|(a, b)| {
        let (a, b, at) = (Vec2::from(*a), Vec2::from(*b), Vec2::from(at));
        let share = (at - a).dot(b - a) / (b - a).length_squared();
        at.distance(a + (b - a) * share.clamp(0.0, 1.0))
    });
    to_edge.fold(f32::INFINITY, f32::min)
}

fn is_free(at: [f32; 2]) -> bool {
    is_inside(&ROOM, at)
        && !is_inside(&PILLAR, at)
        && distance(&ROOM, at).min(distance(&PILLAR, at)) > RADIUS_M
}

fn room() -> (Town, fastrand::Rng) {
    let mut town = Town::new();
    let mut avoidance = Avoidance::new(AvoidanceSettings::default()).unwrap();
    avoidance.set_obstacles(&[Obstacle::polygon(ROOM), Obstacle::polygon(PILLAR)]).unwrap();
    town.walkers.set_avoidance(Some(avoidance));
    let mut random = fastrand::Rng::with_seed(11);
    while town.walkers.members().len() < 200 {
        let at = [14.0 * random.f32(), 12.0 * random.f32()];
        if is_free([at[0], at[1]]) && distance(&ROOM, at) > 0.3 && distance(&PILLAR, at) > 0.3 {
            town.add_at(at);
        }
    }
    (town, random)
}

/// Moves everybody for some frames and checks that all stay inside.
fn stay_inside(town: &mut Town, frames: u32) {
    for frame in 0..frames {
        town.step();
        let out = town.walkers.positions().iter().position(|at| !is_free(*at));
        let at = out.map(|walker| (walker, town.walkers.positions()[walker]));
        assert!(at.is_none(), "frame {frame}: {at:?}");
    }
}

#[test]
fn nobody_passes_a_wall_that_velocities_point_at() {
    let (mut town, mut random) = room();
    for _ in 0..10 {
        let members = town.walkers.members().to_vec();
        let all: Vec<[f32; 2]> = members
            .iter()
            .map(|_| (Vec2::from_angle(7.0 * random.f32()) * 6.0 * random.f32()).to_array())
            .collect();
        town.walkers.set_velocities(&all).unwrap();
        stay_inside(&mut town, 150);
    }
}

#[test]
fn nobody_passes_a_wall_in_a_crush() {
    let (mut town, _) = room();
    for corner in [[14.5, -0.5], [-0.5, 12.5], [4.7, 4.7]] {
        for member in town.walkers.members().to_vec() {
            town.send(member, 2.0, Goal::Point(corner));
        }
        stay_inside(&mut town, 600);
    }
}

#[test]
fn nobody_passes_a_wall_on_a_path_that_does() {
    let (mut town, mut random) = room();
    for member in town.walkers.members().to_vec() {
        let points = [(); 6].map(|()| [20.0 * random.f32() - 3.0, 18.0 * random.f32() - 3.0]);
        let path = Path::new(&points).unwrap().closed();
        town.send(member, 0.5 + 3.0 * random.f32(), Goal::Path(Arc::new(path)));
    }
    stay_inside(&mut town, 1500);
}

#[test]
fn who_is_alone_walks_bit_for_bit_as_without_avoidance() {
    let walk = |avoids: bool| {
        let mut town = Town::new();
        if avoids {
            let mut avoidance = Avoidance::new(AvoidanceSettings::default()).unwrap();
            avoidance.set_obstacles(&[Obstacle::polygon(ROOM)]).unwrap();
            town.walkers.set_avoidance(Some(avoidance));
        }
        let mut random = fastrand::Rng::with_seed(3);
        for nth in 0..30_u16 {
            let corner = [100.0 + 60.0 * f32::from(nth % 6), 60.0 * f32::from(nth / 6)];
            let mut point = || [0, 1].map(|i: usize| corner[i] + 20.0 * random.f32());
            let path = Path::new(&[point(), point(), point(), point()]).unwrap();
            let path = if nth % 2 == 0 { path.closed() } else { path };
            let member = town.add(Placement::at([corner[0], 0.0, corner[1]]).facing(1.0));
            let goal = if nth % 5 == 0 { Goal::Point(point()) } else { Goal::Path(Arc::new(path)) };
            town.send(member, 0.5 + 2.0 * random.f32(), goal);
            if nth % 3 == 0 {
                town.walkers.set_facing(member, Some(0.7)).unwrap();
            }
        }
        let mut all = Vec::new();
        for _ in 0..900 {
            town.step();
            for member in town.walkers.members() {
                let place = town.place(*member);
                all.push((place.position().map(f32::to_bits), place.yaw_rad().to_bits()));
            }
        }
        all
    };
    let (alone, avoiding) = (walk(false), walk(true));
    let first = alone.iter().zip(&avoiding).position(|(a, b)| a != b);
    assert_eq!(first.map(|at| (at / 30, at % 30)), None, "frame and walker that differ");
}
