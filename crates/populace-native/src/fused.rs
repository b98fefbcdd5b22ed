//! The fused schedule: a member's whole frame at once, sixteen joints at a time from rows to local transforms, then
//! parents first down the hierarchy and out to the palette; the twin of `kernels/fused_wide.cl`. Nothing between clip and
//! palette leaves the core's caches.

use std::sync::{Mutex, PoisonError};

use populace_core::layout::{Body, Float4, NONE, PAGE_ENTRIES, PALETTE_BLOCK};
use populace_core::math::components;
use populace_core::{Affine, Frame, MAX_SLOTS, Tables};

use crate::dispatch::Dispatch;
use crate::evaluate::evaluate;
use crate::joint::{Playing, Posing};
use crate::lanes::{LANES, Lanes};
use crate::pages::Pages;
use crate::pose::member_layers;
use crate::rows::Local;
use crate::split;

/// Elements of a palette block.
const BLOCK: usize = PALETTE_BLOCK as usize * 3;

/// What one thread works in: `model_from_joint` of the member that it is at.
pub(crate) type Scratch = Mutex<Vec<Affine>>;

/// Writes the palettes of the frame's members. There is a scratch for each thread.
pub(crate) fn run(tables: &Tables, frame: Frame, dispatch: Dispatch, scratch: &[Scratch], pages: &mut Pages) {
    let all = tables.palette_blocks().as_slice();
    for (page, palettes) in pages.begin_frame().enumerate() {
        let first = page * (PAGE_ENTRIES / PALETTE_BLOCK) as usize;
        let blocks = &all[first..first + palettes.len() / BLOCK];
        split::for_each_member::<BLOCK, 1>(blocks, [palettes], &|place, _, [palette]| {
            if frame.evaluates(place) {
                let own = &scratch[rayon::current_thread_index().unwrap_or(0) % scratch.len()];
                let mut models = own.lock().unwrap_or_else(PoisonError::into_inner);
                dispatch.write_palette(tables, place, frame.tick, &mut models, palette);
            }
        });
    }
}

/// One member's palette.
#[inline(always)]
pub(crate) fn write_palette(
    tables: &Tables,
    place: u32,
    tick: u64,
    models: &mut Vec<Affine>,
    palette: &mut [Float4],
) {
    let body = body_of(tables, place);
    member_matrices(tables, place, tick, models, |_, _| {});
    let first = body.entry_first as usize;
    let entries = &tables.entries().as_slice()[first..first + body.entry_count as usize];
    for (entry, matrix) in entries.iter().zip(palette.as_chunks_mut::<3>().0) {
        let joint_from_bind = Affine { rows: [entry.row0.0, entry.row1.0, entry.row2.0] };
        *matrix = models[entry.joint as usize].mul(&joint_from_bind).rows.map(Float4);
    }
}

/// A member's `model_from_joint`, and its local transforms to `keep`, by first joint.
#[inline(always)]
pub(crate) fn member_matrices(
    tables: &Tables,
    place: u32,
    tick: u64,
    models: &mut Vec<Affine>,
    mut keep: impl FnMut(usize, &Local<Lanes>),
) {
    let body = body_of(tables, place);
    models.resize(body.padded_count as usize, Affine::IDENTITY);
    let mut playing = [Playing::default(); MAX_SLOTS];
    let count = play(tables, place, tick, &mut playing);
    let (playing, layers) = (&playing[..count], member_layers(tables, place));
    for (block, matrices) in models.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
        let joint = block * LANES;
        let local = Posing { tables, playing, layers, body, joint }.pose::<Lanes>();
        keep(joint, &local);
        let m = components(local.t, local.r, local.s);
        for (lane, matrix) in matrices.iter_mut().enumerate() {
            let row = |row: usize| [0, 1, 2, 3].map(|column: usize| m[row * 4 + column].0[lane]);
            matrix.rows = [row(0), row(1), row(2)];
        }
    }
    let first = body.joint_first as usize;
    let parents = &tables.parents().as_slice()[first..first + body.joint_count as usize];
    for (joint, &parent) in parents.iter().enumerate() {
        if parent != NONE {
            models[joint] = models[parent as usize].mul(&models[joint]);
        }
    }
}

pub(crate) fn body_of(tables: &Tables, place: u32) -> &Body {
    &tables.bodies().as_slice()[tables.members().as_slice()[place as usize].body as usize]
}

/// The member's slots that weigh anything now, in order; returns how many.
fn play(tables: &Tables, place: u32, tick: u64, playing: &mut [Playing; MAX_SLOTS]) -> usize {
    let mut count = 0;
    for slot in &tables.slots().as_slice()[tables.slot_range(place)] {
        let at = evaluate(tables, slot, tick);
        if at.weight > 0.0 {
            playing[count] = Playing { at, bound_clip: slot.bound_clip, layer: slot.layer() };
            count += 1;
        }
    }
    count
}
