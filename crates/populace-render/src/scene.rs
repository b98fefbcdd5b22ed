//! Lights and surroundings of a picture.

mod presets;

use crate::Error;

pub use presets::Preset;

/// Directional light of the sun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// Direction to the sun in world space, of any length but zero.
    pub to_sun: [f32; 3],
    /// Linear colour of a white matt surface that faces the sun, without other light.
    pub color: [f32; 3],
    /// True if members cast shadows.
    pub casts_shadows: bool,
    /// Greatest distance, in texels of the shadow map, between what throws a shadow and the
    /// character's surface. Coarser levels of detail throw the shadows of characters that have
    /// some. If the distance is less than 10 mm, the level in which the member is seen throws it.
    pub error_texels: f32,
    /// The same in pixels of the picture, where that is more: far from the camera.
    pub error_px: f32,
}

/// Light of the sky and of what it shines on, by the direction of the surface's normal. It is also
/// what smooth surfaces reflect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ambient {
    /// Linear colour on surfaces that face up.
    pub sky: [f32; 3],
    /// Linear colour on upright surfaces.
    pub side: [f32; 3],
    /// Linear colour on surfaces that face down.
    pub ground: [f32; 3],
    /// Linear colour that surfaces have more if they face the sun, and less if they face away: the
    /// sky is brighter near the sun.
    pub glow: [f32; 3],
}

impl Ambient {
    /// Returns equal light from everywhere.
    #[must_use]
    pub const fn uniform(color: [f32; 3]) -> Self {
        Self { sky: color, side: color, ground: color, glow: [0.0; 3] }
    }
}

/// A level plane, paved: a line every metre, a wider one every five metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Linear colour of the paving.
    pub color: [f32; 3],
    /// Linear colour of the lines.
    pub line_color: [f32; 3],
    /// Height in metres, y in world space.
    pub height_m: f32,
}

/// Background of the picture, and the air before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// Linear colour overhead.
    pub zenith: [f32; 3],
    /// Linear colour at the horizon, and of the haze in the distance.
    pub horizon: [f32; 3],
    /// Linear colour that sky and haze have more in the direction of the sun.
    pub glow: [f32; 3],
    /// True if the sun's disc is drawn.
    pub shows_sun: bool,
    /// Distance in metres at which haze leaves 5 % of a contrast; infinite for clear air. Whatever
    /// it is, haze hides the far plane.
    pub visibility_m: f32,
}

impl Sky {
    /// Returns a background of one colour in clear air.
    #[must_use]
    pub const fn uniform(color: [f32; 3]) -> Self {
        Self {
            zenith: color,
            horizon: color,
            glow: [0.0; 3],
            shows_sun: false,
            visibility_m: f32::INFINITY,
        }
    }
}

/// Mapping of linear light to the range of the picture, before it is encoded as sRGB.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Highlights {
    /// As film does: shadows gain contrast, and highlights approach white and lose saturation. The
    /// curve is the fit of Narkowicz ("ACES Filmic Tone Mapping Curve", 2016) to the reference
    /// curve of ACES, for light times 0.75.
    #[default]
    Filmic,
    /// Linear up to white, then clipped. For pictures whose colours are measured.
    Clipped,
}

impl Highlights {
    /// Returns a, b, c and d of the curve `x (a x + b) / (x (c x + d) + 1)`.
    pub(crate) fn curve(self) -> [f32; 4] {
        const EXPOSURE: f32 = 0.75;
        match self {
            Self::Filmic => {
                let linear = EXPOSURE / 0.14;
                let square = EXPOSURE * linear;
                [2.51 * square, 0.03 * linear, 2.43 * square, 0.59 * linear]
            }
            Self::Clipped => [0.0, 1.0, 0.0, 0.0],
        }
    }
}

/// Lights, surroundings and tone mapping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scene {
    /// Directional light.
    pub sun: Sun,
    /// Light of the sky.
    pub ambient: Ambient,
    /// The ground plane, or `None` to draw only the sky.
    pub ground: Option<Ground>,
    /// Background and haze.
    pub sky: Sky,
    /// Tone mapping.
    pub highlights: Highlights,
    /// Fraction of the light that surfaces reflect as mirrors do, by their material: 1 in nature, 0
    /// for matt surfaces, whose colours are the product of light and base colour.
    pub reflections: f32,
    /// Fraction of the sky's light that members keep from the ground beneath them, and the ground
    /// from members near it: 1 in nature, 0 to draw none of it.
    pub contact_shadows: f32,
    /// Height in metres, y in world space, of the floor on which members stand. Contact shadows lie
    /// there: on the ground if it is as high, and otherwise on what members have there, such as
    /// a slab over lower ground.
    pub floor_m: f32,
}

impl Default for Scene {
    /// Returns [`Preset::Day`]: a clear afternoon on paved ground.
    fn default() -> Self {
        Preset::Day.scene()
    }
}

impl Scene {
    /// Rejects non-finite colours, numbers out of their range, and a direction to the sun that
    /// cannot be normalised.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let ground =
            self.ground.unwrap_or(Ground { color: [0.0; 3], line_color: [0.0; 3], height_m: 0.0 });
        let finite = [
            ("sun colour", self.sun.color),
            ("sky light", self.ambient.sky),
            ("side light", self.ambient.side),
            ("ground light", self.ambient.ground),
            ("glow of the light", self.ambient.glow),
            ("zenith colour", self.sky.zenith),
            ("horizon colour", self.sky.horizon),
            ("glow of the sky", self.sky.glow),
            ("ground colour", ground.color),
            ("line colour", ground.line_color),
        ];
        let is_finite = |color: &[f32; 3]| color.iter().all(|c| c.is_finite());
        if let Some((what, _)) = finite.iter().find(|(_, color)| !is_finite(color)) {
            return Err(Error::BadScene { what, rule: "finite" });
        }
        let (share, height) = ("0 to 1", "-1000000 to 1000000 metres");
        let is_share = |value: f32| (0.0..=1.0).contains(&value);
        let is_height = |value: f32| value.abs() <= 1e6;
        let is_error = |error: f32| (0.0..=1e6).contains(&error);
        let to_sun = glam::Vec3::from(self.sun.to_sun).try_normalize();
        let numbers = [
            ("error of shadows", is_error(self.sun.error_texels), "0 to 1000000 texels"),
            ("error of shadows", is_error(self.sun.error_px), "0 to 1000000 pixels"),
            ("fraction of reflections", is_share(self.reflections), share),
            ("fraction of contact shadows", is_share(self.contact_shadows), share),
            ("visibility", self.sky.visibility_m > 0.0, "above 0 metres"),
            ("height of the ground", is_height(ground.height_m), height),
            ("height of the floor", is_height(self.floor_m), height),
            ("direction to the sun", to_sun.is_some(), "finite and not zero"),
        ];
        match numbers.iter().find(|(_, is_good, _)| !is_good) {
            Some((what, _, rule)) => Err(Error::BadScene { what, rule }),
            None => Ok(()),
        }
    }
}
