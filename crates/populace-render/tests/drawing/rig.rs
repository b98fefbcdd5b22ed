//! A renderer whose pixels can be computed by hand. Ambient light is 1 unless a test changes it, a
//! metre at z = 0 is 32 pixels, and the world's origin is at the centre.

use std::sync::Arc;

use populace_character::{Character, Image};
use populace_device::layout::Float4;
use populace_device::{
    BackendError, DrawSource, GlContext, Instance, MemberLook, PaletteSource, PaletteTarget,
    PaletteTransport, ReleasedPalettes, TargetMark, Visibility,
};
use populace_model::Affine;
use populace_render::{Ambient, Camera, Error, Highlights, Renderer, Scene, Sky, Sun};

use crate::fixture::palette;

/// Side of the picture in pixels.
pub(crate) const SIZE: u32 = 128;
/// Colour of the background.
pub(crate) const NOTHING: [u8; 3] = [0, 0, 0];

/// A renderer, and what it draws.
pub(crate) struct Rig {
    pub(crate) renderer: Renderer,
    pub(crate) camera: Camera,
    pub(crate) scene: Scene,
}

impl Rig {
    pub(crate) fn new() -> Self {
        let renderer = Renderer::headless([SIZE; 2]).unwrap();
        Self { renderer, camera: flat_camera(), scene: flat_scene() }
    }

    /// Sets page 0, the only one.
    pub(crate) fn upload(&mut self, entries: &[Affine]) {
        self.upload_pages(vec![palette(entries)]).unwrap();
    }

    pub(crate) fn upload_pages(&mut self, pages: Vec<Vec<Float4>>) -> Result<(), Error> {
        self.renderer.acquire_palettes(&mut Pages::new(pages, Vec::new()))
    }

    pub(crate) fn try_draw(&mut self, instances: &[Instance<'_>]) -> Result<Picture, Error> {
        self.renderer.draw_instances(instances, &self.camera, &self.scene)?;
        Ok(Picture(self.renderer.read_image()?))
    }

    pub(crate) fn draw(&mut self, instances: &[Instance<'_>]) -> Picture {
        self.try_draw(instances).unwrap()
    }
}

/// Pages of palettes that are copied, and what is drawn with them.
pub(crate) struct Pages {
    pages: Vec<Vec<Float4>>,
    pub(crate) members: Vec<Member>,
    mark: TargetMark,
}

/// A character with its placement and first palette entry.
pub(crate) type Member = (Arc<Character>, Affine, u32);

impl Pages {
    pub(crate) fn new(pages: Vec<Vec<Float4>>, members: Vec<Member>) -> Self {
        Self { pages, members, mark: TargetMark::default() }
    }
}

impl PaletteSource for Pages {
    fn page_lengths(&self) -> Vec<usize> {
        self.pages.iter().map(|page| page.len() / 3).collect()
    }

    fn refuses(&self, transport: PaletteTransport, _context: &dyn GlContext) -> Option<String> {
        (transport != PaletteTransport::Copied).then(|| "these pages are copied".into())
    }

    fn set_target(&mut self, _: PaletteTarget, mark: &TargetMark) -> Result<(), BackendError> {
        self.mark = mark.clone();
        Ok(())
    }

    fn release_palettes(&mut self) -> Result<Option<ReleasedPalettes>, BackendError> {
        Ok(Some(ReleasedPalettes { mark: self.mark.clone(), set: None }))
    }

    fn with_page(
        &mut self,
        page: usize,
        reader: &mut dyn FnMut(&[Float4]),
    ) -> Result<(), BackendError> {
        reader(&self.pages[page]);
        Ok(())
    }
}

impl DrawSource for Pages {
    fn instances(&self) -> Vec<Instance<'_>> {
        let members = self.members.iter();
        members.map(|(character, place, first)| instance(character, *place, *first)).collect()
    }
}

/// Returns a camera 10 m in front of the origin.
fn flat_camera() -> Camera {
    Camera {
        eye: [0.0, 0.0, 10.0],
        target: [0.0; 3],
        up: [0.0, 1.0, 0.0],
        fov_y_rad: 2.0 * 0.2_f32.atan(),
        near: 0.1,
        far: 200.0,
    }
}

/// Returns a scene with uniform ambient light, matt surfaces and a black background.
fn flat_scene() -> Scene {
    Scene {
        sun: Sun {
            to_sun: [0.0, 0.0, 1.0],
            color: [0.0; 3],
            casts_shadows: false,
            error_texels: 0.0,
            error_px: 0.0,
        },
        ambient: Ambient::uniform([1.0; 3]),
        ground: None,
        sky: Sky::uniform([0.0; 3]),
        highlights: Highlights::Clipped,
        reflections: 0.0,
        contact_shadows: 0.0,
        floor_m: 0.0,
    }
}

/// Returns an instance in the character's own colours.
pub(crate) fn instance(
    character: &Arc<Character>,
    world_from_model: Affine,
    palette_first: u32,
) -> Instance<'_> {
    Instance {
        character,
        world_from_model,
        moved: [0.0; 3],
        palette_first,
        look: MemberLook::PLAIN,
        level: 0,
        visibility: Visibility::InView,
    }
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

/// Decodes an sRGB byte (IEC 61966-2-1).
pub(crate) fn linear(byte: u8) -> f64 {
    let stored = f64::from(byte) / 255.0;
    if stored <= 0.040_45 { stored / 12.92 } else { ((stored + 0.055) / 1.055).powf(2.4) }
}
