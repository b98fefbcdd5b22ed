//! Walkers do what they are told.

use std::f32::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use glam::Vec2;
use populace::ClipPlayback;
use populace_locomotion::avoidance::{Avoidance, AvoidanceSettings, Obstacle};
use populace_locomotion::{Goal, Path, WalkerSettings};

use crate::fixture::{FRAME_SECS, Town};

#[test]
fn a_walker_reaches_a_point_and_stops_there() {
    for frame_secs in [1.0 / 240.0, FRAME_SECS, 0.05, 0.5] {
        let mut town = Town::new();
        let goals = [[0.0, 3.0], [0.0, -6.0], [5.0, 0.1], [0.3, 0.0], [-0.1, -0.15]];
        let speeds = [0.4, 1.34, 3.0];
        let mut sent = Vec::new();
        for (goal, speed) in goals.iter().flat_map(|goal| speeds.map(|speed| (*goal, speed))) {
            let member = town.add_at([0.0; 2]);
            town.send(member, speed, Goal::Point(goal));
            sent.push((member, Vec2::from(goal), speed));
        }
        let mut farthest = vec![0.0_f32; sent.len()];
        for _ in 0..(25.0 / frame_secs) as u32 {
            town.walkers.update(&mut town.crowd, frame_secs).unwrap();
            for (farthest, (member, goal, _)) in farthest.iter_mut().zip(&sent) {
                *farthest = farthest.max(town.position(*member).dot(goal.normalize()));
            }
        }
        for ((member, goal, speed), farthest) in sent.into_iter().zip(farthest) {
            let (off, told) = (town.position(member).distance(goal), (goal, speed, frame_secs));
            assert!(off < 0.1, "{told:?}: stands {off} m beside it");
            // In long frames it brakes late.
            let beyond = if frame_secs > 0.1 { 0.3 } else { 0.1 };
            assert!(farthest < goal.length() + beyond, "{told:?}: went on to {farthest} m");
            assert_eq!(town.velocity(member), Vec2::ZERO, "{told:?}");
        }
    }
}

/// Follows a path for a time, and returns the indices of the points as they are passed.
fn passed(town: &mut Town, points: &[[f32; 2]], closed: bool, secs: f32) -> Vec<usize> {
    let member = town.add_at([0.0; 2]);
    let path = Path::new(points).unwrap();
    town.send(member, 1.5, Goal::Path(Arc::new(if closed { path.closed() } else { path })));
    let mut passed = Vec::new();
    for _ in 0..(secs / FRAME_SECS) as u32 {
        town.step();
        let at = town.position(member);
        let near = points.iter().position(|point| at.distance((*point).into()) < 0.7);
        if let Some(point) = near.filter(|point| passed.last() != Some(point)) {
            passed.push(point);
        }
    }
    passed
}

#[test]
fn paths_are_followed_in_order_and_closed_ones_again_and_again() {
    let mut town = Town::new();
    let points = [[0.0, 4.0], [4.0, 4.0], [4.0, 0.0], [-3.0, 1.0]];
    assert_eq!(passed(&mut town, &points, false, 30.0), [0, 1, 2, 3]);
    let end = town.position(town.walkers.members()[0]);
    assert!(end.distance(points[3].into()) < 0.1, "{end}");
    let laps = passed(&mut town, &points, true, 40.0);
    assert!(laps.len() >= 10, "{laps:?}");
    assert!(laps.iter().enumerate().all(|(nth, point)| *point == nth % 4), "{laps:?}");
}

#[test]
fn velocities_drive_all_walkers_and_a_stop_holds_them() {
    let mut town = Town::new();
    let told: Vec<Vec2> = (0..12).map(|nth| Vec2::from_angle(nth as f32) * 1.2).collect();
    let members: Vec<_> = told.iter().map(|_| town.add_at([0.0; 2])).collect();
    town.step();
    assert!(town.walkers.velocities().iter().all(|velocity| *velocity == [0.0; 2]));
    let velocities: Vec<[f32; 2]> = told.iter().map(Vec2::to_array).collect();
    town.walkers.set_velocities(&velocities).unwrap();
    town.run(4.0);
    for (member, told) in members.iter().zip(&told) {
        let velocity = town.velocity(*member);
        assert!(velocity.distance(*told) < 0.02, "{velocity} is not {told}");
        // It faces the way it goes.
        let off = town.off_heading(*member, told.x.atan2(told.y));
        assert!(off < 0.02, "{told}: off by {off} rad");
    }
    let before: Vec<Vec2> = members.iter().map(|member| town.position(*member)).collect();
    town.walkers.set_velocities(&[[0.0; 2]; 12]).unwrap();
    town.run(1.0);
    let stops = 1.2 * 1.2 / (2.0 * WalkerSettings::default().deceleration);
    for (member, from) in members.iter().zip(before) {
        let way = town.position(*member).distance(from);
        assert!((way - stops).abs() < 0.03, "stopped within {way} m");
        assert_eq!(town.velocity(*member), Vec2::ZERO);
    }
}

#[test]
fn a_walker_turns_on_the_spot() {
    let mut town = Town::new();
    let turns = [FRAC_PI_2, -FRAC_PI_2, 3.1, -2.0, 0.2, 40.0];
    let members = turns.map(|yaw| {
        let member = town.add_at([0.0; 2]);
        town.walkers.set_facing(member, Some(yaw)).unwrap();
        member
    });
    let mut half_turn_secs = 0.0;
    for frame in 0..240 {
        town.step();
        let drift = members.map(|member| town.position(member).length());
        assert!(drift.iter().all(|drift| *drift < 0.02), "frame {frame}: {drift:?}");
        if town.off_heading(members[2], turns[2]) > 0.05 {
            half_turn_secs = frame as f32 * FRAME_SECS;
        }
    }
    for (member, yaw) in members.into_iter().zip(turns) {
        let off = town.off_heading(member, yaw);
        assert!(off < 0.01, "{yaw}: off by {off} rad");
    }
    // As the documentation of `WalkerSettings::turn_rate` says.
    assert!((1.7..2.4).contains(&half_turn_secs), "{half_turn_secs} s");
}

#[test]
fn who_keeps_a_heading_steps_sideways_and_backwards_slower() {
    let limits = WalkerSettings::default();
    let mut town = Town::new();
    let told = [
        (0.0, 1.0),
        (FRAC_PI_2, limits.sideways),
        (-FRAC_PI_2, limits.sideways),
        (PI, limits.backwards),
    ];
    for (aside, share) in told {
        for facing in [0.0, 1.0, -2.5] {
            let member = town.add_at([0.0; 2]);
            town.walkers.set_facing(member, Some(facing)).unwrap();
            town.run(3.0);
            let direction = Vec2::new((facing + aside).sin(), (facing + aside).cos());
            town.send(member, 1.0, Goal::Velocity((direction * 1.5).to_array()));
            town.run(3.0);
            let velocity = town.velocity(member);
            let wanted = direction * 1.5 * share;
            assert!(velocity.distance(wanted) < 0.02, "{aside} {facing}: {velocity} {wanted}");
            let off = town.off_heading(member, facing);
            assert!(off < 0.01, "{aside} {facing}: off by {off} rad");
        }
    }
}

/// The largest distance of walkers from the middle of their trio after a while in which its members
/// are told different speeds.
fn spread(are_groups: bool) -> f32 {
    let mut town = Town::new();
    town.avoid();
    let mut members = Vec::new();
    for nth in 0..12_u16 {
        let (trio, place) = (nth / 3, f32::from(nth % 3));
        let member = town.add_at([3.0 * f32::from(trio) + 0.6 * place, 0.0]);
        town.walkers.set_group(member, if are_groups { u32::from(trio) + 1 } else { 0 }).unwrap();
        town.send(member, 1.0, Goal::Velocity([0.0, 1.1 + 0.2 * place]));
        members.push(member);
    }
    town.run(14.0);
    let trios = members.chunks_exact(3).flat_map(|trio| {
        let places = [0, 1, 2].map(|nth: usize| town.position(trio[nth]));
        let middle = places.iter().sum::<Vec2>() / 3.0;
        assert!(middle.y > 15.0, "a trio is late at {middle}");
        places.map(|at| at.distance(middle))
    });
    trios.fold(0.0, f32::max)
}

#[test]
fn groups_keep_together() {
    let (together, alone) = (spread(true), spread(false));
    assert!(together < 1.6, "{together} m");
    assert!(alone > 2.2, "{alone} m: they would keep together anyway");
}

/// Nobody finds a way around a wall; who stands there has not arrived.
#[test]
fn a_walker_tells_whether_it_has_arrived() {
    let mut town = Town::new();
    let mut avoidance = Avoidance::new(AvoidanceSettings::default()).unwrap();
    avoidance.set_obstacles(&[Obstacle::line([[-3.0, 4.0], [3.0, 4.0]])]).unwrap();
    town.walkers.set_avoidance(Some(avoidance));
    let [there, stuck] = [6.0, 0.0].map(|x| town.add_at([x, 0.0]));
    for (member, to) in [(there, [6.0, 8.0]), (stuck, [0.0, 8.0])] {
        assert!(town.walkers.has_arrived(member).unwrap(), "it stands");
        town.send(member, 1.3, Goal::Point(to));
        assert!(!town.walkers.has_arrived(member).unwrap());
    }
    town.run(12.0);
    let arrived = [there, stuck].map(|member| town.walkers.has_arrived(member).unwrap());
    assert_eq!(arrived, [true, false], "{:?}", town.walkers.positions());
    town.send(there, 1.3, Goal::Velocity([0.0; 2]));
    assert!(!town.walkers.has_arrived(there).unwrap());
}

/// A walker that is told to rest while it walks treads no further: it stands, with the strides of
/// its clips. One that plays a clip of the caller by then goes on with that.
#[test]
fn who_rests_lets_its_walk_go() {
    let mut town = Town::new();
    let [walks, waves] = [0.0, 3.0].map(|x| town.add_at([x, 0.0]));
    let wave = town.crowd.clip(town.person, "Wave").unwrap();
    for member in [walks, waves] {
        town.send(member, 1.3, Goal::Velocity([0.0, 1.3]));
    }
    let frames = |town: &mut Town, count: u32| {
        for _ in 0..count {
            town.step();
            town.crowd.update(FRAME_SECS).unwrap();
        }
    };
    frames(&mut town, 120);
    for member in [walks, waves] {
        let at = town.position(member).to_array();
        town.walkers.rest(member, at, 0.5).unwrap();
    }
    let playback = ClipPlayback::looping();
    town.crowd.member_mut(waves).unwrap().play(wave, playback).unwrap();
    frames(&mut town, 60);
    let playing = |member| town.crowd.member(member).unwrap().active_clips();
    let stands = town.crowd.clip(town.person, "Idle").unwrap();
    let weight = |member, clip| -> f32 {
        playing(member).iter().filter(|own| own.clip == clip).map(|own| own.weight).sum()
    };
    assert!(weight(walks, stands) > 0.99, "{:?}", playing(walks));
    assert!(weight(waves, wave) > 0.99, "{:?}", playing(waves));
}

/// Heeding others does not end a rest, and the rest's radius ends with it.
#[test]
fn a_rest_ends_by_resume_alone() {
    let mut town = Town::new();
    town.avoid();
    let member = town.add_at([0.0; 2]);
    town.walkers.rest(member, [0.0; 2], 0.9).unwrap();
    town.walkers.set_velocities(&[[0.0, 1.0]]).unwrap();
    for is_heedless in [true, false] {
        town.walkers.set_heedless(member, is_heedless).unwrap();
        town.run(1.0);
        assert_eq!(town.walkers.positions(), [[0.0; 2]], "heedless: {is_heedless}");
    }
    town.walkers.resume(&town.crowd, member).unwrap();
    town.walkers.set_velocities(&[[0.0, 1.0]]).unwrap();
    town.run(2.0);
    assert!(town.position(member).y > 1.0);
}

/// Somebody that lies has no velocity that others could see, nor does it come towards them.
#[test]
fn orders_to_who_rests_do_not_turn_others() {
    let way = |ordered: bool| {
        let mut town = Town::new();
        town.avoid();
        let [walks, lies] = [0.0, 6.0].map(|z| town.add_at([0.1, z]));
        town.send(walks, 1.0, Goal::Velocity([0.0, 1.0]));
        town.walkers.rest(lies, [0.0, 6.0], 0.7).unwrap();
        if ordered {
            town.walkers.set_goal(lies, Goal::Velocity([0.0, -1.0])).unwrap();
        }
        town.run(4.0);
        town.position(walks)
    };
    assert_eq!(way(true), way(false));
}

/// Walkers stop at the largest coordinate, and turn back from there.
#[test]
fn the_largest_coordinate_stops_walkers() {
    for avoids in [true, false] {
        let mut town = Town::new();
        if avoids {
            town.avoid();
        }
        let member = town.add_at([0.0, 999_999.0]);
        town.send(member, 1.0, Goal::Velocity([0.0, 5.0]));
        town.run(5.0);
        assert_eq!(town.walkers.positions(), [[0.0, 1e6]], "avoids: {avoids}");
        // It gains speed until its steps are no longer rounded away.
        assert!(town.velocity(member).length() < 0.2, "avoids: {avoids}");
        town.send(member, 1.0, Goal::Velocity([0.0, -1.0]));
        town.run(6.0);
        assert!(town.position(member).y < 999_998.0, "avoids: {avoids}");
    }
}
