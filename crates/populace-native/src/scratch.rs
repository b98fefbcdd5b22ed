//! Per-worker scratch buffers.

use std::sync::{Mutex, MutexGuard, PoisonError};

use populace_model::Affine;

use crate::history::DeferredWrites;
use crate::lanes::Line;

/// Buffers of members side by side.
#[derive(Default)]
pub(crate) struct Desk {
    /// Poses of a block of joints: for each component and member, a number for each joint.
    pub(crate) posed: Vec<Line>,
    /// The same transposed: for each component and joint, a number for each member.
    pub(crate) locals: Vec<Line>,
    /// `model_from_joint` of each joint: for each element, a number for each member.
    pub(crate) models: Vec<Line>,
    /// A block of the palettes: for each entry and element, a number for each member.
    pub(crate) palettes: Vec<Line>,
}

/// Scratch buffers of one worker thread.
#[derive(Default)]
pub(crate) struct Scratch {
    /// `model_from_joint` of the member in work; until a joint is reached, its local transform.
    pub(crate) models: Vec<Affine>,
    /// Of members side by side.
    pub(crate) desk: Desk,
    /// Rotations that steps of members side by side hand down.
    pub(crate) rotations: Vec<Line>,
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
