//! What Pose computes for a joint, or for sixteen: a member's slots mixed layer by layer; the twin of `kernels/joint.cl`.

use populace_core::Tables;
use populace_core::layout::{Body, Layer, SlotSample};
use populace_core::math::{Real, quat};

use crate::rows::{Local, Width, load_quat, load_vec3, sample_joint};

/// A slot as it plays now.
#[derive(Clone, Copy, Default)]
pub(crate) struct Playing {
    pub(crate) at: SlotSample,
    pub(crate) bound_clip: u32,
    pub(crate) layer: u32,
}

#[inline(always)]
fn each3<R: Real>(of: impl Fn(usize) -> R) -> [R; 3] {
    [of(0), of(1), of(2)]
}

/// What takes `reference` to `value`, less what changes nothing: sums of it do not depend on their order.
#[inline(always)]
fn difference<R: Real>(value: &Local<R>, reference: &Local<R>) -> Local<R> {
    let delta = quat::mul(quat::conjugate(reference.r), value.r);
    let [x, y, z, w] = quat::hemisphere(delta, quat::identity());
    let (zero, one) = (R::splat(0.0), R::splat(1.0));
    let ratio = |i: usize| {
        let quotient = value.s[i] / reference.s[i];
        let below = R::choose(reference.s[i].less(zero), quotient, one);
        R::choose(zero.less(reference.s[i]), quotient, below)
    };
    Local { t: each3(|i| value.t[i] - reference.t[i]), r: [x, y, z, w - one], s: each3(|i| ratio(i) - one) }
}

#[inline(always)]
fn add_layer<R: Real>(beneath: &Local<R>, sum: &Local<R>, layer_weight: R) -> Local<R> {
    let delta = quat::add(quat::identity(), quat::scale(sum.r, layer_weight));
    let delta = quat::normalize_or(delta, quat::identity());
    Local {
        t: each3(|i| beneath.t[i] + sum.t[i] * layer_weight),
        r: quat::mul(beneath.r, delta),
        s: each3(|i| beneath.s[i] * (R::splat(1.0) + sum.s[i] * layer_weight)),
    }
}

#[inline(always)]
fn mean_of<R: Real>(sum: &Local<R>, total: f32, rest_rotation: [R; 4]) -> Local<R> {
    let k = R::splat(1.0 / total);
    Local {
        t: each3(|i| sum.t[i] * k),
        r: quat::normalize_or(sum.r, rest_rotation),
        s: each3(|i| sum.s[i] * k),
    }
}

/// A layer above 0 whose slots weigh less than 1 in all leaves the remainder to what lies beneath.
#[inline(always)]
fn mix_layer<R: Real>(
    beneath: &Local<R>,
    sum: &Local<R>,
    total: f32,
    layer_weight: R,
    rest_rotation: [R; 4],
) -> Local<R> {
    if total <= 0.0 {
        return *beneath;
    }
    let f = layer_weight * R::splat(if total < 1.0 { total } else { 1.0 });
    let above = mean_of(sum, total, rest_rotation);
    let from = quat::hemisphere(beneath.r, rest_rotation);
    let to = quat::hemisphere(above.r, rest_rotation);
    Local {
        t: each3(|i| beneath.t[i].mix(above.t[i], f)),
        r: quat::normalize_or(quat::mix(from, to, f), rest_rotation),
        s: each3(|i| beneath.s[i].mix(above.s[i], f)),
    }
}

/// A member's joints to pose: one, or the sixteen from it on.
pub(crate) struct Posing<'a> {
    pub(crate) tables: &'a Tables,
    pub(crate) playing: &'a [Playing],
    /// The member's.
    pub(crate) layers: &'a [Layer],
    pub(crate) body: &'a Body,
    pub(crate) joint: usize,
}

impl Posing<'_> {
    /// The sum over a layer's slots of weight times value, or times difference from the first row; and of the weights.
    #[inline(always)]
    fn sum_layer<R: Width>(&self, layer: u32, additive: bool, rest_rotation: [R; 4]) -> (Local<R>, f32) {
        let zero = R::splat(0.0);
        let mut sum = Local { t: [zero; 3], r: [zero; 4], s: [zero; 3] };
        let mut total = 0.0;
        for playing in self.playing {
            if playing.at.weight <= 0.0 || playing.layer != layer {
                continue;
            }
            let bound = &self.tables.bound_clips().as_slice()[playing.bound_clip as usize];
            let sample = |at: &SlotSample| {
                sample_joint::<R>(self.tables, bound, self.body, self.joint, at, rest_rotation)
            };
            let mut value = sample(&playing.at);
            if additive {
                let first = self.tables.clips().as_slice()[bound.clip as usize].row_first;
                let start = SlotSample { row0: first, row1: first, between: 0.0, weight: 0.0 };
                value = difference(&value, &sample(&start));
            }
            let weight = R::splat(playing.at.weight);
            sum.t = each3(|i| sum.t[i] + value.t[i] * weight);
            sum.r = quat::add(sum.r, quat::scale(value.r, weight));
            sum.s = each3(|i| sum.s[i] + value.s[i] * weight);
            total += playing.at.weight;
        }
        (sum, total)
    }

    /// Their local transforms.
    #[inline(always)]
    pub(crate) fn pose<R: Width>(&self) -> Local<R> {
        let padded = self.body.padded_count as usize;
        let rest = &self.tables.poses().as_slice()[self.body.rest_first as usize + self.joint..];
        let rest_rotation = load_quat::<R>(rest, padded);
        let (sum, total) = self.sum_layer::<R>(0, false, rest_rotation);
        // Layer 0 is always divided by its total, so that nobody sees the rest pose by accident.
        let mut pose = if total > 1e-3 {
            mean_of(&sum, total, rest_rotation)
        } else {
            Local {
                t: load_vec3(&rest[4 * padded..], padded),
                r: rest_rotation,
                s: load_vec3(&rest[7 * padded..], padded),
            }
        };
        for (index, layer) in (0..).zip(self.layers).skip(1) {
            let mut weight = R::splat(layer.weight);
            if let Some(mask) = layer.mask() {
                weight = weight * R::load(&self.tables.masks().as_slice()[mask as usize + self.joint..]);
            }
            let additive = layer.is_additive();
            let (sum, total) = self.sum_layer::<R>(index, additive, rest_rotation);
            let above = if additive {
                add_layer(&pose, &sum, weight)
            } else {
                mix_layer(&pose, &sum, total, weight, rest_rotation)
            };
            let laid = R::splat(0.0).less(weight);
            pose = Local {
                t: each3(|i| R::choose(laid, above.t[i], pose.t[i])),
                r: quat::choose(laid, above.r, pose.r),
                s: each3(|i| R::choose(laid, above.s[i], pose.s[i])),
            };
        }
        pose
    }
}
