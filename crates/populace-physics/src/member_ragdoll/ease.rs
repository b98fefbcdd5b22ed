//! Easing from the pose of a ragdoll that lies into the first pose of a motion.
//!
//! Joints turn in model space, on the shortest way if it does not dip below the ground. Otherwise a
//! limb sweeps over the ground: its heading and its slope change evenly.

use std::sync::Arc;

use populace::model::{JointIndex, Skeleton};
use populace::{Affine, BackendError, Crowd, JointOverride, MemberId, Placement, Space, Trs};

use super::MemberRagdoll;
use super::overrides::model_overrides;
use crate::math::{Rotation, Vector, joint_index, origin, point, rotation_of, trs};
use crate::world::World;
use crate::{Error, RagdollPlan};

/// Share of the time during which model-space overrides still prevail over constraints such as
/// planted feet.
const MODEL_OVERRIDE_SHARE: f32 = 0.3;

/// Depth in metres by which a limb may dip lower than at both ends before it sweeps.
const SHALLOW_M: f32 = 0.02;

/// A joint that is moved by a body.
#[derive(Clone)]
struct EasedJoint {
    joint: usize,
    body: usize,
    /// Index of the parent among the eased joints, or `None` if no body moves it.
    parent: Option<usize>,
}

/// A pose of the eased joints.
#[derive(Clone)]
struct EasedPose {
    /// Relative to the parent, or in model space without one.
    locals: Vec<Trs>,
    /// Rotations down the hierarchy in model space, without the effect of scales.
    rotations: Vec<Rotation>,
    /// The axes of all bodies in model space: heights of the joints at their heads, and the way
    /// from there to their far ends.
    axes: Vec<(f32, Vector)>,
}

/// A member that eases from the pose of its ragdoll, which no longer exists, into a motion.
#[derive(Clone)]
pub(crate) struct Ease {
    member: MemberId,
    plan: Arc<RagdollPlan>,
    joints: Vec<EasedJoint>,
    from: EasedPose,
    /// The first pose of the motion, once an update has evaluated it.
    to: Option<EasedPose>,
    /// The bodies whose shortest way would dip below the ground.
    sweeps: Vec<bool>,
    /// The crowd's time at the start. Until it goes on, no update has evaluated the motion.
    start_secs: f64,
    elapsed_secs: f32,
    over_secs: f32,
}

impl MemberRagdoll {
    /// Captures the pose of a ragdoll that is limp as a whole, relative to the placement `place`.
    pub(crate) fn ease(
        &self,
        crowd: &Crowd,
        world: &World,
        place: &Placement,
        over_secs: f32,
    ) -> Ease {
        let locals = self.carried.iter().map(|c| self.joint_override(world, place, c, 1.0));
        let locals: Vec<Trs> = locals.map(|given| given.transform).collect();
        let index = |joint: usize| self.carried.binary_search_by_key(&joint, |c| c.joint).ok();
        let joints: Vec<EasedJoint> = self
            .carried
            .iter()
            .map(|c| EasedJoint { joint: c.joint, body: c.body, parent: c.parent.and_then(index) })
            .collect();
        let from = EasedPose::new(&joints, &self.plan, locals);
        let (member, plan) = (self.member, Arc::clone(&self.plan));
        let start_secs = crowd.time_secs();
        let sweeps = vec![false; plan.bodies().len()];
        let elapsed_secs = 0.0;
        Ease { member, plan, joints, from, to: None, sweeps, start_secs, elapsed_secs, over_secs }
    }
}

impl EasedPose {
    fn new(joints: &[EasedJoint], plan: &RagdollPlan, locals: Vec<Trs>) -> Self {
        let mut rotations: Vec<Rotation> = Vec::with_capacity(joints.len());
        let mut models: Vec<Affine> = Vec::with_capacity(joints.len());
        let mut axes = vec![(0.0, Vector::ZERO); plan.bodies().len()];
        for (eased, local) in joints.iter().zip(&locals) {
            let (own, turn) = (Affine::from_trs(local), rotation_of(local));
            models.push(eased.parent.map_or(own, |p| models[p].mul(&own)));
            rotations.push(eased.parent.map_or(turn, |p| rotations[p] * turn).normalize());
            let body = &plan.bodies()[eased.body];
            if let Some(model) = models.last().filter(|_| body.head == eased.joint) {
                let head = origin(model);
                axes[eased.body] = (head.y, point(model, body.to) - head);
            }
        }
        Self { locals, rotations, axes }
    }

    /// Returns the height of a body's far end.
    fn end(&self, body: usize) -> f32 {
        self.axes[body].0 + self.axes[body].1.y
    }
}

impl Ease {
    /// Returns the remaining weight of the ragdoll's pose, eased in and out.
    pub(crate) fn weight(&self) -> f32 {
        remaining(self.elapsed_secs, self.over_secs)
    }

    /// Takes over the joints of the ragdoll. Overrides in model space alone show its pose, so that
    /// local transforms are those of the motion.
    pub(crate) fn start(&self, crowd: &mut Crowd) -> Result<(), Error> {
        let overrides = self.overrides(&self.from.locals);
        let models = self.models(&overrides, 1.0);
        let shown = |o: &JointOverride| models.iter().any(|m| m.joint == o.joint);
        let hidden: Vec<JointIndex> = overrides
            .iter()
            .filter(|o| o.space == Space::Local && shown(o))
            .map(|o| o.joint)
            .collect();
        let mut view = crowd.member_mut(self.member)?;
        view.override_joints(&overrides)?;
        view.override_joints(&models)?;
        view.release_joints(Space::Local, &hidden)?;
        Ok(())
    }

    /// Advances by `dt_secs` and writes the overrides. Returns whether the member still eases.
    pub(crate) fn advance(&mut self, crowd: &mut Crowd, dt_secs: f32) -> Result<bool, Error> {
        if self.to.is_none() {
            if crowd.time_secs() <= self.start_secs {
                return Ok(true);
            }
            let locals = match crowd.member_mut(self.member)?.local_pose() {
                Ok(locals) => locals,
                Err(populace::Error::Backend(BackendError::NotEvaluated)) => return Ok(true),
                Err(error) => return Err(error.into()),
            };
            let character = crowd.member(self.member)?.character();
            let skeleton = &crowd.character(character)?.asset().skeleton;
            let locals = self.joints.iter().map(|eased| eased.local(skeleton, &locals)).collect();
            let to = EasedPose::new(&self.joints, &self.plan, locals);
            self.sweeps = self.sweeping(&to);
            self.to = Some(to);
        }
        self.elapsed_secs += dt_secs;
        if self.weight() <= 0.0 {
            self.release(crowd)?;
            return Ok(false);
        }
        let Some(to) = &self.to else { return Ok(true) };
        let mut overrides = self.overrides(&self.mixed(to, self.weight()));
        let early = remaining(self.elapsed_secs, MODEL_OVERRIDE_SHARE * self.over_secs);
        overrides.extend(self.models(&overrides, early));
        crowd.member_mut(self.member)?.override_joints(&overrides)?;
        Ok(true)
    }

    /// Releases all overrides, so that the clips move the joints.
    pub(crate) fn release(&self, crowd: &mut Crowd) -> Result<(), Error> {
        let joints: Vec<JointIndex> = self.joints.iter().map(|e| joint_index(e.joint)).collect();
        let mut view = crowd.member_mut(self.member)?;
        view.release_joints(Space::Local, &joints)?;
        view.release_joints(Space::Model, &joints)?;
        Ok(())
    }

    /// Returns for each body whether its far end dips below both ends on the shortest way.
    fn sweeping(&self, to: &EasedPose) -> Vec<bool> {
        let mut sweeps = vec![false; self.plan.bodies().len()];
        for (index, eased) in self.joints.iter().enumerate() {
            let body = eased.body;
            if self.plan.bodies()[body].head != eased.joint {
                continue;
            }
            let (from_head, from_axis) = self.from.axes[body];
            let start = self.from.rotations[index];
            let turn = to.rotations[index] * start.inverse();
            let height = |part: f32| {
                let axis = Rotation::IDENTITY.slerp(turn, part) * from_axis;
                from_head + (to.axes[body].0 - from_head) * part + axis.y
            };
            let least = self.from.end(body).min(to.end(body)) - SHALLOW_M;
            sweeps[body] = [0.2, 0.35, 0.5, 0.65, 0.8].into_iter().any(|part| height(part) < least);
        }
        sweeps
    }

    /// Returns the local transforms of the pose between both.
    fn mixed(&self, to: &EasedPose, weight: f32) -> Vec<Trs> {
        let mut lifts = vec![Rotation::IDENTITY; self.plan.bodies().len()];
        let mut rotations: Vec<Rotation> = Vec::with_capacity(self.joints.len());
        let mut models: Vec<Affine> = Vec::with_capacity(self.joints.len());
        let mut locals = Vec::with_capacity(self.joints.len());
        for (index, eased) in self.joints.iter().enumerate() {
            let (a, b) = (&to.locals[index], &self.from.locals[index]);
            let between = to.rotations[index].slerp(self.from.rotations[index], weight);
            let turn = lifts[eased.body] * between;
            let mut local = Trs {
                translation: mix(a.translation, b.translation, weight),
                rotation: local_rotation(&rotations, eased, turn),
                scale: mix(a.scale, b.scale, weight),
            };
            let model = |local: &Trs| {
                let own = Affine::from_trs(local);
                eased.parent.map_or(own, |p| models[p].mul(&own))
            };
            let body = &self.plan.bodies()[eased.body];
            let mut own = model(&local);
            let mut turn = turn;
            if body.head == eased.joint {
                let head = origin(&own);
                let axis = point(&own, body.to) - head;
                let mut wanted = axis;
                if self.sweeps[eased.body] {
                    let [to, from] = [to, &self.from].map(|pose| pose.axes[eased.body].1);
                    wanted = swept(to, from, weight) * axis.length();
                }
                let least = to.end(eased.body).min(self.from.end(eased.body));
                let lift = arc(axis, lifted(wanted, least - head.y));
                lifts[eased.body] = lift;
                turn = lift * turn;
                local.rotation = local_rotation(&rotations, eased, turn);
                own = model(&local);
            }
            rotations.push(turn.normalize());
            models.push(own);
            locals.push(local);
        }
        locals
    }

    fn overrides(&self, locals: &[Trs]) -> Vec<JointOverride> {
        let one = |(eased, transform): (&EasedJoint, &Trs)| JointOverride {
            joint: joint_index(eased.joint),
            space: if eased.parent.is_some() { Space::Local } else { Space::Model },
            transform: *transform,
            weight: 1.0,
        };
        self.joints.iter().zip(locals).map(one).collect()
    }

    fn models(&self, overrides: &[JointOverride], weight: f32) -> Vec<JointOverride> {
        let parents: Vec<_> = self.joints.iter().map(|eased| eased.parent).collect();
        model_overrides(&parents, overrides, weight)
    }
}

impl EasedJoint {
    /// Returns the joint's transform, relative to its parent or in model space, in a pose of the
    /// whole skeleton.
    fn local(&self, skeleton: &Skeleton, locals: &[Trs]) -> Trs {
        let own = locals[self.joint];
        if self.parent.is_some() {
            return own;
        }
        let mut model = Affine::from_trs(&own);
        let mut at = joint_index(self.joint);
        while let Some(parent) = skeleton.parent(at) {
            model = Affine::from_trs(&locals[parent.index()]).mul(&model);
            at = parent;
        }
        trs(&model)
    }
}

/// Returns a joint's rotation against its parent, of which the rotation is known already.
fn local_rotation(rotations: &[Rotation], eased: &EasedJoint, turn: Rotation) -> [f32; 4] {
    let local = eased.parent.map_or(turn, |p| rotations[p].inverse() * turn);
    local.normalize().to_array()
}

/// Returns the heading about +Y and the slope of a direction in radians.
fn angles(direction: Vector) -> (f32, f32) {
    let unit = direction.normalize_or(Vector::Y);
    (unit.x.atan2(unit.z), unit.y.clamp(-1.0, 1.0).asin())
}

/// Returns the unit vector with a heading and a slope.
fn towards(heading: f32, slope: f32) -> Vector {
    Rotation::from_rotation_y(heading) * Rotation::from_rotation_x(-slope) * Vector::Z
}

/// Returns the unit vector between the directions of `a` and `b` whose heading and slope are
/// between theirs.
fn swept(a: Vector, b: Vector, weight: f32) -> Vector {
    let ((from, low), (to, high)) = (angles(a), angles(b));
    let half_turn = std::f32::consts::PI;
    let turn = (to - from + half_turn).rem_euclid(2.0 * half_turn) - half_turn;
    towards(from + turn * weight, low + (high - low) * weight)
}

/// Returns `axis` turned up until it rises by at least `rise`.
fn lifted(axis: Vector, rise: f32) -> Vector {
    let length = axis.length();
    if axis.y >= rise || length <= 1e-6 {
        return axis;
    }
    towards(angles(axis).0, (rise / length).clamp(-1.0, 1.0).asin()) * length
}

/// Returns the shortest rotation from one direction to another.
fn arc(from: Vector, to: Vector) -> Rotation {
    match (from.try_normalize(), to.try_normalize()) {
        (Some(from), Some(to)) if from != to => Rotation::from_rotation_arc(from, to),
        _ => Rotation::IDENTITY,
    }
}

fn mix(a: [f32; 3], b: [f32; 3], weight: f32) -> [f32; 3] {
    std::array::from_fn(|axis| a[axis] + (b[axis] - a[axis]) * weight)
}

/// Returns 1 minus the smoothstep of the elapsed fraction of `over_secs`.
fn remaining(elapsed_secs: f32, over_secs: f32) -> f32 {
    if elapsed_secs >= over_secs {
        return 0.0;
    }
    let t = elapsed_secs / over_secs;
    1.0 - t * t * (3.0 - 2.0 * t)
}
