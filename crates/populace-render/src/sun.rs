//! Projection of the shadow map.

use glam::{Mat3, Mat4, Vec3};

/// Bounding sphere of an instance at rest, in world space, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sphere {
    pub(crate) center: Vec3,
    pub(crate) radius: f32,
    /// True for a floor: see [`ModelInfo::is_floor`](crate::batch::ModelInfo::is_floor).
    pub(crate) is_floor: bool,
}

/// Projection of the shadow map, and the size of its texels in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SunView {
    pub(crate) shadow_from_world: Mat4,
    pub(crate) texel_m: f32,
}

/// Growth of the bounding sphere that covers a moving member, relative to its rest pose.
const MOTION: f32 = 1.3;
/// Distance outside of the picture, in radii, up to which a member can cast a shadow into it.
const SHADOW_REACH: f32 = 4.0;
/// Distance at which shadows end, relative to that of the nearest member. Farther shadows are too
/// small to be missed.
const DISTANCE_RATIO: f32 = 8.0;
/// Lower bound of the distance at which shadows end, in radii of the largest member.
const DISTANCE_RADII: f32 = 60.0;
/// Size of the texels up to which floors widen the map: in metres, and in pixels at the nearest
/// member. Shadows of people are sharp enough, and no plan of a place ends before its walls' shadows.
const FLOOR_TEXEL_M: f32 = 0.03;
const FLOOR_TEXEL_PX: f32 = 1.25;

impl SunView {
    /// Returns the projection that covers the members in or near the picture, or `None` if there
    /// are none. Pixels measure `pixel_m` at a distance of one metre from the eye. `to_sun` is a
    /// unit vector, `map_size` the side of the map in texels.
    ///
    /// The covered size is rounded up to steps, and the centre to whole texels, so that shadow
    /// edges do not crawl while the crowd moves. Of a floor that is far wider than the crowd, only
    /// the part around the others is covered.
    pub(crate) fn over(
        spheres: &[Sphere],
        (eye, pixel_m): (Vec3, f32),
        clip_from_world: Mat4,
        to_sun: Vec3,
        map_size: u16,
    ) -> Option<Self> {
        let planes = side_planes(clip_from_world);
        let near_picture = |sphere: &&Sphere| {
            planes.iter().all(|&(normal, offset)| {
                normal.dot(sphere.center) + offset > -(1.0 + SHADOW_REACH) * sphere.radius
            })
        };
        let shown = spheres.iter().filter(near_picture);
        let (floors, bodies): (Vec<&Sphere>, Vec<_>) = shown.partition(|sphere| sphere.is_floor);
        let side = if to_sun.y.abs() > 0.99 { Vec3::Z } else { Vec3::Y };
        let right = side.cross(to_sun).normalize();
        let sun_from_world = Mat3::from_cols(right, to_sun.cross(right), to_sun).transpose();
        let (bodies, nearest) = within_reach(bodies, eye);
        let bodies = extent(&bodies, sun_from_world);
        let floors = extent(&floors, sun_from_world);
        let texel_m = FLOOR_TEXEL_M.max(FLOOR_TEXEL_PX * pixel_m * nearest);
        let (low, high) = match (bodies, floors) {
            (Some(bodies), Some(floors)) => widened(bodies, floors, texel_m * f32::from(map_size)),
            (bodies, floors) => bodies.or(floors)?,
        };
        let half = (0.5 * (high - low)).max(Vec3::splat(1e-3));
        // Steps by a factor of 2^(1/4).
        let stepped = |x: f32| ((4.0 * x.log2()).ceil() / 4.0).exp2();
        let half = Vec3::new(stepped(half.x), stepped(half.y), half.z);
        let texel = 2.0 * half / f32::from(map_size);
        let center = 0.5 * (low + high);
        let center = Vec3::new(
            (center.x / texel.x).round() * texel.x,
            (center.y / texel.y).round() * texel.y,
            center.z,
        );
        // Depth grows away from the sun.
        let scale = Mat4::from_scale(Vec3::new(1.0 / half.x, 1.0 / half.y, -1.0 / half.z));
        let shadow_from_world =
            scale * Mat4::from_translation(-center) * Mat4::from_mat3(sun_from_world);
        Some(Self { shadow_from_world, texel_m: texel.x.max(texel.y) })
            .filter(|view| view.shadow_from_world.is_finite())
    }
}

impl SunView {
    /// Returns whether a moving member within a sphere at rest throws a shadow onto the map.
    pub(crate) fn covers(&self, sphere: &Sphere) -> bool {
        let at = self.shadow_from_world.transform_point3(sphere.center);
        let radius = |row: usize| {
            MOTION * sphere.radius * self.shadow_from_world.row(row).truncate().length()
        };
        at.x.abs() <= 1.0 + radius(0) && at.y.abs() <= 1.0 + radius(1)
    }
}

/// Returns the members whose shadows are not too far away to be missed, and the distance of the
/// nearest one in metres.
fn within_reach(shown: Vec<&Sphere>, eye: Vec3) -> (Vec<&Sphere>, f32) {
    let distance = |sphere: &Sphere| (sphere.center.distance(eye) - sphere.radius).max(0.0);
    let nearest = shown.iter().map(|sphere| distance(sphere)).fold(f32::INFINITY, f32::min);
    let largest = shown.iter().map(|sphere| sphere.radius).fold(0.0, f32::max);
    let limit = (DISTANCE_RATIO * nearest).max(DISTANCE_RADII * largest);
    (shown.into_iter().filter(|sphere| distance(sphere) <= limit).collect(), nearest)
}

/// Returns the corners of the box around moving members, as the sun sees them.
fn extent(spheres: &[&Sphere], sun_from_world: Mat3) -> Option<(Vec3, Vec3)> {
    let corners = |sphere: &&Sphere| {
        let (center, half) = (sun_from_world * sphere.center, Vec3::splat(MOTION * sphere.radius));
        (center - half, center + half)
    };
    spheres.iter().map(corners).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

/// Returns a box with what lies around it of another, up to a width and a height of `most_m`. It
/// takes in as much of the other as it can.
fn widened(own: (Vec3, Vec3), other: (Vec3, Vec3), most_m: f32) -> (Vec3, Vec3) {
    let (low, high) = (own.0.min(other.0), own.1.max(other.1));
    // Depth takes no texels.
    let most = Vec3::new(most_m, most_m, f32::INFINITY);
    let left_out = (high - low - most).max(Vec3::ZERO);
    let before = (0.5 * (own.0 + own.1 - most) - low).clamp(Vec3::ZERO, left_out);
    (own.0.min(low + before), own.1.max(high - (left_out - before)))
}

/// Returns the planes of the picture's four edges, as inward unit normal and offset.
pub(crate) fn side_planes(clip_from_world: Mat4) -> [(Vec3, f32); 4] {
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

    fn view(spheres: &[Sphere]) -> Option<SunView> {
        let camera = Camera {
            eye: [0.0, 2.0, 10.0],
            target: [0.0, 1.0, 0.0],
            up: [0.0, 1.0, 0.0],
            fov_y_rad: 0.8,
            near: 0.1,
            far: 1000.0,
        };
        seen_by(&camera, spheres)
    }

    /// Returns the projection for a square picture whose side is two thirds of that of the map.
    fn seen_by(camera: &Camera, spheres: &[Sphere]) -> Option<SunView> {
        let clip = camera.clip_from_world(1.0).unwrap();
        let (eye, pixel_m) = (Vec3::from(camera.eye), 2.0 * (0.5 * camera.fov_y_rad).tan() / 667.0);
        SunView::over(spheres, (eye, pixel_m), clip, Vec3::new(0.6, 0.8, 0.0), 1000)
    }

    fn sphere(x: f32, z: f32) -> Sphere {
        Sphere { center: Vec3::new(x, 1.0, z), radius: 1.0, is_floor: false }
    }

    #[test]
    fn visible_members_lie_in_the_map() {
        let seen = view(&[sphere(0.0, 0.0), sphere(2.0, -3.0)]).unwrap();
        for point in
            [Vec3::new(0.0, 1.0, 0.0), Vec3::new(2.0, 2.0, -3.0), Vec3::new(2.0, 1.0, -4.0)]
        {
            let mapped = seen.shadow_from_world.project_point3(point);
            assert!(mapped.abs().max_element() <= 1.0, "{point} is mapped to {mapped}");
        }
        let towards_sun = seen.shadow_from_world.transform_vector3(Vec3::new(0.6, 0.8, 0.0));
        assert!(towards_sun.z < 0.0, "depth must decrease towards the sun");
    }

    #[test]
    fn members_far_outside_the_picture_take_no_texels() {
        let alone = view(&[sphere(0.0, 0.0)]).unwrap();
        assert_eq!(view(&[sphere(0.0, 0.0), sphere(300.0, 0.0)]), Some(alone));
        assert!(view(&[sphere(0.0, 0.0), sphere(3.0, 0.0)]).unwrap().texel_m > alone.texel_m);
    }

    #[test]
    fn floors_take_the_texels_that_people_do_not_need() {
        let people = [sphere(0.0, 0.0), sphere(2.0, -3.0)];
        let over = |radius: f32, is_floor: bool| {
            let floor = Sphere { center: Vec3::ZERO, radius, is_floor };
            view(&[people.as_slice(), &[floor]].concat()).unwrap()
        };
        assert_eq!(over(10.0, true), over(10.0, false), "a small one is covered whole");
        assert!(over(400.0, false).texel_m > 1.0, "a house of this size");
        assert!(over(400.0, true).texel_m < 1.2 * FLOOR_TEXEL_M, "{}", over(400.0, true).texel_m);
        let at = over(400.0, true).shadow_from_world.project_point3(Vec3::new(2.0, 2.0, -3.0));
        assert!(at.truncate().abs().max_element() < 1.0, "{at}");
        // Alone, its walls throw shadows onto it.
        assert!(view(&[Sphere { is_floor: true, ..sphere(0.0, 0.0) }]).is_some());
    }

    /// Somebody stands in a corner of a hall of 80 metres, which fills the picture.
    #[test]
    fn plans_of_places_show_the_shadows_of_all_walls() {
        let camera = Camera {
            eye: [0.0, 170.0, 0.0],
            target: [0.0; 3],
            up: [0.0, 0.0, -1.0],
            fov_y_rad: 0.5,
            near: 1.0,
            far: 1000.0,
        };
        let radius = 40.0 * std::f32::consts::SQRT_2;
        let hall = Sphere { center: Vec3::ZERO, radius, is_floor: true };
        let seen = seen_by(&camera, &[hall, sphere(-39.0, 39.0)]).unwrap();
        for (x, z) in [(-40.0, -40.0), (40.0, -40.0), (40.0, 40.0), (-40.0, 40.0)] {
            for y in [0.0, 3.0] {
                let at = seen.shadow_from_world.project_point3(Vec3::new(x, y, z));
                assert!(at.abs().max_element() < 1.0, "{x}, {y}, {z} is mapped to {at}");
            }
        }
        assert!(seen.texel_m < 2.0 * 80.0 / 667.0, "{}", seen.texel_m);
    }

    #[test]
    fn there_is_no_map_without_visible_members() {
        assert_eq!(view(&[]), None);
        assert_eq!(view(&[sphere(300.0, 0.0)]), None);
    }
}
