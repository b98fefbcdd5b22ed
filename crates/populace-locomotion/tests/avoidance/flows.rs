//! Streams, a door, a circle and a pillar: everybody gets through without running into others.

use populace_locomotion::avoidance::{AvoidanceSettings, Error, Obstacle};

use crate::scenes::{Scene, circle, corridor, door, through_door};
use crate::walk::{FRAME_SECS, Walk, distance, towards};

#[test]
fn opposing_streams_pass_each_other_in_a_corridor() -> Result<(), Error> {
    // Up to 1.25 people a square metre where the streams are within each other.
    for (count, seed) in [(40, 1), (40, 2), (50, 3), (50, 4), (50, 5)] {
        let width_m = 4.0;
        let Scene { mut walk, goals } = corridor(count, width_m, seed)?;
        let is_through = |(at, goal): (&[f32; 2], &[f32; 2])| at[0] * goal[0].signum() > 5.0;
        while !walk.positions.iter().zip(&goals).all(is_through) {
            walk.step(|nth, _| [1.3 * goals[nth][0].signum(), 0.0])?;
            let side = width_m / 2.0 - 0.25;
            assert!(walk.positions.iter().all(|at| at[1].abs() <= side), "nobody is in a wall");
            // The last one has 30 m to go: 23 s without the others.
            assert!(walk.frame < 40 * 60, "{count}, seed {seed}, are not through after 40 s");
        }
    }
    Ok(())
}

#[test]
fn two_hundred_leave_through_a_door() -> Result<(), Error> {
    let Scene { mut walk, .. } = door(200, 1.2)?;
    let mut left_at = Vec::new();
    let (mut pairs, mut deep) = (0, 0);
    while left_at.len() < 200 {
        walk.step(|_, at| through_door(at))?;
        for nth in (0..walk.positions.len()).rev() {
            let [x, z] = walk.positions[nth];
            assert!(x.abs() > 0.21 || z.abs() < 0.6, "{x} {z} is in a wall");
            if x > 3.0 {
                walk.remove(nth);
                left_at.push(walk.frame as f32 * FRAME_SECS);
            }
        }
        if walk.frame % 6 == 0 {
            pairs += walk.positions.len() * walk.positions.len().saturating_sub(1) / 2;
            deep += walk.overlaps(0.02);
        }
        assert!(walk.frame < 200 * 60, "{} are out after 200 s", left_at.len());
    }
    // Without the first and last ten. Experiments with doors found 1.2 to 1.9 a metre and second.
    let flow = 180.0 / (left_at[189] - left_at[9]) / 1.2;
    assert!((1.1..2.2).contains(&flow), "{flow} people a metre and second");
    assert!(deep * 100 < pairs, "{deep} of {pairs} pairs overlap");
    Ok(())
}

#[test]
fn forty_on_a_circle_reach_the_other_side() -> Result<(), Error> {
    let Scene { mut walk, goals } = circle(40, 10.0)?;
    let (mut pairs, mut deep) = (0, 0);
    while !walk.positions.iter().zip(&goals).all(|(at, goal)| distance(*at, *goal) < 0.3) {
        walk.step(|nth, at| towards(at, goals[nth], 1.3))?;
        pairs += 40 * 39 / 2;
        deep += walk.overlaps(0.02);
        assert!(walk.frame < 40 * 60, "not there after 40 s");
    }
    assert!(deep * 1000 < pairs, "{deep} of {pairs} pairs overlap by more than 2 cm");
    Ok(())
}

#[test]
fn two_who_meet_head_on_pass_on_the_right() -> Result<(), Error> {
    let mut walk = Walk::new(AvoidanceSettings::default(), &[])?;
    walk.add([0.0, -6.0], 0.25, 0);
    walk.add([0.0, 6.0], 0.25, 0);
    while walk.positions[0][1] < 0.0 {
        walk.step(|nth, _| [0.0, if nth == 0 { 1.3 } else { -1.3 }])?;
        assert_eq!(walk.overlaps(0.0), 0);
        assert!(walk.frame < 10 * 60, "they block each other");
    }
    // The first looks along +Z, so that its right is -X.
    assert!(walk.positions[0][0] < -0.2 && walk.positions[1][0] > 0.2, "{:?}", walk.positions);
    Ok(())
}

#[test]
fn a_walker_goes_around_a_pillar_straight_ahead() -> Result<(), Error> {
    let square = vec![[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
    let backwards = square.iter().rev().copied().collect::<Vec<_>>();
    let hook = vec![[-0.6, 0.8], [-0.6, -0.8], [0.6, -0.8], [0.6, 0.8], [0.3, 0.0]];
    for points in [square, backwards, hook] {
        let mut walk = Walk::new(AvoidanceSettings::default(), &[Obstacle::polygon(points)])?;
        walk.add([0.0, -6.0], 0.25, 0);
        walk.velocities[0] = [0.0, 1.3];
        let mut slowest = f32::INFINITY;
        while walk.positions[0][1] < 4.0 {
            walk.step(|_, at| towards(at, [0.0, 6.0], 1.3))?;
            // The first frames are those before everybody has been steered.
            if walk.frame > 6 {
                slowest = slowest.min(distance(walk.velocities[0], [0.0; 2]));
            }
            assert!(walk.frame < 12 * 60, "stuck at {:?}", walk.positions[0]);
        }
        assert!(slowest > 0.6, "it slows down to {slowest} m/s");
    }
    Ok(())
}

#[test]
fn nobody_heeds_those_behind_a_wall() -> Result<(), Error> {
    let wall = Obstacle::line([[-20.0, 0.0], [20.0, 0.0]]);
    let mut walk = Walk::new(AvoidanceSettings::default(), &[wall])?;
    walk.add([-5.0, 0.26], 0.25, 0);
    walk.add([5.0, -0.26], 0.25, 0);
    walk.velocities = vec![[1.3, 0.0], [-1.3, 0.0]];
    for _ in 0..300 {
        walk.step(|nth, _| [if nth == 0 { 1.3 } else { -1.3 }, 0.0])?;
        let [x, z] = walk.told[0];
        assert!(x > 1.29 && z.abs() < 0.01, "{x} {z} at {:?}", walk.positions[0]);
    }
    Ok(())
}

/// People behind a wall take no place among the neighbours that a walker heeds.
#[test]
fn a_walker_sees_who_is_ahead_beside_people_behind_a_wall() -> Result<(), Error> {
    let told = |behind: usize| {
        let wall = Obstacle::line([[-20.0, -0.3], [20.0, -0.3]]);
        let settings = AvoidanceSettings { neighbours: 2, ..AvoidanceSettings::default() };
        let mut walk = Walk::new(settings, &[wall])?;
        walk.add([0.0, 0.0], 0.25, 0);
        walk.add([2.0, 0.0], 0.25, 0);
        for nth in 0..behind {
            walk.add([0.3 * nth as f32, -0.6], 0.25, 0);
        }
        walk.velocities[0] = [1.3, 0.0];
        walk.step(|nth, _| [if nth == 0 { 1.3 } else { 0.0 }, 0.0])?;
        Ok(walk.told[0])
    };
    let alone = told(0)?;
    assert!(alone[0] < 1.25 || alone[1] > 0.05, "{alone:?} leads into the one ahead");
    assert_eq!(told(5)?, alone);
    Ok(())
}
