//! Walkers that are led through a motion.

use populace::{Ground, Placement};
use populace_locomotion::{Error, Lead, SkateMeter};

use crate::fixture::{FRAME_SECS, Town};

/// Radius in metres and speed in metres per second of the circle that leads go round.
const RADIUS_M: f32 = 4.0;
const SPEED: f32 = 1.3;

/// Returns the lead round a circle at a time in seconds.
fn round(secs: f32) -> Lead {
    let angle = SPEED * secs / RADIUS_M;
    let (sin, cos) = angle.sin_cos();
    Lead {
        position: [RADIUS_M * sin, RADIUS_M * cos],
        velocity: [SPEED * cos, -SPEED * sin],
        soon_m_per_sec: SPEED,
        yaw_rad: angle + std::f32::consts::FRAC_PI_2,
        height_m: 0.0,
        step: None,
    }
}

/// Returns a town in which one walker is led.
fn town() -> Town {
    let mut town = Town::new();
    let member = town.crowd.spawn(town.person, Placement::at([0.0; 3])).unwrap();
    town.walkers.add_led(&mut town.crowd, member, &round(0.0), 0.3).unwrap();
    town
}

#[test]
fn it_is_where_it_is_led_and_its_feet_hold() {
    let mut town = town();
    let member = town.walkers.members()[0];
    let mut meter = SkateMeter::new();
    for frame in 1..300_u16 {
        let lead = round(f32::from(frame) * FRAME_SECS);
        town.walkers.follow(&mut town.crowd, &[lead], FRAME_SECS).unwrap();
        town.crowd.update(FRAME_SECS).unwrap();
        let [x, _, z] = town.crowd.member(member).unwrap().placement().position();
        assert!([x, z] == lead.position, "{frame}: {x} {z} is not {lead:?}");
        meter.sample(&mut town.crowd, member, FRAME_SECS).unwrap();
    }
    let skate = meter.skate().unwrap();
    assert!(skate.mean_m_per_sec < 0.01 && skate.p95_m_per_sec < 0.04, "{skate:?}");
    // Half of the frames of two feet or more.
    assert!(skate.samples > 250, "{skate:?}");
}

#[test]
fn the_meter_sees_feet_that_slide() {
    let mut town = town();
    let member = town.walkers.members()[0];
    let mut meter = SkateMeter::new();
    for frame in 1..60_u16 {
        let lead = round(f32::from(frame) * FRAME_SECS);
        // Told to stand while it is carried along.
        let carried = Lead { velocity: [0.0; 2], soon_m_per_sec: 0.0, ..lead };
        town.crowd.member_mut(member).unwrap().plant_feet(0.0).unwrap();
        town.walkers.follow(&mut town.crowd, &[carried], FRAME_SECS).unwrap();
        town.crowd.update(FRAME_SECS).unwrap();
        meter.sample(&mut town.crowd, member, FRAME_SECS).unwrap();
    }
    let skate = meter.skate().unwrap();
    assert!(skate.mean_m_per_sec > 0.5, "{skate:?}");
}

#[test]
fn it_begins_under_way() {
    let mut town = town();
    let member = town.walkers.members()[0];
    town.crowd.update(0.0).unwrap();
    let playing = town.crowd.member(member).unwrap().active_clips();
    let weight = |clip: &populace::ActiveClip| clip.weight;
    let moving: f32 = playing.iter().filter(|clip| clip.time_secs > 0.0).map(weight).sum();
    assert!(moving > 0.5, "{playing:?}");
    assert_eq!(town.walkers.velocities(), [round(0.0).velocity]);
}

#[test]
fn who_is_refused_as_a_walker_again_keeps_its_feet_planted() {
    let joints = |refused: &[f32]| {
        let mut town = town();
        // Feet that are planted are raised to the ground.
        town.crowd.set_ground(&Ground::plane(0.2, [0.0; 2]).unwrap()).unwrap();
        let member = town.walkers.members()[0];
        for phase in refused {
            let wrong = town.walkers.add_led(&mut town.crowd, member, &round(0.0), *phase);
            assert!(wrong.is_err(), "{phase}: {wrong:?}");
        }
        town.walkers.follow(&mut town.crowd, &[round(0.1)], 0.1).unwrap();
        town.crowd.update(0.1).unwrap();
        town.crowd.member_mut(member).unwrap().model_from_joints().unwrap()
    };
    let planted = joints(&[]);
    assert_eq!(joints(&[f32::NAN]), planted);
    assert_eq!(joints(&[-0.1, 1.5]), planted);
}

#[test]
fn who_rests_is_not_led() {
    let mut town = town();
    let member = town.walkers.members()[0];
    town.walkers.rest(member, [7.0, 8.0], 0.7).unwrap();
    town.walkers.follow(&mut town.crowd, &[round(1.0)], FRAME_SECS).unwrap();
    let walkers = &town.walkers;
    assert_eq!((walkers.positions(), walkers.velocities()), (&[[7.0, 8.0]][..], &[[0.0; 2]][..]));
}

#[test]
fn wrong_leads_move_nobody() {
    let mut town = town();
    let before = town.walkers.positions().to_vec();
    let wrong = town.walkers.follow(&mut town.crowd, &[], FRAME_SECS);
    assert!(matches!(wrong, Err(Error::UnequalLengths { found: 0, walkers: 1 })), "{wrong:?}");
    for bad in [
        Lead { position: [f32::NAN, 0.0], ..round(0.5) },
        Lead { velocity: [0.0, f32::INFINITY], ..round(0.5) },
        Lead { yaw_rad: f32::NAN, ..round(0.5) },
        Lead { height_m: 1e9, ..round(0.5) },
    ] {
        let wrong = town.walkers.follow(&mut town.crowd, &[bad], FRAME_SECS);
        assert!(matches!(wrong, Err(Error::BadValue { .. })), "{bad:?}: {wrong:?}");
    }
    assert_eq!(town.walkers.positions(), before);
}

/// Who was led faster than any walker goes walks on, with avoidance and without.
#[test]
fn it_goes_on_by_itself_after_it_was_led_too_fast() {
    for avoids in [true, false] {
        let mut town = town();
        let member = town.walkers.members()[0];
        let fast = Lead { position: [0.0; 2], velocity: [0.0, 1e6], ..round(0.0) };
        town.walkers.follow(&mut town.crowd, &[fast], FRAME_SECS).unwrap();
        if avoids {
            town.avoid();
        }
        for _ in 0..60 {
            town.step();
        }
        let [vx, vz] = town.walkers.velocities()[0];
        assert!(vx.hypot(vz) < 100.0, "{vx} {vz}");
        let at = town.position(member);
        assert!(at.length() < 101.0, "{at}");
    }
}
