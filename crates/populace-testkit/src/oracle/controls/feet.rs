//! Planted feet: where they stand, how far the pelvis sinks for them, and how the legs bend.
//!
//! Headings are angles about +Y from +Z. All that a foot keeps from frame to frame is in world
//! space.

mod foot;
mod foothold;
mod sole;

use glam::{DAffine3, DQuat, DVec3};
use populace_device::layout::{FOOT_SETTLE_SECS, MAX_PELVIS_SINK, PELVIS_RISE_SECS};
use populace_device::{Feet, Foot};

use super::limb::{shortest, two_bones};
use super::{Descent, short_part_of};
use crate::oracle::OracleGround;
use crate::oracle::contacts::{OracleSteps, secs_within};
use foot::FootNow;
use sole::Sole;

/// Part of a leg's length over which it straightens.
const SOFT: f64 = 0.005;
/// Parts of a leg's length: the longest offset of a foot from its clip, and the lift of an ankle up
/// to which a foot stands, and from which it is in the air, if no clip knows its contacts.
const MOST_OFFSET: f64 = 0.5;
const STANDS_BELOW: f64 = 0.03;
const AIR_ABOVE: f64 = 0.14;

/// What feet go by besides the pose.
#[derive(Clone, Debug)]
pub struct OracleGait {
    /// The ground.
    pub ground: OracleGround,
    /// Time since the frame before.
    pub elapsed_secs: f64,
    /// Along X and Z, where a step of one metre along +Z leads; then the tangent of half the angle
    /// of turn per metre.
    pub stride: [f64; 3],
    /// For each foot the clips on the lowest layer that know their contacts.
    pub steps: Vec<Vec<OracleSteps>>,
}

/// How a foot is held.
#[derive(Clone, Copy, Debug)]
enum Hold {
    /// It stands.
    Locked {
        /// The place of its pivot; the height does not count.
        anchor: DVec3,
        /// The heading from heel to toes; `None` for a foot without a sole.
        heading: Option<f64>,
        /// The point of the sole that stands.
        pivot: usize,
        /// Height above the ground.
        above: f64,
    },
    /// It follows its clips, and is behind them by a horizontal offset and by an angle, of which
    /// this is the tangent of the half.
    Follows { lag: DVec3, turn: f64, released: bool },
}

/// A foot between two frames.
#[derive(Clone, Copy, Debug)]
struct FootState {
    hold: Hold,
    /// Height of the ground that it is shown on, and the speed at which that rises.
    height: f64,
    climb: f64,
}

/// The feet of a member between two frames.
#[derive(Clone, Debug, Default)]
pub struct OracleStance {
    feet: Vec<Option<FootState>>,
    pelvis_drop: Option<f64>,
    /// Seconds for which all feet have stood, to FOOT_SETTLE_SECS.
    stood_secs: f64,
}

/// A foot's goal, in model space.
#[derive(Clone, Copy)]
pub(super) struct FootGoal {
    ankle: DVec3,
    /// The tangent of half the angle by which the foot turns.
    turn: f64,
    normal: DVec3,
    /// 1 while it stands, 0 in the air.
    near: f64,
}

/// A leg at rest.
struct LegAtRest {
    length: f64,
    ankle: DVec3,
}

/// Feet on their way through a frame.
pub(super) struct Feeling<'a> {
    pub(super) gait: &'a OracleGait,
    pub(super) stance: &'a mut OracleStance,
    /// Goals of feet whose legs are not solved yet.
    pub(super) goals: Vec<FootGoal>,
}

impl Descent<'_, '_> {
    fn leg_at_rest(&self, foot: &Foot) -> LegAtRest {
        let body = self.of.body;
        let place = |joint| {
            let mut at = Some(self.of.source(joint));
            let mut whole = DAffine3::IDENTITY;
            while let Some(joint) = at {
                whole = super::parent_from_joint(&body.rest(joint)) * whole;
                at = body.joints[joint].parent;
            }
            whole.translation
        };
        let [hip, knee, ankle] = [foot.hip, foot.knee, foot.ankle].map(place);
        LegAtRest { length: hip.distance(knee) + knee.distance(ankle), ankle }
    }

    /// Finds the goals of all feet, and lowers the pelvis until the legs reach them. It sinks at
    /// once, and takes its time to rise.
    pub(super) fn plant(&mut self, feet: &Feet) {
        let Some(mut feeling) = self.feet.take() else { return };
        feeling.stance.feet.resize(feet.feet.len(), None);
        let (weight, mut needed) = (f64::from(feet.weight), 0.0f64);
        let longest_secs = f64::from(FOOT_SETTLE_SECS);
        let mut stood_secs =
            (feeling.stance.stood_secs + feeling.gait.elapsed_secs).min(longest_secs);
        for (nth, foot) in feet.feet.iter().enumerate() {
            let rest = self.leg_at_rest(foot);
            let sole = Sole::of(self.of, foot);
            let now = self.walk(self.of.path(feet.pelvis, sole.tip));
            let model = |joint| {
                let joint = self.of.source(joint);
                let at = now.joints.iter().position(|own| *own == joint);
                now.models[at.expect("the joint is in the leg")]
            };
            let [hip, knee, ankle] = [foot.hip, foot.knee, foot.ankle].map(model);
            let now_at = FootNow {
                rest: &rest,
                hip: hip.translation,
                points: sole.points(&ankle, &now.end, self.noise),
                along: sole.along(&ankle),
                ankle: ankle.translation,
                gait: feeling.gait,
                place: &self.frame.place.world_from_model,
                stood_secs,
            };
            let within = secs_within(&feeling.gait.steps[nth], self.noise);
            let (goal, next) = now_at.goal(feeling.stance.feet[nth].as_ref(), within, self.noise);
            if matches!(next.hold, Hold::Follows { .. }) {
                stood_secs = 0.0;
            }
            feeling.stance.feet[nth] = Some(next);
            feeling.goals.push(goal);
            let [upper, lower] =
                [knee.translation - hip.translation, ankle.translation - knee.translation];
            let length = upper.length() + lower.length();
            let to = self.noise.sized(goal.ankle - hip.translation, goal.ankle.length());
            let reach = length * (1.0 - SOFT);
            let up = self.noise.near(reach * reach - to.x * to.x - to.z * to.z, reach * reach);
            let sinks = -to.y - up.max(0.0).sqrt();
            needed = needed.max(sinks.min(length * f64::from(MAX_PELVIS_SINK)));
        }
        feeling.stance.stood_secs = stood_secs;
        let wanted = needed * weight;
        let rise_secs = f64::from(PELVIS_RISE_SECS);
        let part = feeling.gait.elapsed_secs / (feeling.gait.elapsed_secs + rise_secs);
        let drop = match feeling.stance.pelvis_drop {
            Some(before) if wanted < before => before + (wanted - before) * part,
            _ => wanted,
        };
        feeling.stance.pelvis_drop = Some(drop);
        let pelvis = self.of.source(feet.pelvis);
        let mut model = self.model(pelvis);
        model.translation.y -= drop;
        model.translation = self.noise.vector(model.translation);
        self.models[pelvis] = Some(model);
        self.feet = Some(feeling);
    }

    /// Returns the rotations in model space of hip, knee and ankle, each after that of the joint
    /// above. The ankle keeps its rotation from before, turned with the foot and towards the slope.
    pub(super) fn leg(&mut self, feet: &Feet, nth: usize) -> Vec<(usize, DQuat)> {
        let Some(goal) = self.feet.as_ref().and_then(|feet| feet.goals.get(nth).copied()) else {
            return Vec::new();
        };
        let (foot, weight) = (&feet.feet[nth], f64::from(feet.weight));
        let now = self.walk(self.of.path(foot.hip, foot.ankle));
        let [first, middle, end] = [foot.hip, foot.knee, foot.ankle].map(|j| self.of.source(j));
        let at = |joint: usize| {
            let place = now.joints.iter().position(|own| *own == joint);
            now.positions[place.expect("the joint is in the leg")]
        };
        let bones = [at(middle) - at(first), at(end) - at(middle)].map(|v| self.noise.vector(v));
        let to = self.noise.sized(goal.ankle - at(first), goal.ankle.length());
        let bend = self.model(first).matrix3 * self.of.in_joint(Some(first), [0.0, 0.0, 1.0]);
        let noise = &mut *self.noise;
        let Some(whole) = two_bones(bones, to, bend, (SOFT, None), noise) else {
            return Vec::new();
        };
        let [hip, knee] =
            whole.map(|whole| if weight < 1.0 { short_part_of(whole, weight) } else { whole });
        let slope = shortest(DVec3::Y, goal.normal, DVec3::X, noise);
        let slope = short_part_of(slope, goal.near * weight);
        let turned = DQuat::from_rotation_y(2.0 * (goal.turn * weight).atan());
        let ankle = noise.rotation(slope * turned * (knee * hip).inverse());
        vec![(first, hip), (middle, knee), (end, ankle)]
    }
}
