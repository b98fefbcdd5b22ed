//! Local transforms sampled from a clip, retarget corrections included. Twin of the end of
//! `kernels/rows.cl`.

use populace_device::layout::{
    BLOCK_CORRECTED, BoundClip, REST_SCALE, REST_TRANSLATION, SlotSample,
};
use populace_model::Property;
use populace_model::math::{Real, quat};

use crate::corrections::correct;
use crate::local::Local;
use crate::rows::{Columns, Joints, component, load_quat, sample_vector};
use crate::widths::SampleWidth;

/// Sample of a clip.
pub(crate) struct Sample<R> {
    /// Local transforms, their rotations not yet normalized.
    pub(crate) local: Local<R>,
    /// Factor that makes the rotation a unit quaternion in the hemisphere of the rest rotation, or
    /// 0 if the rotation has no length.
    pub(crate) unit: R,
    /// [`REST_TRANSLATION`] and [`REST_SCALE`], each if the clip leaves the property at rest.
    pub(crate) at_rest: u32,
}

impl<R: Real> Sample<R> {
    /// Returns the local transforms with normalized rotations.
    #[inline(always)]
    pub(crate) fn normalized(self) -> Local<R> {
        Local { r: quat::scale(self.local.r, self.unit), ..self.local }
    }
}

/// Samples local transforms between two rows.
#[inline(always)]
pub(crate) fn sample_joint<R: SampleWidth>(
    joints: &Joints,
    bound: &BoundClip,
    at: &SlotSample,
    rest: &Local<R>,
) -> Sample<R> {
    let columns = R::columns(joints, bound);
    let padded = joints.body.padded_count as usize;
    let range = joints.planes(bound.range_first);
    let mut r = load_quat::<R>(range, padded);
    if !columns.planes(Property::Rotation).are_still() {
        let step = R::load(&range[4 * padded..]);
        r = [
            component(&columns, Property::Rotation, at, 0, step, r[0]),
            component(&columns, Property::Rotation, at, 1, step, r[1]),
            component(&columns, Property::Rotation, at, 2, step, r[2]),
            component(&columns, Property::Rotation, at, 3, step, r[3]),
        ];
    }
    let flags = joints.bound_block(bound).flags;
    let at_rest = flags & (REST_TRANSLATION | REST_SCALE);
    let mut local = Local { r, ..*rest };
    if at_rest & REST_TRANSLATION == 0 {
        let range = &range[5 * padded..];
        local.t = sample_vector::<R>(&columns, Property::Translation, at, range, padded);
    }
    if at_rest & REST_SCALE == 0 {
        let range = &range[9 * padded..];
        local.s = sample_vector::<R>(&columns, Property::Scale, at, range, padded);
    }
    if flags & BLOCK_CORRECTED != 0 {
        local = Local::loaded(correct(joints, bound, at, local.stored()));
    }
    let r = local.r;
    let unit = quat::dot(r, r).inverse_sqrt() * quat::side(r, rest.r);
    Sample { local, unit, at_rest }
}
