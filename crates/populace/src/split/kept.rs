//! What devices keep of members from frame to frame, on its way from one device to another.

use std::ops::Range;

use populace_device::layout::{
    Float4, Member, NONE, RUNNING_ELEMENTS, Running, STATES_PER_CONTROL, STEP_CARRY, STEP_WATCH,
    WATCHED_ELEMENTS,
};
use populace_device::{Backend, BackendError, StageBuffer, Tables};

/// States of all controls, and what is watched; and where state machines are, which devices that
/// share a crowd each find by themselves.
#[derive(Clone, Debug, Default)]
pub(crate) struct Kept {
    states: Vec<Float4>,
    watched: Vec<Float4>,
    running: Vec<Float4>,
}

impl Kept {
    /// Makes room for what devices that share a crowd do not each find; `false` where that is
    /// nothing.
    pub(super) fn make_room(&mut self, tables: &Tables) -> bool {
        self.states.resize(tables.state_elements(), Float4::default());
        self.watched.resize(tables.watched_elements(), Float4::default());
        !self.states.is_empty() || !self.watched.is_empty()
    }

    /// All that a device keeps, for another. One that was lost keeps nothing any more: feet then
    /// come down anew, and machines begin anew.
    pub(crate) fn read_all(backend: &mut dyn Backend, tables: &Tables) -> Self {
        let mut kept = Self::default();
        // What was added since the last update has no place there yet.
        let states = tables.controls().tail().start * STATES_PER_CONTROL as usize;
        let running = tables.machine_instances().tail().start * RUNNING_ELEMENTS as usize;
        for (buffer, all, count) in [
            (StageBuffer::States, &mut kept.states, states),
            (StageBuffer::Watched, &mut kept.watched, tables.watched_elements_known()),
            (StageBuffer::Running, &mut kept.running, running),
        ] {
            all.resize(count, Float4::default());
            if count > 0 && backend.read(tables, buffer, 0, all).is_err() {
                all.clear();
            }
        }
        kept
    }

    /// Elements of the states from one on; of what is not known, zeros.
    pub(crate) fn states<const N: usize>(&self, first: usize) -> [Float4; N] {
        std::array::from_fn(|nth| self.states.get(first + nth).copied().unwrap_or_default())
    }

    /// Where a machine instance was; nowhere if nothing is known of it.
    pub(crate) fn running(&self, machine_instance: u32) -> Running {
        let rows = self.running.as_chunks().0;
        rows.get(machine_instance as usize)
            .copied()
            .map_or_else(Running::default, Running::from_elements)
    }

    /// What a device keeps that others do not find by themselves, waiting for its last frame.
    pub(crate) fn read(backend: &mut dyn Backend, tables: &Tables) -> Result<Self, BackendError> {
        let mut kept = Self::default();
        if kept.make_room(tables) {
            backend.read(tables, StageBuffer::States, 0, &mut kept.states)?;
            backend.read(tables, StageBuffer::Watched, 0, &mut kept.watched)?;
        }
        Ok(kept)
    }

    /// Takes over what `from` has of a member.
    pub(super) fn take_over(&mut self, from: &Self, tables: &Tables, member: &Member) {
        if member.body == NONE || member.control == NONE {
            return;
        }
        copy(&mut self.states, &from.states, elements(member.control, STATES_PER_CONTROL));
        let control = &tables.controls().as_slice()[member.control as usize];
        let first = control.step_first as usize;
        let steps = &tables.steps().as_slice()[first..first + control.step_count as usize];
        for step in steps.iter().filter(|step| matches!(step.kind, STEP_WATCH | STEP_CARRY)) {
            copy(&mut self.watched, &from.watched, elements(step.index, WATCHED_ELEMENTS));
        }
    }

    /// Forgets the joints whose places among what is watched went to others since.
    pub(crate) fn forget_new_watched(&mut self, tables: &Tables) {
        for run in tables.new_watched_elements() {
            if let Some(watched) = self.watched.get_mut(run) {
                watched.fill(Float4::default());
            }
        }
    }

    /// Gives it to a device that took over these tables; of what they no longer hold there is
    /// nothing to give.
    pub(crate) fn write(
        &self,
        backend: &mut dyn Backend,
        tables: &Tables,
    ) -> Result<(), BackendError> {
        for (buffer, all, count) in [
            (StageBuffer::States, &self.states, tables.state_elements()),
            (StageBuffer::Watched, &self.watched, tables.watched_elements()),
            (StageBuffer::Running, &self.running, tables.running_elements()),
        ] {
            backend.write(buffer, 0, &all[..all.len().min(count)])?;
        }
        Ok(())
    }
}

fn elements(index: u32, each: u32) -> Range<usize> {
    let first = (index * each) as usize;
    first..first + each as usize
}

fn copy(to: &mut [Float4], from: &[Float4], elements: Range<usize>) {
    if let (Some(to), Some(from)) = (to.get_mut(elements.clone()), from.get(elements)) {
        to.copy_from_slice(from);
    }
}
