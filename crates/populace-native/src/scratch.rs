//! Per-worker scratch buffers.

use std::ops::Range;
use std::sync::{PoisonError, RwLock, RwLockWriteGuard};

use populace_model::Affine;

use crate::history::DeferredWrites;
use crate::lanes::Line;

/// A member of a part of the work.
pub(crate) struct Place {
    /// Body and shape of the program: members of a kind stand side by side.
    pub(crate) kind: (u32, u32),
    /// Index of the member.
    pub(crate) member: u32,
    /// Elements of its palette among those of the part.
    pub(crate) palette: Range<usize>,
}

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
    /// Members of the part in work, those of a kind after one another.
    pub(crate) places: Vec<Place>,
    /// Of members side by side.
    pub(crate) desk: Desk,
    /// Rotations that steps of members side by side hand down.
    pub(crate) rotations: Vec<Line>,
    /// Writes of the phase's members.
    pub(crate) writes: DeferredWrites,
}

/// Scratch buffers of all worker threads.
pub(crate) struct ScratchPool(Vec<RwLock<Scratch>>);

impl ScratchPool {
    pub(crate) fn new(threads: usize) -> Self {
        Self((0..threads).map(|_| RwLock::default()).collect())
    }

    /// Returns the calling thread's scratch. No other thread takes the same, so it never blocks.
    pub(crate) fn of_current_thread(&self) -> RwLockWriteGuard<'_, Scratch> {
        let own = &self.0[rayon::current_thread_index().unwrap_or(0) % self.0.len()];
        own.write().unwrap_or_else(PoisonError::into_inner)
    }

    /// Passes the deferred writes of each thread. None of them may be at work.
    pub(crate) fn for_each_writes(&self, job: &mut dyn FnMut(&DeferredWrites)) {
        for own in &self.0 {
            job(&own.read().unwrap_or_else(PoisonError::into_inner).writes);
        }
    }

    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = &mut Scratch> {
        self.0.iter_mut().map(|own| own.get_mut().unwrap_or_else(PoisonError::into_inner))
    }
}
