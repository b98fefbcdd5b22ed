//! Reads of stage buffers that the fused schedule does not store: the member is evaluated again.

use populace_device::layout::{Float4, SlotSample};
use populace_device::{BackendError, StageBuffer};

use crate::errors::failed;
use crate::frame::FrameInputs;
use crate::fused::{MemberInputs, member_models};
use crate::lanes::LANES;
use crate::machines::slot_now;
use crate::members::{body_of, member_slots};
use crate::processor::Dispatch;
use crate::scratch::Scratch;
use crate::slot::sample_of;

/// Stage buffers of one member, as of the last frame.
#[derive(Default)]
pub(crate) struct Reading {
    /// `None` if no member has been evaluated since the last frame.
    member: Option<u32>,
    samples: Vec<SlotSample>,
    /// Translation, rotation and scale of each joint.
    locals: Vec<[Float4; 3]>,
    /// Holds the models of the joints.
    scratch: Scratch,
}

impl Reading {
    /// Forgets the member: another frame begins.
    pub(crate) fn forget(&mut self) {
        self.member = None;
    }

    fn evaluate(&mut self, inputs: &FrameInputs, dispatch: Dispatch, member: u32) {
        let (tables, tick) = (inputs.tables, inputs.frame.tick);
        let running = &inputs.history.running;
        let sample = |slot| sample_of(tables, &slot_now(tables, running, slot, tick), tick).0;
        let Self { samples, locals, scratch, .. } = self;
        samples.clear();
        samples.extend(member_slots(tables, member).iter().map(sample));
        locals.clear();
        locals.resize(body_of(tables, member).joint_count as usize, [Float4::default(); 3]);
        let of = MemberInputs { inputs, member, dispatch };
        member_models(of, scratch, &mut |first, local| {
            for (lane, joint) in locals.iter_mut().skip(first).take(LANES).enumerate() {
                *joint = [
                    Float4::from_xyz(local.t.map(|v| v.0[lane])),
                    Float4(local.r.map(|v| v.0[lane])),
                    Float4::from_xyz(local.s.map(|v| v.0[lane])),
                ];
            }
        });
        // Its writes were applied when the frame ran.
        scratch.writes.clear();
        self.member = Some(member);
    }

    /// Returns an element as the staged schedule's buffers hold it; `None` past the member's end.
    fn element(&self, buffer: StageBuffer, at: usize) -> Option<Float4> {
        let local = |property: usize| self.locals.get(at).map(|local| local[property]);
        let models = self.scratch.models.get(..self.locals.len()).unwrap_or(&[]);
        let row = |row: usize| models.get(at).map(|model| Float4(model.rows[row]));
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

/// Reads elements of one member as of a frame. `reading` keeps the member for the next read.
///
/// # Errors
///
/// [`BackendError::Failed`] if an element is past the member's end.
pub(crate) fn read(
    reading: &mut Reading,
    (inputs, dispatch): (&FrameInputs, Dispatch),
    buffer: StageBuffer,
    first: usize,
    into: &mut [Float4],
) -> Result<(), BackendError> {
    let past_the_end =
        || failed(&format!("read {buffer:?}"), format!("element {first} is past a member's end"));
    let (member, at) = inputs.tables.place_of(buffer, first).ok_or_else(past_the_end)?;
    if reading.member != Some(member) {
        reading.evaluate(inputs, dispatch, member);
    }
    for (offset, element) in into.iter_mut().enumerate() {
        *element = reading.element(buffer, at + offset).ok_or_else(past_the_end)?;
    }
    Ok(())
}
