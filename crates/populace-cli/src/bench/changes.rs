//! What members play that crossfade again and again, found apart from the crowd: as the rules say,
//! in double precision.

use populace::character::Character;
use populace::clip::ticks_from_secs;
use populace_testkit::oracle::{OracleSlot, Timing, Weighting};

use super::scene::{FADE_SECS, PlayedSlot};

/// A slot that has faded to less than this share is free.
const NEGLIGIBLE: f64 = 1e-3;

/// One slot of a member, as the oracle needs to know it.
pub(super) struct Playing {
    clip: usize,
    timing: Timing,
    weighting: Weighting,
    layer: usize,
}

impl Playing {
    fn from_the_start(slot: PlayedSlot) -> Self {
        let timing = Timing::Loop { start_tick: 0, phase: f64::from(slot.phase), speed: 1.0 };
        Self {
            clip: slot.clip,
            timing,
            weighting: Weighting::Constant(slot.weight),
            layer: slot.layer,
        }
    }

    pub(super) fn at<'a>(&self, tick: u64, character: &'a Character) -> OracleSlot<'a> {
        let clip = &character.clips[self.clip];
        OracleSlot {
            retarget: None,
            clip: clip.source(),
            time_secs: self.timing.time_secs(tick, clip),
            weight: self.weighting.weight(tick),
            layer: self.layer,
        }
    }

    /// Seconds until a slot that fades out has gone.
    fn secs_left(&self, now: u64) -> f64 {
        match self.weighting {
            Weighting::Ramp { tick, to: 0.0, secs, .. } => {
                f64::from(secs)
                    - now.saturating_sub(tick) as f64 / populace::clip::TICKS_PER_SEC as f64
            }
            _ => f64::INFINITY,
        }
    }

    fn leaves(&self) -> bool {
        matches!(self.weighting, Weighting::Ramp { to: 0.0, .. })
    }

    fn ramp(&mut self, tick: u64, to: f64, secs: f64) {
        #[expect(clippy::cast_possible_truncation, reason = "the nearest is what is wanted")]
        let [from, to, secs] = [self.weighting.weight(tick), to, secs].map(|number| number as f32);
        self.weighting = Weighting::Ramp { tick, from, to, secs };
    }
}

/// A member's slots, and the clip that waits for one.
pub(super) struct Changing {
    pub(super) slots: Vec<Playing>,
    waits: Option<(usize, u64)>,
}

impl Changing {
    pub(super) fn new(slots: impl Iterator<Item = PlayedSlot>) -> Self {
        Self { slots: slots.map(Playing::from_the_start).collect(), waits: None }
    }

    /// Starts what waited until a tick.
    pub(super) fn go_on_to(&mut self, tick: u64) {
        while let Some((clip, due)) = self.waits.filter(|(_, due)| *due <= tick) {
            self.change_over(clip, due);
        }
    }

    /// What a crossfade does: all that plays fades out together and the new clip takes a free slot.
    /// Where none is free the weakest fades out first, in its share of the fade, and leaves its
    /// weight to the strongest.
    pub(super) fn change_over(&mut self, clip: usize, tick: u64) {
        self.waits = None;
        let weights: Vec<f64> = self.slots.iter().map(|slot| slot.weighting.weight(tick)).collect();
        let total: f64 = weights.iter().sum();
        let mut order: Vec<usize> = (0..weights.len()).collect();
        order.sort_by(|&a, &b| weights[a].total_cmp(&weights[b]));
        let is_free =
            |slot: &usize| self.slots[*slot].leaves() && weights[*slot] < NEGLIGIBLE * total;
        let free = order.iter().copied().find(is_free);
        let (weakest, strongest) = (order[0], order[order.len() - 1]);
        let Some(free) = free.or((weakest == strongest).then_some(weakest)) else {
            self.waits =
                Some((clip, self.hasten(weakest, strongest, weights[weakest] / total, tick)));
            return;
        };
        let alone = self.slots.len() == 1;
        self.slots.iter_mut().for_each(|slot| slot.ramp(tick, 0.0, FADE_SECS.into()));
        let timing = Timing::Loop { start_tick: tick, phase: 0.0, speed: 1.0 };
        let secs = if alone { 0.0 } else { FADE_SECS };
        let weighting = Weighting::Ramp { tick, from: 0.0, to: 1.0, secs };
        self.slots[free] = Playing { clip, timing, weighting, layer: 0 };
    }

    /// When the weakest will have gone.
    fn hasten(&mut self, weakest: usize, strongest: usize, share: f64, tick: u64) -> u64 {
        let secs = share * f64::from(FADE_SECS);
        let left = self.slots[weakest].weighting.weight(tick);
        let gone_in = secs.min(self.slots[weakest].secs_left(tick));
        for (index, slot) in self.slots.iter_mut().enumerate() {
            let weight = slot.weighting.weight(tick);
            if index == weakest {
                slot.ramp(tick, 0.0, gone_in);
            } else {
                slot.ramp(tick, if index == strongest { weight + left } else { weight }, secs);
            }
        }
        tick + ticks_from_secs(gone_in) + 1
    }
}
