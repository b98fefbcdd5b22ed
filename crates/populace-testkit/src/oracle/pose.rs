//! Pose: mixes slots into local transforms, layer by layer.

use glam::{DQuat, DVec3, DVec4};
use populace_device::LayerMode;
use populace_model::ClipSource;

use super::inertialize::{Transition, inertialize};
use super::local::{
    Gain, HEMISPHERE_MARGIN, Local, LocalWithGain, quat_from_vec4, ratio, vec4_from_quat,
};
use super::sample::TracksByJoint;
use super::{
    OracleBody, OracleInertialization, OracleLayer, OracleRetarget, OracleSampledState, OracleSlot,
};

/// Layer 0 is divided by its total weight if that is above this; otherwise the rest pose shows.
const LEAST_TOTAL: f64 = 1e-3;

struct Sample {
    weight: f64,
    value: Local,
    reference: Local,
}

/// A clip bound to the body: by joint names, or retargeted to all joints at once.
enum Clip<'a> {
    Named(TracksByJoint<'a>),
    Retargeted { value: Vec<Local>, reference: Vec<Local> },
}

impl<'a> Clip<'a> {
    fn new(slot: &OracleSlot<'a>) -> Self {
        Self::at(slot.clip, slot.time_secs, slot.retarget)
    }

    fn at(clip: &'a ClipSource, secs: f64, retarget: Option<&OracleRetarget>) -> Self {
        let tracks = TracksByJoint::new(clip);
        match retarget {
            None => Self::Named(tracks),
            Some(retarget) => Self::Retargeted {
                value: retarget.locals(clip, secs),
                reference: retarget.locals(clip, tracks.first_time()),
            },
        }
    }

    fn value(&self, joint: usize, name: &str, rest: &Local, time_secs: f64) -> Local {
        match self {
            Self::Named(tracks) => tracks.local(name, rest, time_secs),
            Self::Retargeted { value, .. } => value[joint],
        }
    }

    fn reference(&self, joint: usize, name: &str, rest: &Local) -> Local {
        match self {
            Self::Named(tracks) => tracks.reference(name, rest),
            Self::Retargeted { reference, .. } => reference[joint],
        }
    }
}

/// A sampled state with its clip bound to the body, at its own and at the neighbouring time.
struct SampledClip<'a> {
    state: &'a OracleSampledState<'a>,
    clips: [Clip<'a>; 2],
}

impl<'a> SampledClip<'a> {
    fn new(state: &'a OracleSampledState<'a>) -> Self {
        let times = [state.secs, state.neighbour_secs];
        Self { state, clips: times.map(|secs| Clip::at(state.clip, secs, state.retarget)) }
    }

    /// Returns a joint's transform at the time, at the neighbouring time and at the first key.
    fn values(&self, joint: usize, name: &str, rest: &Local) -> [Local; 3] {
        let [at, neighbour] = &self.clips;
        [
            at.value(joint, name, rest, self.state.secs),
            neighbour.value(joint, name, rest, self.state.neighbour_secs),
            at.reference(joint, name, rest),
        ]
    }
}

/// Returns the local transform of each joint and its error gains.
pub(super) fn pose(
    body: &OracleBody,
    slots: &[OracleSlot<'_>],
    inertialization: &[OracleInertialization<'_>],
    layers: &[OracleLayer],
) -> (Vec<Local>, Vec<Gain>) {
    let clips: Vec<_> = slots.iter().map(Clip::new).collect();
    let inertialization: Vec<_> = inertialization
        .iter()
        .filter(|of| !of.is_over())
        .map(|of| (of, SampledClip::new(&of.outgoing), SampledClip::new(&of.incoming)))
        .collect();
    let plain = [OracleLayer::default()];
    let layers = if layers.is_empty() { &plain } else { layers };
    let one_joint = |joint: usize| {
        let (name, rest) = (&body.joints[joint].name, body.rest(joint));
        let mut posed = (rest, Gain::ONE);
        for (index, layer) in layers.iter().enumerate() {
            let samples: Vec<Sample> = slots
                .iter()
                .zip(&clips)
                .filter(|(slot, _)| slot.layer == index && slot.weight > 0.0)
                .map(|(slot, clip)| Sample {
                    weight: slot.weight,
                    value: clip.value(joint, name, &rest, slot.time_secs),
                    reference: clip.reference(joint, name, &rest),
                })
                .collect();
            let transitions: Vec<Transition> = inertialization
                .iter()
                .filter(|(of, ..)| of.layer == index)
                .map(|(of, outgoing, incoming)| Transition {
                    of,
                    outgoing: outgoing.values(joint, name, &rest),
                    incoming: incoming.values(joint, name, &rest),
                })
                .collect();
            let strength = layer.weight * layer.mask.as_ref().map_or(1.0, |mask| mask[joint]);
            let inputs = (samples.as_slice(), transitions.as_slice());
            posed = match layer.mode {
                _ if index == 0 => inertialize(base(&rest, &samples), &transitions),
                LayerMode::Override => override_with(posed, &rest, inputs, strength),
                LayerMode::Additive => add(posed, inputs, strength),
            };
        }
        posed
    };
    (0..body.joints.len()).map(one_joint).unzip()
}

/// Layer 0: the mix of its slots, or the rest pose if their total weight is nearly 0.
fn base(rest: &Local, samples: &[Sample]) -> LocalWithGain {
    if total(samples) > LEAST_TOTAL { mix(rest, samples) } else { (*rest, Gain::ONE) }
}

fn total(samples: &[Sample]) -> f64 {
    samples.iter().map(|s| s.weight).sum()
}

/// Returns the weighted mean of samples.
fn mix(rest: &Local, samples: &[Sample]) -> LocalWithGain {
    let total = total(samples);
    let mut translation = DVec3::ZERO;
    let mut scale = DVec3::ZERO;
    let mut rotation = DVec4::ZERO;
    let mut clear = true;
    for sample in samples {
        let share = sample.weight / total;
        translation += sample.value.translation * share;
        scale += sample.value.scale * share;
        rotation += in_rest_hemisphere(rest, sample.value.rotation) * share;
        clear &= hemisphere_is_clear(rest, sample.value.rotation);
    }
    let gain = Gain {
        rotation: if clear || samples.len() == 1 { 1.0 / rotation.length() } else { f64::INFINITY },
        ..Gain::ONE
    };
    (Local { translation, rotation: quat_from_vec4(rotation), scale }, gain)
}

/// An override layer: the mix of its slots, blended over the layers below by total slot weight,
/// layer weight and mask.
fn override_with(
    beneath: LocalWithGain,
    rest: &Local,
    (samples, transitions): (&[Sample], &[Transition<'_>]),
    strength: f64,
) -> LocalWithGain {
    let total = total(samples);
    let f = strength * total.min(1.0);
    if total <= 0.0 || f <= 0.0 {
        return beneath;
    }
    let ((below, below_gain), (above, above_gain)) =
        (beneath, inertialize(mix(rest, samples), transitions));
    let from = in_rest_hemisphere(rest, below.rotation);
    let rotation = from + (in_rest_hemisphere(rest, above.rotation) - from) * f;
    let clear =
        hemisphere_is_clear(rest, below.rotation) && hemisphere_is_clear(rest, above.rotation);
    let between = |a: f64, b: f64| if f < 1.0 { a * (1.0 - f) + b * f } else { b };
    let gain = Gain {
        translation: between(below_gain.translation, above_gain.translation),
        rotation: if clear || f == 1.0 {
            between(below_gain.rotation, above_gain.rotation) / rotation.length()
        } else {
            f64::INFINITY
        },
        scale: between(below_gain.scale, above_gain.scale),
    };
    let local = Local {
        translation: below.translation + (above.translation - below.translation) * f,
        rotation: quat_from_vec4(rotation),
        scale: below.scale + (above.scale - below.scale) * f,
    };
    (local, gain)
}

/// An additive layer: adds each slot's difference from its clip's first pose to the layers below.
fn add(
    beneath: LocalWithGain,
    (samples, transitions): (&[Sample], &[Transition<'_>]),
    strength: f64,
) -> LocalWithGain {
    let identity = DVec4::W;
    let (below, below_gain) = beneath;
    let mut translation = DVec3::ZERO;
    let mut rotation = identity;
    let mut scale = DVec3::ONE;
    let (mut strengths, mut ratios, mut clear) = (0.0, 0.0, true);
    for sample in samples {
        let f = sample.weight * strength;
        if f <= 0.0 {
            continue;
        }
        let difference = sample.reference.rotation.inverse() * sample.value.rotation;
        let difference = if difference.w < 0.0 { -difference } else { difference };
        clear &= difference.w > HEMISPHERE_MARGIN;
        let ratio = ratio(sample.value.scale, sample.reference.scale);
        translation += (sample.value.translation - sample.reference.translation) * f;
        rotation += (vec4_from_quat(difference) - identity) * f;
        scale += (ratio - DVec3::ONE) * f;
        strengths += f;
        ratios += f * (1.0 + ratio.abs().max_element())
            / sample.reference.scale.abs().min_element().max(1e-9);
    }
    for offset in transitions.iter().map(|transition| transition.offset(true)) {
        translation += offset.translation * strength;
        rotation += offset.rotation * strength;
        scale += offset.scale * strength;
        clear &= offset.clear;
        strengths += offset.gain * strength;
        ratios += offset.gain * offset.scale_gain * strength;
    }
    if strengths <= 0.0 {
        return beneath;
    }
    let local = Local {
        translation: below.translation + translation,
        rotation: (below.rotation * quat_from_vec4(rotation)).normalize(),
        scale: below.scale * scale,
    };
    // The rounding of the difference itself counts once. The errors of its sample and of its
    // reference count once each per unit of strength.
    let gain = Gain {
        translation: below_gain.translation + 2.0 * strengths,
        rotation: if clear {
            below_gain.rotation + (1.0 + 2.0 * strengths) / rotation.length()
        } else {
            f64::INFINITY
        },
        scale: below_gain.scale * scale.abs().max_element()
            + below.scale.abs().max_element() * ratios,
    };
    (local, gain)
}

/// Returns the quaternion of a rotation that lies in the hemisphere of the rest rotation.
fn in_rest_hemisphere(rest: &Local, rotation: DQuat) -> DVec4 {
    let vector = vec4_from_quat(rotation);
    if rest.rotation.dot(rotation) < 0.0 { -vector } else { vector }
}

/// Returns whether single precision is sure to choose the same hemisphere.
fn hemisphere_is_clear(rest: &Local, rotation: DQuat) -> bool {
    rest.rotation.dot(rotation).abs() > HEMISPHERE_MARGIN
}
