//! Cameras that look in a given direction and show given points.
#![expect(clippy::disallowed_methods, reason = "angles of the host alone; no device computes them")]

use glam::Vec3;
use populace_render::Camera;

/// Largest fraction of the picture's width and height that the points cover.
const FILL: f32 = 0.94;

/// Returns the direction at an angle about +Y, 0 for +Z, and an elevation above the horizon.
pub(super) fn elevated(angle_rad: f32, elevation_rad: f32) -> Vec3 {
    let flat = Vec3::new(angle_rad.sin(), 0.0, angle_rad.cos());
    flat * elevation_rad.cos() + Vec3::Y * elevation_rad.sin()
}

/// Returns the up direction for a view direction: -Z for one that is nearly vertical.
pub(super) fn upright(forward: Vec3) -> Vec3 {
    let is_vertical = forward.x.hypot(forward.z) < 1e-3 * forward.y.abs();
    if is_vertical { Vec3::NEG_Z } else { Vec3::Y }
}

/// Returns half the width and half the height of what is seen at a distance of one metre.
fn slopes(fov_y_rad: f32, aspect: f32) -> [f32; 2] {
    let slope = FILL * (0.5 * fov_y_rad).tan();
    [slope * aspect, slope]
}

/// Returns the right and the up axis of a camera with the back axis `back`.
fn axes(back: Vec3, up: Vec3) -> [Vec3; 2] {
    let right = up.cross(back).normalize_or(Vec3::X);
    [right, back.cross(right)]
}

/// Returns the distance from `center` along `back` from which a camera that looks at `center` shows
/// all points.
pub(super) fn distance(
    points: &[Vec3],
    center: Vec3,
    back: Vec3,
    fov_y_rad: f32,
    aspect: f32,
) -> f32 {
    let [right, up] = axes(back, upright(-back));
    let [wide, high] = slopes(fov_y_rad, aspect);
    let needed = |point: &Vec3| {
        let to = *point - center;
        to.dot(back) + (to.dot(right).abs() / wide).max(to.dot(up).abs() / high)
    };
    points.iter().map(needed).fold(0.0, f32::max)
}

/// Returns the nearest camera that looks along -`back` and shows all points, in the middle of the
/// picture.
///
/// For a point at `(x, z)` along the right and back axes, the right edge of the picture requires
/// `x + slope z <= eye.x + slope eye.z`, and the left edge `-x + slope z <= -eye.x + slope eye.z`.
/// The largest left-hand sides determine both coordinates of the eye.
pub(super) fn fit(points: &[Vec3], back: Vec3, up: Vec3, fov_y_rad: f32, aspect: f32) -> Camera {
    let [right, up] = axes(back, up);
    let [wide, high] = slopes(fov_y_rad, aspect);
    let edges = |axis: Vec3, slope: f32| {
        let most = |sign: f32| {
            points.iter().map(|p| sign * p.dot(axis) + slope * p.dot(back)).fold(f32::MIN, f32::max)
        };
        [most(1.0), most(-1.0)]
    };
    let low = points.iter().copied().reduce(Vec3::min).unwrap_or_default();
    let high_point = points.iter().copied().reduce(Vec3::max).unwrap_or_default();
    let diagonal = (high_point - low).length().max(0.1);
    let middle = 0.5 * (low + high_point);
    let [to_right, to_left] = edges(right, wide);
    let [to_top, to_bottom] = edges(up, high);
    let along = ((to_right + to_left) / (2.0 * wide)).max((to_top + to_bottom) / (2.0 * high));
    let nearest = points.iter().map(|p| p.dot(back)).fold(f32::MIN, f32::max);
    let along = along.max(nearest + 0.05 * diagonal);
    let eye =
        right * (0.5 * (to_right - to_left)) + up * (0.5 * (to_top - to_bottom)) + back * along;
    let distance = (eye - middle).dot(back);
    Camera {
        eye: eye.to_array(),
        target: (eye - back * distance).to_array(),
        up: up.to_array(),
        fov_y_rad,
        near: 0.01 * distance,
        far: 50.0 * (distance + diagonal),
    }
}
