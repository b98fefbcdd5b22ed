//! Where a scene takes place.

use serde::{Deserialize, Serialize};

use super::list::exact;

/// The ground. Roads among the props lie in it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GroundPlan {
    /// True to draw the plain ground, for scenes whose props do not cover it.
    pub shown: bool,
    /// Its height.
    pub height_m: f32,
}

impl Default for GroundPlan {
    fn default() -> Self {
        Self { shown: true, height_m: 0.0 }
    }
}

/// A strip of ground on which people walk along a line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FootwayPlan {
    /// The name.
    pub name: String,
    /// Points of its middle line, at least two.
    #[serde(deserialize_with = "exact")]
    pub points: Vec<[f32; 2]>,
    /// Its width.
    pub width_m: f32,
}

/// A place at which somebody stands and looks at something, such as a shop window.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpotPlan {
    /// Where the person stands.
    #[serde(deserialize_with = "exact")]
    pub at: [f32; 2],
    /// The heading.
    pub facing_deg: f32,
    /// The point looked at.
    #[serde(deserialize_with = "exact")]
    pub look_at: [f32; 3],
}

/// A place at which somebody leans with the back against a wall.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LeanPlan {
    /// Where the person stands, 0.3 m before the wall.
    #[serde(deserialize_with = "exact")]
    pub at: [f32; 2],
    /// The heading, away from the wall.
    pub facing_deg: f32,
}

/// A place to sit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SeatPlan {
    /// The middle of the seat's surface.
    #[serde(deserialize_with = "exact")]
    pub at: [f32; 3],
    /// The heading of who sits on it.
    pub facing_deg: f32,
}

/// A place at which people cross a road.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CrossingPlan {
    /// Where people wait on either side.
    #[serde(deserialize_with = "exact")]
    pub ends: [[f32; 2]; 2],
    /// Its width.
    pub width_m: f32,
    /// True if it has lights; without them people wait for gaps between vehicles.
    #[serde(default)]
    pub lights: bool,
    /// Seconds by which its lights are ahead of others.
    #[serde(default)]
    pub ahead_s: f32,
}

/// A straight lane. Vehicles that reach its end begin again at its start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LanePlan {
    /// The name.
    pub name: String,
    /// Start and end of its middle line.
    #[serde(deserialize_with = "exact")]
    pub ends: [[f32; 2]; 2],
    /// Number of vehicles that drive in it at the beginning.
    pub vehicles: usize,
    /// Height of the road.
    #[serde(default)]
    pub height_m: f32,
    /// The speed that they like, in metres per second.
    #[serde(default = "town_speed")]
    pub speed: f32,
}

const fn town_speed() -> f32 {
    8.0
}

/// A place where a vehicle parks beside a lane.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BayPlan {
    /// The lane.
    pub lane: String,
    /// The middle of a vehicle that is parked in it.
    #[serde(deserialize_with = "exact")]
    pub at: [f32; 2],
    /// True if a vehicle is parked there at the beginning.
    #[serde(default)]
    pub taken: bool,
}

/// A line that nobody walks through.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WallPlan {
    /// Its points, at least two.
    #[serde(deserialize_with = "exact")]
    pub points: Vec<[f32; 2]>,
    /// True if the last is joined to the first.
    #[serde(default)]
    pub closed: bool,
}

/// A thing that stands in the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PropPlan {
    /// Its kind: one of [`PROP_KINDS`](crate::PROP_KINDS); empty for a file.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub kind: String,
    /// A glTF file that is shown at rest, relative to the scene file, in place of a kind.
    #[serde(default)]
    pub file: Option<String>,
    /// Where it stands.
    #[serde(deserialize_with = "exact")]
    pub at: [f32; 3],
    /// Its heading.
    #[serde(default)]
    pub facing_deg: f32,
    /// The seed of what varies.
    #[serde(default)]
    pub seed: u64,
    /// Sizes of kinds that have them, such as the width of a house front.
    #[serde(default)]
    pub size_m: Vec<f32>,
    /// The number of the crossing whose lights it shows, from 0 on in the order of the file.
    #[serde(default)]
    pub crossing: Option<usize>,
}
