//! Per-worker scratch buffers.

use std::sync::{Mutex, MutexGuard, PoisonError};

use populace_model::Affine;

use crate::abreast::Desk;
use crate::history::DeferredWrites;

/// Scratch buffers of one worker thread.
#[derive(Default)]
pub(crate) struct Scratch {
    /// `model_from_joint` of the member in work; until a joint is reached, its local transform.
    pub(crate) models: Vec<Affine>,
    /// Of members side by side.
    pub(crate) desk: Desk,
    /// Writes of the phase's members.
    pub(crate) writes: DeferredWrites,
}

/// Scratch buffers of all worker threads.
pub(crate) struct ScratchPool(Vec<Mutex<Scratch>>);

impl ScratchPool {
    pub(crate) fn new(threads: usize) -> Self {
        Self((0..threads).map(|_| Mutex::default()).collect())
    }

    /// Returns the calling thread's scratch. No other thread takes the same, so it never blocks.
    pub(crate) fn of_current_thread(&self) -> MutexGuard<'_, Scratch> {
        let own = &self.0[rayon::current_thread_index().unwrap_or(0) % self.0.len()];
        own.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = &mut Scratch> {
        self.0.iter_mut().map(|own| own.get_mut().unwrap_or_else(PoisonError::into_inner))
    }
}
