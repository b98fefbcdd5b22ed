//! Limits of bodies, which walkers keep.

use glam::Vec2;
use populace::Placement;
use populace::model::{Role, Side};
use populace_locomotion::{Goal, WalkerSettings};

use crate::fixture::{FRAME_SECS, RADIUS_M, Town, between};

#[derive(Clone, Copy, Default)]
struct Seen {
    at: Vec2,
    velocity: Vec2,
    yaw_rad: f32,
    turn_rate: f32,
}

/// Drives people about at random and checks every frame.
fn drive(mut town: Town, evade: f32) {
    let limits = WalkerSettings::default();
    let mut random = fastrand::Rng::with_seed(7);
    let mut members = Vec::new();
    for nth in 0..49_u16 {
        members.push(town.add_at([f32::from(nth % 7), f32::from(nth / 7)].map(|m| 1.2 * m)));
    }
    let mut told = vec![0.0_f32; members.len()];
    // Who evades others reacts within 0.1 s: its speed in the last frames, or what was allowed.
    let frames = if evade > 1.0 { 7 } else { 1 };
    let mut allowed = vec![[0.0_f32; 7]; members.len()];
    let rest = |member| Seen { at: town.position(member), ..Seen::default() };
    let mut before: Vec<Seen> = members.iter().map(|member| rest(*member)).collect();
    for frame in 0..1200 {
        for (nth, member) in members.iter().enumerate() {
            if random.u8(..) == 0 || frame == 0 {
                let speed = 2.0 * random.f32();
                let to = [random.f32(), random.f32()].map(|m| 8.0 * m);
                let towards = Vec2::from_angle(7.0 * random.f32()) * speed;
                let goal = match random.u8(..4) {
                    0 => Goal::Stand,
                    1 => Goal::Velocity(towards.to_array()),
                    _ => Goal::Point(to),
                };
                town.send(*member, speed, goal);
                let facing = (random.u8(..3) == 0).then(|| 6.0 * random.f32());
                town.walkers.set_facing(*member, facing).unwrap();
                told[nth] = speed;
            }
        }
        town.step();
        for (nth, member) in members.iter().enumerate() {
            let (at, velocity) = (town.position(*member), town.velocity(*member));
            let yaw_rad = town.place(*member).yaw_rad();
            let last = before[nth];
            let turn = between(yaw_rad, last.yaw_rad);
            let ahead = (yaw_rad - last.yaw_rad).sin().signum();
            let turn_rate = ahead * turn / FRAME_SECS;
            let faster = (velocity.length() - last.velocity.length()) / FRAME_SECS;
            let change = (velocity - last.velocity).length() / FRAME_SECS;
            let most_change = limits.acceleration.max(limits.deceleration);
            let what = format!("frame {frame}, walker {nth}: {velocity} after {}", last.velocity);
            assert!(faster <= limits.acceleration + 1e-3, "{what}: {faster} m/s2");
            assert!(-faster <= limits.deceleration + 0.02 / FRAME_SECS, "{what}: {faster} m/s2");
            // The last 2 cm/s go at once.
            let stands = velocity == Vec2::ZERO && last.velocity.length() < 0.05;
            assert!(stands || change <= most_change + 1e-3, "{what}: {change} m/s2");
            assert!(turn_rate.abs() <= limits.turn_rate + 1e-3, "{what}: {turn_rate} rad/s");
            let turns = (turn_rate - last.turn_rate).abs() / FRAME_SECS;
            assert!(turns <= limits.turn_acceleration + 0.1, "{what}: {turns} rad/s2");
            let most = allowed[nth][..frames].iter().fold(evade * told[nth], |a, b| a.max(*b));
            assert!(velocity.length() <= most + 1e-4, "{what}: {} was asked", told[nth]);
            allowed[nth][frame % frames] = velocity.length().max(evade * told[nth]);
            let moved = (at - last.at) / FRAME_SECS;
            assert!(moved.distance(velocity) < 1e-3, "{what}: moved by {moved}");
            before[nth] = Seen { at, velocity, yaw_rad, turn_rate };
        }
    }
}

#[test]
fn limits_hold_in_every_frame() {
    drive(Town::new(), 1.0);
}

#[test]
fn limits_hold_in_every_frame_while_people_evade_others() {
    let mut town = Town::new();
    town.avoid();
    drive(town, 1.3);
}

#[test]
fn speeds_over_the_ground_are_those_asked_for() {
    let mut town = Town::new();
    let mut told = Vec::new();
    for scale in [0.5, 1.0, 2.0] {
        for speed in [0.3, 0.8, 1.3, 2.0, 3.0, 4.0] {
            // Far from the origin steps of a frame are few units of rounding.
            for from in [0.0, 10_000.0] {
                let member = town.add(Placement::at([from, 0.0, 0.0]).scaled(scale));
                town.send(member, 1.0, Goal::Velocity([speed, 0.0]));
                told.push((member, speed, scale));
            }
        }
    }
    town.run(6.0);
    let before: Vec<Vec2> = told.iter().map(|(member, ..)| town.position(*member)).collect();
    town.run(2.0);
    for ((member, speed, scale), before) in told.into_iter().zip(before) {
        let found = town.position(member).distance(before) / 2.0;
        let told = (speed, scale, before);
        assert!((found / speed - 1.0).abs() < 0.02, "{told:?}: {found} m/s");
    }
}

#[test]
fn standing_feet_stay_where_they_are_at_all_scales() {
    for (scale, speed) in [(0.5, 0.6), (1.0, 1.3), (2.0, 2.0)] {
        let mut town = Town::new();
        let member = town.add(Placement::at([0.0; 3]).scaled(scale));
        town.send(member, 1.0, Goal::Velocity([0.0, speed]));
        let view = town.crowd.member(member).unwrap();
        let feet = [Side::Left, Side::Right].map(|side| view.joint(Role::Foot(side)).unwrap());
        let (mut before, mut slides) = ([Vec2::ZERO; 2], Vec::new());
        for frame in 0..360 {
            town.step();
            town.crowd.update(FRAME_SECS).unwrap();
            let rows = town.place(member).world_from_model().rows;
            let joints = town.crowd.member_mut(member).unwrap().model_from_joints().unwrap();
            let now = feet.map(|foot| {
                let [x, y, z] = joints[foot.0 as usize].rows.map(|row| row[3]);
                let world = rows.map(|r| r[0] * x + r[1] * y + r[2] * z + r[3]);
                Vec2::new(world[0], world[2])
            });
            let speeds = [0, 1].map(|nth: usize| now[nth].distance(before[nth]) / FRAME_SECS);
            if frame > 180 {
                slides.push(speeds[0].min(speeds[1]));
            }
            before = now;
        }
        // An ankle rolls over its foot, so it moves a little while the sole stands.
        let mean = slides.iter().sum::<f32>() / slides.len() as f32;
        assert!(mean < 0.2 * speed, "{scale}: ankles of standing feet move at {mean} m/s");
    }
}

#[test]
fn people_keep_apart_where_they_evade_each_other() {
    let closest = |avoids: bool| {
        let mut town = Town::new();
        if avoids {
            town.avoid();
        }
        for nth in 0..20_u16 {
            let side = if nth % 2 == 0 { 1.0 } else { -1.0 };
            let member = town.add_at([side * (3.0 + f32::from(nth / 4)), f32::from(nth / 2 % 2)]);
            town.send(member, 1.0, Goal::Velocity([-1.2 * side, 0.0]));
        }
        let mut closest = f32::INFINITY;
        for _ in 0..600 {
            town.step();
            let all = town.walkers.positions();
            for (nth, at) in all.iter().enumerate() {
                let others =
                    all[..nth].iter().map(|other| Vec2::from(*other).distance((*at).into()));
                closest = others.fold(closest, f32::min);
            }
        }
        closest
    };
    assert!(closest(false) < 0.1, "they do not meet");
    let apart = closest(true);
    assert!(apart > 1.4 * RADIUS_M, "{apart} m");
}
