//! An independent model of crossfades in double precision, for members that crossfade repeatedly.

use populace::character::Character;
use populace::clip::ticks_from_secs;
use populace_model::convert::single;
use populace_testkit::oracle::{OracleSlot, Timing, Weighting};

use crate::scene::{FADE_SECS, InitialSlot};

/// A slot that is fading out and has less than this share of the total weight is free.
const NEGLIGIBLE: f64 = 1e-3;

/// The state of a slot, for the oracle.
pub(crate) struct SlotState {
    clip: usize,
    timing: Timing,
    weighting: Weighting,
    layer: usize,
}

impl SlotState {
    fn new(slot: InitialSlot) -> Self {
        let timing = Timing::Loop { start_tick: 0, phase: f64::from(slot.phase), speed: 1.0 };
        Self {
            clip: slot.clip,
            timing,
            weighting: Weighting::Constant(slot.weight),
            layer: slot.layer,
        }
    }

    pub(crate) fn at<'a>(&self, tick: u64, character: &'a Character) -> OracleSlot<'a> {
        let clip = &character.clips[self.clip];
        OracleSlot {
            retarget: None,
            clip: clip.source(),
            time_secs: self.timing.time_secs(tick, clip),
            weight: self.weighting.weight(tick),
            layer: self.layer,
        }
    }

    /// Returns the seconds until the slot has faded out; infinite if it does not fade out.
    fn secs_left(&self, now: u64) -> f64 {
        match self.weighting {
            Weighting::Ramp { tick, to: 0.0, secs, .. } => {
                f64::from(secs)
                    - now.saturating_sub(tick) as f64 / populace::clip::TICKS_PER_SEC as f64
            }
            _ => f64::INFINITY,
        }
    }

    fn is_fading_out(&self) -> bool {
        matches!(self.weighting, Weighting::Ramp { to: 0.0, .. })
    }

    fn ramp(&mut self, tick: u64, to: f64, secs: f64) {
        let [from, to, secs] = [self.weighting.weight(tick), to, secs].map(single);
        self.weighting = Weighting::Ramp { tick, from, to, secs };
    }
}

/// A member's slots, and the clip scheduled to start.
pub(crate) struct ChangingSlots {
    pub(crate) slots: Vec<SlotState>,
    /// Index of the clip and the tick of its start.
    scheduled: Option<(usize, u64)>,
}

impl ChangingSlots {
    pub(crate) fn new(slots: impl Iterator<Item = InitialSlot>) -> Self {
        Self { slots: slots.map(SlotState::new).collect(), scheduled: None }
    }

    /// Starts the scheduled clip if it is due at `tick`.
    pub(crate) fn advance_to(&mut self, tick: u64) {
        while let Some((clip, due)) = self.scheduled.filter(|(_, due)| *due <= tick) {
            self.crossfade(clip, due);
        }
    }

    /// Crossfades to a clip. All slots fade out, and the new clip takes a free slot. If no slot is
    /// free, the weakest fades out first, for its share of the fade time, and its weight goes to
    /// the strongest; the clip is then scheduled.
    pub(crate) fn crossfade(&mut self, clip: usize, tick: u64) {
        self.scheduled = None;
        let weights: Vec<f64> = self.slots.iter().map(|slot| slot.weighting.weight(tick)).collect();
        let total: f64 = weights.iter().sum();
        let mut order: Vec<usize> = (0..weights.len()).collect();
        order.sort_by(|&a, &b| weights[a].total_cmp(&weights[b]));
        let is_free =
            |slot: &usize| self.slots[*slot].is_fading_out() && weights[*slot] < NEGLIGIBLE * total;
        let free = order.iter().copied().find(is_free);
        let (weakest, strongest) = (order[0], order[order.len() - 1]);
        let Some(free) = free.or((weakest == strongest).then_some(weakest)) else {
            let due = self.evict(weakest, strongest, weights[weakest] / total, tick);
            self.scheduled = Some((clip, due));
            return;
        };
        let alone = self.slots.len() == 1;
        self.slots.iter_mut().for_each(|slot| slot.ramp(tick, 0.0, FADE_SECS.into()));
        let timing = Timing::Loop { start_tick: tick, phase: 0.0, speed: 1.0 };
        let secs = if alone { 0.0 } else { FADE_SECS };
        let weighting = Weighting::Ramp { tick, from: 0.0, to: 1.0, secs };
        self.slots[free] = SlotState { clip, timing, weighting, layer: 0 };
    }

    /// Fades out the weakest slot and returns the tick at which it is free.
    fn evict(&mut self, weakest: usize, strongest: usize, share: f64, tick: u64) -> u64 {
        let secs = share * f64::from(FADE_SECS);
        let freed = self.slots[weakest].weighting.weight(tick);
        let fade_secs = secs.min(self.slots[weakest].secs_left(tick));
        for (index, slot) in self.slots.iter_mut().enumerate() {
            let weight = slot.weighting.weight(tick);
            if index == weakest {
                slot.ramp(tick, 0.0, fade_secs);
            } else {
                slot.ramp(tick, if index == strongest { weight + freed } else { weight }, secs);
            }
        }
        tick + ticks_from_secs(fade_secs) + 1
    }
}
