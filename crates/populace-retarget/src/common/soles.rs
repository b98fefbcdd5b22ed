//! Roll of the feet, to keep the target's mesh above the ground. A foot of another shape, or one
//! without toes, reaches deeper than its ankle shows if it rotates as the source's does.

use glam::{DAffine3, DQuat, DVec3};
use populace_model::JointIndex;
use populace_model::humanoid::{Role, Side};

use super::feet::{SIDES, Stands};
use super::{Common, Figure};

/// Depth to which soles may be in the ground, as a fraction of the body's height. It is invisible,
/// and feet roll less because of it.
const DEPTH_TOLERANCE: f64 = 0.007;
/// Maximum lift of the whole body for heels, as a fraction of the height of its hips.
const MAX_LIFT: f64 = 0.015;
/// Depth of the source's feet, as a fraction of its body's size, beyond which it counts as
/// intended. Depth up to it counts as inexact animation. Intended depth is allowed for the target's
/// feet as well.
const INTENDED_DEPTH: f64 = 0.03;
/// Tilt in radians from which a foot rolls towards flat.
const FLAT_TILT_RAD: f64 = 0.2;
/// Limits from which a foot rolls by the full angle, as fractions of the body's height: the
/// horizontal distance of its contact from the joint, and its excess depth.
const CONTACT_DISTANCE: f64 = 0.02;
const EXCESS_DEPTH: f64 = 0.005;
/// Ranges in radians of toes up, toes down and an edge down. Up to the first value of each pair the
/// foot counts as walking. From the second value on the body lies, sits or kneels, and the foot
/// does not roll.
const TOES_UP_RAD: [f64; 2] = [0.6, 1.1];
const TOES_DOWN_RAD: [f64; 2] = [1.7, 2.1];
const EDGE_DOWN_RAD: [f64; 2] = [0.6, 1.0];
/// Depth of the joint itself, as a fraction of the body's height, over which the roll fades out,
/// because rolling cannot help then.
const ANKLE_DEPTH: [f64; 2] = [0.01, 0.03];
/// Number of bisection steps for the angle of roll.
const HALVINGS: u32 = 24;
/// Rotations up to this angle, in radians, count as the identity.
const NEGLIGIBLE_RAD: f64 = 0.01;

/// A foot without its toes, or the toes.
struct Sole {
    joint: JointIndex,
    /// Rest position of the joint in model space.
    rest: DVec3,
    /// Points that may touch the ground, at rest, relative to the joint.
    points: Vec<DVec3>,
}

impl Sole {
    /// Collects the points of the joint and its descendants, except those of `without` and its
    /// descendants.
    fn new(figure: &Figure<'_>, joint: JointIndex, without: Option<JointIndex>) -> Self {
        let skeleton = figure.skeleton;
        let hangs = |on: JointIndex, j: JointIndex| j == on || skeleton.is_below(j, on);
        let own =
            skeleton.joints().filter(|&j| hangs(joint, j) && !without.is_some_and(|w| hangs(w, j)));
        let rest = figure.position(joint);
        let points = own
            .flat_map(|j| skeleton.soles(j))
            .map(|&p| populace_model::f64math::vec3(p) - rest)
            .collect();
        Self { joint, rest, points }
    }

    fn lowest_at_rest(&self) -> f64 {
        self.points.iter().map(|p| self.rest.y + p.y).fold(f64::INFINITY, f64::min)
    }
}

/// The soles of a figure.
struct Feet {
    /// For each side the foot, and its toes if there are any.
    sides: [Vec<Sole>; 2],
    /// Height of the soles at rest.
    ground: f64,
    /// Height of the highest joint above them.
    height: f64,
}

impl Feet {
    fn new(figure: &Figure<'_>) -> Self {
        let sides = SIDES.map(|side| {
            let (foot, toes) =
                (figure.roles.joint(Role::Foot(side)), figure.roles.joint(Role::Toes(side)));
            let foot = foot.map(|foot| Sole::new(figure, foot, toes));
            foot.into_iter().chain(toes.map(|toes| Sole::new(figure, toes, None))).collect()
        });
        let ground = sides.iter().flatten().map(Sole::lowest_at_rest).fold(f64::INFINITY, f64::min);
        let top = figure
            .skeleton
            .joints()
            .map(|j| figure.position(j).y)
            .fold(f64::NEG_INFINITY, f64::max);
        Self { sides, ground, height: top - ground }
    }

    /// If no sole is known, uses points under the joints.
    fn or_under_joints(mut self) -> Self {
        if !self.ground.is_finite() {
            let soles = || self.sides.iter().flatten();
            self.ground = soles().map(|sole| sole.rest.y).fold(f64::INFINITY, f64::min);
            for sole in self.sides.iter_mut().flatten() {
                sole.points.push(DVec3::new(0.0, self.ground - sole.rest.y, 0.0));
            }
        }
        self
    }
}

/// The feet of both bodies, and the roll of the target's.
pub(crate) struct Soles<'a> {
    common: &'a Common<'a>,
    source: Feet,
    target: Feet,
}

impl<'a> Soles<'a> {
    /// Returns `None` if the target's soles are unknown, or if a foot would separate from toes that
    /// do not descend from it.
    pub(crate) fn new(common: &'a Common<'a>) -> Option<Self> {
        let target = Feet::new(&common.target);
        let whole = |sides: &Vec<Sole>| {
            sides
                .windows(2)
                .all(|pair| common.target.skeleton.is_below(pair[1].joint, pair[0].joint))
        };
        let known =
            target.height.is_finite() && target.height > 0.0 && target.sides.iter().all(whole);
        known.then(|| Self { common, source: Feet::new(&common.source).or_under_joints(), target })
    }

    /// The joints that roll.
    pub(crate) fn joints(&self) -> Vec<JointIndex> {
        self.target.sides.iter().flatten().map(|sole| sole.joint).collect()
    }

    /// Returns the rotations that keep feet above the ground in a pose of the source's joints, in
    /// the order of [`joints`](Self::joints). Each is applied after the joint's own rotation.
    pub(crate) fn rotations(&self, pose: &[DAffine3]) -> Vec<DQuat> {
        let (rotations, models) = self.common.source_models(pose);
        let of = |side| {
            let mut feet = self.common.feet(side, &rotations, &models);
            self.roll_feet(side, &mut feet, self.depth(&rotations, &models, side))
        };
        // A joint scaled to zero has no direction.
        let sound = |rotation: DQuat| if rotation.is_finite() { rotation } else { DQuat::IDENTITY };
        SIDES.into_iter().flat_map(of).map(sound).collect()
    }

    /// Returns the height by which the whole body is lifted so that heels do not strike too deep.
    /// Rolling the foot flat instead would remove the heel strike. `poses` are local transforms of
    /// the source's joints.
    pub(crate) fn heel_lift(&self, poses: &[Vec<DAffine3>]) -> f64 {
        let deep = |pose: &Vec<DAffine3>| {
            let (rotations, models) = self.common.source_models(pose);
            let of = |side: Side| {
                let bottom = self.target.ground - self.depth(&rotations, &models, side);
                let feet = self.common.feet(side, &rotations, &models);
                let sole = self.target.sides[side as usize].first()?;
                let contact =
                    Contact::new(sole, feet.iter().find(|foot| foot.joint == sole.joint)?);
                (contact.flat() > FLAT_TILT_RAD)
                    .then(|| contact.walking_weight() * (bottom - contact.lowest(0.0).0))
            };
            SIDES.into_iter().filter_map(of).fold(0.0, f64::max)
        };
        let target = &self.common.target;
        let hips = target
            .roles
            .joint(Role::Hips)
            .map_or(0.0, |hips| target.position(hips).y - self.target.ground);
        poses.iter().map(deep).fold(0.0, f64::max).min(MAX_LIFT * hips.max(0.0))
    }

    /// Returns whether all rotations are too small to be visible.
    pub(crate) fn are_negligible(rotations: &[DQuat]) -> bool {
        rotations.iter().all(|rotation| rotation.angle_between(DQuat::IDENTITY) <= NEGLIGIBLE_RAD)
    }

    /// Returns how deep a foot of the target may be in the ground, given the intended depth of the
    /// source's.
    pub(super) fn depth(&self, rotations: &[DQuat], models: &[DAffine3], side: Side) -> f64 {
        let source = &self.common.source;
        let lowest = |sole: &Sole| {
            let rotation =
                rotations[sole.joint.index()] * source.rotation[sole.joint.index()].inverse();
            let position = models[sole.joint.index()].translation;
            sole.points.iter().map(|p| position.y + (rotation * *p).y).fold(f64::INFINITY, f64::min)
        };
        let lowest =
            self.source.sides[side as usize].iter().map(lowest).fold(f64::INFINITY, f64::min);
        let (size, depth) = (f64::from(source.skeleton.size_m()), self.source.ground - lowest);
        // From nothing to the whole depth, without a step.
        let meant = (2.0 * (depth - INTENDED_DEPTH * size)).min(depth);
        (self.common.scale * meant).max(DEPTH_TOLERANCE * self.target.height)
    }

    /// Rolls a foot, then its toes, about their own left-right axes by the smallest angle that
    /// keeps them no deeper than `depth`. Returns the rotations of the joints. Toes with a source
    /// joint keep their own direction while the foot rolls.
    pub(super) fn roll_feet(&self, side: Side, feet: &mut [Stands], depth: f64) -> Vec<DQuat> {
        let bottom = self.target.ground - depth;
        let mut found = Vec::new();
        let mut above: Option<(DQuat, Stands, DVec3)> = None;
        for sole in &self.target.sides[side as usize] {
            let own = feet.iter().position(|foot| foot.joint == sole.joint);
            let (before, mut now) = match (&above, own) {
                (None, None) => {
                    return vec![DQuat::IDENTITY; self.target.sides[side as usize].len()];
                }
                (None, Some(own)) => (feet[own].rotation, feet[own]),
                (Some((before, foot, rest)), own) => {
                    // As it would be rotated, and as it is after the foot has rolled.
                    let rotation = own.map_or(*before, |own| feet[own].rotation);
                    let position = foot.position + foot.rotation * (sole.rest - *rest);
                    (
                        rotation,
                        Stands {
                            joint: sole.joint,
                            position,
                            rotation: own.map_or(foot.rotation, |_| rotation),
                        },
                    )
                }
            };
            let roll = Contact::new(sole, &now).roll(bottom, self.target.height);
            now.rotation *= DQuat::from_rotation_x(roll);
            if let Some(own) = own {
                feet[own] = now;
            }
            let at_rest = self.common.target.rotation[sole.joint.index()];
            let (was, is) = (before * at_rest, now.rotation * at_rest);
            let carried =
                above.map_or(DQuat::IDENTITY, |(before, foot, _)| foot.rotation * before.inverse());
            found.push(((carried * was).inverse() * is).normalize());
            above = Some((before, now, sole.rest));
        }
        found
    }
}

/// A sole in a pose, rolling about its own left-right axis.
struct Contact<'a> {
    sole: &'a Sole,
    /// Height of the joint.
    height: f64,
    /// The up direction in the foot's space.
    up: DVec3,
}

impl<'a> Contact<'a> {
    fn new(sole: &'a Sole, now: &Stands) -> Self {
        Self { sole, height: now.position.y, up: now.rotation.inverse() * DVec3::Y }
    }

    /// Returns the roll angle at which the sole is flat; above 0 if the toes are up.
    fn flat(&self) -> f64 {
        self.up.z.atan2(self.up.y)
    }

    /// Returns 1 for a foot that can be walking, 0 for one that cannot, and values in between.
    fn walking_weight(&self) -> f64 {
        let (flat, edge) = (self.flat(), self.up.x.clamp(-1.0, 1.0).asin().abs());
        fade(flat, TOES_UP_RAD) * fade(-flat, TOES_DOWN_RAD) * fade(edge, EDGE_DOWN_RAD)
    }

    /// Returns the height of the lowest point after rolling by an angle, and its derivative.
    fn lowest(&self, angle: f64) -> (f64, f64) {
        let (up, (sin, cos)) = (self.up, angle.sin_cos());
        let heights = self.sole.points.iter().map(|p| {
            let (along, across) = (up.y * p.y + up.z * p.z, up.z * p.y - up.y * p.z);
            (self.height + up.x * p.x + cos * along + sin * across, cos * across - sin * along)
        });
        heights.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, 0.0))
    }

    /// Returns the smallest angle in radians that brings the sole above `bottom`, or the angle at
    /// which it is flat if that is not enough. During a heel strike the contact passes straight
    /// under the ankle, where rolling gains little height. A full roll would flip the foot from one
    /// side to the other there, so it rolls less and stays slightly too deep.
    fn roll(&self, bottom: f64, body_height: f64) -> f64 {
        let (at, rises) = self.lowest(0.0);
        if at >= bottom {
            return 0.0;
        }
        let flat = self.flat();
        let tilted = flat.abs() > FLAT_TILT_RAD;
        let (towards, mut enough) = if tilted {
            (flat.signum(), flat.abs())
        } else {
            (rises.signum(), 2.0 * FLAT_TILT_RAD)
        };
        let mut less = 0.0;
        for _ in 0..HALVINGS {
            let angle = (less + enough) / 2.0;
            let (at, rises) = self.lowest(towards * angle);
            if at >= bottom || !tilted && rises * towards <= 0.0 {
                enough = angle;
            } else {
                less = angle;
            }
        }
        let part = (bottom - at) / (EXCESS_DEPTH * body_height)
            + (towards * rises).max(0.0) / (CONTACT_DISTANCE * body_height);
        let left = bottom - self.lowest(towards * enough).0;
        towards
            * enough
            * part.min(1.0)
            * fade(left / body_height, ANKLE_DEPTH)
            * self.walking_weight()
    }
}

/// Returns 1 up to the first value, 0 from the second on, and a linear ramp in between.
fn fade(value: f64, [from, to]: [f64; 2]) -> f64 {
    ((to - value) / (to - from)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests;
