//! Inertialized transitions: the decaying difference, in pose and in velocity, between clips that
//! have ended and the clips that took their place (Bollo, "Inertialization: high-performance
//! animation transitions in Gears of War", GDC 2018). Twin of `kernels/inertialize.cl`.
//!
//! Reads the member's slots of `SLOT_INERTIALIZATION`, and bound clips, clips and rows. Writes
//! nothing but the pose that it returns.
//!
//! The *outgoing* clip ended; the *incoming* one took its place. Both are sampled where they were
//! at that instant, and at the far row, which tells the velocity.

use populace_device::layout::{ClipRows, InertializationSlot, Slot, SlotSample};
use populace_device::{SampledState, far_row, row_before};
use populace_model::math::quat;

use crate::change::{Change, PoseWidth};
use crate::encoding::Rows;
use crate::local::{Local, add_layer, after, change, each3, quotient};
use crate::playback::Inertialization;
use crate::rows::Joints;
use crate::sample::{first_pose, sample_joint};
use crate::widths::SampleWidth;

/// Returns the sample of one row.
fn row_of(clip: &ClipRows, row: u32) -> SlotSample {
    let row = clip.row_first + row * clip.row_stride;
    SlotSample { row0: row, row1: row, between: 0.0, weight: 0.0 }
}

/// Returns the rows around a fractional row.
fn place_of(clip: &ClipRows, at: f32) -> SlotSample {
    let last = clip.row_count - 1;
    let before = row_before(at, last);
    let next = row_of(clip, if before < last { before + 1 } else { before });
    SlotSample { row1: next.row0, between: at - before as f32, ..row_of(clip, before) }
}

/// Poses of a clip around the transition.
struct SampledPoses<R> {
    /// At the instant of the transition.
    at: Local<R>,
    /// At the far row.
    far: Local<R>,
    /// Start of differences: `at`, or the clip's first row in additive layers.
    reference: Local<R>,
}

#[inline(always)]
fn sampled_poses<R: SampleWidth<Stored: PoseWidth>>(
    joints: &Joints,
    state: SampledState,
    additive: bool,
    rest: &Local<R>,
) -> SampledPoses<R> {
    let bound = &joints.tables.bound_clips().as_slice()[state.bound_clip as usize];
    let clip = &joints.tables.clips().as_slice()[bound.rows as usize];
    let last = clip.row_count - 1;
    let rows = [place_of(clip, state.row), row_of(clip, far_row(state.row, last))];
    let mut poses = [*rest; 2];
    for (pose, at) in poses.iter_mut().zip(&rows) {
        *pose = sample_joint::<R>(joints, bound, &Rows::of(at), rest).normalized(rest);
    }
    let [at, far] = poses;
    SampledPoses { at, far, reference: if additive { first_pose(joints, bound) } else { at } }
}

/// Factors of the four samples. Those of `_step` belong to the step from the instant of the
/// transition to the far row.
struct InertializationWeights<R> {
    outgoing: R,
    outgoing_step: R,
    incoming: R,
    incoming_step: R,
}

/// Returns the parts that are left of the initial difference and of its velocity. They are quintics
/// whose value, slope and curvature are 0 at the end, and whose curvature is 0 at the start.
#[inline(always)]
fn decay(inertialized: f32) -> [f32; 2] {
    let left = 1.0 - inertialized;
    let cube = left * left * left;
    [
        cube * (1.0 + 3.0 * inertialized + 6.0 * inertialized * inertialized),
        inertialized * cube * (1.0 + 3.0 * inertialized),
    ]
}

#[inline(always)]
fn inertialization_weights<R: SampleWidth>(
    slot: &InertializationSlot,
    tick: u64,
    additive: bool,
) -> InertializationWeights<R> {
    let ([still, moving], share) = (decay(slot.inertialized_at(tick)), slot.share);
    InertializationWeights {
        outgoing: R::splat(still * share + moving * slot.share_change),
        outgoing_step: R::splat(moving * share * slot.outgoing_pace),
        incoming: R::splat(if additive { still * share } else { 0.0 }),
        incoming_step: R::splat(moving * share * slot.incoming_pace),
    }
}

/// Returns a component of what is left of a difference, from those of the outgoing and of the
/// incoming clip, at the instant of the transition and at the far row.
#[inline(always)]
fn left_of<R: SampleWidth>(
    weights: &InertializationWeights<R>,
    [at, far]: [R; 2],
    [incoming_at, incoming_far]: [R; 2],
) -> R {
    let outgoing = at * weights.outgoing + (far - at) * weights.outgoing_step;
    let incoming =
        incoming_at * weights.incoming + (incoming_far - incoming_at) * weights.incoming_step;
    outgoing - incoming
}

/// Adds what is left of one slot's difference to a sum.
#[inline(always)]
fn add_inertialization<R: SampleWidth<Stored: PoseWidth>>(
    joints: &Joints,
    slot: &InertializationSlot,
    tick: u64,
    additive: bool,
    rest: &Local<R>,
    sum: &mut Local<R>,
) {
    let weights = inertialization_weights::<R>(slot, tick, additive);
    let outgoing = sampled_poses(joints, slot.outgoing_state(), additive, rest);
    let incoming = sampled_poses(joints, slot.incoming_state(), additive, rest);
    let reference = if additive { outgoing.reference } else { incoming.reference };
    let at = quotient(&outgoing.at, &reference, quat::identity());
    let far = quotient(&outgoing.far, &reference, at.r);
    let mut incoming_at = quotient(&incoming.at, &incoming.reference, quat::identity());
    let mut incoming_far = quotient(&incoming.far, &incoming.reference, incoming_at.r);
    if !additive {
        // The difference is applied over the incoming clip, and moves with it.
        (incoming_at, incoming_far) = (at, after(&incoming_far, &at));
    }
    let (at, far) = (change(&at), change(&far));
    let (incoming_at, incoming_far) = (change(&incoming_at), change(&incoming_far));
    for i in 0..3 {
        let (outgoing, incoming) = ([at.t[i], far.t[i]], [incoming_at.t[i], incoming_far.t[i]]);
        sum.t[i] = sum.t[i] + left_of(&weights, outgoing, incoming);
        let (outgoing, incoming) = ([at.s[i], far.s[i]], [incoming_at.s[i], incoming_far.s[i]]);
        sum.s[i] = sum.s[i] + left_of(&weights, outgoing, incoming);
    }
    for i in 0..4 {
        let (outgoing, incoming) = ([at.r[i], far.r[i]], [incoming_at.r[i], incoming_far.r[i]]);
        sum.r[i] = sum.r[i] + left_of(&weights, outgoing, incoming);
    }
}

/// The inertializations of a layer.
#[derive(Clone, Copy)]
pub(crate) struct OfLayer<'a> {
    pub(crate) joints: &'a Joints<'a>,
    pub(crate) inertialization: Inertialization<'a>,
    pub(crate) layer: u32,
    pub(crate) additive: bool,
}

impl Change for OfLayer<'_> {
    #[inline(always)]
    fn changed<R: SampleWidth<Stored: PoseWidth>>(
        &self,
        rest: &Local<R>,
        pose: Local<R>,
    ) -> Local<R> {
        inertialize(*self, rest, pose)
    }
}

/// Adds all inertializations of a layer to its mean, or to its sum of differences if the layer is
/// additive. Over a mean, the newest transition is applied first: each earlier one is a difference
/// to the clip that the next one ended.
#[inline(always)]
fn inertialize<R: SampleWidth<Stored: PoseWidth>>(
    of: OfLayer,
    rest: &Local<R>,
    mut pose: Local<R>,
) -> Local<R> {
    let OfLayer { joints, inertialization, layer, additive } = of;
    let Inertialization { slots, tick } = inertialization;
    let of_layer = |slot: &&Slot| slot.layer() == layer && slot.inertializes(tick);
    let mut earlier = u64::MAX;
    loop {
        let starts = slots.iter().filter(of_layer).map(|slot| slot.start_tick);
        let Some(start) = starts.filter(|start| *start < earlier).max() else {
            return pose;
        };
        let mut sum = Local::zero();
        let now = slots.iter().filter(of_layer).filter(|slot| slot.start_tick == start);
        for slot in now.filter_map(Slot::as_inertialization) {
            add_inertialization(joints, slot, tick, additive, rest, &mut sum);
        }
        pose = if additive {
            Local {
                t: each3(|i| pose.t[i] + sum.t[i]),
                r: quat::add(pose.r, sum.r),
                s: each3(|i| pose.s[i] + sum.s[i]),
            }
        } else {
            add_layer(&pose, &sum, R::splat(1.0))
        };
        earlier = start;
    }
}
