//! Pose: slots mixed layer by layer into local transforms.

use glam::{DQuat, DVec3, DVec4};
use populace_device::LayerMode;
use populace_model::ClipSource;

use super::inertialize::{Remains, inertialize};
use super::sample::TracksByJoint;
use super::{
    Local, OracleBody, OracleInertialization, OracleLayer, OracleRetarget, OracleSlot, OracleStand,
};

/// Layer 0 is divided by its total weight above this, else the rest pose shows.
const LEAST_TOTAL: f64 = 1e-3;
/// A quaternion this near to the border of its hemisphere may be turned either way by single
/// precision.
pub(super) const HEMISPHERE_MARGIN: f64 = 1e-4;

/// How much an error in a clip's value grows on its way into a joint's local transform. Infinite
/// where single precision may turn a rotation to the other hemisphere: then no device can be held
/// to a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gain {
    /// Of translations.
    pub translation: f64,
    /// Of rotations, as four-component vectors.
    pub rotation: f64,
    /// Of scales.
    pub scale: f64,
}

impl Gain {
    const ONE: Self = Self { translation: 1.0, rotation: 1.0, scale: 1.0 };
}

struct Sample {
    weight: f64,
    value: Local,
    reference: Local,
}

/// What a slot's clip does to the body: to the joints whose names it knows, or to all at once.
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

/// A clip that was left or took another's place: there, and at the far time.
struct SampledState<'a> {
    of: &'a OracleStand<'a>,
    clips: [Clip<'a>; 2],
}

impl<'a> SampledState<'a> {
    fn new(of: &'a OracleStand<'a>) -> Self {
        Self { of, clips: [of.secs, of.far_secs].map(|secs| Clip::at(of.clip, secs, of.retarget)) }
    }

    fn values(&self, joint: usize, name: &str, rest: &Local) -> [Local; 3] {
        let [at, far] = &self.clips;
        [
            at.value(joint, name, rest, self.of.secs),
            far.value(joint, name, rest, self.of.far_secs),
            at.reference(joint, name, rest),
        ]
    }
}

pub(super) type Posed = (Local, Gain);

pub(super) fn pose(
    body: &OracleBody,
    slots: &[OracleSlot<'_>],
    inertialization: &[OracleInertialization<'_>],
    layers: &[OracleLayer],
) -> (Vec<Local>, Vec<Gain>) {
    let clips: Vec<_> = slots.iter().map(Clip::new).collect();
    let inertialization =
        inertialization.iter().filter(|inertialization| !inertialization.is_over());
    let inertialization: Vec<_> = inertialization
        .map(|of| (of, SampledState::new(&of.left), SampledState::new(&of.taking)))
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
            let remains: Vec<Remains> = inertialization
                .iter()
                .filter(|(of, ..)| of.layer == index)
                .map(|(of, left, taking)| Remains {
                    of,
                    left: left.values(joint, name, &rest),
                    taking: taking.values(joint, name, &rest),
                })
                .collect();
            let strength = layer.weight * layer.mask.as_ref().map_or(1.0, |mask| mask[joint]);
            posed = match layer.mode {
                _ if index == 0 => inertialize(base(&rest, &samples), &remains),
                LayerMode::Override => override_with(posed, &rest, (&samples, &remains), strength),
                LayerMode::Additive => add(posed, (&samples, &remains), strength),
            };
        }
        posed
    };
    (0..body.joints.len()).map(one_joint).unzip()
}

/// Layer 0: its mix, or rest where nearly nothing plays.
fn base(rest: &Local, samples: &[Sample]) -> Posed {
    if total(samples) > LEAST_TOTAL { mix(rest, samples) } else { (*rest, Gain::ONE) }
}

fn total(samples: &[Sample]) -> f64 {
    samples.iter().map(|s| s.weight).sum()
}

/// The mean of samples, weighted.
fn mix(rest: &Local, samples: &[Sample]) -> Posed {
    let total = total(samples);
    let mut translation = DVec3::ZERO;
    let mut scale = DVec3::ZERO;
    let mut rotation = DVec4::ZERO;
    let mut clear = true;
    for sample in samples {
        let share = sample.weight / total;
        translation += sample.value.translation * share;
        scale += sample.value.scale * share;
        rotation += towards(rest, sample.value.rotation) * share;
        clear &= is_clear(rest, sample.value.rotation);
    }
    let gain = Gain {
        rotation: if clear || samples.len() == 1 { 1.0 / rotation.length() } else { f64::INFINITY },
        ..Gain::ONE
    };
    (Local { translation, rotation: unit(rotation), scale }, gain)
}

/// An override layer: the mix over what lies beneath, by slot total, layer weight and mask.
fn override_with(
    beneath: Posed,
    rest: &Local,
    (samples, remains): (&[Sample], &[Remains<'_>]),
    strength: f64,
) -> Posed {
    let total = total(samples);
    let f = strength * total.min(1.0);
    if total <= 0.0 || f <= 0.0 {
        return beneath;
    }
    let ((below, below_gain), (above, above_gain)) =
        (beneath, inertialize(mix(rest, samples), remains));
    let from = towards(rest, below.rotation);
    let rotation = from + (towards(rest, above.rotation) - from) * f;
    let clear = is_clear(rest, below.rotation) && is_clear(rest, above.rotation);
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
        rotation: unit(rotation),
        scale: below.scale + (above.scale - below.scale) * f,
    };
    (local, gain)
}

/// An additive layer: each slot's difference from its clip's first pose, laid over what lies
/// beneath.
fn add(beneath: Posed, (samples, remains): (&[Sample], &[Remains<'_>]), strength: f64) -> Posed {
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
        let turn = sample.reference.rotation.inverse() * sample.value.rotation;
        let turn = if turn.w < 0.0 { -turn } else { turn };
        clear &= turn.w > HEMISPHERE_MARGIN;
        let ratio = ratio(sample.value.scale, sample.reference.scale);
        translation += (sample.value.translation - sample.reference.translation) * f;
        rotation += (four(turn) - identity) * f;
        scale += (ratio - DVec3::ONE) * f;
        strengths += f;
        ratios += f * (1.0 + ratio.abs().max_element())
            / sample.reference.scale.abs().min_element().max(1e-9);
    }
    for change in remains.iter().map(|remains| remains.change(true)) {
        translation += change.translation * strength;
        rotation += change.rotation * strength;
        scale += change.scale * strength;
        clear &= change.clear;
        strengths += change.gain * strength;
        ratios += change.gain * change.scale_gain * strength;
    }
    if strengths <= 0.0 {
        return beneath;
    }
    let local = Local {
        translation: below.translation + translation,
        rotation: (below.rotation * unit(rotation)).normalize(),
        scale: below.scale * scale,
    };
    // The rounding of the delta itself counts once, its sample and reference once each for each
    // unit of strength.
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

/// Component by component; 1 where the reference is 0.
pub(super) fn ratio(value: DVec3, reference: DVec3) -> DVec3 {
    let one = |v: f64, r: f64| if r == 0.0 { 1.0 } else { v / r };
    DVec3::new(one(value.x, reference.x), one(value.y, reference.y), one(value.z, reference.z))
}

pub(super) fn four(q: DQuat) -> DVec4 {
    DVec4::from_array(q.to_array())
}

pub(super) fn unit(v: DVec4) -> DQuat {
    DQuat::from_array(v.normalize().to_array())
}

/// A rotation in the hemisphere of the rest rotation.
fn towards(rest: &Local, rotation: DQuat) -> DVec4 {
    if rest.rotation.dot(rotation) < 0.0 { -four(rotation) } else { four(rotation) }
}

/// Whether single precision agrees about the hemisphere.
fn is_clear(rest: &Local, rotation: DQuat) -> bool {
    rest.rotation.dot(rotation).abs() > HEMISPHERE_MARGIN
}
