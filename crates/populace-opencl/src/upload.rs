//! Upload of the host's changed tables, without waiting for work that the device is still doing.

use std::collections::VecDeque;
use std::ops::Range;

use opencl3::error_codes::ClError;
use populace_device::{BackendError, Table, Tables};

use crate::OpenClDevice;
use crate::buffer::{Buffer, Element, StagingWords};
use crate::handles::{CommandQueue, Kernel};
use crate::launch::{Launch, WorkSize};
use crate::program::Form;

/// Upload batches in flight at most. A host that is further ahead waits for the oldest.
const MAX_BATCHES: usize = 64;
/// Runs of more bytes are written from the table itself, and the host waits. They come with
/// loading, and a second copy would take memory that loading needs.
const STAGED_BYTES: usize = 32 << 20;

/// Device copies of some of the host's tables.
pub(crate) trait Copies {
    /// Collects the changes of each table into `batch` and allocates larger buffers where needed.
    /// The copies themselves do not change yet.
    fn pack(
        &mut self,
        device: &OpenClDevice,
        tables: &Tables,
        batch: &mut UploadBatch,
    ) -> Result<(), BackendError>;

    /// Applies the changes that `pack` collected just before.
    fn send(&mut self, tables: &Tables, uploader: &mut BatchUploader) -> Result<(), BackendError>;

    /// Drops collected changes that will not be sent.
    fn discard(&mut self);
}

/// The words that one update uploads.
#[derive(Default)]
pub(crate) struct UploadBatch {
    /// For each table with a few changes: their indices, then their values.
    changes: StagingWords,
    /// Runs of neighbouring elements.
    runs: StagingWords,
}

/// Position of one table's changes in [`UploadBatch::changes`].
struct Scatter {
    index_first: usize,
    value_first: usize,
    end: usize,
}

/// A run of elements and its position in [`UploadBatch::runs`]; `None` if it is written from the
/// table itself.
#[derive(Default)]
struct ElementRun {
    elements: Range<usize>,
    word_first: Option<usize>,
}

/// Collected changes of one table.
struct TableUpdate<T> {
    /// Replaces the copy once it holds the first of `runs`.
    grown: Option<Buffer<T>>,
    scatter: Option<Scatter>,
    runs: [ElementRun; 2],
}

impl<T> Default for TableUpdate<T> {
    fn default() -> Self {
        Self { grown: None, scatter: None, runs: Default::default() }
    }
}

impl UploadBatch {
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
        for position in index_first..value_first {
            let value = table.as_slice()[words[position] as usize];
            words.extend_from_slice(bytemuck::cast_slice(&[value]));
        }
        Ok(Scatter { index_first, value_first, end: words.len() })
    }

    fn add_run<T: Element>(
        &mut self,
        table: &Table<T>,
        elements: Range<usize>,
    ) -> Result<ElementRun, ClError> {
        let words = bytemuck::cast_slice(&table.as_slice()[elements.clone()]);
        if size_of_val::<[u32]>(words) > STAGED_BYTES {
            return Ok(ElementRun { elements, word_first: None });
        }
        let staged = self.runs.words()?;
        let word_first = Some(staged.len());
        staged.extend_from_slice(words);
        Ok(ElementRun { elements, word_first })
    }
}

/// A table's copy on the device, with capacity to grow.
pub(crate) struct DeviceTable<T> {
    pub(crate) buffer: Buffer<T>,
    pending: TableUpdate<T>,
}

impl<T: Element> DeviceTable<T> {
    pub(crate) fn new(device: &OpenClDevice) -> Result<Self, BackendError> {
        Ok(Self {
            buffer: Buffer::new(device, 0, "an empty table")?,
            pending: TableUpdate::default(),
        })
    }

    pub(crate) fn pack(
        &mut self,
        device: &OpenClDevice,
        table: &Table<T>,
        batch: &mut UploadBatch,
    ) -> Result<(), BackendError> {
        let failed = |e| device.failed(&format!("collect changes of {}", table.name()), &e);
        let count = table.as_slice().len();
        if count > self.buffer.len() {
            self.pending.grown = Some(self.larger(device, table)?);
            self.pending.runs[0] = batch.add_run(table, 0..count).map_err(failed)?;
            return Ok(());
        }
        let changed = table.changed().count();
        if changed > count / 4 {
            let ends = table.changed().fold((u32::MAX, 0), |(a, b), i| (a.min(i), b.max(i)));
            self.pending.runs[0] =
                batch.add_run(table, ends.0 as usize..ends.1 as usize + 1).map_err(failed)?;
        } else if changed > 0 {
            self.pending.scatter = Some(batch.add_changes(table).map_err(failed)?);
        }
        self.pending.runs[1] = batch.add_run(table, table.tail()).map_err(failed)?;
        Ok(())
    }

    /// Allocates a buffer for the expected element count of a table; without one, for half as many
    /// elements again as now, so that a growing crowd is not copied at every step. Falls back to
    /// the exact count if that cannot be allocated.
    fn larger(&self, device: &OpenClDevice, table: &Table<T>) -> Result<Buffer<T>, BackendError> {
        let (count, expected) = (table.as_slice().len(), table.expected());
        let capacity =
            if expected < count { count.max(self.buffer.len() * 3 / 2) } else { expected };
        match Buffer::new(device, capacity, table.name()) {
            Err(_) if capacity > count => Buffer::new(device, count, table.name()),
            result => result,
        }
    }

    pub(crate) fn send(
        &mut self,
        table: &Table<T>,
        uploader: &mut BatchUploader,
    ) -> Result<(), BackendError> {
        let update = std::mem::take(&mut self.pending);
        self.apply(update, table, uploader)
            .map_err(|e| uploader.device.failed(&format!("write {}", table.name()), &e))
    }

    pub(crate) fn discard(&mut self) {
        self.pending = TableUpdate::default();
    }

    fn apply(
        &mut self,
        update: TableUpdate<T>,
        table: &Table<T>,
        uploader: &mut BatchUploader,
    ) -> Result<(), ClError> {
        if let Some(mut grown) = update.grown {
            uploader.write(&mut grown, table, &update.runs[0])?;
            // Only now: a buffer that could not be filled must not count as full.
            self.buffer = grown;
            return Ok(());
        }
        if let Some(scatter) = update.scatter {
            uploader.scatter(&mut self.buffer, &scatter)?;
        }
        update.runs.iter().try_for_each(|run| uploader.write(&mut self.buffer, table, run))
    }
}

/// Uploads one batch.
pub(crate) struct BatchUploader<'a> {
    device: &'a OpenClDevice,
    queue: &'a CommandQueue,
    kernel: &'a Kernel,
    group: usize,
    changes: &'a Buffer<u32>,
    batch: UploadBatch,
}

impl BatchUploader<'_> {
    fn write<T: Element>(
        &mut self,
        to: &mut Buffer<T>,
        table: &Table<T>,
        run: &ElementRun,
    ) -> Result<(), ClError> {
        let elements = run.elements.clone();
        match run.word_first {
            Some(word) => to.write_staged(self.queue, elements, &mut self.batch.runs, word),
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
            .run(self.queue, WorkSize::of(word_count, self.group))?;
        Ok(())
    }
}

/// Narrows an offset within one update to 32 bits, or fails.
fn narrow(count: usize) -> Result<u32, ClError> {
    const INVALID_VALUE: i32 = -30;
    u32::try_from(count).map_err(|_| ClError(INVALID_VALUE))
}

/// Uploads changes of tables, and keeps batches until the device has read them.
pub(crate) struct Uploader {
    kernel: Kernel,
    group: usize,
    /// The changed elements of all tables, before they are scattered.
    changes: Buffer<u32>,
    /// Batches that the device may still be reading, the oldest first.
    sent: VecDeque<UploadBatch>,
}

impl Uploader {
    /// `group` is the number of work-items in a work-group.
    pub(crate) fn new(device: &OpenClDevice, group: usize) -> Result<Self, BackendError> {
        Ok(Self {
            kernel: device.kernel(Form::Common, "", "apply_changes")?,
            group,
            changes: Buffer::new(device, 0, "an empty list of changes")?,
            sent: VecDeque::new(),
        })
    }

    /// Enqueues the upload of all changes. If memory cannot be allocated, all copies stay as they
    /// were.
    pub(crate) fn update(
        &mut self,
        device: &OpenClDevice,
        queue: &CommandQueue,
        tables: &Tables,
        copies: &mut [&mut dyn Copies],
    ) -> Result<(), BackendError> {
        let batch = self.empty_batch().map_err(|e| device.failed("start an upload", &e))?;
        let result = self.dispatch(device, queue, tables, copies, batch);
        copies.iter_mut().for_each(|c| c.discard());
        self.sent.push_back(result?);
        Ok(())
    }

    fn dispatch(
        &mut self,
        device: &OpenClDevice,
        queue: &CommandQueue,
        tables: &Tables,
        copies: &mut [&mut dyn Copies],
        mut batch: UploadBatch,
    ) -> Result<UploadBatch, BackendError> {
        copies.iter_mut().try_for_each(|c| c.pack(device, tables, &mut batch))?;
        self.send_changes(device, queue, &mut batch)?;
        let (kernel, group, changes) = (&self.kernel, self.group, &self.changes);
        let mut uploader = BatchUploader { device, queue, kernel, group, changes, batch };
        copies.iter_mut().try_for_each(|c| c.send(tables, &mut uploader))?;
        Ok(uploader.batch)
    }

    fn empty_batch(&mut self) -> Result<UploadBatch, ClError> {
        let oldest_is_done = match self.sent.front() {
            Some(oldest) => oldest.changes.is_done()? && oldest.runs.is_done()?,
            None => false,
        };
        let mut batch = if oldest_is_done || self.sent.len() >= MAX_BATCHES {
            self.sent.pop_front().unwrap_or_default()
        } else {
            UploadBatch::default()
        };
        batch.empty()?;
        Ok(batch)
    }

    fn send_changes(
        &mut self,
        device: &OpenClDevice,
        queue: &CommandQueue,
        batch: &mut UploadBatch,
    ) -> Result<(), BackendError> {
        let failed = |e| device.failed("write changed elements", &e);
        let count = batch.changes.words().map_err(failed)?.len();
        if count > self.changes.len() {
            self.changes = Buffer::new(device, count.next_power_of_two(), "changed elements")?;
        }
        self.changes.write_staged(queue, 0..count, &mut batch.changes, 0).map_err(failed)
    }

    pub(crate) fn bytes(&self) -> usize {
        self.changes.bytes()
    }
}

#[cfg(test)]
mod tests;
