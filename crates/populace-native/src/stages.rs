//! User stages on members' joints: the input of a stage, and checks of its output. Twin of
//! `kernels/stages.cl`.
//!
//! Reads steps, stage values and controls. Writes nothing but the transforms that it returns.

use populace_clip::FIRST_TICK;
use populace_device::layout::{Control, STAGE_LARGEST, STAGE_PARAMETERS, Step};
use populace_device::{Place, StageJoint};
use populace_model::math::quat;
use populace_model::{Affine, JointIndex, Trs};

use crate::frame::FrameInputs;
use crate::lanes::Width;
use crate::local::Local;

/// `Float4` elements of a stage's parameters.
const ELEMENTS: usize = STAGE_PARAMETERS as usize / 4;

fn stage_joint(inputs: &FrameInputs, step: &Step, control: &Control) -> StageJoint {
    let values = inputs.tables.stage_values().as_slice();
    let first = step.index as usize * ELEMENTS;
    let ([x, y, z, scale], sin, cos) = (control.place.0, control.sine, control.cosine);
    let mut parameters = [0.0; STAGE_PARAMETERS as usize];
    for (four, value) in parameters.as_chunks_mut::<4>().0.iter_mut().zip(&values[first..]) {
        *four = value.0;
    }
    StageJoint {
        local: Trs::IDENTITY,
        model: Affine::IDENTITY,
        place: Place { position: [x, y, z], sin_cos: [sin, cos], scale },
        values: values[step.operand as usize].0,
        parameters,
        ticks: inputs.frame.tick.saturating_sub(FIRST_TICK),
        elapsed_secs: inputs.frame.elapsed_secs(),
        joint: JointIndex(step.joint),
        member: control.member,
    }
}

/// Returns whether all values are within [`STAGE_LARGEST`]; false for NaN.
fn stage_bounded(values: &[f32]) -> bool {
    values.iter().all(|v| v.abs() <= STAGE_LARGEST)
}

/// Runs a stage on a model transform. Returns `None`, which keeps the transform, if the result is
/// out of bounds.
pub(crate) fn stage_model(
    inputs: &FrameInputs,
    step: &Step,
    control: &Control,
    own: Affine,
) -> Option<Affine> {
    let mut joint = StageJoint { model: own, ..stage_joint(inputs, step, control) };
    inputs.stages.run(step.index, &mut joint);
    stage_bounded(joint.model.rows.as_flattened()).then_some(joint.model)
}

/// Runs a stage on the local transform in one lane. A result out of bounds is dropped.
fn stage_local<R: Width>(
    inputs: &FrameInputs,
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
    let mut joint = StageJoint { local: own, ..stage_joint(inputs, step, control) };
    inputs.stages.run(step.index, &mut joint);
    let Trs { translation, rotation, scale } = joint.local;
    if !stage_bounded(&translation) || !stage_bounded(&rotation) || !stage_bounded(&scale) {
        return pose;
    }
    let only = R::only(lane);
    let vector = |result: [f32; 3], own: [R; 3]| {
        let mut taken = own;
        for (own, result) in taken.iter_mut().zip(result) {
            *own = R::choose(only, R::splat(result), *own);
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

/// Runs a member's stages on its local transforms from `joint` on. The steps are sorted by joint.
pub(crate) fn stage_locals<R: Width>(
    inputs: &FrameInputs,
    control: &Control,
    joint: usize,
    mut pose: Local<R>,
) -> Local<R> {
    let first = (control.step_first + control.step_count) as usize;
    let steps = inputs.tables.steps().as_slice();
    for step in &steps[first..first + control.pose_step_count as usize] {
        match (step.joint as usize).checked_sub(joint) {
            Some(lane) if lane >= R::COUNT => break,
            Some(lane) => pose = stage_local(inputs, step, control, lane, pose),
            None => {}
        }
    }
    pose
}
