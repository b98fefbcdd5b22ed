//! A renderer whose pixels can be computed by hand. Ambient light is 1 unless a test changes it, a
//! metre at z = 0 is 32 pixels, and the world's origin is at the centre.

use populace_character::{Character, Image};
use populace_model::Affine;
use populace_render::{
    Ambient, Camera, CharacterHandle, Error, Highlights, Instance, Renderer, Scene, Sky, Sun,
};

use crate::fixture::palette;

/// Side of the picture in pixels.
pub(crate) const SIZE: u32 = 128;
/// Colour of the background.
pub(crate) const NOTHING: [u8; 3] = [0, 0, 0];

/// A renderer and its scene.
pub(crate) struct Rig {
    pub(crate) renderer: Renderer,
    pub(crate) scene: Scene,
}

impl Rig {
    pub(crate) fn new() -> Self {
        Self { renderer: Renderer::headless([SIZE; 2]).unwrap(), scene: flat_scene() }
    }

    pub(crate) fn add(&mut self, character: &Character) -> CharacterHandle {
        self.renderer.add_character(character, &|_| false).unwrap()
    }

    /// Uploads page 0.
    pub(crate) fn upload(&mut self, entries: &[Affine]) {
        self.renderer.upload_page(0, &palette(entries)).unwrap();
    }

    pub(crate) fn try_draw(&mut self, instances: &[Instance]) -> Result<Picture, Error> {
        self.renderer.draw(&self.scene, instances)?;
        Ok(Picture(self.renderer.read_image()?))
    }

    pub(crate) fn draw(&mut self, instances: &[Instance]) -> Picture {
        self.try_draw(instances).unwrap()
    }
}

/// Returns a scene with uniform ambient light and a black background, seen from 10 m in front.
pub(crate) fn flat_scene() -> Scene {
    Scene {
        camera: Camera {
            eye: [0.0, 0.0, 10.0],
            target: [0.0; 3],
            up: [0.0, 1.0, 0.0],
            fov_y_rad: 2.0 * 0.2_f32.atan(),
            near: 0.1,
            far: 200.0,
        },
        sun: Sun { to_sun: [0.0, 0.0, 1.0], color: [0.0; 3], casts_shadows: false },
        ambient: Ambient { sky: [1.0; 3], ground: [1.0; 3] },
        ground: None,
        sky: Sky { zenith: [0.0; 3], horizon: [0.0; 3] },
        highlights: Highlights::Clipped,
    }
}

/// Returns an instance without tint.
pub(crate) fn instance(
    character: CharacterHandle,
    world_from_model: Affine,
    palette_first: u32,
) -> Instance {
    Instance { character, world_from_model, moved: [0.0; 3], palette_first, tint: [1.0; 3] }
}

/// A picture that was read back.
pub(crate) struct Picture(pub(crate) Image);

impl Picture {
    /// Returns the colour at position (x, y) in the plane z = 0.
    pub(crate) fn at(&self, x: f32, y: f32) -> [u8; 3] {
        let half = f64::from(SIZE) / 2.0;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "tests use positions within the picture"
        )]
        let pixel = |metres: f64| (half + 32.0 * metres).floor() as usize;
        let first = 4 * (pixel(-f64::from(y)) * SIZE as usize + pixel(f64::from(x)));
        [0, 1, 2].map(|channel| self.0.rgba[first + channel])
    }

    /// Asserts the colour at a position, up to the rounding of two conversions.
    #[track_caller]
    pub(crate) fn expect(&self, x: f32, y: f32, wanted: [u8; 3]) {
        let found = self.at(x, y);
        let off = (0..3).map(|c| found[c].abs_diff(wanted[c])).max().unwrap();
        assert!(off <= 2, "at ({x}, {y}): found {found:?}, wanted {wanted:?}");
    }
}

/// Encodes a linear value as an sRGB byte (IEC 61966-2-1).
pub(crate) fn srgb(linear: f64) -> u8 {
    let stored =
        if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to a byte"
    )]
    let byte = (stored.clamp(0.0, 1.0) * 255.0).round() as u8;
    byte
}
