//! Double-buffered persistent state: what one frame leaves for the next.

use populace_device::layout::{Float4, STATES_PER_CONTROL, WATCHED_ELEMENTS};
use populace_device::{BackendError, Tables};
use populace_model::Affine;
use populace_model::convert::u32_from;
use rayon::prelude::*;

use crate::buffers::grow;

/// Persistent state of all members.
#[derive(Default)]
pub(crate) struct History {
    /// As the newest frame wrote it.
    pub(crate) now: Persistent,
    /// As the frame before wrote it: the newest frame's input.
    before: Persistent,
    /// State of each state-machine instance.
    pub(crate) running: Vec<Float4>,
    /// The same before the newest frame.
    running_before: Vec<Float4>,
    /// Whether a frame has begun since the tables were updated.
    has_begun: bool,
    /// Whether `running_before` was kept since then.
    has_kept: bool,
}

/// One of the two buffers.
#[derive(Default)]
pub(crate) struct Persistent {
    /// State of constraints and root motion, `STATES_PER_CONTROL` elements for each control.
    pub(crate) states: Vec<Float4>,
    /// Transforms of watched joints, `WATCHED_ELEMENTS` rows each.
    pub(crate) watched: Vec<Float4>,
}

/// Elements written one after the other, from `first` on.
struct Run {
    first: u32,
    count: u32,
}

/// Runs of elements, and their values.
#[derive(Default)]
pub(crate) struct Runs {
    runs: Vec<Run>,
    values: Vec<Float4>,
}

impl Runs {
    /// Adds the elements from `first` on.
    pub(crate) fn add(&mut self, first: u32, values: &[Float4]) {
        self.runs.push(Run { first, count: u32_from(values.len()) });
        self.values.extend_from_slice(values);
    }

    fn clear(&mut self) {
        self.runs.clear();
        self.values.clear();
    }

    /// Writes the runs that begin in a part of a buffer, which starts at element `start`.
    fn write(&self, part: &mut [Float4], start: usize) {
        let mut values = self.values.as_slice();
        for run in &self.runs {
            let (own, rest) = values.split_at(run.count as usize);
            values = rest;
            let at = (run.first as usize).wrapping_sub(start);
            if let Some(to) = part.get_mut(at..).and_then(|to| to.get_mut(..own.len())) {
                to.copy_from_slice(own);
            }
        }
    }
}

/// Writes collected by one worker and committed after the phase.
#[derive(Default)]
pub(crate) struct DeferredWrites {
    /// To [`Persistent::states`], for the next frame. No run has elements of two members.
    pub(crate) states: Runs,
    /// To [`Persistent::watched`], for other members.
    pub(crate) watched: Runs,
}

impl DeferredWrites {
    /// Drops all writes.
    pub(crate) fn clear(&mut self) {
        self.states.clear();
        self.watched.clear();
    }
}

/// Least elements of a part of the states that a thread commits.
const LEAST: usize = 1024 * STATES_PER_CONTROL as usize;

impl History {
    /// Grows the buffers to the size of the tables, and clears new watched elements.
    pub(crate) fn grow(&mut self, tables: &Tables) -> Result<(), BackendError> {
        (self.has_begun, self.has_kept) = (false, false);
        grow(&mut self.now.states, tables.state_elements(), "member states")?;
        grow(&mut self.now.watched, tables.watched_elements(), "watched joints")?;
        grow(&mut self.running, tables.running_elements(), "state machine instances")?;
        for run in tables.new_watched_elements() {
            self.now.watched[run].fill(Float4::default());
        }
        Ok(())
    }

    /// Begins a frame: swaps the buffers, and copies the watched joints, which stay where the
    /// frame writes nothing. States are not copied: a frame writes all states of each member that
    /// it evaluates, and a new epoch makes those of a hidden member void.
    pub(crate) fn begin_frame(&mut self) {
        std::mem::swap(&mut self.now.states, &mut self.before.states);
        self.now.states.resize(self.before.states.len(), Float4::default());
        self.before.watched.clone_from(&self.now.watched);
        self.has_begun = true;
    }

    /// Keeps the state of the state machines before a frame advances them.
    pub(crate) fn keep_running(&mut self) {
        self.running_before.clone_from(&self.running);
        self.has_kept = true;
    }

    /// Takes back what the frame since the last update changed.
    pub(crate) fn undo_frame(&mut self) {
        if std::mem::take(&mut self.has_begun) {
            std::mem::swap(&mut self.now, &mut self.before);
        }
        if std::mem::take(&mut self.has_kept) {
            std::mem::swap(&mut self.running, &mut self.running_before);
        }
    }

    /// Applies the writes of all workers, states in parallel. `for_each` passes those of each.
    pub(crate) fn commit(&mut self, for_each: &(impl Fn(&mut dyn FnMut(&DeferredWrites)) + Sync)) {
        let Persistent { states, watched } = &mut self.now;
        for_each(&mut |worker| worker.watched.write(watched, 0));
        let each = states.len().div_ceil(rayon::current_num_threads()).max(LEAST);
        let size = each.next_multiple_of(STATES_PER_CONTROL as usize);
        states.par_chunks_mut(size).enumerate().for_each(|(nth, part)| {
            for_each(&mut |worker| worker.states.write(part, nth * size));
        });
    }

    /// Returns an element of the states as of the frame before; 0 past the end.
    pub(crate) fn state_before(&self, element: u32) -> Float4 {
        self.before.states.get(element as usize).copied().unwrap_or_default()
    }

    /// Returns a watched joint's transform as of the frame before; `None` past the end.
    #[inline(always)]
    pub(crate) fn watched_before(&self, index: u32) -> Option<Affine> {
        affine_at(&self.before.watched, index)
    }

    /// Returns a watched joint's transform as of the newest phase; `None` past the end.
    #[inline(always)]
    pub(crate) fn watched_now(&self, index: u32) -> Option<Affine> {
        affine_at(&self.now.watched, index)
    }

    /// Returns the `Float4` elements held, both buffers counted.
    pub(crate) fn element_count(&self) -> usize {
        self.now.states.len() * 2 + self.now.watched.len() * 2 + self.running.len() * 2
    }
}

#[inline(always)]
fn affine_at(watched: &[Float4], index: u32) -> Option<Affine> {
    let first = (index * WATCHED_ELEMENTS) as usize;
    match watched.get(first..first + WATCHED_ELEMENTS as usize)? {
        [a, b, c] => Some(Affine { rows: [a.0, b.0, c.0] }),
        _ => None,
    }
}
