//! Double-buffered persistent state: the state of members with constraint programs, and watched
//! joints.

use std::collections::VecDeque;

use opencl3::error_codes::ClError;
use populace_device::layout::Float4;
use populace_device::{BackendError, Frame, StageBuffer, Tables};

use crate::OpenClDevice;
use crate::buffer::{AsyncRead, Buffer};
use crate::handles::CommandQueue;
use crate::launch::Launch;
use crate::tables::DeviceTables;

/// Buffers of each kind in pairs: the previous frame's, which a frame is evaluated from, and its
/// own.
pub(crate) struct History {
    states: [Buffer<Float4>; 2],
    watched: [Buffer<Float4>; 2],
    /// States and watched joints that a member writes while it is evaluated once more for reading.
    /// No frame sees them.
    scratch: [Buffer<Float4>; 2],
    /// Index of the buffers of the last frame.
    now: usize,
    /// Whether a frame has begun since the last update.
    has_begun: bool,
    /// Reads of watched joints that are still in progress, the oldest first.
    reads: VecDeque<WatchedRead>,
    /// The newest completed read.
    newest: Option<WatchedRead>,
    /// The number of the oldest reads in progress that are dropped when they complete.
    forgotten: usize,
}

/// A read of the watched joints, as of a clock tick.
struct WatchedRead {
    tick: u64,
    read: AsyncRead<Float4>,
}

/// Where constraint programs write state and watched joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WriteTarget {
    /// Into the history, for the next frame and for later phases of this one.
    Frame,
    /// Into scratch buffers that no frame sees.
    Scratch,
}

/// Reads in progress at most. A device that is further behind skips reads.
const MAX_READS: usize = 3;

impl History {
    pub(crate) fn new(device: &OpenClDevice) -> Result<Self, BackendError> {
        let empty = || Buffer::new(device, 0, "an empty buffer");
        Ok(Self {
            states: [empty()?, empty()?],
            watched: [empty()?, empty()?],
            scratch: [empty()?, empty()?],
            now: 0,
            has_begun: false,
            reads: VecDeque::new(),
            newest: None,
            forgotten: 0,
        })
    }

    /// Grows to the size that the tables need, and keeps the contents.
    pub(crate) fn update(
        &mut self,
        device: &OpenClDevice,
        queue: &CommandQueue,
        tables: &Tables,
    ) -> Result<(), BackendError> {
        self.has_begun = false;
        for states in &mut self.states {
            states.grow(device, queue, tables.state_elements(), "states of members")?;
        }
        let (pair, count) = (self.watched.each_mut(), tables.watched_elements());
        Buffer::grow_pair(pair, device, queue, count, "watched joints")?;
        let watched = &mut self.watched[self.now];
        let cleared = tables.new_watched_elements().try_for_each(|run| watched.clear(queue, run));
        cleared.map_err(|e| device.failed("clear watched joints", &e))
    }

    /// Returns whether the memory suffices for the tables, as it does after an update.
    pub(crate) fn hold(&self, tables: &Tables) -> bool {
        let states = self.states.iter().all(|buffer| tables.state_elements() <= buffer.len());
        states && self.watched.iter().all(|buffer| tables.watched_elements() <= buffer.len())
    }

    pub(crate) fn bytes(&self) -> usize {
        self.states.iter().chain(&self.watched).chain(&self.scratch).map(Buffer::bytes).sum()
    }

    /// Begins a frame: swaps the buffers, and copies the watched joints, which stay where the
    /// frame writes nothing. States are not copied: a frame writes all states of each member that
    /// it evaluates, and a new epoch makes those of a hidden member void.
    pub(crate) fn begin_frame(&mut self, queue: &CommandQueue) -> Result<(), ClError> {
        let [first, second] = &mut self.watched;
        let (from, to) = if self.now == 0 { (first, second) } else { (second, first) };
        to.copy_from(queue, from)?;
        (self.now, self.has_begun) = (1 - self.now, true);
        Ok(())
    }

    /// Takes back what the frame since the last update changed.
    pub(crate) fn undo_frame(&mut self) {
        if std::mem::take(&mut self.has_begun) {
            self.now = 1 - self.now;
        }
    }

    /// Grows the scratch buffers for a member that is evaluated once more, and copies the watched
    /// joints of the last frame into them.
    pub(crate) fn prepare_scratch(
        &mut self,
        device: &OpenClDevice,
        queue: &CommandQueue,
    ) -> Result<(), BackendError> {
        let Self { scratch: [states, watched], now, .. } = self;
        states.grow(device, queue, self.states[*now].len(), "scratch states")?;
        watched.grow(device, queue, self.watched[*now].len(), "scratch watched joints")?;
        let copied = watched.copy_from(queue, &self.watched[*now]);
        copied.map_err(|e| device.failed("read a member's joints", &e))
    }

    /// Sets the arguments declared by `CONSTRAINT_PARAMETERS` in `kernels/kernel_parameters.cl`.
    pub(crate) fn parameters<'a>(
        &self,
        launch: Launch<'a>,
        tables: &DeviceTables,
        frame: Frame,
        writes: WriteTarget,
    ) -> Launch<'a> {
        let before = 1 - self.now;
        let [states, watched] = match writes {
            WriteTarget::Frame => [&self.states[self.now], &self.watched[self.now]],
            WriteTarget::Scratch => [&self.scratch[0], &self.scratch[1]],
        };
        launch
            .buffer("controls", &tables.controls.buffer)
            .buffer("steps", &tables.steps.buffer)
            .buffer("overrides", &tables.overrides.buffer)
            .buffer("constraints", &tables.constraints.buffer)
            .buffer("links", &tables.links.buffer)
            .buffer("targets", &tables.targets.buffer)
            .buffer("ground", &tables.ground.buffer)
            .buffer("heights", &tables.heights.buffer)
            .buffer("soles", &tables.soles.buffer)
            .buffer("contacts", &tables.contacts.buffer)
            .buffer("states_before", &self.states[before])
            .buffer("watched_before", &self.watched[before])
            .buffer("states", states)
            .buffer("watched", watched)
            .buffer("stage_values", &tables.stage_values.buffer)
            .buffer("motions", &tables.motions.buffer)
            .uint("elapsed_ticks", frame.elapsed_ticks)
    }

    /// Starts a read of the watched joints, as of the last frame. Skips it if the device is too far
    /// behind.
    pub(crate) fn fetch(
        &mut self,
        queue: &CommandQueue,
        tick: u64,
        count: usize,
    ) -> Result<(), ClError> {
        self.collect_reads()?;
        if self.reads.len() < MAX_READS {
            let mut read = AsyncRead::default();
            self.watched[self.now].read_async(queue, count, &mut read)?;
            queue.flush()?;
            self.reads.push_back(WatchedRead { tick, read });
        }
        Ok(())
    }

    fn collect_reads(&mut self) -> Result<(), ClError> {
        while let Some(oldest) = self.reads.front_mut()
            && oldest.read.is_done()?
        {
            let done = self.reads.pop_front();
            if self.forgotten > 0 {
                self.forgotten -= 1;
            } else {
                self.newest = done;
            }
        }
        Ok(())
    }

    /// Returns the newest watched joints that have been read, and their clock tick.
    pub(crate) fn fetched(&mut self) -> Result<Option<(u64, &[Float4])>, ClError> {
        self.collect_reads()?;
        Ok(self.newest.as_ref().map(|newest| (newest.tick, newest.read.elements())))
    }

    /// Forgets the newest read, and all that are under way.
    pub(crate) fn forget_fetched(&mut self) {
        (self.newest, self.forgotten) = (None, self.reads.len());
    }

    /// Returns a buffer as the last frame left it; `None` if it is not part of the history.
    pub(crate) fn buffer(&mut self, buffer: StageBuffer) -> Option<&mut Buffer<Float4>> {
        match buffer {
            StageBuffer::States => Some(&mut self.states[self.now]),
            StageBuffer::Watched => Some(&mut self.watched[self.now]),
            _ => None,
        }
    }
}
