//! The stages of the crowd pipeline in Rust, on all cores: no driver needed.
//!
//! [`NativeBackend`] implements [`Backend`] with the *staged* schedule: evaluate, pose, transform and write-back, each
//! for all members, through the same buffers and with the same arithmetic as the OpenCL kernels of the same names.
//! Results do not depend on the number of threads.
//!
//! ```
//! use populace_core::{Backend, Frame, Tables};
//! use populace_native::NativeBackend;
//!
//! let mut backend = NativeBackend::new(2)?;
//! let tables = Tables::new(4);
//! backend.update(&tables)?;
//! backend.run(&tables, Frame { tick: 0 })?;
//! assert!(backend.with_page(0, &mut |_| ()).is_err(), "an empty crowd has no page of palettes");
//! # Ok::<(), populace_core::BackendError>(())
//! ```

mod evaluate;
mod floor;
mod joint;
mod lanes;
mod pose;
mod rows;
mod split;
mod transform;
mod write_back;

use std::time::Instant;

use populace_core::layout::{Float4, PAGE_ENTRIES, SlotSample};
use populace_core::{Backend, BackendError, Frame, Stage, StageBuffer, Tables};

/// Evaluates crowds on the CPU.
pub struct NativeBackend {
    pool: rayon::ThreadPool,
    samples: Vec<SlotSample>,
    joints: JointBuffer,
    models: ModelRows,
    pages: Vec<Vec<Float4>>,
    times_ms: [f64; Stage::ALL.len()],
}

/// Each member's local transforms, stored apart (Lister & Day 2012, section 3, "bone buffer").
#[derive(Default)]
struct JointBuffer {
    translations: Vec<Float4>,
    rotations: Vec<Float4>,
    scales: Vec<Float4>,
}

/// `model_from_joint` as three arrays of rows.
#[derive(Default)]
struct ModelRows([Vec<Float4>; 3]);

const DEVICE: &str = "the native device";

impl NativeBackend {
    /// Starts a pool of `threads` threads; 0 takes one for each core.
    ///
    /// # Errors
    ///
    /// [`BackendError::Failed`] where the system gives no threads.
    pub fn new(threads: usize) -> Result<Self, BackendError> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|index| format!("populace-{index}"))
            .build()
            .map_err(|error| failed("start its threads", error))?;
        Ok(Self {
            pool,
            samples: Vec::new(),
            joints: JointBuffer::default(),
            models: ModelRows::default(),
            pages: Vec::new(),
            times_ms: [0.0; Stage::ALL.len()],
        })
    }

    /// The threads in use.
    #[must_use]
    pub fn thread_count(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// The elements of a buffer from `first` on; of the palettes, those of `first`'s page.
    fn elements(&mut self, buffer: StageBuffer, first: usize) -> &mut [Float4] {
        let all: &mut [Float4] = match buffer {
            StageBuffer::Samples => bytemuck::cast_slice_mut(&mut self.samples),
            StageBuffer::Translations => &mut self.joints.translations,
            StageBuffer::Rotations => &mut self.joints.rotations,
            StageBuffer::Scales => &mut self.joints.scales,
            StageBuffer::ModelRow0 => &mut self.models.0[0],
            StageBuffer::ModelRow1 => &mut self.models.0[1],
            StageBuffer::ModelRow2 => &mut self.models.0[2],
            StageBuffer::Palette => {
                let page = self.pages.get_mut(first / PAGE_ELEMENTS).map_or(&mut [][..], Vec::as_mut_slice);
                return page.get_mut(first % PAGE_ELEMENTS..).unwrap_or(&mut []);
            }
        };
        all.get_mut(first..).unwrap_or(&mut [])
    }
}

const PAGE_ELEMENTS: usize = PAGE_ENTRIES as usize * 3;

fn failed(operation: &str, cause: impl std::fmt::Display) -> BackendError {
    BackendError::Failed { device: DEVICE.into(), operation: operation.into(), cause: cause.to_string() }
}

fn grow<T: Clone + Default>(buffer: &mut Vec<T>, count: usize, what: &str) -> Result<(), BackendError> {
    let more = count.saturating_sub(buffer.len());
    if buffer.try_reserve_exact(more).is_err() {
        let bytes = count.saturating_mul(size_of::<T>());
        return Err(BackendError::OutOfMemory { device: DEVICE.into(), what: what.into(), bytes });
    }
    buffer.resize(buffer.len() + more, T::default());
    Ok(())
}

impl Backend for NativeBackend {
    fn device_name(&self) -> String {
        format!("native ({} threads)", self.thread_count())
    }

    fn schedule(&self) -> &'static str {
        "staged"
    }

    fn update(&mut self, tables: &Tables) -> Result<(), BackendError> {
        let joints = tables.joint_places();
        grow(&mut self.samples, tables.member_places() * tables.slots_per_member(), "slot samples")?;
        grow(&mut self.joints.translations, joints, "joint translations")?;
        grow(&mut self.joints.rotations, joints, "joint rotations")?;
        grow(&mut self.joints.scales, joints, "joint scales")?;
        for rows in &mut self.models.0 {
            grow(rows, joints, "model transforms")?;
        }
        for (page, length) in tables.page_lengths().into_iter().enumerate() {
            if self.pages.len() <= page {
                self.pages.push(Vec::new());
            }
            grow(&mut self.pages[page], length * 3, "matrix palettes")?;
        }
        Ok(())
    }

    fn run_stage(&mut self, tables: &Tables, frame: Frame, stage: Stage) -> Result<(), BackendError> {
        let start = Instant::now();
        let Self { pool, samples, joints, models, pages, .. } = self;
        pool.install(|| match stage {
            Stage::Evaluate => evaluate::run(tables, frame.tick, samples),
            Stage::Pose => pose::run(tables, samples, joints),
            Stage::Transform => transform::run(tables, joints, models),
            Stage::WriteBack => write_back::run(tables, models, pages),
        });
        self.times_ms[stage as usize] = start.elapsed().as_secs_f64() * 1e3;
        Ok(())
    }

    fn read(
        &mut self,
        buffer: StageBuffer,
        mut first: usize,
        mut into: &mut [Float4],
    ) -> Result<(), BackendError> {
        while !into.is_empty() {
            let from = self.elements(buffer, first);
            let count = from.len().min(into.len());
            if count == 0 {
                return Err(failed(&format!("read {buffer:?}"), format!("element {first} is past the end")));
            }
            into[..count].copy_from_slice(&from[..count]);
            into = &mut into[count..];
            first += count;
        }
        Ok(())
    }

    fn write(
        &mut self,
        buffer: StageBuffer,
        mut first: usize,
        mut from: &[Float4],
    ) -> Result<(), BackendError> {
        while !from.is_empty() {
            let to = self.elements(buffer, first);
            let count = to.len().min(from.len());
            if count == 0 {
                return Err(failed(&format!("write {buffer:?}"), format!("element {first} is past the end")));
            }
            to[..count].copy_from_slice(&from[..count]);
            from = &from[count..];
            first += count;
        }
        Ok(())
    }

    fn with_page(&mut self, page: usize, reader: &mut dyn FnMut(&[Float4])) -> Result<(), BackendError> {
        let count = self.pages.len();
        let palettes = self.pages.get(page).ok_or_else(|| {
            failed("hand over palettes", format!("there is no page {page}; {count} are in use"))
        })?;
        reader(palettes);
        Ok(())
    }

    fn finish(&mut self) -> Result<(), BackendError> {
        Ok(())
    }

    fn stage_times_ms(&mut self) -> Vec<(Stage, f64)> {
        Stage::ALL.into_iter().map(|stage| (stage, self.times_ms[stage as usize])).collect()
    }

    fn write_floor(&mut self, _tables: &Tables) -> Result<f64, BackendError> {
        let Self { pool, pages, .. } = self;
        Ok(pool.install(|| floor::write(pages)))
    }

    fn memory_bytes(&self) -> usize {
        let elements = self.samples.len()
            + self.joints.translations.len() * 3
            + self.models.0[0].len() * 3
            + self.pages.iter().map(Vec::len).sum::<usize>();
        elements * size_of::<Float4>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    mod conformance {
        populace_testkit::backend_conformance!(crate::NativeBackend::new(3).unwrap());
    }

    mod conformance_on_1_thread {
        populace_testkit::backend_conformance!(crate::NativeBackend::new(1).unwrap());
    }

    mod conformance_on_16_threads {
        populace_testkit::backend_conformance!(crate::NativeBackend::new(16).unwrap());
    }

    #[test]
    fn past_the_end_is_an_error() {
        let mut backend = NativeBackend::new(1).unwrap();
        assert!(backend.read(StageBuffer::Palette, 0, &mut [Float4::default()]).is_err());
        assert!(backend.write(StageBuffer::Scales, 9, &[Float4::default()]).is_err());
    }
}
