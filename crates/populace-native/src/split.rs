//! Spreading work over threads without a member ever being split.

use populace_core::layout::{Float4, JOINT_BLOCK, NONE};

/// Blocks that one thread takes at a time: large enough to hide the cost of handing over, small enough to balance.
const GRAIN: usize = 128;

/// Calls `job(member, first_joint, slices)` for each member that `blocks` names, on all threads, with its own run of
/// each of the `N` joint arrays.
pub(crate) fn for_each_member<const N: usize>(
    blocks: &[u32],
    arrays: [&mut [Float4]; N],
    job: &(impl Fn(u32, usize, [&mut [Float4]; N]) + Sync),
) {
    split(blocks, 0, arrays, job);
}

fn split<const N: usize>(
    blocks: &[u32],
    first: usize,
    arrays: [&mut [Float4]; N],
    job: &(impl Fn(u32, usize, [&mut [Float4]; N]) + Sync),
) {
    let middle = run_end(blocks, blocks.len() / 2);
    if blocks.len() <= GRAIN || middle == blocks.len() {
        return each(blocks, first, arrays, job);
    }
    let (left, right) = halves(arrays, middle);
    let (left_blocks, right_blocks) = blocks.split_at(middle);
    rayon::join(|| split(left_blocks, first, left, job), || split(right_blocks, first + middle, right, job));
}

fn each<const N: usize>(
    mut blocks: &[u32],
    mut first: usize,
    mut arrays: [&mut [Float4]; N],
    job: &(impl Fn(u32, usize, [&mut [Float4]; N]) + Sync),
) {
    while let Some(&member) = blocks.first() {
        let end = run_end(blocks, 1);
        let (run, rest) = halves(arrays, end);
        if member != NONE {
            job(member, first * JOINT_BLOCK as usize, run);
        }
        blocks = &blocks[end..];
        first += end;
        arrays = rest;
    }
}

/// The first border between members at or after `at`.
fn run_end(blocks: &[u32], at: usize) -> usize {
    let same = |i: &usize| blocks[*i] == blocks[*i - 1];
    at + (at.max(1)..blocks.len()).take_while(same).count()
}

fn halves<const N: usize>(
    arrays: [&mut [Float4]; N],
    blocks: usize,
) -> ([&mut [Float4]; N], [&mut [Float4]; N]) {
    let mut pairs = arrays.map(|array| array.split_at_mut(blocks * JOINT_BLOCK as usize));
    let left = std::array::from_fn(|i| std::mem::take(&mut pairs[i].0));
    (left, pairs.map(|(_, right)| right))
}
