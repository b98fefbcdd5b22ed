//! Controls: what moves a member besides its clips, in double precision. Each kind of constraint
//! has a file of its own.
//!
//! Joints are visited from the roots outwards. At each joint things happen in the order that
//! `docs/animation.md` states.

mod chain;
mod feet;
mod gaze;
mod limb;
mod overrides;
mod targets;

use std::collections::HashMap;

use glam::{DAffine3, DQuat, DVec3};
use populace_clip::FIRST_TICK;
use populace_device::{After, Constraint, Controls, Space};
use populace_model::{JointIndex, Skeleton};

use super::noise::Noise;
use super::transform::parent_from_joint;
use super::{Local, OracleBody};

use feet::Feeling;

pub use feet::{OracleGait, OracleStance};
pub use targets::OraclePlace;

/// The frame in which controls act.
#[derive(Clone, Debug, Default)]
pub struct OracleFrame {
    /// The clock.
    pub tick: u64,
    /// Where the member stands.
    pub place: OraclePlace,
    /// World transforms of watched joints as of the frame before, by index; none was seen before
    /// its first frame.
    pub watched: HashMap<u32, DAffine3>,
    /// The model transform, in this frame, of the joint that the member is attached to.
    pub parent: Option<DAffine3>,
    /// How far clips have moved the member.
    pub motion: Option<DAffine3>,
}

/// A user stage on a transform: the local one of a joint, or its model transform.
#[derive(Clone, Copy)]
pub enum OracleStage {
    /// Runs after Pose.
    Pose(fn(&mut Local, &OracleStageInputs)),
    /// Runs after Transform.
    Transform(fn(&mut DAffine3, &OracleStageInputs)),
}

/// Inputs of a user stage besides the transform.
pub struct OracleStageInputs {
    /// The member's values.
    pub values: [f64; 4],
    /// The joint, in level order.
    pub joint: JointIndex,
    /// Ticks since the crowd began.
    pub ticks: u64,
}

impl OracleStageInputs {
    fn new(values: [f32; 4], joint: JointIndex, tick: u64) -> Self {
        let ticks = tick.saturating_sub(FIRST_TICK);
        Self { values: values.map(f64::from), joint, ticks }
    }
}

/// A member with its controls.
#[derive(Clone)]
pub struct OracleMember<'a> {
    /// Its body.
    pub body: &'a OracleBody,
    /// The same skeleton, which names joints in level order.
    pub skeleton: &'a Skeleton,
    /// What moves it besides its clips, as the host states it.
    pub controls: &'a Controls,
    /// User stages by number.
    pub stages: &'a [OracleStage],
}

/// A chain as its constraint finds it.
struct ChainNow {
    /// Joints in source order, from the first to the last.
    joints: Vec<usize>,
    /// Their positions in model space.
    positions: Vec<DVec3>,
    /// Their model transforms.
    models: Vec<DAffine3>,
    /// The model transform of the last one.
    end: DAffine3,
}

/// Model transforms on the way down the hierarchy.
struct Descent<'a, 'n> {
    of: &'a OracleMember<'a>,
    frame: &'a OracleFrame,
    noise: &'n mut Noise,
    locals: Vec<Local>,
    models: Vec<Option<DAffine3>>,
    /// Rotations that a constraint (by number) leaves for the joints below its first.
    left: HashMap<(usize, usize), DQuat>,
    feet: Option<Feeling<'a>>,
}

impl OracleMember<'_> {
    /// Returns the local transforms after overrides and stages, and `model_from_joint` of each
    /// joint. `clips` are the local transforms that clips give.
    ///
    /// # Panics
    ///
    /// If the controls name a joint or a stage that does not exist.
    #[must_use]
    pub fn posed(
        &self,
        clips: &[Local],
        frame: &OracleFrame,
        noise: &mut Noise,
    ) -> (Vec<Local>, Vec<DAffine3>) {
        self.descend(clips, frame, None, noise)
    }

    /// Returns the same for a member whose feet are planted. `stance` is that after the frame
    /// before, and becomes that after this one.
    ///
    /// # Panics
    ///
    /// As [`posed`](Self::posed), or if the gait does not know all feet.
    #[must_use]
    pub fn posed_on_feet(
        &self,
        clips: &[Local],
        frame: &OracleFrame,
        (gait, stance): (&OracleGait, &mut OracleStance),
        noise: &mut Noise,
    ) -> (Vec<Local>, Vec<DAffine3>) {
        let feet = Feeling { gait, stance, goals: Vec::new() };
        self.descend(clips, frame, Some(feet), noise)
    }

    fn descend<'a>(
        &'a self,
        clips: &[Local],
        frame: &'a OracleFrame,
        feet: Option<Feeling<'a>>,
        noise: &mut Noise,
    ) -> (Vec<Local>, Vec<DAffine3>) {
        let mut locals = clips.to_vec();
        self.override_locals(&mut locals, frame.tick, noise);
        let count = locals.len();
        let mut descent = Descent {
            of: self,
            frame,
            noise,
            locals,
            models: vec![None; count],
            left: HashMap::new(),
            feet,
        };
        (0..count).for_each(|joint| {
            descent.reach(joint);
        });
        let models = descent.models.iter().flatten().copied().collect();
        (descent.locals, models)
    }

    fn source(&self, joint: JointIndex) -> usize {
        self.skeleton.source_from_joint(joint)
    }

    /// Returns the joints from `first` down to `last`, in source order.
    fn path(&self, first: JointIndex, last: JointIndex) -> Vec<usize> {
        let (first, last) = (self.source(first), self.source(last));
        let up = std::iter::successors(Some(last), |joint| {
            (*joint != first).then(|| self.body.joints[*joint].parent.expect("first is above last"))
        });
        let mut path: Vec<usize> = up.collect();
        path.reverse();
        path
    }

    /// Returns the rotation of a joint at rest in model space, as if nothing were scaled.
    fn rest_rotation(&self, joint: Option<usize>) -> DQuat {
        joint.map_or(DQuat::IDENTITY, |joint| {
            let parent = self.body.joints[joint].parent;
            (self.rest_rotation(parent) * self.body.rest(joint).rotation).normalize()
        })
    }

    /// Brings a direction at rest in model space into a joint's space.
    fn in_joint(&self, joint: Option<usize>, direction: [f32; 3]) -> DVec3 {
        let direction = DVec3::from_array(direction.map(f64::from)).normalize_or_zero();
        self.rest_rotation(joint).inverse() * direction
    }

    /// Returns the first joint of a constraint.
    fn first_of(&self, constraint: &Constraint) -> Option<usize> {
        Some(self.source(match constraint {
            Constraint::Gaze(gaze) => gaze.chain.first()?.0,
            Constraint::Limb(limb) => limb.first,
            Constraint::Chain(chain) => chain.first,
            Constraint::Feet(feet) => feet.pelvis,
        }))
    }
}

impl Descent<'_, '_> {
    /// Returns the final model transform of a joint, after that of its parent.
    fn reach(&mut self, joint: usize) -> DAffine3 {
        if let Some(model) = self.models[joint] {
            return model;
        }
        let parent = self.of.body.joints[joint].parent;
        let local = parent_from_joint(&self.locals[joint]);
        let local = DAffine3 { matrix3: self.noise.matrix(local.matrix3), ..local };
        let model = match parent {
            Some(parent) => {
                let above = self.reach(parent);
                self.noise.product(&above, &local)
            }
            None => self.placed(local),
        };
        self.models[joint] = Some(model);
        for number in 0..self.of.controls.constraints.len() {
            self.constrain(number, joint);
        }
        self.run_stages(joint);
        self.override_model(joint);
        self.model(joint)
    }

    fn model(&self, joint: usize) -> DAffine3 {
        self.models[joint].expect("parents come first")
    }

    /// Moves a root as clips move the member, then to what it is attached to.
    fn placed(&mut self, local: DAffine3) -> DAffine3 {
        let mut model = local;
        if let Some(motion) = &self.frame.motion {
            model = self.noise.product(motion, &model);
        }
        if let (Some((_, offset)), Some(parent)) = (self.of.controls.attached, self.frame.parent) {
            let offset = parent_from_joint(&overrides::given(&offset));
            let at = self.noise.product(&parent, &offset);
            model = self.noise.product(&at, &model);
        }
        model
    }

    /// Rotates a joint in model space, about its own position.
    fn rotate(&mut self, joint: usize, rotation: DQuat) {
        let model = self.model(joint);
        let rotated = glam::DMat3::from_quat(rotation) * model.matrix3;
        let matrix3 = self.noise.matrix(rotated);
        self.models[joint] = Some(DAffine3 { matrix3, ..model });
    }

    /// Solves a constraint at its first joint, or takes the rotation that it left for this joint.
    fn constrain(&mut self, number: usize, joint: usize) {
        let constraint = &self.of.controls.constraints[number];
        if self.of.first_of(constraint) == Some(joint) {
            let rotations = match constraint {
                Constraint::Gaze(gaze) => self.gaze(gaze),
                Constraint::Limb(limb) => self.limb(limb),
                Constraint::Chain(chain) => self.chain(chain),
                Constraint::Feet(feet) => {
                    self.plant(feet);
                    Vec::new()
                }
            };
            self.leave(number, rotations);
        }
        if let Constraint::Feet(feet) = constraint {
            for nth in 0..feet.feet.len() {
                if self.of.source(feet.feet[nth].hip) == joint {
                    let rotations = self.leg(feet, nth);
                    self.leave(number, rotations);
                }
            }
        }
        if let Some(rotation) = self.left.remove(&(number, joint)) {
            self.rotate(joint, rotation);
        }
    }

    /// Leaves rotations of a constraint for joints to come.
    fn leave(&mut self, number: usize, rotations: Vec<(usize, DQuat)>) {
        self.left.extend(rotations.into_iter().map(|(joint, q)| ((number, joint), q)));
    }

    /// Walks down a chain by its local transforms, from where its first joint is now.
    fn walk(&mut self, joints: Vec<usize>) -> ChainNow {
        let mut end = self.model(joints[0]);
        let mut models = vec![end];
        for &joint in &joints[1..] {
            let local = parent_from_joint(&self.locals[joint]);
            end = self.noise.product(&end, &local);
            models.push(end);
        }
        let positions = models.iter().map(|model| model.translation).collect();
        ChainNow { joints, positions, models, end }
    }

    fn run_stages(&mut self, joint: usize) {
        for used in &self.of.controls.stages {
            let on = used.joints.iter().find(|at| self.of.source(**at) == joint);
            if let (Some(on), After::Transform, OracleStage::Transform(run)) =
                (on, used.after, self.of.stages[used.stage as usize])
            {
                let mut model = self.model(joint);
                run(&mut model, &OracleStageInputs::new(used.values, *on, self.frame.tick));
                let matrix3 = self.noise.matrix(model.matrix3);
                let translation = self.noise.vector(model.translation);
                self.models[joint] = Some(DAffine3 { matrix3, translation });
            }
        }
    }

    fn override_model(&mut self, joint: usize) {
        for given in &self.of.controls.overrides {
            if given.space == Space::Model && self.of.source(given.joint) == joint {
                let part = f64::from(given.weight);
                let to = overrides::given(&given.transform);
                let now = self.model(joint);
                self.models[joint] = Some(overrides::part_of_the_way(&now, &to, part, self.noise));
            }
        }
    }
}

/// Returns a part of a rotation: the mean, by weight, of no rotation and all of it, normalised.
/// Beyond half a turn it is the longer way if `w` is negative.
fn part_of(rotation: DQuat, part: f64) -> DQuat {
    (DQuat::IDENTITY * (1.0 - part) + rotation * part).normalize()
}

/// Returns a part of a rotation by the shorter way.
fn short_part_of(rotation: DQuat, part: f64) -> DQuat {
    part_of(if rotation.w < 0.0 { -rotation } else { rotation }, part)
}
