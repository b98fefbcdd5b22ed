//! Slots, layers and masks: which clips a member plays, and how they are mixed.

use crate::layout::{
    LAYER_ADDITIVE, LAYER_OVERRIDE, LAYERS_PER_MEMBER, SLOT_HELD, SLOT_LOOP, SLOT_ONCE, Slot,
};
use crate::{Error, JointIndex, Skeleton};

/// The most slots that a member can have.
pub const MAX_SLOTS: usize = 8;
/// The most layers that a member can have.
pub const MAX_LAYERS: usize = LAYERS_PER_MEMBER as usize;
/// Ticks of the crowd's clock in a second: a multiple of the usual frame rates (24, 25, 30, 50, 60, 120, 144), so that
/// whole frames are whole numbers of ticks.
pub const TICKS_PER_SEC: u64 = 705_600;
/// One tick in seconds, rounded to single precision.
pub(crate) const TICK_SECS: f32 = 1.0 / 705_600.0;

/// Ticks in a time, rounded to the nearest.
///
/// Negative and non-finite times give 0.
#[must_use]
pub fn ticks_from_secs(secs: f64) -> u64 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "`as` saturates, which is wanted"
    )]
    let ticks = (secs * TICKS_PER_SEC as f64).round() as u64;
    ticks
}

impl Slot {
    /// A slot that loops over a clip.
    ///
    /// `phase` is where it starts, from 0 to 1; `speed` is 1 for the clip's own pace and negative for backwards.
    #[must_use]
    pub fn looping(bound_clip: u32, tick: u64, duration_secs: f32, phase: f64, speed: f32) -> Self {
        Self {
            start_phase: fraction(phase),
            phase_rate: phase_rate(duration_secs, speed),
            mode: SLOT_LOOP,
            ..Self::still(bound_clip, tick)
        }
    }

    /// A slot that plays a clip once, from its start (from its end where `speed` is negative), and holds its end.
    #[must_use]
    pub fn once(bound_clip: u32, tick: u64, start_secs: f32, duration_secs: f32, speed: f32) -> Self {
        let backwards = speed < 0.0;
        let hold_ticks = if speed == 0.0 {
            u64::MAX
        } else {
            ticks_from_secs(f64::from(duration_secs) / f64::from(speed.abs()))
        };
        Self {
            // A whole cycle wraps to 0, so backwards starts one step below it.
            start_phase: if backwards { u64::MAX } else { 0 },
            phase_rate: phase_rate(duration_secs, speed),
            hold_ticks,
            mode: SLOT_ONCE,
            held_secs: if backwards { start_secs } else { start_secs + duration_secs },
            ..Self::still(bound_clip, tick)
        }
    }

    /// A slot that stands at one time on the clip's own axis; before the first key the first value holds, after the
    /// last the last.
    #[must_use]
    pub fn held(bound_clip: u32, tick: u64, held_secs: f32) -> Self {
        Self { mode: SLOT_HELD, held_secs, ..Self::still(bound_clip, tick) }
    }

    fn still(bound_clip: u32, tick: u64) -> Self {
        Self {
            start_tick: tick,
            bound_clip,
            hold_ticks: u64::MAX,
            start_weight: 1.0,
            end_weight: 1.0,
            weight_tick: tick,
            ..Self::default()
        }
    }

    /// Puts the slot into a layer.
    #[must_use]
    pub fn on_layer(mut self, layer: u32) -> Self {
        self.layer = layer;
        self
    }

    /// Gives the slot a constant weight.
    #[must_use]
    pub fn with_weight(mut self, weight: f32) -> Self {
        self.ramp_weight(self.start_tick, weight, weight, 0.0);
        self
    }

    /// Lets the weight run from `from` to `to` in `secs`, beginning at `tick`; at once where `secs` is not above zero.
    pub fn ramp_weight(&mut self, tick: u64, from: f32, to: f32, secs: f32) {
        let ramps = secs > 0.0 && from != to;
        self.start_weight = if ramps { from } else { to };
        self.end_weight = to;
        self.weight_rate = if ramps { (to - from) / secs } else { 0.0 };
        self.weight_tick = tick;
    }

    /// The weight at a time of the clock, 0 before the slot begins; the twin of `slot_weight` in
    /// `kernels/evaluate.cl`.
    #[inline]
    #[must_use]
    pub fn weight_at(&self, tick: u64) -> f32 {
        if tick < self.start_tick {
            return 0.0;
        }
        let elapsed_secs = tick.saturating_sub(self.weight_tick) as f32 * TICK_SECS;
        let weight = self.start_weight + self.weight_rate * elapsed_secs;
        let rising = self.weight_rate >= 0.0;
        if (rising && weight > self.end_weight) || (!rising && weight < self.end_weight) {
            self.end_weight
        } else {
            weight
        }
    }

    /// The time on the clip's own axis at a time of the clock that is not before the start; the twin of `slot_time` in `kernels/evaluate.cl`.
    #[inline]
    #[must_use]
    pub fn time_at(&self, tick: u64, start_secs: f32, duration_secs: f32) -> f32 {
        let elapsed = tick.wrapping_sub(self.start_tick);
        if self.mode == SLOT_HELD || (self.mode == SLOT_ONCE && elapsed >= self.hold_ticks) {
            return self.held_secs;
        }
        let phase = self.start_phase.wrapping_add(elapsed.wrapping_mul(self.phase_rate));
        // The upper 24 bits are exact in single precision and never round up to a whole cycle.
        start_secs + (phase >> 40) as f32 * (1.0 / 16_777_216.0) * duration_secs
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a fraction of 2^64; `as` saturates"
)]
fn fraction(phase: f64) -> u64 {
    (phase.rem_euclid(1.0) * 18_446_744_073_709_551_616.0) as u64
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "two's complement carries the sign"
)]
fn phase_rate(duration_secs: f32, speed: f32) -> u64 {
    if duration_secs <= 0.0 {
        return 0;
    }
    let cycles_per_tick = f64::from(speed) / f64::from(duration_secs) / TICKS_PER_SEC as f64;
    (cycles_per_tick * 18_446_744_073_709_551_616.0) as i64 as u64
}

/// How a layer meets what lies beneath it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LayerMode {
    /// The layer's mix replaces what lies beneath, by layer weight times mask.
    #[default]
    Override,
    /// Each slot's difference from its clip's first row is added, by slot weight times layer weight times mask.
    Additive,
}

impl LayerMode {
    /// The `LAYER_` constant of the device.
    #[must_use]
    pub const fn device_value(self) -> u32 {
        match self {
            Self::Override => LAYER_OVERRIDE,
            Self::Additive => LAYER_ADDITIVE,
        }
    }
}

/// A layer as a user sets it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerSettings {
    /// How the layer meets what lies beneath it. Layer 0 lies over the rest pose and always overrides.
    pub mode: LayerMode,
    /// From 0 to 1; not looked at in layer 0.
    pub weight: f32,
}

impl Default for LayerSettings {
    fn default() -> Self {
        Self { mode: LayerMode::Override, weight: 1.0 }
    }
}

/// A weight per joint of one skeleton: 1 = affected, 0 = left alone.
#[derive(Clone, Debug, PartialEq)]
pub struct Mask {
    weights: Vec<f32>,
}

impl Mask {
    /// From one weight per joint, in level order.
    ///
    /// # Errors
    ///
    /// [`Error::BadMask`] where the number of weights is not the number of joints, or one is not from 0 to 1.
    pub fn new(skeleton: &Skeleton, weights: Vec<f32>) -> Result<Self, Error> {
        let good = weights.len() == skeleton.joint_count() && weights.iter().all(|w| (0.0..=1.0).contains(w));
        if good {
            Ok(Self { weights })
        } else {
            Err(Error::BadMask { weights: weights.len(), joints: skeleton.joint_count() })
        }
    }

    /// Weight 1 for a joint and all that hangs on it, 0 for the rest.
    #[must_use]
    pub fn subtree(skeleton: &Skeleton, root: JointIndex) -> Self {
        let mut weights = vec![0.0; skeleton.joint_count()];
        for joint in skeleton.joints() {
            let inherited = skeleton.parent(joint).map_or(0.0, |p| weights[p.index()]);
            weights[joint.index()] = if joint == root { 1.0 } else { inherited };
        }
        Self { weights }
    }

    /// The weight of each joint, in level order.
    #[must_use]
    pub fn weights(&self) -> &[f32] {
        &self.weights
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_loop_keeps_its_phase_for_a_year() {
        let slot = Slot::looping(0, 0, 1.25, 0.25, 1.0);
        let year = 31_536_000 * TICKS_PER_SEC; // a whole number of 1.25 s cycles
        let time = slot.time_at(year, 0.5, 1.25);
        // The rate is rounded to 2^-64 of a cycle per tick: over a year of ticks, 2^-64 * 2.2e13 of a cycle.
        assert!((time - (0.5 + 0.25 * 1.25)).abs() < 3e-6, "{time}");
    }

    #[test]
    fn backwards_starts_at_the_end_and_holds_the_start() {
        let slot = Slot::once(0, 100, 0.5, 2.0, -2.0);
        assert!((slot.time_at(100, 0.5, 2.0) - 2.5).abs() < 1e-6);
        assert!((slot.time_at(100 + TICKS_PER_SEC / 2, 0.5, 2.0) - 1.5).abs() < 1e-6);
        assert_eq!(slot.time_at(100 + TICKS_PER_SEC, 0.5, 2.0), 0.5);
        assert_eq!(slot.time_at(100 + 50 * TICKS_PER_SEC, 0.5, 2.0), 0.5);
    }

    #[test]
    fn once_reaches_its_end_exactly_and_stays() {
        let slot = Slot::once(0, 0, 0.0, 0.75, 1.0);
        assert_eq!(slot.time_at(ticks_from_secs(0.75), 0.0, 0.75), 0.75);
        assert_eq!(slot.time_at(ticks_from_secs(75.0), 0.0, 0.75), 0.75);
    }

    #[test]
    fn weights_ramp_and_stop() {
        let mut slot = Slot::held(0, 0, 0.0);
        slot.ramp_weight(TICKS_PER_SEC, 1.0, 0.25, 0.5);
        assert_eq!(slot.weight_at(TICKS_PER_SEC), 1.0);
        assert!((slot.weight_at(TICKS_PER_SEC * 5 / 4) - 0.625).abs() < 1e-6);
        assert_eq!(slot.weight_at(TICKS_PER_SEC * 9), 0.25);
    }

    #[test]
    fn a_slot_of_the_future_weighs_nothing_until_its_time() {
        let mut slot = Slot::once(0, 100, 0.0, 1.0, 1.0);
        assert_eq!((slot.weight_at(99), slot.weight_at(100)), (0.0, 1.0));
        slot.ramp_weight(100 + TICKS_PER_SEC, 0.25, 1.0, 1.0);
        assert_eq!(slot.weight_at(200), 0.25, "the ramp has not begun");
    }

    #[test]
    fn usual_frame_rates_are_whole_ticks() {
        for rate in [24, 25, 30, 48, 50, 60, 72, 90, 100, 120, 144] {
            assert_eq!(TICKS_PER_SEC % rate, 0, "{rate}");
        }
    }
}
