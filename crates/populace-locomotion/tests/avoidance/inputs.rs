//! Refused input, equal results whatever runs them, and walkers at one place.

use populace::ErrorKind;
use populace_locomotion::avoidance::{
    Agents, Avoidance, AvoidanceSettings, Error, Obstacle, Stagger,
};

use crate::scenes::{Scene, corridor, door, through_door};
use crate::walk::{Walk, distance};

fn bits(walk: &Walk) -> Vec<[u32; 2]> {
    walk.positions.iter().chain(&walk.told).map(|v| v.map(f32::to_bits)).collect()
}

fn some_door(frames: usize) -> Result<Walk, Error> {
    let Scene { mut walk, .. } = door(120, 1.2)?;
    walk.groups.iter_mut().enumerate().for_each(|(nth, group)| *group = nth as u32 / 3 % 20);
    for _ in 0..frames {
        walk.step(|_, at| through_door(at))?;
    }
    Ok(walk)
}

#[test]
fn results_do_not_depend_on_threads() -> Result<(), Error> {
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.map(|pool| pool.install(|| some_door(300)))
    };
    let [one, four] = [1, 4].map(|threads| with(threads).expect("threads can be started"));
    assert_eq!(bits(&one?), bits(&four?));
    Ok(())
}

#[test]
fn a_clone_replays_the_same_bits() -> Result<(), Error> {
    let mut walk = some_door(200)?;
    let mut replay = walk.clone();
    for walk in [&mut walk, &mut replay] {
        for _ in 0..200 {
            walk.step(|_, at| through_door(at))?;
        }
    }
    assert_eq!(bits(&walk), bits(&replay));
    // Nor does an avoidance remember: a new one does the same.
    let mut fresh = some_door(200)?;
    let used = fresh.avoidance.clone();
    let Scene { walk: new, .. } = door(1, 1.2)?;
    fresh.avoidance = new.avoidance;
    let mut other = fresh.clone();
    other.avoidance = used;
    for walk in [&mut fresh, &mut other] {
        walk.step(|_, at| through_door(at))?;
    }
    assert_eq!(bits(&fresh), bits(&other));
    Ok(())
}

#[test]
fn shares_of_a_stagger_add_up_to_all() -> Result<(), Error> {
    let Scene { mut walk, .. } = corridor(40, 4.0, 1)?;
    walk.preferred.iter_mut().for_each(|wish| *wish = [1.0, 0.3]);
    let agents = Agents {
        positions: &walk.positions,
        velocities: &walk.velocities,
        preferred: &walk.preferred,
        radii_m: &walk.radii_m,
        most_speeds: &walk.most_speeds,
        groups: &walk.groups,
    };
    let mut all = vec![[9.0; 2]; 80];
    walk.avoidance.steer(&agents, Stagger::ALL, &mut all)?;
    let mut shares = vec![[9.0; 2]; 80];
    for nth in 0..6 {
        let untouched = shares.iter().filter(|velocity| velocity[0] == 9.0).count();
        assert_eq!(untouched, 80 - (0..80).filter(|walker| walker % 6 < nth).count());
        walk.avoidance.steer(&agents, Stagger { count: 6, nth }, &mut shares)?;
    }
    assert_eq!(all, shares);
    Ok(())
}

#[test]
fn walkers_at_one_place_part() -> Result<(), Error> {
    let mut walk = Walk::new(AvoidanceSettings::default(), &[])?;
    (0..8).for_each(|_| walk.add([3.0, -2.0], 0.25, 0));
    for _ in 0..5 * 60 {
        walk.step(|_, _| [0.0; 2])?;
    }
    assert_eq!(walk.overlaps(0.02), 0);
    assert!(walk.positions.iter().all(|at| distance(*at, [3.0, -2.0]) < 4.0), "not far apart");
    Ok(())
}

#[test]
fn walkers_far_apart_and_far_away_avoid_only_neighbours() -> Result<(), Error> {
    let mut walk = Walk::new(AvoidanceSettings::default(), &[])?;
    // Cells repeat: these share cells of the grid with others without being near.
    for nth in 0..20 {
        walk.add([nth as f32 * 32.0, 0.0], 0.25, 0);
        walk.add([-1e5 + nth as f32 * 4096.0, 1e5], 0.25, 0);
    }
    for _ in 0..60 {
        walk.step(|_, _| [0.0, 1.25])?;
    }
    assert!(walk.told.iter().all(|velocity| *velocity == [0.0, 1.25]), "{:?}", walk.told);
    Ok(())
}

#[test]
fn bad_obstacles_are_refused_and_the_old_ones_stay() -> Result<(), Error> {
    let mut avoidance = Avoidance::new(AvoidanceSettings::default())?;
    avoidance.set_obstacles(&[Obstacle::line([[-5.0, 0.0], [5.0, 0.0]])])?;
    let cases = [
        (Obstacle::line([]), "0 points"),
        (Obstacle::polygon([[1.0, 2.0]]), "1 points"),
        (Obstacle::line([[0.0, 0.0], [1.0, f32::NAN]]), "point 1 of obstacle 1"),
        (Obstacle::line([[0.0, 0.0], [f32::INFINITY, 1.0]]), "inf"),
        (Obstacle::line([[0.0, 0.0], [2.0, 1.0], [2.0, 1.0]]), "points 1 and 2"),
        (Obstacle::polygon([[0.0, 0.0], [2.0, 1.0], [0.0, 0.0]]), "points 2 and 0"),
    ];
    let good = Obstacle::polygon([[0.0, 9.0], [1.0, 9.0]]);
    for (obstacle, message) in cases {
        let error = avoidance.set_obstacles(&[good.clone(), obstacle]).expect_err(message);
        assert_eq!(error.kind(), ErrorKind::InvalidInput);
        assert!(error.to_string().contains(message), "{error}");
    }
    assert!(avoidance.slide([0.0, 1.0], [0.0, -1.0], 0.2)[1] >= 0.2);
    avoidance.set_obstacles(&[])?;
    assert_eq!(avoidance.slide([0.0, 1.0], [0.0, -1.0], 0.2), [0.0, -1.0]);
    Ok(())
}

#[test]
fn bad_walkers_are_refused_by_name() -> Result<(), Error> {
    let mut avoidance = Avoidance::new(AvoidanceSettings::default())?;
    let vectors = [[0.0; 2]; 2];
    let good = Agents {
        positions: &vectors,
        velocities: &vectors,
        preferred: &vectors,
        radii_m: &[0.3; 2],
        most_speeds: &[1.5; 2],
        groups: &[0; 2],
    };
    let nan = [[0.0; 2], [0.0, f32::NAN]];
    let cases = [
        (Agents { positions: &nan, ..good }, "position of walker 1"),
        (Agents { positions: &[[2e6, 0.0], [0.0; 2]], ..good }, "position of walker 0"),
        (Agents { velocities: &nan, ..good }, "velocity of walker 1"),
        (Agents { preferred: &nan, ..good }, "preferred velocity of walker 1"),
        (Agents { radii_m: &[0.3, 0.0], ..good }, "radius of walker 1"),
        (Agents { most_speeds: &[-1.0, 1.0], ..good }, "highest speed of walker 0"),
        (Agents { groups: &[0; 3], ..good }, "2 positions, but 3 groups"),
    ];
    let mut results = [[5.0; 2]; 2];
    for (agents, message) in cases {
        let error = avoidance.steer(&agents, Stagger::ALL, &mut results).expect_err(message);
        assert!(error.to_string().contains(message), "{error}");
        assert_eq!(error.kind(), ErrorKind::InvalidInput);
    }
    for stagger in [Stagger { count: 0, nth: 0 }, Stagger { count: 6, nth: 6 }] {
        assert!(avoidance.steer(&good, stagger, &mut results).is_err());
    }
    assert!(avoidance.steer(&good, Stagger::ALL, &mut results[..1]).is_err());
    assert_eq!(results, [[5.0; 2]; 2], "nothing was written");
    let settings = AvoidanceSettings { neighbours: 0, ..Default::default() };
    let error = Avoidance::new(settings).expect_err("no neighbours");
    assert_eq!(error.to_string(), "the setting neighbours is 0; it must be from 1 to 16");
    avoidance.steer(&Agents::default(), Stagger::ALL, &mut [])
}
