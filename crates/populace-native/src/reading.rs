//! What lies between slots and palette, for those who want to read it while a fused schedule runs.

use populace_device::layout::{Float4, SlotSample};
use populace_device::{BackendError, StageBuffer, Tables};
use populace_model::Affine;

use crate::controls::{Clock, Keeping};
use crate::dispatch::Dispatch;
use crate::evaluate::evaluate;
use crate::fused::{Desk, Evaluation};
use crate::machines::slot_now;
use crate::{failed, fused};

/// Of one member, evaluated once more.
pub(crate) struct Reading {
    place: u32,
    samples: Vec<SlotSample>,
    locals: Vec<[Float4; 3]>,
    models: Vec<Affine>,
}

impl Reading {
    fn new(member: Evaluation) -> Self {
        let Evaluation { tables, place, clock, keeping, .. } = member;
        let slots = &tables.slots().as_slice()[tables.slot_range(place)];
        let sample = |slot| {
            evaluate(tables, &slot_now(tables, &keeping.running, slot, clock.tick), clock.tick)
        };
        let samples = slots.iter().map(sample).collect();
        let joint_count = fused::body_of(tables, place).joint_count as usize;
        let (mut desk, mut locals) = (Desk::default(), vec![[Float4::default(); 3]; joint_count]);
        fused::member_matrices(member, &mut desk, |first, local| {
            for (lane, joint) in locals.iter_mut().skip(first).take(crate::lanes::LANES).enumerate()
            {
                *joint = [
                    Float4::from_xyz(local.t.map(|v| v.0[lane])),
                    Float4(local.r.map(|v| v.0[lane])),
                    Float4::from_xyz(local.s.map(|v| v.0[lane])),
                ];
            }
        });
        let mut models = desk.models;
        models.truncate(joint_count);
        Self { place, samples, locals, models }
    }

    /// An element as the buffers of the staged schedule hold it; `None` past the member's end.
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

/// Reads elements of one member as of a frame; `last` keeps the member for the next time.
pub(crate) fn read(
    last: &mut Option<Reading>,
    tables: &Tables,
    (clock, keeping): (Clock, &Keeping),
    buffer: StageBuffer,
    first: usize,
    into: &mut [Float4],
) -> Result<(), BackendError> {
    let past_the_end =
        || failed(&format!("read {buffer:?}"), format!("element {first} is past a member's end"));
    let (place, at) = tables.place_of(buffer, first).ok_or_else(past_the_end)?;
    let reading = match last.take() {
        Some(reading) if reading.place == place => reading,
        _ => {
            Reading::new(Evaluation { tables, place, clock, keeping, dispatch: Dispatch::Baseline })
        }
    };
    for (offset, element) in into.iter_mut().enumerate() {
        *element = reading.element(buffer, at + offset).ok_or_else(past_the_end)?;
    }
    *last = Some(reading);
    Ok(())
}
