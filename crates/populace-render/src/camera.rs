//! Where a picture is taken from.

use glam::camera::rh;
use glam::{Mat4, Vec3};

use crate::Error;

/// A perspective camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Its place in world space.
    pub eye: [f32; 3],
    /// What is in the middle of the picture.
    pub target: [f32; 3],
    /// What is up in the picture, roughly.
    pub up: [f32; 3],
    /// From the picture's lower edge to its upper one.
    pub fov_y_rad: f32,
    /// Metres; nearer things are cut off.
    pub near: f32,
    /// Metres; farther things are cut off, after haze from a tenth of it onwards has hidden them.
    pub far: f32,
}

impl Default for Camera {
    /// A person of 1.8 m at the origin, from the front.
    fn default() -> Self {
        Self::framing([-0.5, 0.0, -0.5], [0.5, 1.8, 0.5], 16.0 / 9.0)
    }
}

/// What the box may take of the picture's width and height.
const FILL: f32 = 0.94;

impl Camera {
    /// Frames what stands in the box from `low` to `high`, seen from the front (+Z) and a little above, with the
    /// horizon in the picture. `aspect` is the picture's width over its height.
    ///
    /// A single character is seen almost level; the deeper the crowd, the more from above, so that the rows behind
    /// show. A box or aspect that is not finite is taken as a box of one metre or a square picture.
    #[must_use]
    pub fn framing(low: [f32; 3], high: [f32; 3], aspect: f32) -> Self {
        let (mut low, mut high) = (Vec3::from(low), Vec3::from(high));
        if !(low.is_finite() && high.is_finite()) {
            (low, high) = (Vec3::ZERO, Vec3::ONE);
        }
        let aspect = if aspect.is_finite() && aspect > 0.0 {
            aspect
        } else {
            1.0
        };
        let size = (high - low).abs().max(Vec3::splat(0.01));
        let middle = 0.5 * (low + high);
        // From 0 for one character to 1 for many rows.
        let crowd = (size.z / (12.0 * size.y)).min(1.0);
        let fov_y_rad = 0.6 + 0.2 * crowd;
        let back = Vec3::new(0.0, 0.06 + 0.24 * crowd, 1.0).normalize();
        let up = back.cross(Vec3::X);
        // How fast the part of the picture that may be filled widens with distance.
        let widening_y = (0.5 * fov_y_rad).tan() * FILL;
        let widening_x = widening_y * aspect;
        // For each corner: how far from the middle the camera must be to have it within the left and right edges, and
        // where the upper and lower edges would cut the plane through the middle.
        let (mut distance, mut behind) = (0.0_f32, 0.0_f32);
        let (mut upper, mut lower) = (f32::NEG_INFINITY, f32::INFINITY);
        for corner in corners(Vec3::ZERO, 0.5 * size) {
            let (depth, height) = (corner.dot(back), corner.dot(up));
            distance = distance.max(depth + corner.x.abs() / widening_x);
            behind = behind.max(-depth);
            upper = upper.max(height + depth * widening_y);
            lower = lower.min(height - depth * widening_y);
        }
        distance = distance.max(0.5 * (upper - lower) / widening_y);
        let target = middle + up * balanced_height(0.5 * size, back, up, distance);
        Self {
            eye: (target + back * distance).to_array(),
            target: target.to_array(),
            up: [0.0, 1.0, 0.0],
            fov_y_rad,
            near: 0.02 * distance,
            far: 12.0 * (distance + behind),
        }
    }

    /// The projection after the view, for a picture of this width over height.
    pub(crate) fn clip_from_world(&self, aspect: f32) -> Result<Mat4, Error> {
        let [eye, target, up] = [self.eye, self.target, self.up].map(Vec3::from);
        let bad = |what| Err(Error::BadCamera { what });
        if !(eye.is_finite() && target.is_finite() && up.is_finite()) {
            return bad("has a place or direction that is not finite");
        }
        if !(self.fov_y_rad > 0.0 && self.fov_y_rad < std::f32::consts::PI) {
            return bad("needs a field of view between 0 and pi");
        }
        if !(self.near > 0.0 && self.far > self.near && self.far.is_finite()) {
            return bad("needs a near plane above 0 and a far plane beyond it");
        }
        let forward = (target - eye).try_normalize();
        if forward.is_none_or(|f| f.cross(up).try_normalize().is_none()) {
            return bad("needs a target apart from its eye, and an up that does not point along its view");
        }
        let view = rh::view::look_at_mat4(eye, target, up);
        let matrix = rh::proj::opengl::perspective(self.fov_y_rad, aspect, self.near, self.far) * view;
        if !matrix.is_finite() || matrix.determinant() == 0.0 {
            return bad("is too far off for single precision");
        }
        Ok(matrix)
    }
}

/// How far above the box's middle the camera must look, from this distance, to see as much of the picture left above
/// the box as below.
fn balanced_height(half: Vec3, back: Vec3, up: Vec3, distance: f32) -> f32 {
    let (mut low, mut high) = (-half.length(), half.length());
    // Single precision has no more bits than this to settle.
    for _ in 0..24 {
        let height = 0.5 * (low + high);
        let (mut above, mut below) = (0.0_f32, 0.0_f32);
        for corner in corners(Vec3::ZERO, half) {
            let at = (corner.dot(up) - height) / (distance - corner.dot(back));
            (above, below) = (above.max(at), below.max(-at));
        }
        if above > below {
            low = height
        } else {
            high = height
        }
    }
    0.5 * (low + high)
}

fn corners(middle: Vec3, half: Vec3) -> impl Iterator<Item = Vec3> {
    (0..8).map(move |bits: u32| {
        let sign = |bit: u32| if bits & bit == 0 { -1.0 } else { 1.0 };
        middle + half * Vec3::new(sign(1), sign(2), sign(4))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn framing_shows_the_whole_box_and_the_horizon() {
        for (low, high) in [
            ([-0.5, 0.0, -0.5], [0.5, 1.8, 0.5]),
            ([-30.0, 0.0, -60.0], [30.0, 2.0, 0.0]),
            ([100.0, 0.0, -3.0], [400.0, 2.0, 3.0]),
            ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
        ] {
            for aspect in [0.3, 1.0, 16.0 / 9.0, 4.0] {
                let camera = Camera::framing(low, high, aspect);
                let clip = camera.clip_from_world(aspect).unwrap();
                let (middle, half) = (
                    0.5 * (Vec3::from(low) + Vec3::from(high)),
                    0.5 * (Vec3::from(high) - Vec3::from(low)),
                );
                let mut widest = 0.0_f32;
                let (mut top, mut bottom) = (-1.0_f32, 1.0_f32);
                for corner in corners(middle, half) {
                    let at = clip.project_point3(corner);
                    (top, bottom) = (top.max(at.y), bottom.min(at.y));
                    let at = at.abs();
                    assert!(
                        at.max_element() < 1.0,
                        "{corner} of {low:?} {high:?} is at {at} at aspect {aspect}"
                    );
                    widest = widest.max(at.x).max(at.y);
                }
                assert!(
                    widest > 0.8 || low == high,
                    "{low:?} {high:?} take only {widest} at aspect {aspect}"
                );
                assert!(
                    (top + bottom).abs() < 0.01 || low == high,
                    "{low:?} {high:?} stand from {bottom} to {top}"
                );
                let horizon = clip.project_point3(Vec3::from(camera.eye) + Vec3::new(0.0, 0.0, -1e5));
                assert!(
                    horizon.y > 0.0 && horizon.y < 0.95,
                    "the horizon is at {}",
                    horizon.y
                );
            }
        }
    }

    #[test]
    fn framing_takes_nonsense() {
        for aspect in [f32::NAN, 0.0, -1.0, f32::INFINITY] {
            assert!(
                Camera::framing([f32::NAN; 3], [1.0; 3], aspect)
                    .clip_from_world(1.0)
                    .is_ok()
            );
        }
    }
}
