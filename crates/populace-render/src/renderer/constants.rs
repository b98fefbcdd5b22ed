//! The constants of a picture, and the spheres around what it shows.

use glam::{Mat4, Vec3};
use populace_device::Instance;
use populace_device::layout::Float4;

use crate::batch::ModelInfo;
use crate::layout::Frame;
use crate::sun::{Sphere, SunView};
use crate::{Ambient, Camera, Scene};

/// Binary logarithm of 20: at the distance of visibility, haze leaves 5 % of a contrast.
const CONTRAST_BITS: f32 = 4.321_928;

/// Returns the bounding sphere of an instance in world space, or `None` if it is not finite.
pub(super) fn bounding_sphere(info: &ModelInfo, instance: &Instance<'_>) -> Option<Sphere> {
    let (center, radius) = info.sphere;
    let world = &instance.world_from_model;
    let column = |c: usize| Vec3::from(world.rows.map(|row| row[c])).length();
    let radius = radius * column(0).max(column(1)).max(column(2));
    let center = Vec3::from(world.transform_point(center.to_array())) + Vec3::from(instance.moved);
    let is_floor = info.is_floor;
    (center.is_finite() && radius.is_finite()).then_some(Sphere { center, radius, is_floor })
}

/// Returns width and height of a picture in pixels.
pub(super) fn sides(size: [u32; 2]) -> [f32; 2] {
    #[expect(clippy::cast_precision_loss, reason = "no picture is 2^24 pixels wide")]
    size.map(|side| side as f32)
}

/// Returns the size of a pixel in metres, at a distance of one metre from the eye.
pub(super) fn pixel_m(clip_from_world: Mat4, size: [u32; 2]) -> f32 {
    let [_, height] = sides(size);
    2.0 / (clip_from_world.row(1).truncate().length() * height)
}

/// Returns the constants of a picture.
pub(super) fn frame(
    camera: &Camera,
    scene: &Scene,
    clip_from_world: Mat4,
    sun: Option<SunView>,
    size: [u32; 2],
) -> Frame {
    let color = |[r, g, b]: [f32; 3]| Float4([r, g, b, 0.0]);
    let with = |[x, y, z]: [f32; 3], w| Float4([x, y, z, w]);
    let Ambient { sky: up, side, ground: down, .. } = scene.ambient;
    let to_sun = Vec3::from(scene.sun.to_sun).normalize().to_array();
    let pixel_m = pixel_m(clip_from_world, size);
    let [wide, high] = sides(size);
    Frame {
        clip_from_world: clip_from_world.into(),
        picture: Float4([wide, high, wide / (wide + high), high / (wide + high)]),
        world_from_clip: clip_from_world.inverse().into(),
        shadow_from_world: sun.map_or(Mat4::IDENTITY, |s| s.shadow_from_world).into(),
        eye: with(camera.eye, camera.far),
        to_sun: with(to_sun, sun.map_or(0.0, |s| s.texel_m)),
        sun_color: color(scene.sun.color),
        ambient_base: with(side, scene.ground.map_or(0.0, |_| scene.contact_shadows)),
        ambient_slope: with([0, 1, 2].map(|c| 0.5 * (up[c] - down[c])), scene.reflections),
        ambient_bow: color([0, 1, 2].map(|c| 0.5 * (up[c] + down[c]) - side[c])),
        ambient_glow: with(scene.ambient.glow, scene.floor_m),
        zenith_color: color(scene.sky.zenith),
        horizon_color: with(scene.sky.horizon, CONTRAST_BITS / scene.sky.visibility_m),
        glow_color: with(scene.sky.glow, f32::from(u8::from(scene.sky.shows_sun))),
        tone: Float4(scene.highlights.curve()),
        ground_color: scene.ground.map_or(with([0.0; 3], 0.0), |g| with(g.color, pixel_m)),
        line_color: scene.ground.map_or(with([0.0; 3], 0.0), |g| with(g.line_color, g.height_m)),
    }
}
