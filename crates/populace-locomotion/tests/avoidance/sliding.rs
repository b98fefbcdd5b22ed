//! Nothing crosses a wall, whatever pushes it.

use populace_locomotion::avoidance::{Avoidance, AvoidanceSettings, Error, Obstacle};

use crate::walk::distance;

/// The least that rounding may bring a disc into a wall, in metres.
const ROUNDING_M: f32 = 1e-5;

struct Room {
    avoidance: Avoidance,
    walls: Vec<[[f32; 2]; 2]>,
}

impl Room {
    fn new(shapes: &[(Vec<[f32; 2]>, bool)]) -> Result<Self, Error> {
        let mut obstacles = Vec::new();
        let mut walls = Vec::new();
        for (points, closed) in shapes {
            walls.extend(points.windows(2).map(|pair| [pair[0], pair[1]]));
            if *closed {
                walls.push([points[points.len() - 1], points[0]]);
            }
            let points = points.clone();
            obstacles.push(if *closed {
                Obstacle::polygon(points)
            } else {
                Obstacle::line(points)
            });
        }
        let mut avoidance = Avoidance::new(AvoidanceSettings::default())?;
        avoidance.set_obstacles(&obstacles)?;
        Ok(Self { avoidance, walls })
    }

    /// Random stars, zigzags and combs, in a square of `size_m`.
    fn random(random: &mut fastrand::Rng, size_m: f32) -> Result<Self, Error> {
        let shape = |random: &mut fastrand::Rng| {
            let closed = random.bool();
            let [x, z] = [(); 2].map(|()| (random.f32() - 0.5) * size_m);
            let points = (0..random.usize(2..9)).map(|nth| {
                let radius = 0.2 + 2.5 * random.f32();
                let (sin, cos) = (nth as f64 * 0.8).sin_cos();
                [x + radius * cos as f32, z + radius * sin as f32]
            });
            (points.collect(), closed)
        };
        let shapes: Vec<_> = (0..12).map(|_| shape(random)).collect();
        Self::new(&shapes)
    }

    /// Distance from the nearest wall, found in double precision.
    fn clearance(&self, at: [f32; 2]) -> f32 {
        let from = |wall: &[[f32; 2]; 2]| {
            let [a, b, p] = [wall[0], wall[1], at].map(|v| v.map(f64::from));
            let along = [b[0] - a[0], b[1] - a[1]];
            let square = along[0] * along[0] + along[1] * along[1];
            let share = ((p[0] - a[0]) * along[0] + (p[1] - a[1]) * along[1]) / square;
            let share = share.clamp(0.0, 1.0);
            (p[0] - a[0] - along[0] * share).hypot(p[1] - a[1] - along[1] * share) as f32
        };
        self.walls.iter().map(from).fold(f32::INFINITY, f32::min)
    }

    fn crosses(&self, from: [f32; 2], to: [f32; 2]) -> bool {
        let turn = |a: [f32; 2], b: [f32; 2], c: [f32; 2]| {
            let [a, b, c] = [a, b, c].map(|v| v.map(f64::from));
            (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        };
        let apart = |a, b, c, d| turn(a, b, c) * turn(a, b, d) < 0.0;
        self.walls.iter().any(|[a, b]| apart(from, to, *a, *b) && apart(*a, *b, from, to))
    }
}

#[test]
fn random_pushes_cross_no_wall() -> Result<(), Error> {
    let mut random = fastrand::Rng::with_seed(11);
    let (mut pushes, mut touched) = (0, 0);
    for _ in 0..60 {
        let room = Room::random(&mut random, 14.0)?;
        let radius = 0.05 + 0.4 * random.f32();
        for _ in 0..20 {
            let mut at = [(); 2].map(|()| (random.f32() - 0.5) * 16.0);
            if room.clearance(at) < radius {
                continue;
            }
            for _ in 0..50 {
                // Mostly steps of a walker, some blows, and steps far across everything.
                let length = [0.05, 0.05, 1.0, 30.0][random.usize(0..4)];
                let to = at.map(|c| c + (random.f32() - 0.5) * 2.0 * length);
                let now = room.avoidance.slide(at, to, radius);
                let clearance = room.clearance(now);
                assert!(clearance >= radius - ROUNDING_M, "{clearance} of {radius} at {now:?}");
                // A detour along walls may cut behind a corner in a straight line, a step may not.
                if length < 0.1 {
                    assert!(!room.crosses(at, now), "{at:?} {now:?}");
                }
                touched += usize::from(clearance < radius + 0.01);
                pushes += 1;
                at = now;
            }
        }
    }
    assert!(pushes > 20_000 && touched > 2_000, "{pushes} {touched}");
    Ok(())
}

#[test]
fn nobody_is_pressed_out_of_a_room() -> Result<(), Error> {
    let mut random = fastrand::Rng::with_seed(12);
    // An acute corner, at a distance from the origin where numbers are coarse.
    let corners = [[1000.0, 2000.0], [1006.0, 2000.0], [1001.0, 2001.0], [1000.0, 2006.0]];
    let room = Room::new(&[(corners.to_vec(), true)])?;
    let mut at = [1000.8, 2000.7];
    assert!(room.clearance(at) > 0.3);
    for round in 0..20_000 {
        let corner = corners[round / 500 % 4];
        let push = [corner[0] - at[0], corner[1] - at[1]];
        let to = [0, 1].map(|c| at[c] + push[c] * 0.1 + (random.f32() - 0.5) * 0.5);
        let now = room.avoidance.slide(at, to, 0.3);
        assert!(room.clearance(now) >= 0.3 - ROUNDING_M, "{now:?} {}", room.clearance(now));
        assert!(!room.crosses(at, now));
        at = now;
    }
    Ok(())
}

#[test]
fn a_disc_slides_along_a_wall_and_over_its_joints() -> Result<(), Error> {
    let room = Room::new(&[(vec![[-9.0, 0.0], [0.0, 0.0], [1.0, 0.0], [9.0, 0.0]], false)])?;
    let mut at = [-5.0, 0.5];
    for _ in 0..200 {
        at = room.avoidance.slide(at, [at[0] + 0.05, at[1] - 0.05], 0.3);
    }
    assert!(distance(at, [5.0, 0.301]) < 1e-3, "{at:?}");
    Ok(())
}

#[test]
fn a_disc_that_starts_in_a_wall_is_led_out_on_its_side() -> Result<(), Error> {
    let room = Room::new(&[(vec![[-9.0, 0.0], [9.0, 0.0]], false)])?;
    let mut at = [0.0, 0.1];
    for _ in 0..20 {
        at = room.avoidance.slide(at, [at[0], at[1] - 0.02], 0.3);
        assert!(at[1] >= 0.1, "no nearer than it was");
    }
    assert!(at[1] >= 0.29, "{at:?}");
    // Right in a wall it comes out on either side.
    let mut at = [0.0, 0.0];
    for _ in 0..20 {
        at = room.avoidance.slide(at, at, 0.3);
    }
    assert!(at[1].abs() > 0.29, "{at:?}");
    Ok(())
}

#[test]
fn bad_numbers_do_not_move_a_disc() -> Result<(), Error> {
    let room = Room::new(&[(vec![[-9.0, 0.0], [9.0, 0.0]], false)])?;
    let from = [1.0, 1.0];
    for bad in [f32::NAN, f32::INFINITY] {
        assert_eq!(room.avoidance.slide(from, [bad, 1.0], 0.3), from);
        assert_eq!(room.avoidance.slide(from, [2.0, 1.0], bad), from);
    }
    let far = room.avoidance.slide(from, [1.0, -3e38], 0.3);
    assert!(far[1] > 0.0, "{far:?}");
    Ok(())
}
