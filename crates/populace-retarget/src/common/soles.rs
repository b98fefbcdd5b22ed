//! Feet that roll where the mesh of the target would go into the ground: a foot of another shape,
//! or without toes, that turns as the source's does reaches deeper than its ankle tells.

use glam::{DAffine3, DQuat, DVec3};
use populace_model::JointIndex;
use populace_model::humanoid::{Role, Side};

use super::feet::{SIDES, Stands};
use super::{Common, Figure};

/// Soles may be this deep in the ground, in parts of the body's height: nobody sees it, and feet
/// roll the less.
const SINKS: f64 = 0.007;
/// The whole body is lifted by no more than this part of its hips' height for the sake of heels.
const LIFTS: f64 = 0.015;
/// What feet of the source sink, in parts of its body, is a walk that is not exact; so much deeper
/// they are meant to, and those of the target are let.
const MEANT: f64 = 0.03;
/// A foot that is further from flat than this, in radians, rolls towards that.
const TILTED_RAD: f64 = 0.2;
/// It rolls all of its way where its contact is no nearer than this to straight under the joint, or
/// as much too deep, in parts of the body's height.
const NEAR: f64 = 0.02;
const DEEP: f64 = 0.005;
/// Feet of who walks have toes up, toes down and an edge down, in radians, by no more than the
/// first of each pair; those of who lies, sits or kneels by the second or more, and rolling does
/// not help them.
const TOES_UP_RAD: [f64; 2] = [0.6, 1.1];
const TOES_DOWN_RAD: [f64; 2] = [1.7, 2.1];
const EDGE_DOWN_RAD: [f64; 2] = [0.6, 1.0];
/// Nor does it where the joint itself is too deep by as much, in parts of the body's height.
const HOPELESS: [f64; 2] = [0.01, 0.03];
/// Halvings of the angle by which a foot rolls.
const HALVINGS: u32 = 24;
/// Rotations that are no further from none, in radians, are none.
const STILL_RAD: f64 = 0.01;

/// A foot without its toes, or toes.
struct Sole {
    joint: JointIndex,
    /// Where the joint rests, in model space.
    rest: DVec3,
    /// Points that may touch the ground, at rest, from the joint.
    points: Vec<DVec3>,
}

impl Sole {
    /// Of the joint and all that hangs on it, less `without` and what hangs on that.
    fn new(figure: &Figure<'_>, joint: JointIndex, without: Option<JointIndex>) -> Self {
        let skeleton = figure.skeleton;
        let hangs = |on: JointIndex, j: JointIndex| j == on || skeleton.is_below(j, on);
        let own =
            skeleton.joints().filter(|&j| hangs(joint, j) && !without.is_some_and(|w| hangs(w, j)));
        let rest = figure.place(joint);
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
    /// Of each side a foot, and its toes where there are any.
    sides: [Vec<Sole>; 2],
    /// How high they are at rest.
    ground: f64,
    /// How much higher the highest joint is.
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
        let top =
            figure.skeleton.joints().map(|j| figure.place(j).y).fold(f64::NEG_INFINITY, f64::max);
        Self { sides, ground, height: top - ground }
    }

    /// Where no mesh is known, what is under the joints is the sole.
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

/// What keeps the soles of the target above the ground.
pub(crate) struct Soles<'a> {
    common: &'a Common<'a>,
    source: Feet,
    target: Feet,
}

impl<'a> Soles<'a> {
    /// `None` where the target's soles are not known, or a foot would be torn from toes that do not
    /// hang on it.
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

    /// The joints that are turned.
    pub(crate) fn joints(&self) -> Vec<JointIndex> {
        self.target.sides.iter().flatten().map(|sole| sole.joint).collect()
    }

    /// The rotations that keep feet above the ground in a pose of the source's joints, in the order
    /// of [`joints`](Self::joints): each comes after the joint's own.
    pub(crate) fn turns(&self, pose: &[DAffine3]) -> Vec<DQuat> {
        let (turns, models) = self.common.source_models(pose);
        let of = |side| {
            let mut feet = self.common.feet(side, &turns, &models);
            self.stand(side, &mut feet, self.depth(&turns, &models, side))
        };
        // What a clip scales to nothing has no direction.
        let sound = |turn: DQuat| if turn.is_finite() { turn } else { DQuat::IDENTITY };
        SIDES.into_iter().flat_map(of).map(sound).collect()
    }

    /// How much the whole body is to be lifted for heels that would strike too deep: to roll the
    /// foot until it is flat would be no heel strike. `poses` are local transforms of the source's
    /// joints.
    pub(crate) fn heels(&self, poses: &[Vec<DAffine3>]) -> f64 {
        let deep = |pose: &Vec<DAffine3>| {
            let (turns, models) = self.common.source_models(pose);
            let of = |side: Side| {
                let bottom = self.target.ground - self.depth(&turns, &models, side);
                let feet = self.common.feet(side, &turns, &models);
                let sole = self.target.sides[side as usize].first()?;
                let contact =
                    Contact::new(sole, feet.iter().find(|foot| foot.joint == sole.joint)?);
                (contact.flat() > TILTED_RAD)
                    .then(|| contact.walks() * (bottom - contact.lowest(0.0).0))
            };
            SIDES.into_iter().filter_map(of).fold(0.0, f64::max)
        };
        let target = &self.common.target;
        let hips = target
            .roles
            .joint(Role::Hips)
            .map_or(0.0, |hips| target.place(hips).y - self.target.ground);
        poses.iter().map(deep).fold(0.0, f64::max).min(LIFTS * hips.max(0.0))
    }

    /// Whether rotations change nothing that can be seen.
    pub(crate) fn are_none(turns: &[DQuat]) -> bool {
        turns.iter().all(|turn| turn.angle_between(DQuat::IDENTITY) <= STILL_RAD)
    }

    /// How deep a foot of the target may be in the ground: the source's may be meant to.
    pub(super) fn depth(&self, turns: &[DQuat], models: &[DAffine3], side: Side) -> f64 {
        let source = &self.common.source;
        let lowest = |sole: &Sole| {
            let turn = turns[sole.joint.index()] * source.turn[sole.joint.index()].inverse();
            let place = models[sole.joint.index()].translation;
            sole.points.iter().map(|p| place.y + (turn * *p).y).fold(f64::INFINITY, f64::min)
        };
        let lowest =
            self.source.sides[side as usize].iter().map(lowest).fold(f64::INFINITY, f64::min);
        let (size, depth) = (f64::from(source.skeleton.size_m()), self.source.ground - lowest);
        // From none at all to all of it, without a step.
        let meant = (2.0 * (depth - MEANT * size)).min(depth);
        (self.common.scale * meant).max(SINKS * self.target.height)
    }

    /// Rolls a foot, then its toes, about their own left-right axes by as little as keeps them no
    /// deeper than `depth`, and returns how the joints are turned for it. Toes keep their own
    /// direction while the foot rolls where they have one.
    pub(super) fn stand(&self, side: Side, feet: &mut [Stands], depth: f64) -> Vec<DQuat> {
        let bottom = self.target.ground - depth;
        let mut found = Vec::new();
        let mut above: Option<(DQuat, Stands, DVec3)> = None;
        for sole in &self.target.sides[side as usize] {
            let own = feet.iter().position(|foot| foot.joint == sole.joint);
            let (before, mut now) = match (&above, own) {
                (None, None) => {
                    return vec![DQuat::IDENTITY; self.target.sides[side as usize].len()];
                }
                (None, Some(own)) => (feet[own].turn, feet[own]),
                (Some((before, foot, rest)), own) => {
                    // As it would be turned, and as it is once the foot has rolled.
                    let turn = own.map_or(*before, |own| feet[own].turn);
                    let place = foot.place + foot.turn * (sole.rest - *rest);
                    (
                        turn,
                        Stands { joint: sole.joint, place, turn: own.map_or(foot.turn, |_| turn) },
                    )
                }
            };
            let roll = Contact::new(sole, &now).roll(bottom, self.target.height);
            now.turn *= DQuat::from_rotation_x(roll);
            if let Some(own) = own {
                feet[own] = now;
            }
            let at_rest = self.common.target.turn[sole.joint.index()];
            let (was, is) = (before * at_rest, now.turn * at_rest);
            let carried =
                above.map_or(DQuat::IDENTITY, |(before, foot, _)| foot.turn * before.inverse());
            found.push(((carried * was).inverse() * is).normalize());
            above = Some((before, now, sole.rest));
        }
        found
    }
}

/// A sole in a pose, rolled about its own left-right axis.
struct Contact<'a> {
    sole: &'a Sole,
    /// Of the joint.
    height: f64,
    /// Up as the foot sees it.
    up: DVec3,
}

impl<'a> Contact<'a> {
    fn new(sole: &'a Sole, now: &Stands) -> Self {
        Self { sole, height: now.place.y, up: now.turn.inverse() * DVec3::Y }
    }

    /// The angle by which it would have to roll to be flat; more than 0 where toes are up.
    fn flat(&self) -> f64 {
        self.up.z.atan2(self.up.y)
    }

    /// 1 for a foot that may be that of who walks, 0 for one that is not, or between.
    fn walks(&self) -> f64 {
        let (flat, edge) = (self.flat(), self.up.x.clamp(-1.0, 1.0).asin().abs());
        fade(flat, TOES_UP_RAD) * fade(-flat, TOES_DOWN_RAD) * fade(edge, EDGE_DOWN_RAD)
    }

    /// The height of its lowest point once it has rolled by an angle, and how fast that changes.
    fn lowest(&self, angle: f64) -> (f64, f64) {
        let (up, (sin, cos)) = (self.up, angle.sin_cos());
        let heights = self.sole.points.iter().map(|p| {
            let (along, across) = (up.y * p.y + up.z * p.z, up.z * p.y - up.y * p.z);
            (self.height + up.x * p.x + cos * along + sin * across, cos * across - sin * along)
        });
        heights.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, 0.0))
    }

    /// The smallest angle, in radians, that brings it above `bottom`, or as far as rolling does:
    /// then it is flat. What a heel rests on passes straight under the ankle as it strikes; there
    /// it would take much to gain little, and the foot would flip from one side of that to the
    /// other, so it rolls less and stays a little too deep.
    fn roll(&self, bottom: f64, body_height: f64) -> f64 {
        let (at, rises) = self.lowest(0.0);
        if at >= bottom {
            return 0.0;
        }
        let flat = self.flat();
        let tilted = flat.abs() > TILTED_RAD;
        let (towards, mut enough) =
            if tilted { (flat.signum(), flat.abs()) } else { (rises.signum(), 2.0 * TILTED_RAD) };
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
        let part = (bottom - at) / (DEEP * body_height)
            + (towards * rises).max(0.0) / (NEAR * body_height);
        let left = bottom - self.lowest(towards * enough).0;
        towards * enough * part.min(1.0) * fade(left / body_height, HOPELESS) * self.walks()
    }
}

/// 1 up to the first of two values, 0 from the second on.
fn fade(value: f64, [from, to]: [f64; 2]) -> f64 {
    ((to - value) / (to - from)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests;
