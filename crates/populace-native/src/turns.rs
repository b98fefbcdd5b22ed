//! What a retargeted clip's poses go through; the twin of `kernels/turns.cl`. See
//! [`TURN_PLANES`](populace_device::layout::TURN_PLANES).

use populace_device::Tables;
use populace_device::layout::{BLOCK_TURNED, Body, BoundClip, NONE, REST_TRANSLATION, SlotSample};
use populace_model::Property;
use populace_model::math::{quat, vec3};

use crate::rows::{Columns, Width, bound_block, component, load_quat, sample_vector};

/// A translation and a rotation, not of length 1, through all turns of a clip. Apart: most clips
/// have none, and it must not take the registers of what most do.
#[inline(never)]
pub(crate) fn turn<R: Width>(
    tables: &Tables,
    bound: &BoundClip,
    body: &Body,
    joint: usize,
    at: &SlotSample,
    (mut t, mut r): ([R; 3], [R; 4]),
) -> ([R; 3], [R; 4]) {
    let padded = body.padded_count as usize;
    let (mut clip, mut at) = (bound, *at);
    while bound_block(tables, clip, joint).flags & BLOCK_TURNED != 0 {
        clip = &tables.bound_clips().as_slice()[clip.next as usize];
        if clip.row_stride != 0 {
            at = own_rows(tables, clip, &at);
        }
        let columns = R::columns(tables, clip, joint);
        let planes = &tables.poses().as_slice()[clip.range_first as usize + joint..];
        if bound_block(tables, clip, joint).flags & REST_TRANSLATION == 0 {
            let arm = sample_vector::<R>(
                &columns,
                Property::Translation,
                &at,
                &planes[6 * padded..],
                padded,
            );
            let [x, y, z] = vec3::turned(quat::scale(r, quat::dot(r, r).inverse_sqrt()), arm);
            t = [t[0] + x, t[1] + y, t[2] + z];
        }
        let mut q = load_quat::<R>(planes, padded);
        if columns.planes(Property::Rotation).first != NONE {
            let (step, step_w) = (R::load(&planes[4 * padded..]), R::load(&planes[5 * padded..]));
            q = [
                component(&columns, Property::Rotation, &at, 0, step, q[0]),
                component(&columns, Property::Rotation, &at, 1, step, q[1]),
                component(&columns, Property::Rotation, &at, 2, step, q[2]),
                component(&columns, Property::Rotation, &at, 3, step_w, q[3]),
            ];
        }
        r = quat::mul(quat::mul(r, q), load_quat::<R>(&planes[10 * padded..], padded));
    }
    (t, r)
}

/// The rows that a turn has for two of its clip's.
fn own_rows(tables: &Tables, turn: &BoundClip, at: &SlotSample) -> SlotSample {
    let clip = &tables.clips().as_slice()[turn.clip as usize];
    let own =
        |row: u32| turn.row_first + (row - clip.row_first) / clip.row_stride * turn.row_stride;
    SlotSample { row0: own(at.row0), row1: own(at.row1), ..*at }
}
