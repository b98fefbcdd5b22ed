//! The history of members on its way from one device to another.

use std::ops::Range;

use populace_device::layout::{
    Float4, Member, NONE, RUNNING_ELEMENTS, Running, STATES_PER_CONTROL, STEP_CARRY, STEP_WATCH,
    WATCHED_ELEMENTS,
};
use populace_device::{Backend, BackendError, StageBuffer, Tables};

/// States of all constraint programs, watched joints, and state machines, which devices that share
/// a crowd each compute for themselves.
#[derive(Clone, Debug, Default)]
pub struct DeviceHistory {
    states: Vec<Float4>,
    watched: Vec<Float4>,
    running: Vec<Float4>,
}

impl DeviceHistory {
    /// Allocates for the history that devices do not compute for themselves. Returns `false` if
    /// there is none.
    pub(crate) fn allocate(&mut self, tables: &Tables) -> bool {
        self.states.resize(tables.state_elements(), Float4::default());
        self.watched.resize(tables.watched_elements(), Float4::default());
        !self.states.is_empty() || !self.watched.is_empty()
    }

    /// Reads the whole history of a device. Waits for the last frame.
    ///
    /// # Errors
    ///
    /// A failing device.
    pub fn read_all(backend: &mut dyn Backend, tables: &Tables) -> Result<Self, BackendError> {
        let mut history = Self::default();
        // States added since the last update are not on the device yet.
        let states = tables.controls().tail().start * STATES_PER_CONTROL as usize;
        let running = tables.machine_instances().tail().start * RUNNING_ELEMENTS as usize;
        for (buffer, all, count) in [
            (StageBuffer::States, &mut history.states, states),
            (StageBuffer::Watched, &mut history.watched, tables.watched_elements_known()),
            (StageBuffer::Running, &mut history.running, running),
        ] {
            all.resize(count, Float4::default());
            if count > 0 {
                backend.read(tables, buffer, 0, all)?;
            }
        }
        Ok(history)
    }

    /// Returns elements of the states from `first` on; zeros for unknown states.
    #[must_use]
    pub fn states<const N: usize>(&self, first: usize) -> [Float4; N] {
        std::array::from_fn(|nth| self.states.get(first + nth).copied().unwrap_or_default())
    }

    /// Returns the state of a machine instance; the default if it is unknown.
    #[must_use]
    pub fn running(&self, machine_instance: u32) -> Running {
        let rows = self.running.as_chunks().0;
        rows.get(machine_instance as usize)
            .copied()
            .map_or_else(Running::default, Running::from_elements)
    }

    /// Reads the history that other devices do not compute for themselves. Waits for the last
    /// frame.
    pub(crate) fn read(backend: &mut dyn Backend, tables: &Tables) -> Result<Self, BackendError> {
        let mut history = Self::default();
        if history.allocate(tables) {
            backend.read(tables, StageBuffer::States, 0, &mut history.states)?;
            backend.read(tables, StageBuffer::Watched, 0, &mut history.watched)?;
        }
        Ok(history)
    }

    /// Copies the history of a member from `from`.
    pub(crate) fn take_over(&mut self, from: &Self, tables: &Tables, member: &Member) {
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

    /// Clears watched joints whose indices were reused since.
    pub fn forget_new_watched(&mut self, tables: &Tables) {
        for run in tables.new_watched_elements() {
            if let Some(watched) = self.watched.get_mut(run) {
                watched.fill(Float4::default());
            }
        }
    }

    /// Adds cleared states for all elements of the tables that the history lacks. A device that has
    /// run before then loses its own.
    pub fn begin_rest(&mut self, tables: &Tables) {
        for (all, count) in [
            (&mut self.states, tables.state_elements()),
            (&mut self.watched, tables.watched_elements()),
            (&mut self.running, tables.running_elements()),
        ] {
            all.resize(all.len().max(count), Float4::default());
        }
    }

    /// Writes the history to a device that has these tables. States that the tables no longer hold
    /// are dropped; those that the history does not hold stay as the device has them.
    ///
    /// # Errors
    ///
    /// A failing device.
    pub fn write(&self, backend: &mut dyn Backend, tables: &Tables) -> Result<(), BackendError> {
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
