//! What the sun's depth map covers.

use glam::{Mat3, Mat4, Vec3};

/// A ball around a member, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ball {
    pub(crate) middle: Vec3,
    pub(crate) radius: f32,
}

/// The depth map's projection, and the size of its texels on the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SunView {
    pub(crate) shadow_from_world: Mat4,
    pub(crate) texel_m: f32,
}

/// Members reach out of the ball they fill at rest.
const MOTION: f32 = 1.3;
/// A member may stand out of the picture by this many radii and still throw its shadow into it.
const SHADOW_REACH: f32 = 4.0;
/// Shadows end this many times as far away as the nearest member, where one is too small to be
/// missed.
const DISTANCE_RATIO: f32 = 8.0;
/// And never nearer than this many radii.
const DISTANCE_RADII: f32 = 60.0;

impl SunView {
    /// Covers the members in or near the picture that `clip_from_world` shows; `None` where there
    /// are none.
    ///
    /// The size is rounded up and the place to whole texels, so that edges do not crawl while a
    /// crowd moves.
    pub(crate) fn over(
        balls: &[Ball],
        eye: Vec3,
        clip_from_world: Mat4,
        to_sun: Vec3,
        map_size: u16,
    ) -> Option<Self> {
        let planes = side_planes(clip_from_world);
        let near_picture = |ball: &&Ball| {
            planes.iter().all(|&(normal, offset)| {
                normal.dot(ball.middle) + offset > -(1.0 + SHADOW_REACH) * ball.radius
            })
        };
        let shown: Vec<&Ball> = balls.iter().filter(near_picture).collect();
        let distance = |ball: &Ball| (ball.middle.distance(eye) - ball.radius).max(0.0);
        let nearest = shown.iter().map(|ball| distance(ball)).fold(f32::INFINITY, f32::min);
        let largest = shown.iter().map(|ball| ball.radius).fold(0.0, f32::max);
        let limit = (DISTANCE_RATIO * nearest).max(DISTANCE_RADII * largest);
        let side = if to_sun.y.abs() > 0.99 { Vec3::Z } else { Vec3::Y };
        let right = side.cross(to_sun).normalize();
        let sun_from_world = Mat3::from_cols(right, to_sun.cross(right), to_sun).transpose();
        let (low, high) = shown
            .into_iter()
            .filter(|ball| distance(ball) <= limit)
            .map(|ball| (sun_from_world * ball.middle, Vec3::splat(MOTION * ball.radius)))
            .map(|(middle, half)| (middle - half, middle + half))
            .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))?;
        let half = (0.5 * (high - low)).max(Vec3::splat(1e-3));
        // Steps of a quarter of a power of two.
        let stepped = |x: f32| ((4.0 * x.log2()).ceil() / 4.0).exp2();
        let half = Vec3::new(stepped(half.x), stepped(half.y), half.z);
        let texel = 2.0 * half / f32::from(map_size);
        let middle = 0.5 * (low + high);
        let middle = Vec3::new(
            (middle.x / texel.x).round() * texel.x,
            (middle.y / texel.y).round() * texel.y,
            middle.z,
        );
        // Depth grows away from the sun.
        let scale = Mat4::from_scale(Vec3::new(1.0 / half.x, 1.0 / half.y, -1.0 / half.z));
        let shadow_from_world =
            scale * Mat4::from_translation(-middle) * Mat4::from_mat3(sun_from_world);
        Some(Self { shadow_from_world, texel_m: texel.x.max(texel.y) })
            .filter(|view| view.shadow_from_world.is_finite())
    }
}

/// The planes of the picture's four edges, as inward unit normal and offset.
fn side_planes(clip_from_world: Mat4) -> [(Vec3, f32); 4] {
    let w = clip_from_world.row(3);
    [0, 1]
        .map(|axis| clip_from_world.row(axis))
        .map(|row| [w + row, w - row])
        .as_flattened()
        .try_into()
        .map_or([(Vec3::Y, f32::INFINITY); 4], |rows: [glam::Vec4; 4]| {
            rows.map(|row| {
                let length = row.truncate().length().max(f32::MIN_POSITIVE);
                (row.truncate() / length, row.w / length)
            })
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Camera;

    fn view(balls: &[Ball]) -> Option<SunView> {
        let camera = Camera {
            eye: [0.0, 2.0, 10.0],
            target: [0.0, 1.0, 0.0],
            up: [0.0, 1.0, 0.0],
            fov_y_rad: 0.8,
            near: 0.1,
            far: 1000.0,
        };
        let clip = camera.clip_from_world(1.0).unwrap();
        SunView::over(balls, Vec3::from(camera.eye), clip, Vec3::new(0.6, 0.8, 0.0), 1000)
    }

    fn ball(x: f32, z: f32) -> Ball {
        Ball { middle: Vec3::new(x, 1.0, z), radius: 1.0 }
    }

    #[test]
    fn what_is_shown_lies_in_the_map() {
        let seen = view(&[ball(0.0, 0.0), ball(2.0, -3.0)]).unwrap();
        for middle in
            [Vec3::new(0.0, 1.0, 0.0), Vec3::new(2.0, 2.0, -3.0), Vec3::new(2.0, 1.0, -4.0)]
        {
            let at = seen.shadow_from_world.project_point3(middle);
            assert!(at.abs().max_element() <= 1.0, "{middle} is at {at}");
        }
        let towards_sun = seen.shadow_from_world.transform_vector3(Vec3::new(0.6, 0.8, 0.0));
        assert!(towards_sun.z < 0.0, "nearer to the sun is less deep");
    }

    #[test]
    fn what_is_far_to_the_side_takes_no_texels() {
        let alone = view(&[ball(0.0, 0.0)]).unwrap();
        assert_eq!(view(&[ball(0.0, 0.0), ball(300.0, 0.0)]), Some(alone));
        assert!(view(&[ball(0.0, 0.0), ball(3.0, 0.0)]).unwrap().texel_m > alone.texel_m);
    }

    #[test]
    fn nobody_needs_no_map() {
        assert_eq!(view(&[]), None);
        assert_eq!(view(&[ball(300.0, 0.0)]), None);
    }
}
