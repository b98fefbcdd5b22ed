//! Several devices that evaluate one crowd at the same time. Each takes the members of one range of
//! indices.

mod balance;
mod places;

use std::ops::Range;
use std::panic::resume_unwind;
use std::thread::{self, ScopedJoinHandle};

use populace_device::layout::{Float4, JOINT_BLOCK, PAGE_ENTRIES, PALETTE_BLOCK};
use populace_device::{
    Backend, BackendError, Frame, GlContext, PaletteSource, PaletteTarget, PaletteTransport,
    ReleasedPalettes, Schedule, Stage, StageBuffer, Tables, TargetMark, UserStage,
};

use crate::history::DeviceHistory;
use balance::Balance;
use places::{Places, Run};

/// Elements of a palette page.
const PAGE: usize = PAGE_ENTRIES as usize * 3;

/// The most runs of palettes that are written one by one. Each write costs as much as copying some
/// hundred kilobytes, so a page with more runs is written as a whole.
const CALLS: usize = 64;

/// A crowd on several devices. Each device holds a copy of all tables and space for all palettes,
/// so members move between devices at no cost. Palettes are gathered on the first device when pages
/// are read.
pub struct SplitBackend {
    /// The devices, two or more.
    parts: Vec<Part>,
    balance: Balance,
    places: Places,
    /// Whether the first device holds all palettes of the last frame.
    is_gathered: bool,
    /// Scratch memory for a page that holds palettes of two devices.
    page: Vec<Float4>,
    /// Whether a frame ran that `balance` has not been told of.
    is_measurable: bool,
    /// The user stages that all devices have.
    stages: Vec<Option<UserStage>>,
}

/// A device and the range that it evaluated last.
struct Part {
    backend: Box<dyn Backend>,
    places: Range<u32>,
    members: usize,
    /// Whether the device runs frames. The first always does: the palettes of others are written
    /// into its pages, and only a frame swaps them for pages that OpenGL does not draw.
    is_at_work: bool,
}

impl Part {
    fn new(backend: Box<dyn Backend>) -> Self {
        Self { backend, places: 0..0, members: 0, is_at_work: false }
    }

    fn run(&mut self, tables: &Tables, frame: Frame) -> Result<(), BackendError> {
        self.backend.run(tables, self.own(frame))
    }

    /// Returns this device's part of a frame.
    fn own(&self, frame: Frame) -> Frame {
        let place_first = frame.place_first.max(self.places.start);
        Frame { place_first, place_end: frame.place_end.min(self.places.end), ..frame }
    }
}

impl SplitBackend {
    /// Shares a crowd among devices, by fixed shares whose sum is 1 or by measured speed.
    #[must_use]
    pub fn new(backends: Vec<Box<dyn Backend>>, shares: Option<Vec<f64>>) -> Self {
        let balance = Balance::new(backends.len(), shares);
        let parts = backends.into_iter().map(Part::new).collect();
        Self {
            parts,
            balance,
            places: Places::default(),
            is_gathered: true,
            page: Vec::new(),
            is_measurable: false,
            stages: Vec::new(),
        }
    }

    /// Sets the shares from the next frame on.
    pub fn set_shares(&mut self, shares: Option<Vec<f64>>) {
        if shares.is_some() || self.balance.is_fixed() {
            self.balance = Balance::new(self.parts.len(), shares);
        }
    }

    /// The share of each device; the sum is 1.
    #[must_use]
    pub fn shares(&self) -> &[f64] {
        self.balance.shares()
    }

    /// Updates the shares from the last frame and divides the members.
    fn divide(&mut self, tables: &Tables) {
        if std::mem::take(&mut self.is_measurable) && !self.balance.is_fixed() {
            let work: Vec<_> = self
                .parts
                .iter_mut()
                .map(|part| (part.members, part.backend.frame_time_ms()))
                .collect();
            self.balance.measured(work.into_iter());
        }
        let ends = self.balance.ends(self.places.members());
        let (mut first, mut place) = (0, 0);
        for (part, end) in self.parts.iter_mut().zip(ends) {
            // The device of the last member also takes the free indices after it.
            let place_end = self.places.place_after(end);
            (part.places, part.members) = (place..place_end, end - first);
            // Each device advances all state machines, so that it knows their states when it
            // receives members.
            part.is_at_work = part.members > 0 || !tables.machine_instances().as_slice().is_empty();
            (first, place) = (end, place_end);
        }
        self.parts[0].is_at_work = true;
        self.is_gathered = false;
    }

    fn at_work(&mut self, runs_ahead: bool) -> impl Iterator<Item = &mut Part> {
        let parts = self.parts.iter_mut().filter(|part| part.is_at_work);
        parts.filter(move |part| part.backend.runs_ahead() == runs_ahead)
    }

    fn with_members(&mut self) -> impl Iterator<Item = &mut Part> {
        self.parts.iter_mut().filter(|part| part.members > 0)
    }

    /// Returns the device that evaluated an element, and the first element that may belong to
    /// another.
    fn owner_of(&self, tables: &Tables, buffer: StageBuffer, element: usize) -> (usize, usize) {
        let block = match buffer {
            StageBuffer::Samples => tables.slots_per_member(),
            StageBuffer::Palette => PALETTE_BLOCK as usize * 3,
            _ => JOINT_BLOCK as usize,
        };
        let place = match buffer {
            StageBuffer::Palette => {
                tables.palette_blocks().as_slice().get(element / block).copied()
            }
            _ => tables.place_of(buffer, element).map(|(place, _)| place),
        };
        let of_place = |place: u32| self.parts.iter().position(|part| part.places.contains(&place));
        (place.and_then(of_place).unwrap_or(0), (element / block + 1) * block)
    }

    /// Exchanges history and watched joints between the devices: in the next frame, or the next
    /// phase, another device may evaluate a member, look at it or follow it. Waits for all devices.
    /// Does nothing if there is nothing to exchange.
    fn share_history(&mut self, tables: &Tables) -> Result<(), BackendError> {
        if !DeviceHistory::default().allocate(tables) {
            return Ok(());
        }
        // Joints of members that are gone stay where they were, and are the same on all devices.
        let mut all = DeviceHistory::read(&mut *self.parts[0].backend, tables)?;
        for at in 1..self.parts.len() {
            let own = DeviceHistory::read(&mut *self.parts[at].backend, tables)?;
            let places = self.parts[at].places.clone();
            for (_, member) in
                (0..).zip(tables.members().as_slice()).filter(|(place, _)| places.contains(place))
            {
                all.take_over(&own, tables, member);
            }
        }
        self.parts.iter_mut().try_for_each(|part| all.write(&mut *part.backend, tables))
    }

    /// Copies the palettes that other devices wrote to the pages of the first.
    fn gather(&mut self) -> Result<(), BackendError> {
        let Self { parts, places, is_gathered, page, .. } = self;
        if let Some((first, others)) = parts.split_first_mut().filter(|_| !*is_gathered) {
            for part in others.iter_mut().filter(|part| part.members > 0) {
                for runs in places.palettes(part.places.clone()).chunk_by(|a, b| a.page == b.page) {
                    bring(&mut *part.backend, &mut *first.backend, runs, page)?;
                }
            }
        }
        *is_gathered = true;
        Ok(())
    }
}

/// Runs a frame on devices whose `run` blocks: one on this thread, the others on threads of their
/// own.
fn run_together<'a>(
    parts: impl Iterator<Item = &'a mut Part>,
    tables: &Tables,
    frame: Frame,
) -> Result<(), BackendError> {
    let mut parts = parts.peekable();
    let Some(here) = parts.next() else { return Ok(()) };
    if parts.peek().is_none() {
        return here.run(tables, frame);
    }
    thread::scope(|scope| {
        let others: Vec<_> =
            parts.map(|part| scope.spawn(move || part.run(tables, frame))).collect();
        let result = here.run(tables, frame);
        let join = |other: ScopedJoinHandle<'_, _>| {
            other.join().unwrap_or_else(|panic| resume_unwind(panic))
        };
        others.into_iter().map(join).fold(result, Result::and)
    })
}

/// Copies runs of one page from one device to another. `copy` is scratch memory.
fn bring(
    from: &mut dyn Backend,
    to: &mut dyn Backend,
    runs: &[Run],
    copy: &mut Vec<Float4>,
) -> Result<(), BackendError> {
    let page = runs[0].page;
    let scattered = to.runs_ahead() && runs.len() > CALLS;
    if scattered {
        copy.clear();
        to.with_page(page, &mut |palettes| copy.extend_from_slice(palettes))?;
    }
    let mut result = Ok(());
    from.with_page(page, &mut |palettes| {
        result = runs.iter().try_for_each(|run| {
            let length = if scattered { copy.len().min(palettes.len()) } else { palettes.len() };
            let end = run.elements.end.min(length);
            let own = run.elements.start.min(end)..end;
            if scattered {
                copy[own.clone()].copy_from_slice(&palettes[own]);
                return Ok(());
            }
            to.write(StageBuffer::Palette, page * PAGE + own.start, &palettes[own])
        });
    })?;
    result?;
    if scattered { to.write(StageBuffer::Palette, page * PAGE, copy) } else { Ok(()) }
}

impl Backend for SplitBackend {
    fn device_name(&self) -> String {
        let names: Vec<_> = self.parts.iter().map(|part| part.backend.device_name()).collect();
        names.join(" + ")
    }

    fn schedule(&self) -> Schedule {
        self.parts[0].backend.schedule()
    }

    fn update(&mut self, tables: &Tables) -> Result<(), BackendError> {
        self.parts.iter_mut().try_for_each(|part| part.backend.update(tables))?;
        self.places.update(tables);
        Ok(())
    }

    fn set_stages(&mut self, stages: &[Option<UserStage>]) -> Result<(), BackendError> {
        for at in 0..self.parts.len() {
            if let Err(error) = self.parts[at].backend.set_stages(stages) {
                for part in &mut self.parts[..at] {
                    // It keeps the stages that all devices had, or can build them again.
                    let _kept = part.backend.set_stages(&self.stages);
                }
                return Err(error);
            }
        }
        self.stages = stages.to_vec();
        Ok(())
    }

    fn run_stage(
        &mut self,
        tables: &Tables,
        frame: Frame,
        stage: Stage,
    ) -> Result<(), BackendError> {
        if stage == Stage::Evaluate {
            self.divide(tables);
        }
        self.is_gathered = false;
        let run = |parts: &mut [Part], frame| {
            parts
                .iter_mut()
                .try_for_each(|part| part.backend.run_stage(tables, part.own(frame), stage))
        };
        if stage != Stage::Transform {
            return run(&mut self.parts, frame);
        }
        for phase in frame.phases(tables) {
            run(&mut self.parts, frame.of_phase(phase))?;
            self.share_history(tables)?;
        }
        Ok(())
    }

    fn run(&mut self, tables: &Tables, frame: Frame) -> Result<(), BackendError> {
        self.divide(tables);
        for phase in frame.phases(tables) {
            let frame = frame.of_phase(phase);
            // First the devices whose `run` does not block.
            self.at_work(true).try_for_each(|part| part.run(tables, frame))?;
            run_together(self.at_work(false), tables, frame)?;
            self.share_history(tables)?;
        }
        self.is_measurable = true;
        Ok(())
    }

    fn undo_frame(&mut self) {
        self.parts.iter_mut().for_each(|part| part.backend.undo_frame());
    }

    fn runs_ahead(&self) -> bool {
        self.parts.iter().all(|part| part.backend.runs_ahead())
    }

    fn read(
        &mut self,
        tables: &Tables,
        buffer: StageBuffer,
        mut first: usize,
        mut into: &mut [Float4],
    ) -> Result<(), BackendError> {
        while !into.is_empty() {
            let (owner, mut end) = self.owner_of(tables, buffer, first);
            while end < first + into.len() {
                match self.owner_of(tables, buffer, end) {
                    (other, next) if other == owner => end = next,
                    _ => break,
                }
            }
            let (now, later) = into.split_at_mut((end - first).min(into.len()));
            self.parts[owner].backend.read(tables, buffer, first, now)?;
            (first, into) = (end, later);
        }
        Ok(())
    }

    /// Every device receives them, because any of them may run the next stage.
    fn write(
        &mut self,
        buffer: StageBuffer,
        first: usize,
        from: &[Float4],
    ) -> Result<(), BackendError> {
        self.parts.iter_mut().try_for_each(|part| part.backend.write(buffer, first, from))
    }

    fn finish(&mut self) -> Result<(), BackendError> {
        self.parts.iter_mut().try_for_each(|part| part.backend.finish())
    }

    /// The first device holds the watched joints of all members.
    fn fetch_watched(&mut self, tables: &Tables, tick: u64) -> Result<(), BackendError> {
        self.parts[0].backend.fetch_watched(tables, tick)
    }

    fn fetched(&mut self) -> Result<Option<(u64, &[Float4])>, BackendError> {
        self.parts[0].backend.fetched()
    }

    fn forget_fetched(&mut self) {
        self.parts[0].backend.forget_fetched();
    }

    fn waits(&self) -> u64 {
        self.parts.iter().map(|part| part.backend.waits()).max().unwrap_or(0)
    }

    /// The longest time: the devices work at the same time.
    fn frame_time_ms(&mut self) -> Option<f64> {
        let times: Option<Vec<f64>> =
            self.with_members().map(|part| part.backend.frame_time_ms()).collect();
        times?.into_iter().reduce(f64::max)
    }

    fn stage_times_ms(&mut self) -> Vec<(Stage, f64)> {
        let times: Vec<_> =
            self.with_members().flat_map(|part| part.backend.stage_times_ms()).collect();
        let longest = |stage: Stage| {
            let of_stage = times.iter().filter(|(known, _)| *known == stage).map(|(_, ms)| *ms);
            Some((stage, of_stage.reduce(f64::max)?))
        };
        Stage::ALL.into_iter().filter_map(longest).collect()
    }

    /// The shortest time: each device writes every palette.
    fn write_floor(&mut self, tables: &Tables) -> Result<f64, BackendError> {
        let times: Result<Vec<f64>, _> =
            self.parts.iter_mut().map(|part| part.backend.write_floor(tables)).collect();
        Ok(times?.into_iter().fold(f64::INFINITY, f64::min))
    }

    fn memory_bytes(&self) -> usize {
        self.parts.iter().map(|part| part.backend.memory_bytes()).sum()
    }
}

impl PaletteSource for SplitBackend {
    fn page_lengths(&self) -> Vec<usize> {
        self.parts[0].backend.page_lengths()
    }

    fn refuses(&self, transport: PaletteTransport, context: &dyn GlContext) -> Option<String> {
        self.parts[0].backend.refuses(transport, context)
    }

    fn set_target(&mut self, target: PaletteTarget, mark: &TargetMark) -> Result<(), BackendError> {
        self.parts[0].backend.set_target(target, mark)
    }

    fn release_palettes(&mut self) -> Result<Option<ReleasedPalettes>, BackendError> {
        self.gather()?;
        self.parts[0].backend.release_palettes()
    }

    fn with_page(
        &mut self,
        page: usize,
        reader: &mut dyn FnMut(&[Float4]),
    ) -> Result<(), BackendError> {
        self.gather()?;
        self.parts[0].backend.with_page(page, reader)
    }
}

#[cfg(test)]
mod tests;
