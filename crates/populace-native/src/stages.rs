//! Users' stages: what they get of a joint, and what is taken of what they leave; the twin of
//! `kernels/stage.cl`.

use populace_clip::FIRST_TICK;
use populace_device::layout::{Control, STAGE_PARAMETERS, Step};
use populace_device::{BackendError, Place, StageFn, StageJoint, Tables, UserStage};
use populace_model::math::quat;
use populace_model::{Affine, JointIndex, Trs};

use crate::DEVICE;
use crate::controls::Clock;
use crate::rows::{Local, Width};

/// Past this a number is no place, turn or scale any longer, and what hangs on it would come to be
/// not finite.
const BOUND: f32 = 1e9;

/// Elements of a stage's parameters.
const ELEMENTS: usize = STAGE_PARAMETERS as usize / 4;

/// Stages by number.
#[derive(Clone, Default)]
pub(crate) struct Stages(Vec<Option<StageFn>>);

impl Stages {
    pub(crate) fn new(stages: &[Option<UserStage>]) -> Result<Self, BackendError> {
        let function = |stage: &UserStage| {
            stage.rust_function().cloned().ok_or_else(|| BackendError::NoForm {
                device: DEVICE.into(),
                stage: stage.name().into(),
                form: "a function in Rust",
            })
        };
        let functions = stages.iter().map(|stage| stage.as_ref().map(function).transpose());
        Ok(Self(functions.collect::<Result<_, _>>()?))
    }

    fn run(&self, stage: u32, joint: &mut StageJoint) {
        if let Some(Some(function)) = self.0.get(stage as usize) {
            function(joint);
        }
    }
}

fn stage_joint(tables: &Tables, clock: Clock, step: &Step, control: &Control) -> StageJoint {
    let values = tables.stage_values().as_slice();
    let first = step.index as usize * ELEMENTS;
    let ([x, y, z, scale], [sin, cos, ..]) = (control.place.0, control.facing.0);
    let mut parameters = [0.0; STAGE_PARAMETERS as usize];
    for (four, value) in parameters.as_chunks_mut::<4>().0.iter_mut().zip(&values[first..]) {
        *four = value.0;
    }
    StageJoint {
        local: Trs::IDENTITY,
        model: Affine::IDENTITY,
        place: Place { position: [x, y, z], sin_cos: [sin, cos], scale },
        values: values[step.turn as usize].0,
        parameters,
        ticks: clock.tick.saturating_sub(FIRST_TICK),
        elapsed_secs: clock.elapsed_secs,
        joint: JointIndex(step.joint),
        member: control.member,
    }
}

fn bounded(values: &[f32]) -> bool {
    values.iter().all(|v| v.abs() <= BOUND)
}

/// What a stage makes of a model transform; `None` leaves it as it is.
pub(crate) fn model(
    tables: &Tables,
    clock: Clock,
    step: &Step,
    control: &Control,
    own: Affine,
) -> Option<Affine> {
    let mut joint = StageJoint { model: own, ..stage_joint(tables, clock, step, control) };
    clock.stages.run(step.index, &mut joint);
    bounded(joint.model.rows.as_flattened()).then_some(joint.model)
}

/// What a stage makes of the local transform in one lane.
fn local<R: Width>(
    tables: &Tables,
    clock: Clock,
    step: &Step,
    control: &Control,
    lane: usize,
    pose: Local<R>,
) -> Local<R> {
    let own = Trs {
        translation: pose.t.map(|v| v.lane(lane)),
        rotation: pose.r.map(|v| v.lane(lane)),
        scale: pose.s.map(|v| v.lane(lane)),
    };
    let mut joint = StageJoint { local: own, ..stage_joint(tables, clock, step, control) };
    clock.stages.run(step.index, &mut joint);
    let Trs { translation, rotation, scale } = joint.local;
    if !bounded(&translation) || !bounded(&rotation) || !bounded(&scale) {
        return pose;
    }
    let only = R::only(lane);
    let vector = |left: [f32; 3], own: [R; 3]| {
        let mut taken = own;
        for (own, left) in taken.iter_mut().zip(left) {
            *own = R::choose(only, R::splat(left), *own);
        }
        taken
    };
    let turned = quat::normalize_or(rotation.map(R::splat), pose.r);
    Local {
        t: vector(translation, pose.t),
        r: quat::choose::<R>(only, turned, pose.r),
        s: vector(scale, pose.s),
    }
}

/// What a member's stages make of its local transforms from `joint` on; their steps stand by joint.
pub(crate) fn locals<R: Width>(
    tables: &Tables,
    clock: Clock,
    control: &Control,
    joint: usize,
    mut pose: Local<R>,
) -> Local<R> {
    let first = (control.step_first + control.step_count) as usize;
    for step in &tables.steps().as_slice()[first..first + control.pose_step_count as usize] {
        match (step.joint as usize).checked_sub(joint) {
            Some(lane) if lane >= R::COUNT => break,
            Some(lane) => pose = local(tables, clock, step, control, lane, pose),
            None => {}
        }
    }
    pose
}
