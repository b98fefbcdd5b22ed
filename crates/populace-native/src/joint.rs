//! What Pose computes for a joint, or for sixteen: a member's slots mixed layer by layer; the twin
//! of `kernels/joint.cl`.

use populace_device::Tables;
use populace_device::layout::{
    Body, Control, LEAST_WEIGHT, Layer, NONE, REST_SCALE, REST_TRANSLATION, Slot, SlotSample,
};
use populace_model::math::{Real, quat};

use crate::controls::Clock;
use crate::dispatch::Dispatch;
use crate::rows::{Local, Width, load_quat, load_vec3, sample_joint};
use crate::stages;

/// A slot as it plays now.
#[derive(Clone, Copy, Default)]
pub(crate) struct Playing {
    pub(crate) at: SlotSample,
    pub(crate) bound_clip: u32,
    pub(crate) layer: u32,
}

#[inline(always)]
pub(crate) fn each3<R: Real>(of: impl Fn(usize) -> R) -> [R; 3] {
    [of(0), of(1), of(2)]
}

/// What takes `reference` to `value`, its rotation on the side of another one.
#[inline(always)]
pub(crate) fn quotient<R: Real>(value: &Local<R>, reference: &Local<R>, side: [R; 4]) -> Local<R> {
    let r = quat::hemisphere(quat::mul(quat::conjugate(reference.r), value.r), side);
    let (zero, one) = (R::splat(0.0), R::splat(1.0));
    let ratio = |i: usize| {
        let quotient = value.s[i] / reference.s[i];
        let below = R::choose(reference.s[i].less(zero), quotient, one);
        R::choose(zero.less(reference.s[i]), quotient, below)
    };
    Local { t: each3(|i| value.t[i] - reference.t[i]), r, s: each3(ratio) }
}

/// A change, less what changes nothing: sums of it do not depend on their order.
#[inline(always)]
pub(crate) fn change<R: Real>(quotient: &Local<R>) -> Local<R> {
    let ([x, y, z, w], one) = (quotient.r, R::splat(1.0));
    Local { t: quotient.t, r: [x, y, z, w - one], s: each3(|i| quotient.s[i] - one) }
}

#[inline(always)]
pub(crate) fn add_layer<R: Real>(beneath: &Local<R>, sum: &Local<R>, layer_weight: R) -> Local<R> {
    let delta = quat::add(quat::identity(), quat::scale(sum.r, layer_weight));
    let delta = quat::normalize_or(delta, quat::identity());
    Local {
        t: each3(|i| beneath.t[i] + sum.t[i] * layer_weight),
        r: quat::mul(beneath.r, delta),
        s: each3(|i| beneath.s[i] * (R::splat(1.0) + sum.s[i] * layer_weight)),
    }
}

/// The weighted sum over a layer's slots.
struct Sum<R> {
    local: Local<R>,
    /// Of the weights.
    total: f32,
    /// [`REST_TRANSLATION`] and [`REST_SCALE`], where no slot leaves the rest.
    at_rest: u32,
}

/// What no slot moves is at rest, to the bit.
#[inline(always)]
fn mean_of<R: Real>(sum: &Sum<R>, rest: &Local<R>) -> Local<R> {
    let k = R::splat(1.0 / sum.total);
    let vector = |flag, at_rest: [R; 3], sums: [R; 3]| {
        if sum.at_rest & flag != 0 { at_rest } else { each3(|i| sums[i] * k) }
    };
    Local {
        t: vector(REST_TRANSLATION, rest.t, sum.local.t),
        r: quat::normalize_or(sum.local.r, rest.r),
        s: vector(REST_SCALE, rest.s, sum.local.s),
    }
}

/// A layer above 0 whose slots weigh less than 1 in all leaves the remainder to what lies beneath.
#[inline(always)]
fn mix_layer<R: Real>(
    beneath: &Local<R>,
    above: &Local<R>,
    total: f32,
    layer_weight: R,
    rest: &Local<R>,
) -> Local<R> {
    let f = layer_weight * R::splat(if total < 1.0 { total } else { 1.0 });
    let from = quat::hemisphere(beneath.r, rest.r);
    let to = quat::hemisphere(above.r, rest.r);
    Local {
        t: each3(|i| beneath.t[i].mix(above.t[i], f)),
        r: quat::normalize_or(quat::mix(from, to, f), rest.r),
        s: each3(|i| beneath.s[i].mix(above.s[i], f)),
    }
}

/// Whether anything but clips is to change a pose.
#[inline(always)]
fn is_adjusted(control: &Control) -> bool {
    control.scale_first != NONE || control.local_count > 0 || control.pose_step_count > 0
}

/// A member's joints to pose: one, or the sixteen from it on.
pub(crate) struct Posing<'a> {
    pub(crate) tables: &'a Tables,
    pub(crate) playing: &'a [Playing],
    /// The member's slots, where any inertializes.
    pub(crate) inertialization: &'a [Slot],
    /// The member's.
    pub(crate) layers: &'a [Layer],
    pub(crate) body: &'a Body,
    pub(crate) control: Option<&'a Control>,
    pub(crate) joint: usize,
    pub(crate) clock: Clock<'a>,
    /// The registers that sixteen joints are computed in.
    pub(crate) dispatch: Dispatch,
}

impl Posing<'_> {
    /// The sum over a layer's slots of weight times value, or times difference from the first row.
    #[inline(always)]
    fn sum_layer<R: Width>(&self, layer: u32, additive: bool, rest: &Local<R>) -> Sum<R> {
        let Self { tables, body, joint, .. } = *self;
        let zero = R::splat(0.0);
        let local = Local { t: [zero; 3], r: [zero; 4], s: [zero; 3] };
        let mut sum = Sum { local, total: 0.0, at_rest: REST_TRANSLATION | REST_SCALE };
        for playing in self.playing {
            if playing.at.weight <= 0.0 || playing.layer != layer {
                continue;
            }
            let bound = &tables.bound_clips().as_slice()[playing.bound_clip as usize];
            let sample = sample_joint::<R>(tables, bound, body, joint, &playing.at, rest);
            let (weight, local) = (R::splat(playing.at.weight), &mut sum.local);
            sum.at_rest &= sample.at_rest;
            let (mut value, mut unit) = (sample.local, sample.unit);
            if additive {
                let first = tables.clips().as_slice()[bound.clip as usize].row_first;
                let start = SlotSample { row0: first, row1: first, between: 0.0, weight: 0.0 };
                let start =
                    sample_joint::<R>(tables, bound, body, joint, &start, rest).normalized();
                value.r = quat::scale(value.r, unit);
                let turned = quotient(&value, &start, quat::identity());
                (value, unit) = (change(&turned), R::splat(1.0));
            }
            local.t = each3(|i| local.t[i] + value.t[i] * weight);
            local.r = quat::add(local.r, quat::scale(value.r, unit * weight));
            local.s = each3(|i| local.s[i] + value.s[i] * weight);
            sum.total += playing.at.weight;
        }
        sum
    }

    /// Their local transforms.
    #[inline(always)]
    pub(crate) fn pose<R: Width>(&self) -> Local<R> {
        let padded = self.body.padded_count as usize;
        let rest = &self.tables.poses().as_slice()[self.body.rest_first as usize + self.joint..];
        let rest = Local {
            r: load_quat::<R>(rest, padded),
            t: load_vec3(&rest[4 * padded..], padded),
            s: load_vec3(&rest[7 * padded..], padded),
        };
        let sum = self.sum_layer::<R>(0, false, &rest);
        // Layer 0 is always divided by its total, so that nobody sees the rest pose by accident.
        let pose = if sum.total > 1e-3 { mean_of(&sum, &rest) } else { rest };
        let mut pose = if self.inertialization.is_empty() {
            pose
        } else {
            self.inertialize(0, false, &rest, pose)
        };
        if self.layers.len() > 1 {
            R::lay_over(self, &rest, &mut pose);
        }
        match self.control {
            Some(control) if is_adjusted(control) => self.adjust(control, pose),
            _ => pose,
        }
    }

    /// What the member's proportions, its overrides in local space and users' stages make of a
    /// pose.
    #[inline(never)]
    fn adjust<R: Width>(&self, control: &Control, mut pose: Local<R>) -> Local<R> {
        let Self { tables, joint, .. } = *self;
        if control.scale_first != NONE {
            let factor =
                R::load(&tables.joint_scales().as_slice()[control.scale_first as usize + joint..]);
            pose.t = each3(|i| pose.t[i] * factor);
        }
        let first = control.local_first as usize;
        for given in &tables.overrides().as_slice()[first..first + control.local_count as usize] {
            let lane = (given.joint as usize).wrapping_sub(joint);
            if lane >= R::COUNT {
                continue;
            }
            let ([x, y, z, weight], [sx, sy, sz, _]) =
                (given.translation_and_weight.0, given.scale.0);
            let (t, s) = ([x, y, z].map(R::splat), [sx, sy, sz].map(R::splat));
            let r = given.rotation.0.map(R::splat);
            let (whole, k, only) = (weight >= 1.0, R::splat(weight), R::only(lane));
            let turned = quat::mix(pose.r, quat::hemisphere(r, pose.r), k);
            let r = if whole { r } else { quat::normalize_or(turned, r) };
            pose = Local {
                t: each3(|i| {
                    R::choose(only, if whole { t[i] } else { pose.t[i].mix(t[i], k) }, pose.t[i])
                }),
                r: quat::choose::<R>(only, r, pose.r),
                s: each3(|i| {
                    R::choose(only, if whole { s[i] } else { pose.s[i].mix(s[i], k) }, pose.s[i])
                }),
            };
        }
        if control.pose_step_count > 0 {
            pose = stages::locals(tables, self.clock, control, joint, pose);
        }
        pose
    }

    /// What the layers above 0 make of what lies beneath. Called by [`Width::lay_over`].
    #[inline(always)]
    pub(crate) fn lay_over<R: Width>(&self, rest: &Local<R>, pose: &mut Local<R>) {
        for (index, layer) in (0..).zip(self.layers).skip(1) {
            let mut weight = R::splat(layer.weight);
            if let Some(mask) = layer.mask() {
                weight =
                    weight * R::load(&self.tables.masks().as_slice()[mask as usize + self.joint..]);
            }
            let laid = R::splat(0.0).less(weight);
            if !R::any(laid) {
                continue;
            }
            let additive = layer.is_additive();
            let sum = self.sum_layer::<R>(index, additive, rest);
            if !additive && sum.total <= LEAST_WEIGHT {
                continue;
            }
            let mut own = if additive { sum.local } else { mean_of(&sum, rest) };
            if !self.inertialization.is_empty() {
                own = self.inertialize(index, additive, rest, own);
            }
            let above = if additive {
                add_layer(pose, &own, weight)
            } else {
                mix_layer(pose, &own, sum.total, weight, rest)
            };
            *pose = Local {
                t: each3(|i| R::choose(laid, above.t[i], pose.t[i])),
                r: quat::choose(laid, above.r, pose.r),
                s: each3(|i| R::choose(laid, above.s[i], pose.s[i])),
            };
        }
    }
}
