//! Retarget corrections of sampled poses. Twin of `kernels/corrections.cl`.
//!
//! Reads bound clips, rows and stored planes; writes nothing but the sample that it returns.
//! [`CORRECTION_PLANES`](populace_device::layout::CORRECTION_PLANES) describes a correction.

use populace_device::layout::{BLOCK_CORRECTED, BoundClip, REST_TRANSLATION, SlotSample};
use populace_model::Property;
use populace_model::math::{quat, vec3};

#[cfg(target_arch = "x86_64")]
use crate::lanes::{LANES, Simd};
use crate::lanes::{Lanes, Members};
#[cfg(target_arch = "x86_64")]
use crate::registers::Registers;
use crate::rows::{Columns, Joints, RowWidth, component, load_quat, sample_vector};

/// Returns the rows of a correction that has its own, for two rows of its clip.
fn own_rows(joints: &Joints, correction: &BoundClip, at: &SlotSample) -> SlotSample {
    let clip = &joints.tables.clips().as_slice()[correction.clip as usize];
    let own = |row: u32| {
        correction.row_first + (row - clip.row_first) / clip.row_stride * correction.row_stride
    };
    SlotSample { row0: own(at.row0), row1: own(at.row1), ..*at }
}

/// Applies all corrections of a clip to a translation and a rotation that is not yet normalized.
///
/// It is never inlined: most clips have no corrections, and their path must not pay for the
/// registers of this one.
#[inline(never)]
pub(crate) fn correct<R: RowWidth>(
    joints: &Joints,
    bound: &BoundClip,
    at: &SlotSample,
    mut t: [R; 3],
    mut r: [R; 4],
) -> ([R; 3], [R; 4]) {
    let padded = joints.body.padded_count as usize;
    let (mut clip, mut at) = (bound, *at);
    while joints.bound_block(clip).flags & BLOCK_CORRECTED != 0 {
        clip = &joints.tables.bound_clips().as_slice()[clip.next as usize];
        if clip.row_stride != 0 {
            at = own_rows(joints, clip, &at);
        }
        let columns = R::columns(joints, clip);
        let planes = joints.planes(clip.range_first);
        if joints.bound_block(clip).flags & REST_TRANSLATION == 0 {
            let arm = sample_vector::<R>(
                &columns,
                Property::Translation,
                &at,
                &planes[6 * padded..],
                padded,
            );
            let [x, y, z] = vec3::rotated(quat::scale(r, quat::dot(r, r).inverse_sqrt()), arm);
            t = [t[0] + x, t[1] + y, t[2] + z];
        }
        let mut q = load_quat::<R>(planes, padded);
        if !columns.planes(Property::Rotation).are_still() {
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

/// A width that local transforms are sampled in.
pub(crate) trait SampleWidth: RowWidth {
    /// Calls [`correct`] without registers of its own.
    fn corrected(
        joints: &Joints,
        bound: &BoundClip,
        at: &SlotSample,
        t: [Self; 3],
        r: [Self; 4],
    ) -> ([Self; 3], [Self; 4]);
}

/// A width of sixteen joints, for the path that every member takes.
pub(crate) trait JointLanes: SampleWidth {
    /// One register of the same kind, for members side by side.
    type Members: Members;

    /// Stores the lanes.
    fn to_lanes(self) -> Lanes;
}

impl SampleWidth for f32 {
    #[inline(always)]
    fn corrected(
        joints: &Joints,
        bound: &BoundClip,
        at: &SlotSample,
        t: [f32; 3],
        r: [f32; 4],
    ) -> ([f32; 3], [f32; 4]) {
        correct(joints, bound, at, t, r)
    }
}

impl SampleWidth for Lanes {
    #[inline(always)]
    fn corrected(
        joints: &Joints,
        bound: &BoundClip,
        at: &SlotSample,
        t: [Self; 3],
        r: [Self; 4],
    ) -> ([Self; 3], [Self; 4]) {
        correct(joints, bound, at, t, r)
    }
}

#[cfg(target_arch = "x86_64")]
impl<R: Registers> SampleWidth for R {
    #[inline(always)]
    fn corrected(
        joints: &Joints,
        bound: &BoundClip,
        at: &SlotSample,
        [tx, ty, tz]: [Self; 3],
        [rx, ry, rz, rw]: [Self; 4],
    ) -> ([Self; 3], [Self; 4]) {
        let t = [tx.to_lanes(), ty.to_lanes(), tz.to_lanes()];
        let r = [rx.to_lanes(), ry.to_lanes(), rz.to_lanes(), rw.to_lanes()];
        let ([tx, ty, tz], [rx, ry, rz, rw]) = correct(joints, bound, at, t, r);
        (
            [Self::load(&tx.0), Self::load(&ty.0), Self::load(&tz.0)],
            [Self::load(&rx.0), Self::load(&ry.0), Self::load(&rz.0), Self::load(&rw.0)],
        )
    }
}

impl JointLanes for Lanes {
    type Members = f32;

    #[inline(always)]
    fn to_lanes(self) -> Lanes {
        self
    }
}

#[cfg(target_arch = "x86_64")]
impl<R: Registers> JointLanes for R {
    type Members = R::One;

    #[inline(always)]
    fn to_lanes(self) -> Lanes {
        let mut lanes = Simd([0.0; LANES]);
        self.store(&mut lanes.0);
        lanes
    }
}
