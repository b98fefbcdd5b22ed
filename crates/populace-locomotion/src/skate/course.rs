//! The standard course, and a crowd of one character that walks it.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::Vec3;
use populace::character::Character;
use populace::{
    Affine, CharacterId, ClipId, ClipPlayback, Crowd, Device, Ground, JointIndex, Placement,
};

use super::body::Body;
use crate::feet::Feet;
use crate::{Error, GaitClips, GaitSpace};

/// Frames in a second of the course.
pub(super) const FRAMES_PER_SEC: f32 = 60.0;
/// Radius of the curve, in metres.
const CURVE_M: f32 = 3.0;
/// Seconds after which a start or a stop is told.
const TOLD_SECS: f32 = 0.5;
/// How far it turns on the spot, and the seconds until it turns back.
const TURN: (f32, f32) = (0.75 * PI, 2.5);
/// Rise and depth of the stairs' treads, in metres.
const STAIR: [f32; 2] = [0.15, 0.3];
/// The stairs begin at this z, in metres, and have this many treads.
const STAIRS_AT_M: f32 = 2.0;
const TREADS: u16 = 12;
/// Distance between samples of the ground, in metres.
const SPACING_M: f32 = 0.05;

/// A part of the course; speeds are in metres per second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Part {
    /// From standing to a speed.
    Start(f32),
    /// Straight on.
    Straight(f32),
    /// Along a circle.
    Curve(f32),
    /// From a speed to standing.
    Stop(f32),
    /// A turn on the spot, and back.
    Turn,
    /// Up stairs.
    Stairs(f32),
}

/// Names of the parts, and the seconds that each is measured.
pub(super) const COURSE: [(&str, Part, f32); 11] = [
    ("start", Part::Start(1.3), 2.0),
    ("straight 0.3", Part::Straight(0.3), 6.0),
    ("straight 0.8", Part::Straight(0.8), 5.0),
    ("straight 1.3", Part::Straight(1.3), 5.0),
    ("straight 2", Part::Straight(2.0), 5.0),
    ("straight 3", Part::Straight(3.0), 5.0),
    ("straight 4", Part::Straight(4.0), 5.0),
    ("curve", Part::Curve(1.3), 5.0),
    ("stop", Part::Stop(1.3), 3.0),
    ("turn", Part::Turn, 5.0),
    ("stairs", Part::Stairs(0.8), 5.0),
];

/// The order to a member at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Order {
    /// `[x, z]` in metres per second.
    pub(super) velocity: [f32; 2],
    pub(super) facing_rad: Option<f32>,
}

impl Part {
    /// Returns what a member is told, seconds after the part began.
    pub(super) fn order(self, secs: f32) -> Order {
        let ahead = |speed: f32| Order { velocity: [0.0, speed], facing_rad: None };
        match self {
            Self::Start(speed) => ahead(if secs > TOLD_SECS { speed } else { 0.0 }),
            Self::Straight(speed) | Self::Stairs(speed) => ahead(speed),
            Self::Curve(speed) => {
                let angle = f64::from(secs * speed / CURVE_M);
                let [sin, cos] = narrowed([angle.sin(), angle.cos()]);
                Order { velocity: [sin * speed, cos * speed], facing_rad: None }
            }
            Self::Stop(speed) => ahead(if secs < TOLD_SECS { speed } else { 0.0 }),
            Self::Turn => {
                let facing = if secs < TURN.1 { TURN.0 } else { 0.0 };
                Order { velocity: [0.0; 2], facing_rad: Some(facing) }
            }
        }
    }

    /// The seconds in which it comes to its speed.
    pub(super) fn warm_secs(self) -> f32 {
        match self {
            Self::Straight(speed) | Self::Stop(speed) | Self::Curve(speed) => 2.0 + speed,
            Self::Start(_) | Self::Turn | Self::Stairs(_) => 1.0,
        }
    }

    /// The speed that it is held to, in metres per second.
    pub(super) fn requested(self) -> Option<f32> {
        if let Self::Straight(speed) = self { Some(speed) } else { None }
    }

    pub(super) fn ground(self) -> Result<Ground, Error> {
        if matches!(self, Self::Stairs(_)) { stairs() } else { Ok(Ground::default()) }
    }
}

#[expect(clippy::cast_possible_truncation, reason = "rounding to the nearest f32 is intended")]
fn narrowed(values: [f64; 2]) -> [f32; 2] {
    values.map(|value| value as f32)
}

/// Returns stairs that go up along +Z, with level ground before and behind them.
fn stairs() -> Result<Ground, Error> {
    let [rise, depth] = STAIR;
    let heights = (0..400_u16).flat_map(|row| {
        let z = -3.0 + f32::from(row) * SPACING_M;
        let tread = ((z - STAIRS_AT_M) / depth).ceil().clamp(0.0, f32::from(TREADS));
        [tread * rise; 2]
    });
    let ground = Ground::height_field([-10.0, -3.0], SPACING_M, 2, heights.collect());
    Ok(ground.map_err(populace::Error::from)?)
}

/// The joints of the legs, from the hips to the ankles.
pub(super) struct Legs(Vec<JointIndex>);

impl Legs {
    /// Returns the largest acceleration in the last three poses, of which this is the last, in
    /// metres per second squared. `last` holds the two before.
    pub(super) fn acceleration(&self, last: &mut Vec<Vec<Vec3>>, models: &[Affine]) -> f32 {
        let places = |joint: &JointIndex| Vec3::from(models[joint.index()].origin());
        last.push(self.0.iter().map(places).collect());
        let [.., a, b, c] = last.as_slice() else { return 0.0 };
        let found = acceleration([a, b, c]);
        last.remove(0);
        found
    }
}

/// A crowd in which a character walks the course.
pub(super) struct Course {
    pub(super) crowd: Crowd,
    pub(super) id: CharacterId,
    moving: Vec<ClipId>,
    pub(super) gaits: GaitSpace,
    pub(super) body: Body,
    pub(super) legs: Legs,
}

impl Course {
    pub(super) fn new(character: &Arc<Character>, clips: &GaitClips) -> Result<Self, Error> {
        let mut crowd = Crowd::builder().device(Device::native()).capacity(2).build()?;
        let id = crowd.add_character(Arc::clone(character))?;
        let idle = crowd.character_mut(id)?.add_clip(&clips.idle)?;
        let mut moving = Vec::new();
        for clip in &clips.moving {
            moving.push(crowd.character_mut(id)?.add_clip(clip)?);
        }
        let gaits = GaitSpace::new(&mut crowd, id, idle, &moving)?;
        let body = Body::new(&crowd, id)?;
        let body = body.ok_or_else(|| Error::NoGait { clip: clips.idle.name().to_owned() })?;
        let legs = Legs(legs(character, &body.feet));
        Ok(Self { crowd, id, moving, gaits, body, legs })
    }

    /// Returns the largest acceleration of the legs' joints in the moving clips, each played alone
    /// for two cycles, in metres per second squared.
    pub(super) fn clip_acceleration(&mut self) -> Result<f32, Error> {
        let mut most = 0.0_f32;
        for clip in &self.moving {
            let member = self.crowd.spawn(self.id, Placement::at([0.0; 3]))?;
            self.crowd.member_mut(member)?.play(*clip, ClipPlayback::looping())?;
            let gait = self.body.gait(&self.crowd, *clip)?;
            let cycle_secs = gait.map_or(1.0, |gait| gait.duration_secs);
            let cycle_secs = cycle_secs.clamp(0.1, 10.0);
            let mut last = Vec::new();
            for _ in frames(2.0 * cycle_secs) {
                self.crowd.update(1.0 / FRAMES_PER_SEC)?;
                let models = self.crowd.member_mut(member)?.model_from_joints()?;
                most = most.max(self.legs.acceleration(&mut last, &models));
            }
            self.crowd.despawn(member)?;
        }
        Ok(most)
    }
}

/// The numbers of the frames that begin within some seconds.
pub(super) fn frames(secs: f32) -> impl Iterator<Item = f32> {
    (0_u16..).map(f32::from).take_while(move |frame| *frame < secs * FRAMES_PER_SEC)
}

/// Returns the joints from the hips to the ankles.
fn legs(character: &Character, feet: &Feet) -> Vec<JointIndex> {
    let skeleton = &character.skeleton;
    let ankles = feet.feet.each_ref().map(|foot| foot.ankle.joint());
    let top = feet.hips.as_ref().map(|hips| hips.joint());
    let leads = |joint: JointIndex| {
        ankles.iter().any(|ankle| joint == *ankle || skeleton.is_below(*ankle, joint))
    };
    let within =
        |joint: JointIndex| top.is_none_or(|top| joint == top || skeleton.is_below(joint, top));
    skeleton.joints().filter(|joint| within(*joint) && leads(*joint)).collect()
}

/// Returns the largest acceleration of points over three frames, in metres per second squared.
fn acceleration([a, b, c]: [&[Vec3]; 3]) -> f32 {
    let points = a.iter().zip(b).zip(c);
    let of = points.map(|((a, b), c)| (*a - 2.0 * *b + *c).length());
    of.fold(0.0, f32::max) * FRAMES_PER_SEC * FRAMES_PER_SEC
}
