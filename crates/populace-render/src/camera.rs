//! The camera, and its automatic framing of a crowd.

use glam::camera::rh;
use glam::{Mat4, Vec3};

use populace_device::{VIEW_PLANES, View};

use crate::sun::side_planes;
use crate::{Error, Scene};

/// A perspective camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position in world space, in metres.
    pub eye: [f32; 3],
    /// Point in world space at the centre of the picture; must differ from `eye`.
    pub target: [f32; 3],
    /// Approximate up direction of the picture in world space, of any length but zero; must not be
    /// parallel to the view direction.
    pub up: [f32; 3],
    /// Vertical field of view in radians, between 0 and pi.
    pub fov_y_rad: f32,
    /// Distance of the near plane in metres, above 0. Nearer geometry is clipped.
    pub near: f32,
    /// Distance of the far plane in metres, above `near`. Farther geometry is clipped. Haze starts
    /// at a tenth of this distance and hides everything before the far plane.
    pub far: f32,
}

impl Default for Camera {
    /// Frames a person of 1.8 m at the origin, seen from the front.
    fn default() -> Self {
        Self::framing([[-0.5, 0.0, 0.0], [0.5, 1.8, 0.0]], 16.0 / 9.0)
    }
}

/// Largest fraction of the picture's width and height that the framed points cover.
const FILL: f32 = 0.94;

impl Camera {
    /// Returns a camera that shows all `points` (feet and heads of a crowd, corners of a box) from
    /// the front (+Z) and slightly above, with the horizon in the picture. `aspect` is the width of
    /// the picture divided by its height.
    ///
    /// A single character is seen almost level. The elevation grows with the depth of the crowd, so
    /// that the rows at the back stay visible. Non-finite points are ignored. Without any finite
    /// point, a box of one metre is framed. An aspect that is not finite and positive counts as 1.
    #[must_use]
    pub fn framing(points: impl IntoIterator<Item = [f32; 3]>, aspect: f32) -> Self {
        let mut points: Vec<Vec3> =
            points.into_iter().map(Vec3::from).filter(|p| p.is_finite()).collect();
        if points.is_empty() {
            points = vec![Vec3::ZERO, Vec3::ONE];
        }
        let aspect = if aspect.is_finite() && aspect > 0.0 { aspect } else { 1.0 };
        let low = points.iter().copied().reduce(Vec3::min).unwrap_or_default();
        let high = points.iter().copied().reduce(Vec3::max).unwrap_or_default();
        let size = (high - low).max(Vec3::splat(0.01));
        // 0 for one character, 1 for many rows.
        let depth = (size.z / (12.0 * size.y)).min(1.0);
        let fov_y_rad = 0.6 + 0.2 * depth;
        let back = Vec3::new(0.0, 0.06 + 0.24 * depth, 1.0).normalize();
        let up = back.cross(Vec3::X);
        let eye = fit_eye(
            &points,
            [Vec3::X, up, back],
            (0.5 * fov_y_rad).tan() * FILL,
            aspect,
            size.length(),
        );
        let distance = (eye - 0.5 * (low + high)).dot(back);
        Self {
            eye: eye.to_array(),
            target: (eye - back * distance).to_array(),
            up: [0.0, 1.0, 0.0],
            fov_y_rad,
            near: 0.01 * distance,
            far: 12.0 * (distance + size.length()),
        }
    }

    /// Returns the view of a picture of `size` pixels (width, height), for a crowd to choose its
    /// members' levels of detail: the coarsest that are less than `error_px` pixels off.
    ///
    /// # Errors
    ///
    /// [`Error::BadCamera`] for invalid settings.
    pub fn view(&self, size: [u32; 2], scene: &Scene, error_px: f32) -> Result<View, Error> {
        #[expect(clippy::cast_precision_loss, reason = "no picture is 2^24 pixels wide")]
        let [width, height] = size.map(|side| side.max(1) as f32);
        let clip_from_world = self.clip_from_world(width / height)?;
        let [sides @ .., near] = &mut [[0.0; 4]; VIEW_PLANES];
        for (plane, (normal, offset)) in sides.iter_mut().zip(side_planes(clip_from_world)) {
            *plane = normal.extend(offset).to_array();
        }
        let [eye, target] = [self.eye, self.target].map(Vec3::from);
        let forward = (target - eye).normalize();
        *near = forward.extend(-forward.dot(eye)).to_array();
        let to_sun = Vec3::from(scene.sun.to_sun).try_normalize().map(|to_sun| to_sun.to_array());
        Ok(View {
            eye: self.eye,
            planes: [sides[0], sides[1], sides[2], sides[3], *near],
            pixels_per_metre: 0.5 * height / (0.5 * self.fov_y_rad).tan(),
            to_sun: to_sun.filter(|_| scene.sun.casts_shadows),
            error_px,
        })
    }

    /// Returns where a point of the world is in a picture of `size` pixels (width, height), from
    /// the top left corner. `None` for a point that is not before the camera, and for invalid
    /// settings.
    #[must_use]
    pub fn project(&self, point: [f32; 3], size: [u32; 2]) -> Option<[f32; 2]> {
        #[expect(clippy::cast_precision_loss, reason = "no picture is 2^24 pixels wide")]
        let [width, height] = size.map(|side| side as f32);
        let clip = self.clip_from_world(width / height).ok()? * Vec3::from(point).extend(1.0);
        let [x, y] = [clip.x / clip.w, clip.y / clip.w];
        (clip.w > self.near).then_some([0.5 * (1.0 + x) * width, 0.5 * (1.0 - y) * height])
    }

    /// Returns the distance of a point of the world along the view direction, in metres; less than
    /// 0 behind the camera.
    #[must_use]
    pub fn depth_m(&self, point: [f32; 3]) -> f32 {
        let [eye, target] = [self.eye, self.target].map(Vec3::from);
        (Vec3::from(point) - eye).dot((target - eye).normalize_or_zero())
    }

    /// Returns the view-projection matrix for a picture of width over height `aspect`.
    pub(crate) fn clip_from_world(&self, aspect: f32) -> Result<Mat4, Error> {
        let [eye, target, up] = [self.eye, self.target, self.up].map(Vec3::from);
        let bad = |what| Err(Error::BadCamera { what });
        if !(eye.is_finite() && target.is_finite() && up.is_finite()) {
            return bad("must have a finite eye, target and up vector");
        }
        if !(self.fov_y_rad > 0.0 && self.fov_y_rad < std::f32::consts::PI) {
            return bad("must have a field of view between 0 and pi radians");
        }
        if !(self.near > 0.0 && self.far > self.near && self.far.is_finite()) {
            return bad("must have a near plane above 0 and a finite far plane beyond it");
        }
        let forward = (target - eye).try_normalize();
        if forward.is_none_or(|f| f.cross(up).try_normalize().is_none()) {
            return bad(
                "must have a target that differs from its eye, and an up vector that is not \
                 parallel to its view direction",
            );
        }
        let view = rh::view::look_at_mat4(eye, target, up);
        let matrix =
            rh::proj::opengl::perspective(self.fov_y_rad, aspect, self.near, self.far) * view;
        if !matrix.is_finite() || matrix.determinant() == 0.0 {
            return bad(
                "has no finite, invertible view-projection matrix in single precision; move it \
                 closer to the origin or reduce its far plane",
            );
        }
        Ok(matrix)
    }
}

/// Returns the position nearest to `points` from which all of them are in view.
///
/// `[right, up, back]` are the camera's axes. `slope` is the half height of the usable part of the
/// picture per metre of distance. `diagonal` is the size of the points' bounding box in metres; the
/// eye stays a twentieth of it before the nearest point. Points are centred horizontally. Of the
/// vertical margin, 85 % goes above them, since sky looks better than bare ground before the first
/// row.
///
/// For a point at `(x, z)` along the right and back axes, the right edge of the picture requires
/// `x + slope z <= eye.x + slope eye.z`, and the left edge `-x + slope z <= -eye.x + slope eye.z`.
/// The largest left-hand sides determine both coordinates of the eye.
fn fit_eye(
    points: &[Vec3],
    [right, up, back]: [Vec3; 3],
    slope: f32,
    aspect: f32,
    diagonal: f32,
) -> Vec3 {
    let edges = |axis: Vec3, slope: f32| {
        let most = |sign: f32| {
            points.iter().map(|p| sign * p.dot(axis) + slope * p.dot(back)).fold(f32::MIN, f32::max)
        };
        (most(1.0), most(-1.0))
    };
    let (to_right, to_left) = edges(right, slope * aspect);
    let (to_top, to_bottom) = edges(up, slope);
    let nearest = points.iter().map(|p| p.dot(back)).fold(f32::MIN, f32::max);
    let distance = ((to_right + to_left) / (2.0 * slope * aspect))
        .max((to_top + to_bottom) / (2.0 * slope))
        .max(nearest + 0.05 * diagonal);
    let spare = slope * distance - 0.5 * (to_top + to_bottom);
    let height = 0.5 * (to_top - to_bottom) + 0.7 * spare;
    right * (0.5 * (to_right - to_left)) + up * height + back * distance
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_projected_from_the_top_left_corner() {
        let camera = Camera {
            eye: [0.0, 1.0, 5.0],
            target: [0.0, 1.0, 0.0],
            ..Camera::framing([[0.0; 3]], 2.0)
        };
        let size = [200, 100];
        let near = |found: Option<[f32; 2]>, wanted: [f32; 2]| {
            let found = found.expect("a point before the camera");
            let off = (found[0] - wanted[0]).hypot(found[1] - wanted[1]);
            assert!(off < 0.01, "{found:?} is not {wanted:?}");
        };
        near(camera.project([0.0, 1.0, 0.0], size), [100.0, 50.0]);
        // The upper edge at five metres.
        let high = 5.0 * (0.5 * camera.fov_y_rad).tan();
        near(camera.project([0.0, 1.0 + high, 0.0], size), [100.0, 0.0]);
        near(camera.project([2.0 * high, 1.0, 0.0], size), [200.0, 50.0]);
        assert_eq!(camera.project([0.0, 1.0, 6.0], size), None);
        assert_eq!(camera.project([f32::NAN; 3], size), None);
    }

    #[test]
    fn framing_shows_all_points_and_the_horizon() {
        let boxes = [
            ([-0.5, 0.0, -0.5], [0.5, 1.8, 0.5]),
            ([-30.0, 0.0, -60.0], [30.0, 2.0, 0.0]),
            ([100.0, 0.0, -3.0], [400.0, 2.0, 3.0]),
            ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
        ];
        for (low, high) in boxes.map(|(low, high)| (Vec3::from(low), Vec3::from(high))) {
            let corners = (0..8u32).map(|bits| {
                let of = |axis: usize| {
                    if bits >> axis & 1 == 0 { low[axis] } else { high[axis] }
                };
                [of(0), of(1), of(2)]
            });
            for aspect in [0.3, 1.0, 16.0 / 9.0, 4.0] {
                let camera = Camera::framing(corners.clone(), aspect);
                let clip = camera.clip_from_world(aspect).unwrap();
                let seen: Vec<Vec3> =
                    corners.clone().map(|c| clip.project_point3(Vec3::from(c))).collect();
                let least = seen.iter().copied().reduce(Vec3::min).unwrap();
                let most = seen.iter().copied().reduce(Vec3::max).unwrap();
                assert!(
                    least.min_element() > -1.0 && most.max_element() < 1.0,
                    "{low} {high}: {least} {most}"
                );
                if low != high {
                    let fill = (most.x - least.x).max(most.y - least.y) / 2.0;
                    assert!(
                        (0.85..0.95).contains(&fill),
                        "{low} {high} take {fill} at aspect {aspect}"
                    );
                }
                let horizon =
                    clip.project_point3(Vec3::from(camera.eye) + Vec3::new(0.0, 0.0, -1e5)).y;
                assert!((0.0..0.95).contains(&horizon), "the horizon is at {horizon}");
            }
        }
    }

    #[test]
    fn framing_accepts_non_finite_points_and_aspects() {
        for aspect in [f32::NAN, 0.0, -1.0, f32::INFINITY] {
            assert!(
                Camera::framing([[f32::NAN; 3], [1.0; 3]], aspect).clip_from_world(1.0).is_ok()
            );
            assert!(Camera::framing([], aspect).clip_from_world(1.0).is_ok());
        }
    }
}
