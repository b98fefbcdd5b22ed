//! How far mixes of clips step, in the contacts of their clips.

use std::sync::Arc;

use populace::character::Character;
use populace::model::Side;

use crate::soles::Soles;
use crate::{Error, Gait, MixedClip};

/// Times within a contact count up to this, in seconds, when those of several clips are mixed.
const WITHIN_SECS: f32 = 0.12;
/// A foot that this share of a cycle stands does not lift.
const WHOLE: f32 = 0.999;
/// Clips of less than this share of the weight do not make a standing foot step.
const STEPPING: f32 = 0.02;

/// Contacts of one foot, mixed by the weights of the clips.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Planting {
    within: f32,
    steps: f32,
    stands: f32,
}

impl Planting {
    /// Adds a clip at seconds after the start of its cycle.
    pub(crate) fn add(&mut self, gait: &Gait, foot: Side, secs: f32, weight: f32) {
        let own = || gait.contacts.iter().filter(|contact| contact.foot == foot);
        let lasts = |from: f32, until: f32| until - from;
        let cycle = gait.duration_secs;
        if own().any(|c| lasts(c.from_secs, c.until_secs) >= WHOLE * cycle) {
            self.stands += weight;
            return;
        }
        // From the nearest end of a contact: positive within one.
        let within = own().map(|c| {
            let away = (secs - 0.5 * (c.from_secs + c.until_secs)).abs();
            let away = if away > 0.5 * cycle { (cycle - away).abs() } else { away };
            0.5 * lasts(c.from_secs, c.until_secs) - away
        });
        self.within += weight * within.fold(-WITHIN_SECS, f32::max).min(WITHIN_SECS);
        self.steps += weight;
    }

    /// Returns whether the foot is planted, as devices decide it.
    pub(crate) fn is_planted(self) -> bool {
        self.steps <= STEPPING * (self.steps + self.stands) || self.within > 0.0
    }
}

/// How far a mix steps forwards in a cycle, in metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MixStride {
    /// By the median velocity of planted soles.
    pub(crate) sole_m: f32,
    /// Metres that the stride gains when the steps of ankles are doubled and the roll of feet is
    /// not.
    pub(crate) ankle_m: f32,
}

impl MixStride {
    /// Measures clips that are mixed, each with its gait. `None` if no foot is planted.
    pub(crate) fn measure(
        character: &Arc<Character>,
        clips: &[(MixedClip, &Gait)],
    ) -> Result<Option<Self>, Error> {
        let mixed: Vec<_> = clips.iter().map(|(clip, _)| clip.clone()).collect();
        let Some(soles) = Soles::sample(character, &mixed)? else { return Ok(None) };
        let (mut own, mut doubled) = (Vec::new(), Vec::new());
        for (samples, side) in soles.feet.iter().zip([Side::Left, Side::Right]) {
            let count = samples.len() as f32;
            let step_secs = soles.duration_secs / count;
            let next = samples.iter().skip(1).chain(samples.first());
            for ((sample, next), nth) in samples.iter().zip(next).zip((0_u16..).map(f32::from)) {
                let mut planting = Planting::default();
                for (mixed, gait) in clips {
                    let phase = (nth / count + mixed.offset).rem_euclid(1.0);
                    planting.add(gait, side, phase * gait.duration_secs, mixed.weight);
                }
                if planting.is_planted() {
                    let ankle = (sample.ankle.y - next.ankle.y) / step_secs;
                    own.push(-sample.velocity.y);
                    doubled.push(ankle - sample.velocity.y);
                }
            }
        }
        let stride = |mut speeds: Vec<f32>| {
            speeds.sort_by(f32::total_cmp);
            speeds.get(speeds.len() / 2).map(|speed| speed * soles.duration_secs)
        };
        let both = stride(own).zip(stride(doubled));
        Ok(both.map(|(sole_m, doubled_m)| Self { sole_m, ankle_m: doubled_m - sole_m }))
    }
}
