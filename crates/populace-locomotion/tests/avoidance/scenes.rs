//! Scenes: a corridor, a door and a circle.

use populace_locomotion::avoidance::{AvoidanceSettings, Error, Obstacle};

use crate::walk::{Walk, scatter};

/// A scene and where its walkers go.
pub(crate) struct Scene {
    pub(crate) walk: Walk,
    pub(crate) goals: Vec<[f32; 2]>,
}

/// Two streams of `count` people each at random places of a corridor along x, `width_m` wide.
pub(crate) fn corridor(count: usize, width_m: f32, seed: u64) -> Result<Scene, Error> {
    let side = width_m / 2.0;
    let walls = [side, -side].map(|z| Obstacle::line([[-60.0, z], [-10.0, z], [60.0, z]]));
    let mut walk = Walk::new(AvoidanceSettings::default(), &walls)?;
    let mut random = fastrand::Rng::with_seed(seed);
    let mut goals = Vec::new();
    for (from, to) in [(-25.0, 50.0), (5.0, -50.0)] {
        let high = [from + 20.0, side - 0.3];
        for place in scatter(&mut random, count, [from, 0.3 - side], high) {
            walk.add(place, 0.25, 0);
            goals.push([to, place[1]]);
        }
    }
    Ok(Scene { walk, goals })
}

/// A room of 12 by 12 metres with `count` people and a door of `width_m` at x = 0 to the right.
pub(crate) fn door(count: usize, width_m: f32) -> Result<Scene, Error> {
    let post = width_m / 2.0;
    let wall = Obstacle::line([
        [0.0, post],
        [0.0, 6.0],
        [-12.0, 6.0],
        [-12.0, -6.0],
        [0.0, -6.0],
        [0.0, -post],
    ]);
    let mut walk = Walk::new(AvoidanceSettings::default(), &[wall])?;
    let mut random = fastrand::Rng::with_seed(4);
    let places = scatter(&mut random, count, [-11.5, -5.5], [-1.5, 5.5]);
    places.iter().for_each(|place| walk.add(*place, 0.22, 0));
    Ok(Scene { walk, goals: vec![[0.0; 2]; count] })
}

/// A walker's wish in the room with a door: to the door, and then straight on.
pub(crate) fn through_door(at: [f32; 2]) -> [f32; 2] {
    if at[0] > 0.0 {
        return [1.3, 0.0];
    }
    // To the nearest point of the opening that a shoulder fits through.
    let [x, z] = [0.4 - at[0], at[1].clamp(-0.35, 0.35) - at[1]];
    let rate = 1.3 / x.hypot(z);
    [x * rate, z * rate]
}

/// People on a circle who all go to the opposite point.
pub(crate) fn circle(count: usize, radius_m: f32) -> Result<Scene, Error> {
    let mut walk = Walk::new(AvoidanceSettings::default(), &[])?;
    let mut goals = Vec::new();
    for nth in 0..count {
        let (sin, cos) = (nth as f64 / count as f64 * std::f64::consts::TAU).sin_cos();
        let place = [(f64::from(radius_m) * cos) as f32, (f64::from(radius_m) * sin) as f32];
        walk.add(place, 0.25, 0);
        goals.push([-place[0], -place[1]]);
    }
    Ok(Scene { walk, goals })
}
