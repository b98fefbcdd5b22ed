//! Reads of stage buffers that the fused schedule does not store: the member is evaluated again.

use populace_device::layout::{Float4, SlotSample};
use populace_device::{BackendError, StageBuffer};
use populace_model::Affine;

use crate::corrections::JointLanes;
use crate::dispatch::{Dispatch, Work};
use crate::errors::failed;
use crate::frame::FrameInputs;
use crate::fused::{MemberInputs, member_models};
use crate::lanes::LANES;
use crate::machines::slot_now;
use crate::members::{body_of, member_slots};
use crate::scratch::Scratch;
use crate::slot::sample_of;

/// Stage buffers of one member, as of the last frame.
pub(crate) struct Reading {
    member: u32,
    samples: Vec<SlotSample>,
    /// Translation, rotation and scale of each joint.
    locals: Vec<[Float4; 3]>,
    models: Vec<Affine>,
}

/// Evaluation of one member, with its local transforms.
struct Evaluate<'a> {
    of: MemberInputs<'a>,
    scratch: &'a mut Scratch,
    locals: &'a mut [[Float4; 3]],
}

impl Work for Evaluate<'_> {
    #[inline(always)]
    fn run<J: JointLanes>(self) {
        member_models(self.of, self.scratch, |first, local| {
            for (lane, joint) in self.locals.iter_mut().skip(first).take(LANES).enumerate() {
                *joint = [
                    Float4::from_xyz(local.t.map(|v| v.0[lane])),
                    Float4(local.r.map(|v| v.0[lane])),
                    Float4::from_xyz(local.s.map(|v| v.0[lane])),
                ];
            }
        });
    }
}

impl Reading {
    fn new(inputs: &FrameInputs, dispatch: Dispatch, member: u32) -> Self {
        let (tables, tick) = (inputs.tables, inputs.frame.tick);
        let running = &inputs.history.running;
        let sample = |slot| sample_of(tables, &slot_now(tables, running, slot, tick), tick);
        let samples = member_slots(tables, member).iter().map(sample).collect();
        let joint_count = body_of(tables, member).joint_count as usize;
        let mut scratch = Scratch::default();
        let mut locals = vec![[Float4::default(); 3]; joint_count];
        let of = MemberInputs { inputs, member, dispatch };
        dispatch.run(Evaluate { of, scratch: &mut scratch, locals: &mut locals });
        let mut models = scratch.models;
        models.truncate(joint_count);
        Self { member, samples, locals, models }
    }

    /// Returns an element as the staged schedule's buffers hold it; `None` past the member's end.
    fn element(&self, buffer: StageBuffer, at: usize) -> Option<Float4> {
        let local = |property: usize| self.locals.get(at).map(|local| local[property]);
        let row = |row: usize| self.models.get(at).map(|model| Float4(model.rows[row]));
        match buffer {
            StageBuffer::Samples => self.samples.get(at).map(|sample| bytemuck::cast(*sample)),
            StageBuffer::Translations => local(0),
            StageBuffer::Rotations => local(1),
            StageBuffer::Scales => local(2),
            StageBuffer::ModelRow0 => row(0),
            StageBuffer::ModelRow1 => row(1),
            StageBuffer::ModelRow2 => row(2),
            StageBuffer::Palette
            | StageBuffer::States
            | StageBuffer::Watched
            | StageBuffer::Running => None,
        }
    }
}

/// Reads elements of one member as of a frame. `last` caches the member for the next read.
///
/// # Errors
///
/// [`BackendError::Failed`] if an element is past the member's end.
pub(crate) fn read(
    last: &mut Option<Reading>,
    (inputs, dispatch): (&FrameInputs, Dispatch),
    buffer: StageBuffer,
    first: usize,
    into: &mut [Float4],
) -> Result<(), BackendError> {
    let past_the_end =
        || failed(&format!("read {buffer:?}"), format!("element {first} is past a member's end"));
    let (member, at) = inputs.tables.place_of(buffer, first).ok_or_else(past_the_end)?;
    let reading = match last.take() {
        Some(reading) if reading.member == member => reading,
        _ => Reading::new(inputs, dispatch, member),
    };
    for (offset, element) in into.iter_mut().enumerate() {
        *element = reading.element(buffer, at + offset).ok_or_else(past_the_end)?;
    }
    *last = Some(reading);
    Ok(())
}
