//! Work spread over threads. A member is never split between two.

use populace_device::layout::{Float4, NONE};

/// Elements that one thread takes at a time: enough to hide the cost of scheduling, few enough to
/// balance the load.
const GRAIN: usize = 4096;

/// Calls `job(member, first_block, slices)` for each member, on all threads.
///
/// `blocks` names the member that owns each block of `BLOCK` elements of the arrays, or [`NONE`]. A
/// member's blocks are consecutive. `slices` are the member's part of each of the `N` arrays.
pub(crate) fn for_each_member<const BLOCK: usize, const N: usize>(
    blocks: &[u32],
    arrays: [&mut [Float4]; N],
    job: &(impl Fn(u32, usize, [&mut [Float4]; N]) + Sync),
) {
    split::<BLOCK, N>(blocks, 0, arrays, job);
}

fn split<const BLOCK: usize, const N: usize>(
    blocks: &[u32],
    first: usize,
    arrays: [&mut [Float4]; N],
    job: &(impl Fn(u32, usize, [&mut [Float4]; N]) + Sync),
) {
    let middle = run_end(blocks, blocks.len() / 2);
    if blocks.len() * BLOCK <= GRAIN || middle == blocks.len() {
        return each::<BLOCK, N>(blocks, first, arrays, job);
    }
    let (left, right) = halves::<BLOCK, N>(arrays, middle);
    let (left_blocks, right_blocks) = blocks.split_at(middle);
    rayon::join(
        || split::<BLOCK, N>(left_blocks, first, left, job),
        || split::<BLOCK, N>(right_blocks, first + middle, right, job),
    );
}

fn each<const BLOCK: usize, const N: usize>(
    mut blocks: &[u32],
    mut first: usize,
    mut arrays: [&mut [Float4]; N],
    job: &(impl Fn(u32, usize, [&mut [Float4]; N]) + Sync),
) {
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
