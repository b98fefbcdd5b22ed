//! Scenes by name.

use std::fmt;
use std::str::FromStr;

use super::{Ambient, Ground, Highlights, Scene, Sky, Sun};

/// A light that scenes can have: a kind of sky, or a studio.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Preset {
    /// A clear afternoon.
    #[default]
    Day,
    /// A low sun in warm haze.
    Evening,
    /// Clouds without a sun: soft light from above.
    Overcast,
    /// A grey backdrop with one large lamp. Its haze leaves half of a contrast at 35 m: for what is
    /// farther away, raise [`Sky::visibility_m`](crate::Sky::visibility_m) of the scene.
    Studio,
}

impl Preset {
    /// All presets.
    pub const ALL: [Self; 4] = [Self::Day, Self::Evening, Self::Overcast, Self::Studio];

    /// The preset's name, as [`FromStr`] takes it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Day => "day",
            Self::Evening => "evening",
            Self::Overcast => "overcast",
            Self::Studio => "studio",
        }
    }

    /// Returns a scene with this light.
    #[must_use]
    pub const fn scene(self) -> Scene {
        match self {
            Self::Day => day(),
            Self::Evening => evening(),
            Self::Overcast => overcast(),
            Self::Studio => studio(),
        }
    }
}

impl fmt::Display for Preset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Preset {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|preset| preset.name() == name);
        found.ok_or_else(|| {
            let [first, second, third, last] = Self::ALL.map(Self::name);
            format!("\"{name}\" is none of {first}, {second}, {third} and {last}")
        })
    }
}

const fn day() -> Scene {
    Scene {
        sun: Sun {
            to_sun: [0.55, 1.0, 0.6],
            color: [1.5, 1.37, 1.15],
            casts_shadows: true,
            error_texels: 1.0,
            error_px: 1.0,
        },
        ambient: Ambient {
            sky: [0.44, 0.53, 0.72],
            side: [0.36, 0.4, 0.47],
            ground: [0.26, 0.24, 0.21],
            glow: [0.08, 0.07, 0.05],
        },
        ground: Some(Ground {
            color: [0.3, 0.275, 0.24],
            line_color: [0.2, 0.185, 0.16],
            height_m: 0.0,
        }),
        sky: Sky {
            zenith: [0.14, 0.34, 0.82],
            horizon: [0.72, 0.86, 1.02],
            glow: [0.3, 0.26, 0.18],
            shows_sun: true,
            visibility_m: 1500.0,
        },
        highlights: Highlights::Filmic,
        reflections: 1.0,
        contact_shadows: 0.8,
        floor_m: 0.0,
    }
}

const fn evening() -> Scene {
    Scene {
        sun: Sun {
            to_sun: [-0.9, 0.32, -0.45],
            color: [2.1, 1.15, 0.5],
            casts_shadows: true,
            error_texels: 1.0,
            error_px: 1.0,
        },
        ambient: Ambient {
            sky: [0.32, 0.36, 0.52],
            side: [0.36, 0.33, 0.37],
            ground: [0.22, 0.17, 0.13],
            glow: [0.2, 0.12, 0.05],
        },
        ground: Some(Ground {
            color: [0.36, 0.32, 0.28],
            line_color: [0.25, 0.22, 0.19],
            height_m: 0.0,
        }),
        sky: Sky {
            zenith: [0.1, 0.18, 0.42],
            horizon: [0.72, 0.52, 0.42],
            glow: [1.1, 0.55, 0.16],
            shows_sun: true,
            visibility_m: 350.0,
        },
        highlights: Highlights::Filmic,
        reflections: 1.0,
        contact_shadows: 0.85,
        floor_m: 0.0,
    }
}

const fn overcast() -> Scene {
    Scene {
        sun: Sun {
            to_sun: [0.2, 1.0, 0.3],
            color: [0.0; 3],
            casts_shadows: false,
            error_texels: 1.0,
            error_px: 1.0,
        },
        ambient: Ambient {
            sky: [1.15, 1.2, 1.27],
            side: [0.58, 0.61, 0.65],
            ground: [0.2, 0.195, 0.19],
            glow: [0.0; 3],
        },
        ground: Some(Ground {
            color: [0.22, 0.215, 0.21],
            line_color: [0.15, 0.147, 0.145],
            height_m: 0.0,
        }),
        sky: Sky {
            zenith: [0.66, 0.7, 0.76],
            horizon: [0.9, 0.92, 0.94],
            glow: [0.0; 3],
            shows_sun: false,
            visibility_m: 400.0,
        },
        highlights: Highlights::Filmic,
        reflections: 1.0,
        contact_shadows: 0.9,
        floor_m: 0.0,
    }
}

const fn studio() -> Scene {
    const BACKDROP: [f32; 3] = [0.46, 0.46, 0.47];
    Scene {
        sun: Sun {
            to_sun: [-0.6, 1.1, 0.9],
            color: [1.15, 1.12, 1.08],
            casts_shadows: true,
            error_texels: 1.0,
            error_px: 1.0,
        },
        ambient: Ambient {
            sky: [0.62, 0.63, 0.66],
            side: [0.5, 0.5, 0.52],
            ground: [0.36, 0.36, 0.36],
            glow: [0.1, 0.1, 0.1],
        },
        // The floor, lit by lamp and backdrop, is about as bright as the backdrop.
        ground: Some(Ground {
            color: [0.3, 0.3, 0.305],
            line_color: [0.3, 0.3, 0.305],
            height_m: 0.0,
        }),
        sky: Sky {
            zenith: [0.3, 0.3, 0.31],
            horizon: BACKDROP,
            glow: [0.0; 3],
            shows_sun: false,
            visibility_m: 150.0,
        },
        highlights: Highlights::Filmic,
        reflections: 1.0,
        contact_shadows: 0.8,
        floor_m: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_presets() {
        for preset in Preset::ALL {
            assert_eq!(preset.name().parse(), Ok(preset));
            preset.scene().check().unwrap();
        }
        let said = "noon".parse::<Preset>().unwrap_err();
        assert_eq!(said, "\"noon\" is none of day, evening, overcast and studio");
    }
}
