//! Who is in a scene, and what they do.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::list::exact;

/// Characters by a name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CastPlan {
    /// The name by which crowds refer to it.
    pub name: String,
    /// Files, folders, or `@people` and the names of built-in people. Paths are relative to the
    /// scene file.
    pub from: Vec<String>,
    /// Files with more clips.
    #[serde(default)]
    pub clips_from: Vec<String>,
    /// Names of clips by their role, such as `sit = "SitIdle"`, for characters whose clips have
    /// other names than those of the built-in people.
    #[serde(default)]
    pub clips: BTreeMap<String, String>,
    /// Seed of colours, options and heights; they are as in the file if false.
    #[serde(default = "yes")]
    pub varied: bool,
    /// Height of each of its characters in metres, before the variety. Without it, they are as high
    /// as in their files if that suits people.
    #[serde(default)]
    pub height_m: Option<f32>,
    /// Things that each member wears or holds, by the prop's kind: `shield`, `spear`, `helmet`.
    #[serde(default)]
    pub holds: Vec<String>,
    /// A colour for the region `top`, linear red, green and blue from 0 to 1, over the variety.
    #[serde(default, deserialize_with = "exact")]
    pub top: Option<[f32; 3]>,
}

const fn yes() -> bool {
    true
}

/// Members of a cast that do the same kind of thing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CrowdPlan {
    /// The cast.
    pub cast: String,
    /// Number of members.
    pub count: usize,
    /// What they do.
    pub does: BehaviourPlan,
    /// Clips that they play over what they do.
    #[serde(default)]
    pub layers: Vec<LayerPlan>,
    /// Where they look, unless what they do says otherwise.
    #[serde(default)]
    pub gaze: Option<GazePlan>,
}

/// The activity of members.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum BehaviourPlan {
    /// They walk about on footways, look into windows, cross, sit, talk and drive.
    Stroll(StrollPlan),
    /// They sit on a stand, clap, cheer and do the wave.
    Spectate(SpectatePlan),
    /// They stand in a line of battle, advance and fight.
    Fight(FightPlan),
    /// They stand where they are.
    Stand(StandPlan),
}

/// How people stroll. Rates are the number of times in a minute at which one person would do a
/// thing if there were always a place for it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StrollPlan {
    /// Names of the footways; all if empty.
    pub footways: Vec<String>,
    /// The mean walking speed in metres per second.
    pub speed: f32,
    /// Looks into a window.
    pub look_in: f32,
    /// Crosses the road.
    pub cross: f32,
    /// Sits down.
    pub sit: f32,
    /// Meets somebody and talks.
    pub talk: f32,
    /// Leans against a wall.
    pub lean: f32,
    /// Telephones.
    pub phone: f32,
    /// Reads a message while walking, and heeds nobody meanwhile.
    pub text: f32,
    /// Gets into a parked car.
    pub drive: f32,
    /// Is in a hurry, and may run into somebody.
    pub hurry: f32,
    /// The share of people who carry a parcel, 0 to 1. They walk, look into windows and cross.
    pub carry: f32,
    /// The share of people on their way who walk in groups of two or three, side by side, and talk,
    /// 0 to 1. They do nothing else.
    pub together: f32,
}

impl Default for StrollPlan {
    fn default() -> Self {
        Self {
            footways: Vec::new(),
            speed: 1.25,
            look_in: 0.5,
            cross: 0.5,
            sit: 0.35,
            talk: 0.35,
            phone: 0.25,
            text: 0.4,
            drive: 0.3,
            hurry: 0.3,
            lean: 0.3,
            carry: 0.04,
            together: 0.5,
        }
    }
}

/// How people watch from seats.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SpectatePlan {
    /// Times in a minute at which one person claps.
    pub clap: f32,
    /// Times in a minute at which one person cheers.
    pub cheer: f32,
    /// Seconds from one wave to the next; 0 for none. It begins at the first seat.
    pub wave_every_s: f32,
    /// Speed of the wave in metres per second.
    pub wave_speed: f32,
}

impl Default for SpectatePlan {
    fn default() -> Self {
        // A wave passes about 20 seats of 0.5 m each second (I. Farkas, D. Helbing and T. Vicsek,
        // "Mexican waves in an excitable medium", Nature 419 (2002), 131).
        Self { clap: 2.0, cheer: 0.6, wave_every_s: 20.0, wave_speed: 11.0 }
    }
}

/// How people fight: in ranks, against those of another crowd.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FightPlan {
    /// The middle of the front rank `[x, z]`.
    #[serde(deserialize_with = "exact")]
    pub at: [f32; 2],
    /// The heading of the line.
    pub facing_deg: f32,
    /// Members in a rank.
    pub rank: usize,
    /// Distance between neighbours in a rank and between ranks.
    #[serde(deserialize_with = "exact")]
    pub spacing_m: [f32; 2],
    /// Distance that the line advances before it fights.
    pub advance_m: f32,
    /// Times in a minute at which a member of the front rank thrusts its spear.
    pub thrust: f32,
    /// Times in a minute at which one of the front rank is hit; one in four hit falls.
    pub hit: f32,
}

impl Default for FightPlan {
    fn default() -> Self {
        Self {
            at: [0.0; 2],
            facing_deg: 0.0,
            rank: 50,
            spacing_m: [0.9, 1.2],
            advance_m: 8.0,
            thrust: 12.0,
            hit: 3.0,
        }
    }
}

/// How people stand.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StandPlan {
    /// The middle of the front row, `[x, z]`.
    #[serde(deserialize_with = "exact")]
    pub at: [f32; 2],
    /// Their heading.
    pub facing_deg: f32,
    /// Members in a row, at most.
    pub row: usize,
    /// Distance between neighbours.
    pub spacing_m: f32,
    /// True for exact rows and one heading. Otherwise, unless there is only one, each stands up to
    /// a quarter of the spacing off its place, not within its neighbours, and is turned by up to
    /// 15 degrees.
    pub even: bool,
    /// The clip that they play.
    pub clip: String,
    /// True to play the clip again and again, false to play it once and hold its end. Without it,
    /// a clip whose last pose is far from its first, such as a fall, is played once.
    #[serde(rename = "loop")]
    pub looping: Option<bool>,
    /// Seconds of the scene at which a clip that is played once begins. Its first pose is held
    /// until then.
    pub start_s: f32,
}

impl Default for StandPlan {
    fn default() -> Self {
        Self {
            at: [0.0; 2],
            facing_deg: 0.0,
            row: 10,
            spacing_m: 1.0,
            even: false,
            clip: "Idle".into(),
            looping: None,
            start_s: 0.0,
        }
    }
}

/// A clip over what members do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LayerPlan {
    /// The clip's name.
    pub clip: String,
    /// The weight, 0 to 1.
    #[serde(default = "one")]
    pub weight: f32,
    /// True to add the clip's difference from its first pose; it replaces otherwise.
    #[serde(default)]
    pub additive: bool,
    /// The part of the body that the clip moves.
    #[serde(default)]
    pub mask: MaskPlan,
    /// The share of members that play it, 0 to 1.
    #[serde(default = "one")]
    pub share: f32,
}

const fn one() -> f32 {
    1.0
}

/// A part of the body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum MaskPlan {
    /// All joints.
    WholeBody,
    /// The spine and all above it.
    #[default]
    UpperBody,
    /// The left arm from the shoulder on.
    LeftArm,
    /// The right arm from the shoulder on.
    RightArm,
}

/// A point to look at.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GazePlan {
    /// The point.
    #[serde(deserialize_with = "exact")]
    pub at: [f32; 3],
    /// The weight, 0 to 1.
    #[serde(default = "one")]
    pub weight: f32,
}
