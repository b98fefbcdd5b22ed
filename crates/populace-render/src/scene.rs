//! What is drawn, besides the characters themselves.

use populace_model::Affine;

use crate::{Camera, Error};

/// A character held by one [`Renderer`](crate::Renderer).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CharacterHandle(pub(crate) usize);

/// One drawn character.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// What to draw.
    pub character: CharacterHandle,
    /// Where.
    pub world_from_model: Affine,
    /// How far from there its palette has it, in metres of the world: shadows reach as far.
    pub moved: [f32; 3],
    /// Its first palette entry: page times [`PAGE_ENTRIES`](populace_device::layout::PAGE_ENTRIES)
    /// plus the place within the page, as in [`Member`](populace_device::layout::Member).
    pub palette_first: u32,
    /// Linear colour that multiplies its surfaces.
    pub tint: [f32; 3],
}

/// The light of the sun, from one direction everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// From anywhere to the sun; any length but zero.
    pub to_sun: [f32; 3],
    /// Linear; what a white surface that faces the sun sends back.
    pub color: [f32; 3],
    /// Whether members stand in its way.
    pub casts_shadows: bool,
}

/// Light without direction, so that what the sun does not reach is not black.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ambient {
    /// Linear, on what faces up.
    pub sky: [f32; 3],
    /// Linear, on what faces down.
    pub ground: [f32; 3],
}

/// The plane y = 0, paved: lines every metre, wider ones every five.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Linear colour of the paving.
    pub color: [f32; 3],
    /// Linear colour of the lines.
    pub line_color: [f32; 3],
}

/// What is behind everything.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// Linear colour overhead.
    pub zenith: [f32; 3],
    /// Linear colour at the horizon, into which the distance fades.
    pub horizon: [f32; 3],
}

/// What becomes of light that is brighter than a picture can show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Highlights {
    /// Tone mapping: linear up to three quarters of white, then a shoulder that nears white without
    /// reaching it.
    #[default]
    Shoulder,
    /// Cut off at white, linear below: for pictures that are measured.
    Clipped,
}

impl Highlights {
    /// Where the curve begins to bend.
    pub(crate) const fn knee(self) -> f32 {
        match self {
            Self::Shoulder => 0.75,
            Self::Clipped => 1.0,
        }
    }
}

/// Camera, light and surroundings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scene {
    /// From where.
    pub camera: Camera,
    /// The sun.
    pub sun: Sun,
    /// The light of everything else.
    pub ambient: Ambient,
    /// What members stand on; `None` draws only sky.
    pub ground: Option<Ground>,
    /// The background.
    pub sky: Sky,
    /// Tone mapping.
    pub highlights: Highlights,
}

impl Default for Scene {
    /// A clear afternoon on paved ground.
    fn default() -> Self {
        Self {
            camera: Camera::default(),
            sun: Sun { to_sun: [0.55, 1.0, 0.6], color: [0.86, 0.81, 0.72], casts_shadows: true },
            ambient: Ambient { sky: [0.4, 0.45, 0.54], ground: [0.2, 0.19, 0.18] },
            ground: Some(Ground { color: [0.4, 0.37, 0.32], line_color: [0.27, 0.25, 0.22] }),
            sky: Sky { zenith: [0.17, 0.36, 0.7], horizon: [0.66, 0.76, 0.86] },
            highlights: Highlights::Shoulder,
        }
    }
}

impl Scene {
    /// Refuses what would turn the whole picture into nothing.
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
        match glam::Vec3::from(self.sun.to_sun).try_normalize() {
            Some(_) => Ok(()),
            None => Err(Error::BadScene { what: "direction to the sun" }),
        }
    }
}
