//! Several devices that evaluate one crowd: each takes the members of one range of places, all at
//! the same time.

mod balance;
mod kept;
mod places;

use std::ops::Range;
use std::panic::resume_unwind;
use std::thread::{self, ScopedJoinHandle};

use populace_device::layout::{Float4, JOINT_BLOCK, PAGE_ENTRIES, PALETTE_BLOCK};
use populace_device::{
    Backend, BackendError, Frame, GlContext, HandedOver, PaletteSource, PaletteTarget,
    PaletteTransport, Schedule, Stage, StageBuffer, Tables, TargetMark, UserStage,
};

use balance::Balance;
use places::{Places, Run};

pub(crate) use kept::Kept;

/// Elements of a page of palettes.
const PAGE: usize = PAGE_ENTRIES as usize * 3;

/// Runs of palettes that a driver is given one by one. Each call takes as long as copying some
/// hundred kilobytes: where there are more, as come with members that come and go, the page is
/// written as a whole.
const CALLS: usize = 64;

/// A crowd on several devices. Each keeps copies of all tables and has room for all palettes, so
/// that members change over from one to another at no cost. Palettes are gathered on the first
/// device, once somebody looks at pages.
pub(crate) struct SplitBackend {
    /// Two or more.
    parts: Vec<Part>,
    balance: Balance,
    places: Places,
    /// Whether the first device holds all palettes of the last frame.
    is_gathered: bool,
    /// A page on which palettes of both sides are laid together.
    page: Vec<Float4>,
    /// Whether a whole frame ran that `balance` does not know of yet.
    is_measurable: bool,
    /// Users', as all devices have them.
    stages: Vec<Option<UserStage>>,
}

/// A device, and what it evaluated last.
struct Part {
    backend: Box<dyn Backend>,
    places: Range<u32>,
    members: usize,
    /// Whether it has a part in frames. The first has even without a member: others' palettes are
    /// written into its pages, and only a frame turns it to pages that OpenGL does not draw from.
    is_at_work: bool,
}

impl Part {
    fn new(backend: Box<dyn Backend>) -> Self {
        Self { backend, places: 0..0, members: 0, is_at_work: false }
    }

    fn run(&mut self, tables: &Tables, frame: Frame) -> Result<(), BackendError> {
        self.backend.run(tables, self.own(frame))
    }

    /// What of a frame is this device's.
    fn own(&self, frame: Frame) -> Frame {
        let place_first = frame.place_first.max(self.places.start);
        Frame { place_first, place_end: frame.place_end.min(self.places.end), ..frame }
    }
}

impl SplitBackend {
    /// Lets devices share a crowd, by fixed shares of 1 in all, or as they are measured.
    pub(crate) fn new(backends: Vec<Box<dyn Backend>>, shares: Option<Vec<f64>>) -> Self {
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

    /// Replaces the shares, from the next frame on.
    pub(crate) fn set_shares(&mut self, shares: Option<Vec<f64>>) {
        if shares.is_some() || self.balance.is_fixed() {
            self.balance = Balance::new(self.parts.len(), shares);
        }
    }

    /// The share of each device, of 1 in all.
    pub(crate) fn shares(&self) -> &[f64] {
        self.balance.shares()
    }

    /// Learns from the last frame and divides the places anew.
    fn divide(&mut self, tables: &Tables) {
        if std::mem::take(&mut self.is_measurable) && !self.balance.is_fixed() {
            let work: Vec<_> = self
                .parts
                .iter_mut()
                .map(|part| (part.members, part.backend.frame_time_ms()))
                .collect();
            self.balance.measured(work.into_iter());
        }
        let all = self.places.members();
        let (mut share, mut first, mut place) = (0.0, 0, 0);
        for (part, own) in self.parts.iter_mut().zip(self.balance.shares()) {
            share += own;
            let end = nth_of(share, all).max(first);
            // Whoever has the last member has the places after it too.
            let place_end = self.places.place_after(end);
            (part.places, part.members) = (place..place_end, end - first);
            // Each device moves all state machines on, so that it knows where they are once it gets
            // members.
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

    /// The device that evaluated an element, and the first element that may be another's.
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

    /// Lets every device have what each keeps of its members, and what of them is watched: a
    /// member's next frame may be another device's, and so may those that look at it, or that are
    /// attached to it in the next phase. This waits for all devices, and nothing is done where
    /// there is nothing to share.
    fn share_kept(&mut self, tables: &Tables) -> Result<(), BackendError> {
        let mut all = Kept::default();
        if !all.make_room(tables) {
            return Ok(());
        }
        for at in 0..self.parts.len() {
            let own = Kept::read(&mut *self.parts[at].backend, tables)?;
            let places = self.parts[at].places.clone();
            for (_, member) in
                (0..).zip(tables.members().as_slice()).filter(|(place, _)| places.contains(place))
            {
                all.take_over(&own, tables, member);
            }
        }
        self.parts.iter_mut().try_for_each(|part| all.write(&mut *part.backend, tables))
    }

    /// Brings the palettes that other devices wrote into the pages of the first.
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

/// Runs a frame on devices whose `run` waits until it is done: one on this thread, others on
/// threads of their own.
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

/// Brings runs of one page from one device to another. `copy` is memory to work in.
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

/// How many of all members a share comes to.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "shares lie between 0 and 1, and there are less than 2^32 members"
)]
fn nth_of(share: f64, all: usize) -> usize {
    ((share * all as f64).round() as usize).min(all)
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
                    // It keeps what all had, or can build it again: it did before.
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
            self.share_kept(tables)?;
        }
        Ok(())
    }

    fn run(&mut self, tables: &Tables, frame: Frame) -> Result<(), BackendError> {
        self.divide(tables);
        for phase in frame.phases(tables) {
            let frame = frame.of_phase(phase);
            // First those that need only be told.
            self.at_work(true).try_for_each(|part| part.run(tables, frame))?;
            run_together(self.at_work(false), tables, frame)?;
            self.share_kept(tables)?;
        }
        self.is_measurable = true;
        Ok(())
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

    /// Every device gets them: which one the next stage needs them on is then no matter.
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

    /// The first has what is watched of all members.
    fn fetch_watched(&mut self, tables: &Tables, tick: u64) -> Result<(), BackendError> {
        self.parts[0].backend.fetch_watched(tables, tick)
    }

    fn fetched(&mut self) -> Result<Option<(u64, &[Float4])>, BackendError> {
        self.parts[0].backend.fetched()
    }

    fn waits(&self) -> u64 {
        self.parts.iter().map(|part| part.backend.waits()).max().unwrap_or(0)
    }

    /// The longest of all: they work at the same time.
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

    /// The least of all: each writes every palette.
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

    fn refuses(&self, way: PaletteTransport, context: &dyn GlContext) -> Option<String> {
        self.parts[0].backend.refuses(way, context)
    }

    fn set_target(&mut self, target: PaletteTarget, mark: &TargetMark) -> Result<(), BackendError> {
        self.parts[0].backend.set_target(target, mark)
    }

    fn hand_over(&mut self) -> Result<Option<HandedOver>, BackendError> {
        self.gather()?;
        self.parts[0].backend.hand_over()
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
