//! Footholds: how high a foot stands or swings over the ground.

use glam::{DAffine3, DVec3};
use populace_device::layout::{FOOT_AHEAD, FOOT_CLIMB_GAIN, FOOT_CLIMB_M_PER_SEC, FOOT_EDGE};

use super::{FootState, Hold, OracleGait};
use crate::oracle::noise::Noise;

/// The ground under a sole.
pub(super) struct Under {
    /// The height at which no point of the sole is in the ground.
    pub(super) height: f64,
    pub(super) normal: DVec3,
    /// The sole is on the edge of a step, and level.
    pub(super) on_edge: bool,
}

/// Returns the ground under a sole whose pivot is at a place. It lies on the plane through the
/// pivot, or is level where the ground is far off that plane. `points` are those of the sole.
pub(super) fn under(
    gait: &OracleGait,
    pivot: DVec3,
    points: &[DVec3],
    most: f64,
    noise: &mut Noise,
) -> Under {
    let (ground, normal) = gait.ground.at(pivot, noise);
    let mut under = Under { height: ground, normal, on_edge: false };
    if !gait.ground.has_heights() {
        return under;
    }
    let (mut level, mut tilted) = (ground, ground);
    for point in points {
        let (height, _) = gait.ground.at(*point, noise);
        let off = *point - pivot;
        let plane = ground - (normal.x * off.x + normal.z * off.z) / normal.y;
        level = level.max(height - off.y);
        tilted = tilted.max(height - off.y + (ground - plane));
        under.on_edge |= (height - plane).abs() > f64::from(FOOT_EDGE) * most;
    }
    if under.on_edge {
        (under.height, under.normal) = (level, DVec3::Y);
    } else {
        under.height = tilted;
    }
    under.height = noise.near(under.height, under.height.abs() + pivot.y.abs());
    under
}

/// Returns the height that a foot in the air rises to: that of the ground a little ahead, if it is
/// higher. The nearer the foot is to standing, the less that counts.
pub(super) fn ahead(
    gait: &OracleGait,
    place: &DAffine3,
    pivot: DVec3,
    ground: f64,
    [most, near]: [f64; 2],
    noise: &mut Noise,
) -> f64 {
    if !gait.ground.has_heights() {
        return ground;
    }
    let [along_x, along_z, _] = gait.stride;
    let scale = place.matrix3.y_axis.length();
    let along = place.transform_vector3(DVec3::new(along_x, 0.0, along_z)) / scale;
    let (there, _) = gait.ground.at(pivot + along * (f64::from(FOOT_AHEAD) * most), noise);
    ground + (there - ground).max(0.0) * (1.0 - near)
}

/// Returns a height on its way to another one, and its speed. Speed and its changes are limited; the
/// way ends at rest. What moves no faster than a slope under a foot is followed at once.
fn climb(from: f64, speed: f64, to: f64, secs: f64) -> (f64, f64) {
    let (fastest, gain) = (f64::from(FOOT_CLIMB_M_PER_SEC), f64::from(FOOT_CLIMB_GAIN));
    let way = to - from;
    if 1.5 * way.abs() <= fastest * secs {
        return (to, if secs > 0.0 { way / secs } else { speed });
    }
    // At constant deceleration `v^2 = 2 a s`.
    let most = (2.0 * gain * way.abs()).sqrt().min(fastest).min(way.abs() / secs);
    let speed = (most * way.signum()).clamp(speed - gain * secs, speed + gain * secs);
    (from + speed * secs, speed)
}

/// Returns the height of the ground that a foot is shown on, and how fast it rises. A foot that
/// stays where it stands loses its height above the ground; others go to the ground, or to the
/// height `ahead`.
pub(super) fn shown(
    before: Option<&FootState>,
    stands: bool,
    (under, ahead): (&Under, f64),
    secs: f64,
    noise: &mut Noise,
) -> (f64, f64) {
    let Some(before) = before else { return (under.height, 0.0) };
    let (height, speed) = match before.hold {
        Hold::Locked { above, .. } if stands && !under.on_edge => {
            let (above, speed) = climb(above, before.climb, 0.0, secs);
            (under.height + above, speed)
        }
        _ => {
            let to = if stands { under.height } else { ahead };
            climb(before.height, before.climb, to, secs)
        }
    };
    let size = under.height.abs() + before.height.abs();
    (noise.near(height, size), if secs > 0.0 { noise.near(speed, size / secs) } else { speed })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_climb_ends_at_rest() {
        let (mut height, mut speed, mut fastest) = (0.0, 0.0, 0.0f64);
        for _ in 0..120 {
            (height, speed) = climb(height, speed, 0.3, 1.0 / 120.0);
            assert!(height <= 0.3 + 1e-12, "{height}");
            fastest = fastest.max(speed);
        }
        assert!((height - 0.3).abs() < 1e-12 && speed.abs() < 1e-12, "{height} {speed}");
        assert!((1.3..=1.5).contains(&fastest), "{fastest}");
    }
}
