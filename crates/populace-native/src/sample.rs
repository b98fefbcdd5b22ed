//! Local transforms sampled from a clip. Twin of the end of
//! `kernels/rows.cl`.

use populace_device::layout::{
    BOUND_PLANES, BoundClip, FIRST_POSE_PLANE, REST_SCALE, REST_TRANSLATION,
};
use populace_model::Property;
use populace_model::math::{Real, quat};

use crate::change::{Change, PoseWidth};
use crate::encoding::Rows;
use crate::lanes::LANES;
use crate::local::Local;
use crate::rows::{
    Columns, Joints, RowWidth, load_quat, load_vec3, sample_rotation, sample_vector,
};
use crate::widths::SampleWidth;

/// Sample of a clip.
pub(crate) struct Sample<R> {
    /// Local transforms. Rotations are near length 1, as [`unit_of`] needs.
    pub(crate) local: Local<R>,
    /// [`REST_TRANSLATION`] and [`REST_SCALE`], each if the clip leaves the property at rest.
    pub(crate) at_rest: u32,
}

/// Returns the factor that brings a sampled rotation to length 1, in the hemisphere of the rest
/// rotation.
///
/// Rows are near each other, so that three terms of a series are enough: halfway between rows that
/// are 60 degrees apart, the length is off by 0.0001.
#[inline(always)]
pub(crate) fn unit_of<R: Real>(rotation: [R; 4], rest: [R; 4]) -> R {
    let short_by = R::splat(1.0) - quat::dot(rotation, rotation);
    (R::splat(1.0) + short_by * (R::splat(0.5) + short_by * R::splat(0.375)))
        * quat::side(rotation, rest)
}

impl<R: Real> Sample<R> {
    /// Returns the local transforms with rotations of length 1 in the hemisphere of the rest
    /// rotation.
    #[inline(always)]
    pub(crate) fn normalized(self, rest: &Local<R>) -> Local<R> {
        let r = quat::scale(self.local.r, unit_of(self.local.r, rest.r));
        Local { r, ..self.local }
    }
}

/// Loads the poses in the first row of a bound clip.
#[inline(always)]
pub(crate) fn first_pose<R: SampleWidth>(joints: &Joints, bound: &BoundClip) -> Local<R> {
    let planes = joints.stored(bound.plane_first, BOUND_PLANES);
    stored_pose(&planes[FIRST_POSE_PLANE as usize * LANES..])
}

/// Loads poses, from their first plane on.
#[inline(always)]
pub(crate) fn stored_pose<R: SampleWidth>(planes: &[f32]) -> Local<R> {
    Local { r: load_quat::<R>(planes, 0), t: load_vec3(planes, 4), s: load_vec3(planes, 7) }
}

/// Samples local transforms between two rows.
#[inline(always)]
pub(crate) fn sample_joint<R: SampleWidth<Stored: PoseWidth>>(
    joints: &Joints,
    bound: &BoundClip,
    at: &Rows,
    rest: &Local<R>,
) -> Sample<R> {
    let columns = R::columns(joints, bound);
    let at_rest = joints.bound_block(bound).flags() & (REST_TRANSLATION | REST_SCALE);
    let local = if columns.are_common() {
        sample_columns::<R, true>(joints, &columns, bound, at, rest)
    } else {
        let (rest, any) = (rest.stored(), AnyColumns { joints, bound, at });
        let mut local = rest;
        R::Stored::apply(&any, joints.registers, &rest, &mut local);
        Local::loaded(local)
    };
    Sample { local, at_rest }
}

/// Columns of any storage.
///
/// They are sampled apart: most columns are common, and their path must not pay for the registers of
/// this one.
struct AnyColumns<'a> {
    joints: &'a Joints<'a>,
    bound: &'a BoundClip,
    at: &'a Rows,
}

impl Change for AnyColumns<'_> {
    #[inline(always)]
    fn changed<R: SampleWidth<Stored: PoseWidth>>(&self, rest: &Local<R>, _: Local<R>) -> Local<R> {
        let Self { joints, bound, at } = *self;
        let columns = R::columns(joints, bound);
        sample_columns::<R, false>(joints, &columns, bound, at, rest)
    }
}

#[inline(always)]
fn sample_columns<R: RowWidth, const COMMON: bool>(
    joints: &Joints,
    columns: &R::Columns<'_>,
    bound: &BoundClip,
    at: &Rows,
    rest: &Local<R>,
) -> Local<R> {
    let range = joints.stored(bound.plane_first, BOUND_PLANES);
    let mut local = Local { r: sample_rotation::<R, COMMON>(columns, at, range), ..*rest };
    let flags = joints.bound_block(bound).flags();
    if flags & REST_TRANSLATION == 0 {
        local.t = sample_vector::<R, COMMON>(columns, Property::Translation, at, range, 5);
    }
    if flags & REST_SCALE == 0 {
        local.s = sample_vector::<R, COMMON>(columns, Property::Scale, at, range, 9);
    }
    local
}
