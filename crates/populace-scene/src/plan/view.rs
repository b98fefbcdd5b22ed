//! How a scene is seen.

use serde::{Deserialize, Serialize};

use super::list::exact;

/// Light and sky.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LightPlan {
    /// `day`, `evening`, `overcast` or `studio`.
    pub sky: String,
    /// Height of the sun above the horizon; that of the sky if `None`.
    pub sun_height_deg: Option<f32>,
    /// The heading of the sun; that of the sky if `None`.
    pub sun_facing_deg: Option<f32>,
}

impl Default for LightPlan {
    fn default() -> Self {
        Self { sky: "day".into(), sun_height_deg: None, sun_facing_deg: None }
    }
}

/// Pictures to draw.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OutputPlan {
    /// Width and height in pixels.
    #[serde(deserialize_with = "exact")]
    pub size: [u32; 2],
    /// Frames in a second, from 0.001 to 1000.
    pub fps: f64,
    /// Length of a film.
    pub seconds: f32,
    /// Seconds before the first picture.
    pub lead_in_s: f32,
}

impl Default for OutputPlan {
    fn default() -> Self {
        Self { size: [1280, 720], fps: 30.0, seconds: 10.0, lead_in_s: 0.0 }
    }
}

/// A camera, which may move through several keys.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraPlan {
    /// The name.
    pub name: String,
    /// Its keys, in the order of their times. Between them it moves smoothly. Two keys at one time
    /// are a cut.
    #[serde(rename = "key")]
    pub keys: Vec<CameraKey>,
}

/// A key of a camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraKey {
    /// Time after the first picture.
    #[serde(default)]
    pub time: f64,
    /// Where it stands.
    #[serde(deserialize_with = "exact")]
    pub from: [f32; 3],
    /// The point in the middle of the picture.
    #[serde(deserialize_with = "exact")]
    pub to: [f32; 3],
    /// The vertical angle of view.
    #[serde(default = "usual_angle")]
    pub fov: f32,
}

const fn usual_angle() -> f32 {
    40.0
}
