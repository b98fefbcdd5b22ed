//! What is kept from frame to frame: states of members with controls, and what is watched of
//! joints.

use std::collections::VecDeque;

use opencl3::command_queue::CommandQueue;
use opencl3::error_codes::ClError;
use populace_device::layout::Float4;
use populace_device::{BackendError, Frame, StageBuffer, Tables};

use crate::OpenClDevice;
use crate::buffer::{Buffer, Landing};
use crate::launch::Launch;
use crate::tables::DeviceTables;

/// Two of each: what the last frame was evaluated from, and what it left.
pub(crate) struct Keeping {
    states: [Buffer<Float4>; 2],
    watched: [Buffer<Float4>; 2],
    /// States and watched joints that a member writes while it is evaluated once more to be read:
    /// no frame sees them.
    aside: [Buffer<Float4>; 2],
    /// Which of the two the last frame left.
    now: usize,
    /// What was watched, on its way to the host, the oldest first.
    landings: VecDeque<(u64, Landing<Float4>)>,
    /// The newest that landed, and the clock when it was so.
    landed: Option<(u64, Landing<Float4>)>,
}

/// Where what members keep is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Writes {
    /// For the next frame, and for later phases of this one.
    Frame,
    /// Where no frame sees it.
    Aside,
}

/// As many frames as a device may be behind before what it is asked for is left out.
const LANDINGS: usize = 3;

impl Keeping {
    pub(crate) fn new(device: &OpenClDevice) -> Result<Self, BackendError> {
        let empty = || Buffer::new(device, 0, "an empty buffer");
        Ok(Self {
            states: [empty()?, empty()?],
            watched: [empty()?, empty()?],
            aside: [empty()?, empty()?],
            now: 0,
            landings: VecDeque::new(),
            landed: None,
        })
    }

    /// Makes room for what the tables hold, and keeps what is there.
    pub(crate) fn update(
        &mut self,
        device: &OpenClDevice,
        queue: &CommandQueue,
        tables: &Tables,
    ) -> Result<(), BackendError> {
        for states in &mut self.states {
            states.grow(device, queue, tables.state_elements(), "what is kept of members")?;
        }
        for watched in &mut self.watched {
            watched.grow(device, queue, tables.watched_elements(), "what is watched of members")?;
        }
        let watched = &mut self.watched[self.now];
        let cleared = tables.new_watched_elements().try_for_each(|run| watched.clear(queue, run));
        cleared.map_err(|e| device.failed("clear what is watched of members", &e))
    }

    /// Whether there is room for what the tables hold, as there is after an update.
    pub(crate) fn hold(&self, tables: &Tables) -> bool {
        let states = self.states.iter().all(|buffer| tables.state_elements() <= buffer.len());
        states && self.watched.iter().all(|buffer| tables.watched_elements() <= buffer.len())
    }

    pub(crate) fn bytes(&self) -> usize {
        self.states.iter().chain(&self.watched).chain(&self.aside).map(Buffer::bytes).sum()
    }

    /// Begins a frame: what the last one left is what this one is evaluated from, and stays where
    /// this one writes nothing.
    pub(crate) fn begin_frame(&mut self, queue: &CommandQueue) -> Result<(), ClError> {
        for [first, second] in [&mut self.states, &mut self.watched] {
            if self.now == 0 {
                second.copy_from(queue, first)
            } else {
                first.copy_from(queue, second)
            }?;
        }
        self.now = 1 - self.now;
        Ok(())
    }

    /// Makes room aside for a member that is evaluated once more, with the watched joints of the
    /// last frame for it to read.
    pub(crate) fn prepare_aside(
        &mut self,
        device: &OpenClDevice,
        queue: &CommandQueue,
    ) -> Result<(), BackendError> {
        let Self { aside: [states, watched], now, .. } = self;
        states.grow(device, queue, self.states[*now].len(), "states of a member that is read")?;
        watched.grow(
            device,
            queue,
            self.watched[*now].len(),
            "watched joints of a member that is read",
        )?;
        let copied = watched.copy_from(queue, &self.watched[*now]);
        copied.map_err(|e| device.failed("read a member's joints", &e))
    }

    /// Sets what the steps of members read and write.
    pub(crate) fn parameters<'a>(
        &self,
        launch: Launch<'a>,
        tables: &DeviceTables,
        frame: Frame,
        writes: Writes,
    ) -> Launch<'a> {
        let before = 1 - self.now;
        let [states, watched] = match writes {
            Writes::Frame => [&self.states[self.now], &self.watched[self.now]],
            Writes::Aside => [&self.aside[0], &self.aside[1]],
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
            .buffer("states_before", &self.states[before])
            .buffer("watched_before", &self.watched[before])
            .buffer("states", states)
            .buffer("watched", watched)
            .buffer("stage_values", &tables.stage_values.buffer)
            .buffer("motions", &tables.motions.buffer)
            .uint("elapsed_ticks", frame.elapsed_ticks)
    }

    /// Lets what is watched come to the host, as of the last frame; leaves it out where the device
    /// is too far behind.
    pub(crate) fn fetch(
        &mut self,
        queue: &CommandQueue,
        tick: u64,
        count: usize,
    ) -> Result<(), ClError> {
        self.land()?;
        if self.landings.len() < LANDINGS {
            let mut landing = Landing::default();
            self.watched[self.now].read_later(queue, count, &mut landing)?;
            queue.flush()?;
            self.landings.push_back((tick, landing));
        }
        Ok(())
    }

    fn land(&mut self) -> Result<(), ClError> {
        while let Some((_, landing)) = self.landings.front_mut()
            && landing.is_done()?
        {
            self.landed = self.landings.pop_front();
        }
        Ok(())
    }

    /// The newest of what was watched that has come to the host, and the clock when it was so.
    pub(crate) fn fetched(&mut self) -> Result<Option<(u64, &[Float4])>, ClError> {
        self.land()?;
        Ok(self.landed.as_ref().map(|(tick, landing)| (*tick, landing.elements())))
    }

    /// The buffer of a kind as the last frame left it; `None` for those that are not kept here.
    pub(crate) fn buffer(&mut self, buffer: StageBuffer) -> Option<&mut Buffer<Float4>> {
        match buffer {
            StageBuffer::States => Some(&mut self.states[self.now]),
            StageBuffer::Watched => Some(&mut self.watched[self.now]),
            _ => None,
        }
    }
}
