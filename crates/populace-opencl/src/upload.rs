//! Bringing a device's copies of the host's tables up to date, without waiting for what the device
//! is still doing.

use std::collections::VecDeque;
use std::ops::Range;

use opencl3::command_queue::CommandQueue;
use opencl3::error_codes::ClError;
use opencl3::kernel::Kernel;
use populace_device::{BackendError, Table, Tables};

use crate::OpenClDevice;
use crate::buffer::{Buffer, Element, Staging};
use crate::launch::Launch;
use crate::program::Form;

/// Updates whose memory on the host is kept until the device has read it; a host that is as many
/// ahead waits for the oldest.
const RING: usize = 64;
/// Longer runs of elements are written from the table itself while the host waits: they come with
/// loading, and a second copy of them would take memory that loading is short of.
const STAGED_BYTES: usize = 32 << 20;

/// Copies of some of the host's tables.
pub(crate) trait Copies {
    /// Finds out what each copy lacks, makes room for it, and lays it into `parcel`. Copies stay as
    /// they are.
    fn pack(
        &mut self,
        device: &OpenClDevice,
        tables: &Tables,
        parcel: &mut Parcel,
    ) -> Result<(), BackendError>;

    /// Brings each copy up to date with what was packed just before.
    fn send(&mut self, tables: &Tables, route: &mut Route) -> Result<(), BackendError>;

    /// Frees what was made ready and will not be sent.
    fn forget(&mut self);
}

/// What one update carries.
#[derive(Default)]
pub(crate) struct Parcel {
    /// Of each table with a few changes the indices, then the values.
    changes: Staging,
    /// Runs of elements.
    runs: Staging,
}

/// Where in [`Parcel::changes`] the changed elements of one table stand.
struct Scatter {
    index_first: usize,
    value_first: usize,
    end: usize,
}

/// A run of elements, and where in [`Parcel::runs`] it stands; nowhere where it is to be written
/// from the table.
#[derive(Default)]
struct Run {
    elements: Range<usize>,
    word_first: Option<usize>,
}

/// How one table's copy will be brought up to date.
struct Plan<T> {
    /// Takes the place of the copy once it holds the first of `runs`.
    grown: Option<Buffer<T>>,
    scatter: Option<Scatter>,
    runs: [Run; 2],
}

impl<T> Default for Plan<T> {
    fn default() -> Self {
        Self { grown: None, scatter: None, runs: Default::default() }
    }
}

impl Parcel {
    fn empty(&mut self) -> Result<(), ClError> {
        self.changes.words()?.clear();
        self.runs.words()?.clear();
        Ok(())
    }

    fn add_changes<T: Element>(&mut self, table: &Table<T>) -> Result<Scatter, ClError> {
        let words = self.changes.words()?;
        let index_first = words.len();
        words.extend(table.changed());
        let value_first = words.len();
        for place in index_first..value_first {
            let value = table.as_slice()[words[place] as usize];
            words.extend_from_slice(bytemuck::cast_slice(&[value]));
        }
        Ok(Scatter { index_first, value_first, end: words.len() })
    }

    fn add_run<T: Element>(
        &mut self,
        table: &Table<T>,
        elements: Range<usize>,
    ) -> Result<Run, ClError> {
        let words = bytemuck::cast_slice(&table.as_slice()[elements.clone()]);
        if size_of_val::<[u32]>(words) > STAGED_BYTES {
            return Ok(Run { elements, word_first: None });
        }
        let staged = self.runs.words()?;
        let word_first = Some(staged.len());
        staged.extend_from_slice(words);
        Ok(Run { elements, word_first })
    }
}

/// A table's copy on the device, with room to grow.
pub(crate) struct DeviceTable<T> {
    pub(crate) buffer: Buffer<T>,
    plan: Plan<T>,
}

impl<T: Element> DeviceTable<T> {
    pub(crate) fn new(device: &OpenClDevice) -> Result<Self, BackendError> {
        Ok(Self { buffer: Buffer::new(device, 0, "an empty table")?, plan: Plan::default() })
    }

    pub(crate) fn pack(
        &mut self,
        device: &OpenClDevice,
        table: &Table<T>,
        parcel: &mut Parcel,
    ) -> Result<(), BackendError> {
        let failed = |e| device.failed(&format!("gather changes of {}", table.name()), &e);
        let count = table.as_slice().len();
        if count > self.buffer.len() {
            self.plan.grown = Some(self.larger(device, table)?);
            self.plan.runs[0] = parcel.add_run(table, 0..count).map_err(failed)?;
            return Ok(());
        }
        let changed = table.changed().count();
        if changed > count / 4 {
            let ends = table.changed().fold((u32::MAX, 0), |(a, b), i| (a.min(i), b.max(i)));
            self.plan.runs[0] =
                parcel.add_run(table, ends.0 as usize..ends.1 as usize + 1).map_err(failed)?;
        } else if changed > 0 {
            self.plan.scatter = Some(parcel.add_changes(table).map_err(failed)?);
        }
        self.plan.runs[1] = parcel.add_run(table, table.tail()).map_err(failed)?;
        Ok(())
    }

    /// A buffer with room for as many elements as a table is expected to have, else for half as
    /// many again as now, so that a growing crowd is not copied at every step; where that is too
    /// much, for those that there are.
    fn larger(&self, device: &OpenClDevice, table: &Table<T>) -> Result<Buffer<T>, BackendError> {
        let (count, expected) = (table.as_slice().len(), table.expected());
        let room = if expected < count { count.max(self.buffer.len() * 3 / 2) } else { expected };
        match Buffer::new(device, room, table.name()) {
            Err(_) if room > count => Buffer::new(device, count, table.name()),
            result => result,
        }
    }

    pub(crate) fn send(&mut self, table: &Table<T>, route: &mut Route) -> Result<(), BackendError> {
        let plan = std::mem::take(&mut self.plan);
        self.carry_out(plan, table, route)
            .map_err(|e| route.device.failed(&format!("write {}", table.name()), &e))
    }

    pub(crate) fn forget(&mut self) {
        self.plan = Plan::default();
    }

    fn carry_out(
        &mut self,
        plan: Plan<T>,
        table: &Table<T>,
        route: &mut Route,
    ) -> Result<(), ClError> {
        if let Some(mut grown) = plan.grown {
            route.write(&mut grown, table, &plan.runs[0])?;
            // Only now: a buffer that could not be filled must not be taken for a full one.
            self.buffer = grown;
            return Ok(());
        }
        if let Some(scatter) = plan.scatter {
            route.scatter(&mut self.buffer, &scatter)?;
        }
        plan.runs.iter().try_for_each(|run| route.write(&mut self.buffer, table, run))
    }
}

/// The way of one parcel to the device.
pub(crate) struct Route<'a> {
    device: &'a OpenClDevice,
    queue: &'a CommandQueue,
    kernel: &'a Kernel,
    group: usize,
    changes: &'a Buffer<u32>,
    parcel: Parcel,
}

impl Route<'_> {
    fn write<T: Element>(
        &mut self,
        to: &mut Buffer<T>,
        table: &Table<T>,
        run: &Run,
    ) -> Result<(), ClError> {
        let elements = run.elements.clone();
        match run.word_first {
            Some(word) => to.write_staged(self.queue, elements, &mut self.parcel.runs, word),
            None => to.write(self.queue, elements.start, &table.as_slice()[elements]),
        }
    }

    fn scatter<T: Element>(&mut self, to: &mut Buffer<T>, of: &Scatter) -> Result<(), ClError> {
        let word_count = of.end - of.value_first;
        Launch::of(self.kernel)
            .buffer("changes", self.changes)
            .uint("index_first", narrow(of.index_first)?)
            .uint("value_first", narrow(of.value_first)?)
            .uint("element_words", narrow(size_of::<T>() / size_of::<u32>())?)
            .uint("word_count", narrow(word_count)?)
            .words("table", to)
            .run(self.queue, [word_count.next_multiple_of(self.group), 1], [self.group, 1])?;
        Ok(())
    }
}

/// Offsets within one update, which is far below 2^32 words, or is not done.
fn narrow(count: usize) -> Result<u32, ClError> {
    const INVALID_VALUE: i32 = -30;
    u32::try_from(count).map_err(|_| ClError(INVALID_VALUE))
}

/// Brings copies up to date.
pub(crate) struct Uploader {
    kernel: Kernel,
    group: usize,
    /// Changed elements of all tables on their way to their places.
    changes: Buffer<u32>,
    /// Parcels that the device may still be reading, the oldest first.
    sent: VecDeque<Parcel>,
}

impl Uploader {
    /// `group` is the work-items in a group.
    pub(crate) fn new(device: &OpenClDevice, group: usize) -> Result<Self, BackendError> {
        Ok(Self {
            kernel: device.kernel(Form::Common, "", "apply_changes")?,
            group,
            changes: Buffer::new(device, 0, "an empty list of changes")?,
            sent: VecDeque::new(),
        })
    }

    /// Enqueues what brings all copies up to date, or leaves them as they were where there is no
    /// room.
    pub(crate) fn update(
        &mut self,
        device: &OpenClDevice,
        queue: &CommandQueue,
        tables: &Tables,
        copies: &mut [&mut dyn Copies],
    ) -> Result<(), BackendError> {
        let parcel = self.empty_parcel().map_err(|e| device.failed("take over changes", &e))?;
        let result = self.dispatch(device, queue, tables, copies, parcel);
        copies.iter_mut().for_each(|c| c.forget());
        self.sent.push_back(result?);
        Ok(())
    }

    fn dispatch(
        &mut self,
        device: &OpenClDevice,
        queue: &CommandQueue,
        tables: &Tables,
        copies: &mut [&mut dyn Copies],
        mut parcel: Parcel,
    ) -> Result<Parcel, BackendError> {
        copies.iter_mut().try_for_each(|c| c.pack(device, tables, &mut parcel))?;
        self.send_changes(device, queue, &mut parcel)?;
        let (kernel, group, changes) = (&self.kernel, self.group, &self.changes);
        let mut route = Route { device, queue, kernel, group, changes, parcel };
        copies.iter_mut().try_for_each(|c| c.send(tables, &mut route))?;
        Ok(route.parcel)
    }

    fn empty_parcel(&mut self) -> Result<Parcel, ClError> {
        let oldest_is_done = match self.sent.front() {
            Some(oldest) => oldest.changes.is_done()? && oldest.runs.is_done()?,
            None => false,
        };
        let mut parcel = if oldest_is_done || self.sent.len() >= RING {
            self.sent.pop_front().unwrap_or_default()
        } else {
            Parcel::default()
        };
        parcel.empty()?;
        Ok(parcel)
    }

    fn send_changes(
        &mut self,
        device: &OpenClDevice,
        queue: &CommandQueue,
        parcel: &mut Parcel,
    ) -> Result<(), BackendError> {
        let failed = |e| device.failed("write changed elements", &e);
        let count = parcel.changes.words().map_err(failed)?.len();
        if count > self.changes.len() {
            self.changes = Buffer::new(device, count.next_power_of_two(), "changed elements")?;
        }
        self.changes.write_staged(queue, 0..count, &mut parcel.changes, 0).map_err(failed)
    }

    pub(crate) fn bytes(&self) -> usize {
        self.changes.bytes()
    }
}

#[cfg(test)]
mod tests;
