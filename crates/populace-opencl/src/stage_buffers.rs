//! What stages write and the next ones read, on the device.

use opencl3::command_queue::CommandQueue;
use opencl3::error_codes::ClError;
use populace_core::layout::{Float4, PAGE_ENTRIES, SlotSample};
use populace_core::{BackendError, StageBuffer, Tables};

use crate::OpenClDevice;
use crate::buffer::{Buffer, Element};

/// Elements of a whole page.
const PAGE_ELEMENTS: usize = PAGE_ENTRIES as usize * 3;

/// The buffers between stages; those of joints are as long as the joint buffer.
pub(crate) struct StageBuffers {
    pub(crate) samples: Buffer<SlotSample>,
    pub(crate) translations: Buffer<Float4>,
    pub(crate) rotations: Buffer<Float4>,
    pub(crate) scales: Buffer<Float4>,
    /// Rows of `model_from_joint`.
    pub(crate) models: [Buffer<Float4>; 3],
    /// Matrix palettes, three elements for each entry.
    pub(crate) pages: Vec<Buffer<Float4>>,
}

impl StageBuffers {
    pub(crate) fn new(device: &OpenClDevice) -> Result<Self, BackendError> {
        let empty = || Buffer::new(device, 0, "an empty buffer");
        Ok(Self {
            samples: Buffer::new(device, 0, "an empty buffer")?,
            translations: empty()?,
            rotations: empty()?,
            scales: empty()?,
            models: [empty()?, empty()?, empty()?],
            pages: Vec::new(),
        })
    }

    /// Makes room for what the tables hold. What stood in a buffer that grows is lost: the next frame writes it anew.
    pub(crate) fn update(&mut self, device: &OpenClDevice, tables: &Tables) -> Result<(), BackendError> {
        let joints = tables.joint_places();
        grow(device, &mut self.samples, tables.member_places() * tables.slots_per_member(), "slot samples")?;
        grow(device, &mut self.translations, joints, "joint translations")?;
        grow(device, &mut self.rotations, joints, "joint rotations")?;
        grow(device, &mut self.scales, joints, "joint scales")?;
        for rows in &mut self.models {
            grow(device, rows, joints, "model transforms")?;
        }
        for (page, entries) in tables.page_lengths().into_iter().enumerate() {
            if self.pages.len() <= page {
                self.pages.push(Buffer::new(device, 0, "an empty page")?);
            }
            grow(device, &mut self.pages[page], entries * 3, "matrix palettes")?;
        }
        Ok(())
    }

    /// Whether there is room for what the tables hold, as there is after an update.
    pub(crate) fn hold(&self, tables: &Tables) -> bool {
        let joints = [&self.translations, &self.rotations, &self.scales].into_iter().chain(&self.models);
        let pages = tables.page_lengths();
        tables.member_places() * tables.slots_per_member() <= self.samples.len()
            && joints.into_iter().all(|buffer| tables.joint_places() <= buffer.len())
            && pages.len() <= self.pages.len()
            && pages.iter().zip(&self.pages).all(|(entries, page)| entries * 3 <= page.len())
    }

    pub(crate) fn bytes(&self) -> usize {
        let joints = [&self.translations, &self.rotations, &self.scales];
        let all = joints.into_iter().chain(&self.models).chain(&self.pages);
        self.samples.bytes() + all.map(Buffer::bytes).sum::<usize>()
    }

    /// The memory that holds an element, the element's place in it, and how many from there on it can hold.
    fn place(
        &mut self,
        buffer: StageBuffer,
        first: usize,
    ) -> Result<(&mut Buffer<Float4>, usize, usize), ClError> {
        const INVALID_BUFFER: i32 = -38;
        let joints = match buffer {
            StageBuffer::Translations => &mut self.translations,
            StageBuffer::Rotations => &mut self.rotations,
            StageBuffer::Scales => &mut self.scales,
            StageBuffer::ModelRow0 => &mut self.models[0],
            StageBuffer::ModelRow1 => &mut self.models[1],
            StageBuffer::ModelRow2 => &mut self.models[2],
            StageBuffer::Samples | StageBuffer::Palette => {
                let page = self.pages.get_mut(first / PAGE_ELEMENTS).ok_or(ClError(INVALID_BUFFER))?;
                let at = first % PAGE_ELEMENTS;
                return Ok((page, at, PAGE_ELEMENTS - at));
            }
        };
        Ok((joints, first, usize::MAX))
    }

    pub(crate) fn read(
        &mut self,
        queue: &CommandQueue,
        buffer: StageBuffer,
        mut first: usize,
        mut into: &mut [Float4],
    ) -> Result<(), ClError> {
        if buffer == StageBuffer::Samples {
            return self.samples.read(queue, first, bytemuck::cast_slice_mut(into));
        }
        while !into.is_empty() {
            let (memory, at, room) = self.place(buffer, first)?;
            let (now, later) = into.split_at_mut(into.len().min(room));
            memory.read(queue, at, now)?;
            (first, into) = (first + now.len(), later);
        }
        Ok(())
    }

    pub(crate) fn write(
        &mut self,
        queue: &CommandQueue,
        buffer: StageBuffer,
        mut first: usize,
        mut from: &[Float4],
    ) -> Result<(), ClError> {
        if buffer == StageBuffer::Samples {
            return self.samples.write(queue, first, bytemuck::cast_slice(from));
        }
        while !from.is_empty() {
            let (memory, at, room) = self.place(buffer, first)?;
            let (now, later) = from.split_at(from.len().min(room));
            memory.write(queue, at, now)?;
            (first, from) = (first + now.len(), later);
        }
        Ok(())
    }
}

fn grow<T: Element>(
    device: &OpenClDevice,
    buffer: &mut Buffer<T>,
    count: usize,
    what: &str,
) -> Result<(), BackendError> {
    if count > buffer.len() {
        *buffer = Buffer::new(device, count, what)?;
    }
    Ok(())
}
