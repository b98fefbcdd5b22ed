//! Lights and surroundings of a picture.

use crate::Error;

/// Directional light of the sun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// Direction to the sun in world space, of any length but zero.
    pub to_sun: [f32; 3],
    /// Linear colour of a white surface that faces the sun, without other light.
    pub color: [f32; 3],
    /// True if members cast shadows.
    pub casts_shadows: bool,
    /// Greatest distance, in texels of the shadow map, between what throws a shadow and the
    /// character's surface. Coarser levels of detail throw the shadows of characters that have
    /// some; 0 takes the level in which the member is seen.
    pub error_texels: f32,
}

/// Ambient light, interpolated by the height component of the surface normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ambient {
    /// Linear colour on surfaces that face up.
    pub sky: [f32; 3],
    /// Linear colour on surfaces that face down.
    pub ground: [f32; 3],
}

/// The plane y = 0, paved: a line every metre, a wider one every five metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Linear colour of the paving.
    pub color: [f32; 3],
    /// Linear colour of the lines.
    pub line_color: [f32; 3],
}

/// Background of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// Linear colour overhead.
    pub zenith: [f32; 3],
    /// Linear colour at the horizon, and of the haze in the distance.
    pub horizon: [f32; 3],
}

/// Treatment of colours brighter than white.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Highlights {
    /// Tone mapping that is linear up to 75 % of white and approaches white above.
    #[default]
    Shoulder,
    /// Linear up to white, then clipped. For pictures whose colours are measured.
    Clipped,
}

impl Highlights {
    /// Returns the value from which the tone mapping curve is no longer linear.
    pub(crate) const fn knee(self) -> f32 {
        match self {
            Self::Shoulder => 0.75,
            Self::Clipped => 1.0,
        }
    }
}

/// Lights, surroundings and tone mapping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scene {
    /// Directional light.
    pub sun: Sun,
    /// Ambient light.
    pub ambient: Ambient,
    /// The ground plane, or `None` to draw only the sky.
    pub ground: Option<Ground>,
    /// Background and haze.
    pub sky: Sky,
    /// Tone mapping.
    pub highlights: Highlights,
}

impl Default for Scene {
    /// Returns a clear afternoon on paved ground.
    fn default() -> Self {
        Self {
            sun: Sun {
                to_sun: [0.55, 1.0, 0.6],
                color: [0.86, 0.81, 0.72],
                casts_shadows: true,
                error_texels: 0.75,
            },
            ambient: Ambient { sky: [0.4, 0.45, 0.54], ground: [0.2, 0.19, 0.18] },
            ground: Some(Ground { color: [0.4, 0.37, 0.32], line_color: [0.27, 0.25, 0.22] }),
            sky: Sky { zenith: [0.17, 0.36, 0.7], horizon: [0.66, 0.76, 0.86] },
            highlights: Highlights::Shoulder,
        }
    }
}

impl Scene {
    /// Returns the linear colour of the horizon after tone mapping, the same curve as
    /// `tone_mapped` in `light.glsl`.
    pub(crate) fn shown_horizon(&self) -> [f32; 3] {
        let knee = self.highlights.knee();
        let headroom = 1.0 - knee;
        self.sky.horizon.map(|color| {
            let over = (color - knee).max(0.0) / headroom.max(1e-3);
            color.min(knee) + headroom * (1.0 - (-over).exp())
        })
    }

    /// Rejects non-finite colours, and a direction to the sun that cannot be normalised.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let ground = self.ground.unwrap_or(Ground { color: [0.0; 3], line_color: [0.0; 3] });
        let finite = [
            ("sun colour", self.sun.color),
            ("sky light", self.ambient.sky),
            ("ground light", self.ambient.ground),
            ("zenith colour", self.sky.zenith),
            ("horizon colour", self.sky.horizon),
            ("ground colour", ground.color),
            ("line colour", ground.line_color),
        ];
        if let Some((what, _)) =
            finite.iter().find(|(_, color)| color.iter().any(|c| !c.is_finite()))
        {
            return Err(Error::BadScene { what });
        }
        if !(0.0..=1e6).contains(&self.sun.error_texels) {
            return Err(Error::BadScene { what: "error of the shadow map" });
        }
        match glam::Vec3::from(self.sun.to_sun).try_normalize() {
            Some(_) => Ok(()),
            None => Err(Error::BadScene { what: "direction to the sun" }),
        }
    }
}
