//! Work spread over threads. A member is never split between two.

use std::ops::Range;

use populace_device::layout::{Float4, NONE};

/// Elements that one thread takes at a time: enough to hide the cost of scheduling, few enough to
/// balance the load.
const GRAIN: usize = 4096;
/// Parts for each thread where parts are as large as they may be: enough to balance the load.
const PARTS: usize = 8;

/// Part of the work, which one thread does: blocks of `BLOCK` elements of `N` arrays.
///
/// `blocks` names the member that owns each block, or [`NONE`]. A member's blocks are consecutive.
pub(crate) struct Part<'a, const BLOCK: usize, const N: usize> {
    blocks: &'a [u32],
    /// Index of the first block among all.
    first: usize,
    pub(crate) arrays: [&'a mut [Float4]; N],
}

impl<'a, const BLOCK: usize, const N: usize> Part<'a, BLOCK, N> {
    /// Calls `job(member, first_block, slices)` for each member. `slices` are the member's part of
    /// each of the arrays.
    pub(crate) fn for_each_member(self, mut job: impl FnMut(u32, usize, [&'a mut [Float4]; N])) {
        let Self { mut blocks, mut first, mut arrays } = self;
        while let Some(&member) = blocks.first() {
            let end = run_end(blocks, 1);
            let (run, rest) = halves::<BLOCK, N>(arrays, end);
            if member != NONE {
                job(member, first, run);
            }
            blocks = &blocks[end..];
            first += end;
            arrays = rest;
        }
    }

    /// Iterates over the members, each with the range of its elements in an array.
    pub(crate) fn members(&self) -> impl Iterator<Item = (u32, Range<usize>)> {
        let runs = self.blocks.chunk_by(|a, b| a == b);
        let ranges = runs.scan(0, |end, run| {
            let start = *end;
            *end += run.len() * BLOCK;
            Some((run[0], start..*end))
        });
        ranges.filter(|(member, _)| *member != NONE)
    }

    /// Does a job on all threads, for parts of at most `grain` elements or of one member.
    fn split(self, grain: usize, job: &(impl Fn(Self) + Sync)) {
        let Self { blocks, first, arrays } = self;
        let middle = run_end(blocks, blocks.len() / 2);
        if blocks.len() * BLOCK <= grain || middle == blocks.len() {
            return job(Self { blocks, first, arrays });
        }
        let (left, right) = halves::<BLOCK, N>(arrays, middle);
        let (left_blocks, right_blocks) = blocks.split_at(middle);
        rayon::join(
            || Self { blocks: left_blocks, first, arrays: left }.split(grain, job),
            || {
                Self { blocks: right_blocks, first: first + middle, arrays: right }
                    .split(grain, job);
            },
        );
    }
}

/// Calls `job` for large parts, on all threads. Each thread has several of them to do.
pub(crate) fn for_each_part<'a, const BLOCK: usize>(
    blocks: &'a [u32],
    array: &'a mut [Float4],
    job: &(impl Fn(Part<'a, BLOCK, 1>) + Sync),
) {
    let grain = (array.len() / (rayon::current_num_threads() * PARTS)).max(GRAIN);
    Part { blocks, first: 0, arrays: [array] }.split(grain, job);
}

/// Calls `job(member, first_block, slices)` for each member, on all threads; see [`Part`].
pub(crate) fn for_each_member<const BLOCK: usize, const N: usize>(
    blocks: &[u32],
    arrays: [&mut [Float4]; N],
    job: &(impl Fn(u32, usize, [&mut [Float4]; N]) + Sync),
) {
    Part { blocks, first: 0, arrays }.split(GRAIN, &|part: Part<BLOCK, N>| {
        part.for_each_member(job);
    });
}

/// Returns the first border between members at or after block `at`.
fn run_end(blocks: &[u32], at: usize) -> usize {
    let same = |i: &usize| blocks[*i] == blocks[*i - 1];
    at + (at.max(1)..blocks.len()).take_while(same).count()
}

/// Splits each array after `blocks` blocks.
fn halves<const BLOCK: usize, const N: usize>(
    arrays: [&mut [Float4]; N],
    blocks: usize,
) -> ([&mut [Float4]; N], [&mut [Float4]; N]) {
    let mut pairs = arrays.map(|array| array.split_at_mut(blocks * BLOCK));
    let left = std::array::from_fn(|i| std::mem::take(&mut pairs[i].0));
    (left, pairs.map(|(_, right)| right))
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use populace_model::convert::u32_from;

    use super::*;

    #[test]
    fn each_thread_has_several_of_the_large_parts() {
        const BLOCK: usize = 64;
        let blocks: Vec<u32> = (0..u32_from(1_000 * rayon::current_num_threads())).collect();
        let mut array = vec![Float4([0.0; 4]); blocks.len() * BLOCK];
        let (parts, members) = (AtomicUsize::new(0), AtomicUsize::new(0));
        for_each_part::<BLOCK>(&blocks, &mut array, &|part| {
            parts.fetch_add(1, Ordering::Relaxed);
            part.for_each_member(|_, _, [own]| {
                members.fetch_add(own.len() / BLOCK, Ordering::Relaxed);
            });
        });
        assert!(parts.into_inner() >= PARTS * rayon::current_num_threads());
        assert_eq!(members.into_inner(), blocks.len());
    }
}
