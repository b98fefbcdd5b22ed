//! Inertialize: what is left of clips that were left at once, in pose and in speed (Bollo,
//! "Inertialization", GDC 2018).

use glam::{DQuat, DVec3, DVec4};
use populace_model::ClipSource;

use super::pose::{Gain, HEMISPHERE_MARGIN, Posed, four, ratio, unit};
use super::{Local, OracleRetarget};

/// How a clip stood at one instant.
#[derive(Clone, Copy, Debug)]
pub struct OracleStand<'a> {
    /// The motion as its file states it.
    pub clip: &'a ClipSource,
    /// Time on the clip's own axis.
    pub secs: f64,
    /// A time near that, towards which its speed is measured.
    pub far_secs: f64,
    /// How many times the way from the one to the other it went in a second.
    pub pace: f64,
    /// See [`OracleSlot::retarget`](super::OracleSlot::retarget).
    pub retarget: Option<&'a OracleRetarget>,
}

/// A clip that was left, and what took its place.
#[derive(Clone, Copy, Debug)]
pub struct OracleInertialization<'a> {
    /// How it stood.
    pub left: OracleStand<'a>,
    /// How that stood which took its place.
    pub taking: OracleStand<'a>,
    /// The clock then.
    pub start_tick: u64,
    /// Since then.
    pub elapsed_secs: f64,
    /// In which it inertializes.
    pub secs: f64,
    /// Its part of what its layer showed.
    pub share: f64,
    /// By how much that changed in a second.
    pub share_per_sec: f64,
    /// The layer.
    pub layer: usize,
}

impl OracleInertialization<'_> {
    pub(super) fn is_over(&self) -> bool {
        self.elapsed_secs >= self.secs
    }
}

/// One joint of a clip that was left, and of what took its place: there, at the far time, and at
/// the clip's first key.
pub(super) struct Remains<'a> {
    pub(super) of: &'a OracleInertialization<'a>,
    pub(super) left: [Local; 3],
    pub(super) taking: [Local; 3],
}

/// A change of a joint, less what changes nothing, and how errors grow in it.
pub(super) struct Change {
    pub(super) translation: DVec3,
    pub(super) rotation: DVec4,
    pub(super) scale: DVec3,
    pub(super) gain: f64,
    pub(super) scale_gain: f64,
    pub(super) clear: bool,
}

/// What takes one transform to another.
struct Way {
    translation: DVec3,
    rotation: DQuat,
    scale: DVec3,
    /// By how much an error in a scale grows.
    scale_gain: f64,
}

impl Way {
    fn new(from: &Local, to: &Local, side: DQuat) -> Self {
        let turn = from.rotation.inverse() * to.rotation;
        let scale = ratio(to.scale, from.scale);
        Self {
            translation: to.translation - from.translation,
            rotation: if turn.dot(side) < 0.0 { -turn } else { turn },
            scale,
            scale_gain: (1.0 + scale.abs().max_element())
                / from.scale.abs().min_element().max(1e-9),
        }
    }
}

impl Remains<'_> {
    /// The quintics, and the seconds that the second stands for.
    fn decay(&self) -> (f64, f64) {
        let s = self.of.elapsed_secs / self.of.secs;
        let still = 1.0 - 10.0 * s.powi(3) + 15.0 * s.powi(4) - 6.0 * s.powi(5);
        let moving = s - 6.0 * s.powi(3) + 8.0 * s.powi(4) - 3.0 * s.powi(5);
        (still, moving * self.of.secs)
    }

    pub(super) fn change(&self, additive: bool) -> Change {
        let (still, moving) = self.decay();
        let OracleInertialization { share, share_per_sec, .. } = *self.of;
        let part = still * share + moving * share_per_sec;
        let [went, goes] =
            [self.of.left.pace, self.of.taking.pace].map(|pace| moving * share * pace);
        let ([at, far, first], [taking, taking_far, taking_first]) = (&self.left, &self.taking);
        let from = if additive { first } else { taking };
        let at = Way::new(from, at, DQuat::IDENTITY);
        let far = Way::new(from, far, at.rotation);
        let mut change = Change {
            translation: at.translation * part + (far.translation - at.translation) * went,
            rotation: (four(at.rotation) - DVec4::W) * part
                + (four(far.rotation) - four(at.rotation)) * went,
            scale: (at.scale - DVec3::ONE) * part + (far.scale - at.scale) * went,
            gain: 2.0 * part.abs() + 3.0 * (went.abs() + goes.abs()),
            scale_gain: at.scale_gain.max(far.scale_gain),
            clear: at.rotation.w > HEMISPHERE_MARGIN
                && at.rotation.dot(far.rotation) > HEMISPHERE_MARGIN,
        };
        if additive {
            let at = Way::new(taking_first, taking, DQuat::IDENTITY);
            let far = Way::new(taking_first, taking_far, at.rotation);
            let own = still * share;
            change.translation -= at.translation * own + (far.translation - at.translation) * goes;
            change.rotation -= (four(at.rotation) - DVec4::W) * own
                + (four(far.rotation) - four(at.rotation)) * goes;
            change.scale -= (at.scale - DVec3::ONE) * own + (far.scale - at.scale) * goes;
            change.gain += 2.0 * own;
            change.scale_gain = change.scale_gain.max(at.scale_gain).max(far.scale_gain);
            change.clear &= at.rotation.w > HEMISPHERE_MARGIN;
        } else {
            // What is left lies over what took the place, and goes along with it.
            let moves = Way::new(taking, taking_far, DQuat::IDENTITY);
            change.translation -= moves.translation * goes;
            change.rotation -= (four(moves.rotation * at.rotation) - four(at.rotation)) * goes;
            change.scale -= (moves.scale - DVec3::ONE) * at.scale * goes;
            change.scale_gain *= 1.0 + moves.scale_gain;
            change.clear &= moves.rotation.w > HEMISPHERE_MARGIN;
        }
        change
    }
}

/// A layer's mean with all that inertializes in it: what was left last is nearest to the mean.
pub(super) fn inertialize(mean: Posed, remains: &[Remains<'_>]) -> Posed {
    let mut starts: Vec<u64> = remains.iter().map(|remains| remains.of.start_tick).collect();
    starts.sort_unstable();
    starts.dedup();
    starts.into_iter().rev().fold(mean, |posed, start| {
        let of_start = remains.iter().filter(|remains| remains.of.start_tick == start);
        inertialize_together(posed, of_start.map(|remains| remains.change(false)))
    })
}

fn inertialize_together((mean, gain): Posed, changes: impl Iterator<Item = Change>) -> Posed {
    let (mut translation, mut rotation, mut scale) = (DVec3::ZERO, DVec4::W, DVec3::ONE);
    let (mut grows, mut scale_grows, mut clear) = (0.0, 0.0, true);
    for change in changes {
        translation += change.translation;
        rotation += change.rotation;
        scale += change.scale;
        grows += change.gain;
        scale_grows += change.gain * change.scale_gain;
        clear &= change.clear;
    }
    let local = Local {
        translation: mean.translation + translation,
        rotation: (mean.rotation * unit(rotation)).normalize(),
        scale: mean.scale * scale,
    };
    let gain = Gain {
        translation: gain.translation + grows,
        rotation: if clear {
            gain.rotation + (1.0 + grows) / rotation.length()
        } else {
            f64::INFINITY
        },
        scale: gain.scale * scale.abs().max_element()
            + mean.scale.abs().max_element() * scale_grows,
    };
    (local, gain)
}
