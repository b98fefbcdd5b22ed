//! The plan of a scene: plain data that a scene file holds.
//!
//! Lengths are in metres, times in seconds, angles in degrees. Points on the ground are `[x, z]`,
//! points in space `[x, y, z]`. A heading of 0 looks along +Z, one of 90 along +X.

mod list;
mod people;
mod place;
mod view;

use serde::{Deserialize, Serialize};

pub use people::{
    BehaviourPlan, CastPlan, CrowdPlan, FightPlan, GazePlan, LayerPlan, MaskPlan, SpectatePlan,
    StandPlan, StrollPlan,
};
pub use place::{
    BayPlan, CrossingPlan, FootwayPlan, GroundPlan, LanePlan, LeanPlan, PropPlan, SeatPlan,
    SpotPlan, WallPlan,
};
pub use view::{CameraKey, CameraPlan, LightPlan, OutputPlan};

/// The version of scene files that this library reads and writes.
pub const SCHEMA: u32 = 1;

/// The plan of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScenePlan {
    /// Version of the format: 1.
    pub schema: u32,
    /// Seed of everything that varies.
    #[serde(default)]
    pub seed: u64,
    /// Light and sky.
    #[serde(default)]
    pub light: LightPlan,
    /// Pictures to draw, unless the command line says otherwise.
    #[serde(default)]
    pub output: OutputPlan,
    /// The ground.
    #[serde(default)]
    pub ground: GroundPlan,
    /// Characters, by name.
    #[serde(default, rename = "cast")]
    pub casts: Vec<CastPlan>,
    /// Members and what they do.
    #[serde(default, rename = "crowd")]
    pub crowds: Vec<CrowdPlan>,
    /// Strips of ground on which people walk.
    #[serde(default, rename = "footway")]
    pub footways: Vec<FootwayPlan>,
    /// Places that people look into.
    #[serde(default, rename = "spot")]
    pub spots: Vec<SpotPlan>,
    /// Places before walls against which people lean.
    #[serde(default, rename = "lean")]
    pub leans: Vec<LeanPlan>,
    /// Places that people sit on.
    #[serde(default, rename = "seat")]
    pub seats: Vec<SeatPlan>,
    /// Places at which people cross a road.
    #[serde(default, rename = "crossing")]
    pub crossings: Vec<CrossingPlan>,
    /// Lanes in which vehicles drive.
    #[serde(default, rename = "lane")]
    pub lanes: Vec<LanePlan>,
    /// Places beside lanes where vehicles park.
    #[serde(default, rename = "bay")]
    pub bays: Vec<BayPlan>,
    /// Lines that nobody walks through.
    #[serde(default, rename = "wall")]
    pub walls: Vec<WallPlan>,
    /// Things that stand in the scene.
    #[serde(default, rename = "prop")]
    pub props: Vec<PropPlan>,
    /// Cameras; the first is used unless another is named.
    #[serde(default, rename = "camera")]
    pub cameras: Vec<CameraPlan>,
}

impl Default for ScenePlan {
    /// An empty scene by day.
    fn default() -> Self {
        Self {
            schema: SCHEMA,
            seed: 0,
            light: LightPlan::default(),
            output: OutputPlan::default(),
            ground: GroundPlan::default(),
            casts: Vec::new(),
            crowds: Vec::new(),
            footways: Vec::new(),
            spots: Vec::new(),
            leans: Vec::new(),
            seats: Vec::new(),
            crossings: Vec::new(),
            lanes: Vec::new(),
            bays: Vec::new(),
            walls: Vec::new(),
            props: Vec::new(),
            cameras: Vec::new(),
        }
    }
}

impl ScenePlan {
    /// The number of members of all crowds.
    #[must_use]
    pub fn member_count(&self) -> usize {
        self.crowds.iter().map(|crowd| crowd.count).sum()
    }
}
