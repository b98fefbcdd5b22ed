//! What clips that were left leave behind for a while: the difference from what took their place,
//! in pose and in speed; the twin of `kernels/inertialize.cl`.

use populace_device::layout::{ClipRows, Slot, SlotSample};
use populace_device::{SampledState, Tables, far_row, row_before};
use populace_model::math::quat;

use crate::joint::{Posing, add_layer, change, each3, quotient};
use crate::rows::{Local, Width, sample_joint};

/// The slots of a member if any of them inertializes, else none.
#[inline(always)]
pub(crate) fn inertialization_slots(tables: &Tables, place: u32, tick: u64) -> &[Slot] {
    let slots = &tables.slots().as_slice()[tables.slot_range(place)];
    if slots.iter().any(|slot| slot.inertializes(tick)) { slots } else { &[] }
}

/// By what each way that a clip stood is multiplied.
struct Weights<R> {
    /// What was left, and what it would have moved by.
    left: R,
    left_way: R,
    /// What took its place, alike.
    taking: R,
    taking_way: R,
}

/// The part of a difference that is left of all that there was, and of its speed: quintics whose
/// value, slope and curvature are 0 at the end, and whose curvature is 0 at the start.
#[inline(always)]
fn decay(inertialized: f32) -> [f32; 2] {
    let left = 1.0 - inertialized;
    let cube = left * left * left;
    [
        cube * (1.0 + 3.0 * inertialized + 6.0 * inertialized * inertialized),
        inertialized * cube * (1.0 + 3.0 * inertialized),
    ]
}

fn nothing<R: Width>() -> Local<R> {
    let zero = R::splat(0.0);
    Local { t: [zero; 3], r: [zero; 4], s: [zero; 3] }
}

/// One change after another.
#[inline(always)]
fn after<R: Width>(first: &Local<R>, then: &Local<R>) -> Local<R> {
    Local {
        t: each3(|i| first.t[i] + then.t[i]),
        r: quat::mul(first.r, then.r),
        s: each3(|i| first.s[i] * then.s[i]),
    }
}

impl Posing<'_> {
    /// A layer's mean, or its sum of differences where it is additive, with all that inertializes
    /// in it. Over a mean the newest start comes first: those before it lie over what was then
    /// left.
    #[inline(never)]
    pub(crate) fn inertialize<R: Width>(
        &self,
        layer: u32,
        additive: bool,
        rest: &Local<R>,
        mut pose: Local<R>,
    ) -> Local<R> {
        let tick = self.clock.tick;
        let of_layer = |slot: &&Slot| slot.layer() == layer && slot.inertializes(tick);
        let mut earlier = u64::MAX;
        loop {
            let starts = self.inertialization.iter().filter(of_layer).map(|slot| slot.start_tick);
            let Some(start) = starts.filter(|start| *start < earlier).max() else {
                return pose;
            };
            let mut sum = nothing();
            for slot in
                self.inertialization.iter().filter(of_layer).filter(|slot| slot.start_tick == start)
            {
                self.add_inertialization(slot, additive, rest, &mut sum);
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

    fn add_inertialization<R: Width>(
        &self,
        slot: &Slot,
        additive: bool,
        rest: &Local<R>,
        sum: &mut Local<R>,
    ) {
        let ([still, moving], share) =
            (decay(slot.inertialized_at(self.clock.tick)), slot.start_weight);
        let (left, taking) = (slot.left(), slot.taking());
        let weights = Weights {
            left: R::splat(still * share + moving * slot.weight_rate),
            left_way: R::splat(moving * share * left.pace),
            taking: R::splat(if additive { still * share } else { 0.0 }),
            taking_way: R::splat(moving * share * taking.pace),
        };
        let [at, far, reference] = self.stands(left, additive, rest);
        let [taking_at, taking_far, taking_reference] = self.stands(taking, additive, rest);
        let reference = if additive { reference } else { taking_reference };
        let at = quotient(&at, &reference, quat::identity());
        let far = quotient(&far, &reference, at.r);
        let mut taking_at = quotient(&taking_at, &taking_reference, quat::identity());
        let mut taking_far = quotient(&taking_far, &taking_reference, taking_at.r);
        if !additive {
            // The difference lies over what took the place, and is carried along as that moves.
            (taking_at, taking_far) = (at, after(&taking_far, &at));
        }
        let all = [at, far, taking_at, taking_far].map(|quotient| change(&quotient));
        let of = |value: fn(&Local<R>, usize) -> R, i: usize| {
            let [at, far, taking_at, taking_far] = [0, 1, 2, 3].map(|k: usize| value(&all[k], i));
            let left = at * weights.left + (far - at) * weights.left_way;
            left - (taking_at * weights.taking + (taking_far - taking_at) * weights.taking_way)
        };
        sum.t = each3(|i| sum.t[i] + of(|l, i| l.t[i], i));
        sum.r = [0, 1, 2, 3].map(|i: usize| sum.r[i] + of(|l, i| l.r[i], i));
        sum.s = each3(|i| sum.s[i] + of(|l, i| l.s[i], i));
    }

    /// A clip where it stood, at its far row, and what differences are measured from: where it
    /// stood, in additive layers its first row.
    fn stands<R: Width>(
        &self,
        stand: SampledState,
        additive: bool,
        rest: &Local<R>,
    ) -> [Local<R>; 3] {
        let Self { tables, body, joint, .. } = *self;
        let bound = &tables.bound_clips().as_slice()[stand.bound_clip as usize];
        let clip = &tables.clips().as_slice()[bound.clip as usize];
        let last = clip.row_count - 1;
        let sample = |at| sample_joint::<R>(tables, bound, body, joint, &at, rest).normalized();
        let at = sample(place_of(clip, stand.row));
        let far = sample(row(clip, far_row(stand.row, last)));
        [at, far, if additive { sample(row(clip, 0)) } else { at }]
    }
}

fn row(clip: &ClipRows, row: u32) -> SlotSample {
    let row = clip.row_first + row * clip.row_stride;
    SlotSample { row0: row, row1: row, between: 0.0, weight: 0.0 }
}

/// The rows around a place in a clip's rows.
fn place_of(clip: &ClipRows, at: f32) -> SlotSample {
    let last = clip.row_count - 1;
    let before = row_before(at, last);
    let next = row(clip, if before < last { before + 1 } else { before });
    SlotSample { row1: next.row0, between: at - before as f32, ..row(clip, before) }
}
