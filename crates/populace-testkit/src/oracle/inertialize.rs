//! Inertialize: the decaying offsets of clips that were replaced at once, in pose and in velocity
//! (Bollo, "Inertialization", GDC 2018).

use glam::{DQuat, DVec3, DVec4};
use populace_model::ClipSource;

use super::OracleRetarget;
use super::local::{
    Gain, HEMISPHERE_MARGIN, Local, LocalWithGain, quat_from_vec4, ratio, vec4_from_quat,
};

/// The state of a clip at one instant: its time and its velocity.
#[derive(Clone, Copy, Debug)]
pub struct OracleSampledState<'a> {
    /// The motion as its file states it.
    pub clip: &'a ClipSource,
    /// Time on the clip's own axis.
    pub secs: f64,
    /// The time of a neighbouring row; the velocity is measured towards it.
    pub neighbour_secs: f64,
    /// Velocity, in units of the difference from `secs` to `neighbour_secs`, per second.
    pub rate: f64,
    /// See [`OracleSlot::retarget`](super::OracleSlot::retarget).
    pub retarget: Option<&'a OracleRetarget>,
}

/// A transition from an outgoing to an incoming clip by inertialization.
#[derive(Clone, Copy, Debug)]
pub struct OracleInertialization<'a> {
    /// The outgoing clip at the start.
    pub outgoing: OracleSampledState<'a>,
    /// The incoming clip at the start.
    pub incoming: OracleSampledState<'a>,
    /// The clock at the start.
    pub start_tick: u64,
    /// Time since the start.
    pub elapsed_secs: f64,
    /// Time in which the offset decays to 0.
    pub secs: f64,
    /// The outgoing clip's share of the layer at the start.
    pub share: f64,
    /// The rate of change of that share.
    pub share_per_sec: f64,
    /// Index of the layer.
    pub layer: usize,
}

impl OracleInertialization<'_> {
    pub(super) fn is_over(&self) -> bool {
        self.elapsed_secs >= self.secs
    }
}

/// One joint of a transition. Each clip is given at its own time, at the neighbouring time and at
/// its first key.
pub(super) struct Transition<'a> {
    pub(super) of: &'a OracleInertialization<'a>,
    pub(super) outgoing: [Local; 3],
    pub(super) incoming: [Local; 3],
}

/// The offset that a transition adds to a joint, relative to the identity, and how errors grow in
/// it.
pub(super) struct Offset {
    pub(super) translation: DVec3,
    pub(super) rotation: DVec4,
    pub(super) scale: DVec3,
    pub(super) gain: f64,
    pub(super) scale_gain: f64,
    pub(super) clear: bool,
}

/// The difference between two local transforms.
struct Difference {
    translation: DVec3,
    rotation: DQuat,
    scale: DVec3,
    /// The factor by which an error in a scale grown.
    scale_gain: f64,
}

impl Difference {
    /// Takes `from` to `to`; the rotation is in the hemisphere of `side`.
    fn new(from: &Local, to: &Local, side: DQuat) -> Self {
        let rotation = from.rotation.inverse() * to.rotation;
        let scale = ratio(to.scale, from.scale);
        Self {
            translation: to.translation - from.translation,
            rotation: if rotation.dot(side) < 0.0 { -rotation } else { rotation },
            scale,
            scale_gain: (1.0 + scale.abs().max_element())
                / from.scale.abs().min_element().max(1e-9),
        }
    }
}

impl Transition<'_> {
    /// Returns the quintic decay of a pose offset (a factor) and of a velocity offset (in seconds).
    fn decay(&self) -> (f64, f64) {
        let s = self.of.elapsed_secs / self.of.secs;
        let pose = 1.0 - 10.0 * s.powi(3) + 15.0 * s.powi(4) - 6.0 * s.powi(5);
        let velocity = s - 6.0 * s.powi(3) + 8.0 * s.powi(4) - 3.0 * s.powi(5);
        (pose, velocity * self.of.secs)
    }

    pub(super) fn offset(&self, additive: bool) -> Offset {
        let (pose, velocity) = self.decay();
        let OracleInertialization { share, share_per_sec, .. } = *self.of;
        let weight = pose * share + velocity * share_per_sec;
        let [leaving, entering] =
            [self.of.outgoing.rate, self.of.incoming.rate].map(|rate| velocity * share * rate);
        let [outgoing, outgoing_next, outgoing_first] = &self.outgoing;
        let [incoming, incoming_next, incoming_first] = &self.incoming;
        let from = if additive { outgoing_first } else { incoming };
        let at = Difference::new(from, outgoing, DQuat::IDENTITY);
        let next = Difference::new(from, outgoing_next, at.rotation);
        let mut offset = Offset {
            translation: at.translation * weight + (next.translation - at.translation) * leaving,
            rotation: (vec4_from_quat(at.rotation) - DVec4::W) * weight
                + (vec4_from_quat(next.rotation) - vec4_from_quat(at.rotation)) * leaving,
            scale: (at.scale - DVec3::ONE) * weight + (next.scale - at.scale) * leaving,
            gain: 2.0 * weight.abs() + 3.0 * (leaving.abs() + entering.abs()),
            scale_gain: at.scale_gain.max(next.scale_gain),
            clear: at.rotation.w > HEMISPHERE_MARGIN
                && at.rotation.dot(next.rotation) > HEMISPHERE_MARGIN,
        };
        if additive {
            let at = Difference::new(incoming_first, incoming, DQuat::IDENTITY);
            let next = Difference::new(incoming_first, incoming_next, at.rotation);
            let own = pose * share;
            offset.translation -=
                at.translation * own + (next.translation - at.translation) * entering;
            offset.rotation -= (vec4_from_quat(at.rotation) - DVec4::W) * own
                + (vec4_from_quat(next.rotation) - vec4_from_quat(at.rotation)) * entering;
            offset.scale -= (at.scale - DVec3::ONE) * own + (next.scale - at.scale) * entering;
            offset.gain += 2.0 * own;
            offset.scale_gain = offset.scale_gain.max(at.scale_gain).max(next.scale_gain);
            offset.clear &= at.rotation.w > HEMISPHERE_MARGIN;
        } else {
            // The offset is relative to the incoming clip, so that clip's velocity is taken off.
            let own = Difference::new(incoming, incoming_next, DQuat::IDENTITY);
            let moved = vec4_from_quat(own.rotation * at.rotation);
            offset.translation -= own.translation * entering;
            offset.rotation -= (moved - vec4_from_quat(at.rotation)) * entering;
            offset.scale -= (own.scale - DVec3::ONE) * at.scale * entering;
            offset.scale_gain *= 1.0 + own.scale_gain;
            offset.clear &= own.rotation.w > HEMISPHERE_MARGIN;
        }
        offset
    }
}

/// Applies all transitions of a layer to the mean of its slots. The transition that started last
/// is applied first.
pub(super) fn inertialize(mean: LocalWithGain, transitions: &[Transition<'_>]) -> LocalWithGain {
    let mut starts: Vec<u64> = transitions.iter().map(|one| one.of.start_tick).collect();
    starts.sort_unstable();
    starts.dedup();
    starts.into_iter().rev().fold(mean, |posed, start| {
        let of_start = transitions.iter().filter(|one| one.of.start_tick == start);
        add_offsets(posed, of_start.map(|one| one.offset(false)))
    })
}

/// Applies the offsets of transitions that started at one tick.
fn add_offsets(
    (mean, gain): LocalWithGain,
    offsets: impl Iterator<Item = Offset>,
) -> LocalWithGain {
    let (mut translation, mut rotation, mut scale) = (DVec3::ZERO, DVec4::W, DVec3::ONE);
    let (mut grown, mut scale_grown, mut clear) = (0.0, 0.0, true);
    for offset in offsets {
        translation += offset.translation;
        rotation += offset.rotation;
        scale += offset.scale;
        grown += offset.gain;
        scale_grown += offset.gain * offset.scale_gain;
        clear &= offset.clear;
    }
    let local = Local {
        translation: mean.translation + translation,
        rotation: (mean.rotation * quat_from_vec4(rotation)).normalize(),
        scale: mean.scale * scale,
    };
    let gain = Gain {
        translation: gain.translation + grown,
        rotation: if clear {
            gain.rotation + (1.0 + grown) / rotation.length()
        } else {
            f64::INFINITY
        },
        scale: gain.scale * scale.abs().max_element()
            + mean.scale.abs().max_element() * scale_grown,
    };
    (local, gain)
}
