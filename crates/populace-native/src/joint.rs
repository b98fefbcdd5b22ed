//! Pose of a joint, or of sixteen: a member's slots mixed layer by layer (Lister & Day 2012,
//! section 3, fig. 1). Twin of `kernels/joint.cl` and `kernels/sums.cl`.
//!
//! Reads what the member plays, its layers, the clips' rows, stored poses, masks, overrides in
//! local space, bone-length scales and user stages. Writes nothing but the pose that it returns.

use populace_device::layout::{
    Control, LEAST_TOTAL, LEAST_WEIGHT, Layer, NONE, POSE_PLANES, REST_SCALE, REST_TRANSLATION,
};
use populace_model::math::{Real, quat};

use crate::change::{Change, PoseWidth};
use crate::frame::FrameInputs;
use crate::inertialize::OfLayer;
use crate::local::{Local, add_layer, change, each3, quotient};
use crate::members::control_of;
use crate::playback::{Inertialization, Play, Playing};
use crate::rows::Joints;
use crate::sample::{first_pose, sample_joint, stored_pose, unit_of};
use crate::stages::stage_locals;
use crate::widths::SampleWidth;

/// Loads rest poses.
#[inline(always)]
pub(crate) fn rest_of<R: SampleWidth>(joints: &Joints) -> Local<R> {
    stored_pose(joints.stored(joints.body.rest_first, POSE_PLANES))
}

/// Weighted sum over a layer's slots.
pub(crate) struct Sum<R> {
    pub(crate) local: Local<R>,
    /// Sum of the weights.
    pub(crate) total: f32,
    /// True if the layer's only slot was not weighted in the sum.
    pub(crate) unweighted: bool,
    /// [`REST_TRANSLATION`] and [`REST_SCALE`], each if all slots leave the property at rest.
    pub(crate) at_rest: u32,
}

/// Divides a sum by its weights. A property at rest in all slots is exactly the rest pose's.
#[inline(always)]
fn mean_of<R: Real>(sum: &Sum<R>, rest: &Local<R>) -> Local<R> {
    let k = R::splat(if sum.unweighted { 1.0 } else { 1.0 / sum.total });
    let vector = |flag, at_rest: [R; 3], sums: [R; 3]| {
        if sum.at_rest & flag != 0 { at_rest } else { each3(|i| sums[i] * k) }
    };
    Local {
        t: vector(REST_TRANSLATION, rest.t, sum.local.t),
        r: quat::normalize_or(sum.local.r, rest.r),
        s: vector(REST_SCALE, rest.s, sum.local.s),
    }
}

/// Returns the mean of the slots of layer 0, or the rest pose below [`LEAST_TOTAL`]. The layer is
/// always divided by its total weight, so that weights below 1 do not show the rest pose.
#[inline(always)]
pub(crate) fn mean_or_rest<R: Real>(sum: &Sum<R>, rest: &Local<R>) -> Local<R> {
    if sum.total > LEAST_TOTAL { mean_of(sum, rest) } else { *rest }
}

/// Mixes a layer's mean over the pose beneath. A layer with a total weight below 1 shows the pose
/// beneath for the remainder.
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

/// Inputs of the pose of a member's joints.
pub(crate) struct Posing<'a> {
    pub(crate) inputs: &'a FrameInputs<'a>,
    pub(crate) joints: Joints<'a>,
    pub(crate) playing: &'a [Playing],
    /// A bit for each layer that plays one slot.
    pub(crate) alone: u32,
    pub(crate) inertialization: Inertialization<'a>,
    /// Layers that the member uses.
    pub(crate) layers: &'a [Layer],
    pub(crate) control: Option<&'a Control>,
}

impl<'a> Play<'a> {
    /// Returns the inputs of the poses of joints.
    #[inline(always)]
    pub(crate) fn posing(
        &'a self,
        inputs: &'a FrameInputs<'a>,
        member: u32,
        joints: Joints<'a>,
    ) -> Posing<'a> {
        Posing {
            inputs,
            joints,
            playing: self.playing(),
            alone: self.alone,
            inertialization: self.inertialization,
            layers: self.layers,
            control: control_of(inputs.tables, member),
        }
    }
}

/// The layers above 0, laid over the pose of those beneath.
struct LayOver<'a, 'b>(&'a Posing<'b>);

impl Change for LayOver<'_, '_> {
    #[inline(always)]
    fn changed<R: SampleWidth<Stored: PoseWidth>>(
        &self,
        rest: &Local<R>,
        pose: Local<R>,
    ) -> Local<R> {
        self.0.lay_over(rest, pose)
    }
}

/// Returns whether anything but clips changes the pose.
#[inline(always)]
fn is_adjusted(control: &Control) -> bool {
    control.scale_first != NONE || control.local_count > 0 || control.pose_step_count > 0
}

impl Posing<'_> {
    /// Sums a layer's slots, each weighted. In an additive layer, the terms are differences from
    /// the clip's first row.
    #[inline(always)]
    pub(crate) fn sum_layer<R: SampleWidth<Stored: PoseWidth>>(
        &self,
        layer: u32,
        additive: bool,
        rest: &Local<R>,
    ) -> Sum<R> {
        let (joints, tables) = (&self.joints, self.joints.tables);
        let alone = !additive && self.alone & 1 << layer != 0;
        let mut sum = Sum {
            local: Local::zero(),
            total: 0.0,
            unweighted: alone,
            at_rest: REST_TRANSLATION | REST_SCALE,
        };
        for playing in self.playing {
            if playing.weight <= 0.0 || playing.layer != layer {
                continue;
            }
            let bound = &tables.bound_clips().as_slice()[playing.bound_clip as usize];
            let sample = sample_joint::<R>(joints, bound, &playing.rows, rest);
            let part = if alone { 1.0 } else { playing.weight };
            let (weight, local) = (R::splat(part), &mut sum.local);
            sum.at_rest &= sample.at_rest;
            let (value, k) = if additive {
                let first = first_pose::<R>(joints, bound);
                let turned = quotient(&sample.normalized(rest), &first, quat::identity());
                (change(&turned), weight)
            } else {
                let r = sample.local.r;
                let k = if alone { quat::side(r, rest.r) } else { unit_of(r, rest.r) * weight };
                (sample.local, k)
            };
            local.t = each3(|i| local.t[i] + value.t[i] * weight);
            local.r = quat::add(local.r, quat::scale(value.r, k));
            local.s = each3(|i| local.s[i] + value.s[i] * weight);
            sum.total += playing.weight;
        }
        sum
    }

    /// Applies the layers above 0 to the pose of those beneath. Called by [`LayOver`].
    #[inline(always)]
    fn lay_over<R: SampleWidth<Stored: PoseWidth>>(
        &self,
        rest: &Local<R>,
        mut pose: Local<R>,
    ) -> Local<R> {
        for (index, layer) in (0..).zip(self.layers).skip(1) {
            let mut weight = R::splat(layer.weight);
            if let Some(mask) = layer.mask() {
                let first = mask as usize + self.joints.first;
                weight = weight * R::load(&self.joints.tables.masks().as_slice()[first..]);
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
            if !self.inertialization.slots.is_empty() {
                let mut stored = own.stored();
                self.inertialize_layer(index, additive, &rest.stored(), &mut stored);
                own = Local::loaded(stored);
            }
            let above = if additive {
                add_layer(&pose, &own, weight)
            } else {
                mix_layer(&pose, &own, sum.total, weight, rest)
            };
            pose = Local {
                t: each3(|i| R::choose(laid, above.t[i], pose.t[i])),
                r: quat::choose(laid, above.r, pose.r),
                s: each3(|i| R::choose(laid, above.s[i], pose.s[i])),
            };
        }
        pose
    }

    /// Adds the inertializations of a layer to its mean or to its sum of differences.
    #[inline(always)]
    fn inertialize_layer<R: PoseWidth>(
        &self,
        layer: u32,
        additive: bool,
        rest: &Local<R>,
        pose: &mut Local<R>,
    ) {
        let (joints, inertialization) = (&self.joints, self.inertialization);
        let change = OfLayer { joints, inertialization, layer, additive };
        R::apply(&change, self.joints.registers, rest, pose);
    }

    /// Applies the member's bone-length scaling, overrides in local space, and user stages.
    #[inline(never)]
    fn adjust<R: PoseWidth>(&self, control: &Control, mut pose: Local<R>) -> Local<R> {
        let Joints { tables, first: joint, .. } = self.joints;
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
            pose = stage_locals(self.inputs, control, joint, pose);
        }
        pose
    }

    /// Returns whether anything but the slots of layer 0 changes the pose.
    #[inline(always)]
    pub(crate) fn is_changed(&self) -> bool {
        !self.inertialization.slots.is_empty()
            || self.layers.len() > 1
            || self.control.is_some_and(is_adjusted)
    }

    /// Applies all but the slots of layer 0.
    #[inline(always)]
    pub(crate) fn change_pose<R: PoseWidth>(
        &self,
        rest: &Local<R>,
        mut pose: Local<R>,
    ) -> Local<R> {
        if !self.inertialization.slots.is_empty() {
            self.inertialize_layer(0, false, rest, &mut pose);
        }
        if self.layers.len() > 1 {
            R::apply(&LayOver(self), self.joints.registers, rest, &mut pose);
        }
        match self.control {
            Some(control) if is_adjusted(control) => self.adjust(control, pose),
            _ => pose,
        }
    }

    /// Computes the local transform of one joint.
    #[inline(always)]
    pub(crate) fn pose_joint(&self) -> Local<f32> {
        let rest = rest_of(&self.joints);
        let sum = self.sum_layer(0, false, &rest);
        self.change_pose(&rest, mean_or_rest(&sum, &rest))
    }
}
