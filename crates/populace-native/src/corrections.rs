//! Retarget corrections of sampled poses. Twin of `kernels/corrections.cl`.
//!
//! Reads bound clips, rows and stored planes; writes nothing but the sample that it returns.
//! [`CORRECTION_PLANES`](populace_device::layout::CORRECTION_PLANES) describes a correction.

use populace_device::layout::{BLOCK_CORRECTED, BoundClip, REST_TRANSLATION, SlotSample};
use populace_model::Property;
use populace_model::math::{quat, vec3};

use crate::encoding::Rows;
use crate::local::Local;
use crate::rows::{
    Columns, Joints, RowWidth, load_part, load_quat, sample_rotation, sample_vector,
};

/// Returns the rows of a correction that has its own, for two rows of its clip.
fn own_rows(joints: &Joints, correction: &BoundClip, at: &SlotSample) -> SlotSample {
    let clip = &joints.tables.clips().as_slice()[correction.clip as usize];
    let own = |row: u32| {
        correction.row_first + (row - clip.row_first) / clip.row_stride * correction.row_stride
    };
    SlotSample { row0: own(at.row0), row1: own(at.row1), ..*at }
}

/// Applies all corrections of a clip to local transforms whose rotations are not yet normalized.
#[inline(always)]
pub(crate) fn correct<R: RowWidth>(
    joints: &Joints,
    bound: &BoundClip,
    at: &SlotSample,
    mut local: Local<R>,
) -> Local<R> {
    let padded = joints.body.padded_count as usize;
    let (mut clip, mut at) = (bound, *at);
    while joints.bound_block(clip).flags & BLOCK_CORRECTED != 0 {
        clip = &joints.tables.bound_clips().as_slice()[clip.next as usize];
        if clip.row_stride != 0 {
            at = own_rows(joints, clip, &at);
        }
        let (columns, rows) = (R::columns(joints, clip), Rows::of(&at));
        let planes = joints.planes(clip.range_first);
        if joints.bound_block(clip).flags & REST_TRANSLATION == 0 {
            let arm = sample_vector::<R, false>(
                &columns,
                Property::Translation,
                &rows,
                &planes[6 * padded..],
                padded,
            );
            let r = local.r;
            let turned = vec3::rotated(quat::scale(r, quat::dot(r, r).inverse_sqrt()), arm);
            local.t = vec3::add(local.t, turned);
        }
        let mut q = load_quat::<R>(planes, padded);
        if !columns.planes(Property::Rotation).are_still() {
            let part = load_part::<R>(&planes[4 * padded..]);
            let part_w = load_part::<R>(&planes[5 * padded..]);
            q = sample_rotation::<R, false>(&columns, &rows, [part, part, part, part_w], q);
        }
        let after = load_quat::<R>(&planes[10 * padded..], padded);
        local.r = quat::mul(quat::mul(local.r, q), after);
    }
    local
}
