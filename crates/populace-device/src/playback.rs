//! Slots, layers and masks: the clips that a member plays, and how they are mixed.

mod inertialize;
mod pace;

use populace_clip::{TICK_SECS, TICKS_PER_SEC, ticks_from_secs};

use crate::layout::{
    self, LAYER_ADDITIVE, LAYER_MASK, LAYERS_PER_MEMBER, Layer, SLOT_HELD, SLOT_LIVE, SLOT_LOOP,
    SLOT_MACHINE, SLOT_MODE_BITS, SLOT_ONCE, Slot,
};

pub use inertialize::{SampledState, far_row, row_before};

/// Maximum number of slots of a member.
pub const MAX_SLOTS: usize = layout::MAX_SLOTS as usize;
/// Maximum number of layers of a member.
pub const MAX_LAYERS: usize = LAYERS_PER_MEMBER as usize;
/// A weight that runs from `start` by `rate` per second to `end`; the twin of `ramp` in
/// `kernels/slot.cl`.
#[inline]
#[must_use]
pub(crate) fn ramp(elapsed_ticks: u64, start: f32, rate: f32, end: f32) -> f32 {
    let weight = start + rate * (elapsed_ticks as f32 * TICK_SECS);
    let rising = rate >= 0.0;
    if (rising && weight > end) || (!rising && weight < end) { end } else { weight }
}

/// Returns the rate per second of a weight that changes `from` one value `to` another in `secs`, at
/// least one tick. Returns 0 for an immediate change.
#[inline]
pub(crate) fn ramp_rate(from: f32, to: f32, secs: f32) -> f32 {
    if secs > 0.0 { (to - from) / secs.max(TICK_SECS) } else { 0.0 }
}

/// Returns whether a ramp leads to `to` and was created with this `secs`, be it finished or not.
pub(crate) fn is_ramp_to([start, rate, end]: [f32; 3], to: f32, secs: f32) -> bool {
    end == to && rate == ramp_rate(start, to, secs)
}

impl Slot {
    /// Creates a slot that loops over a clip.
    ///
    /// `phase` is where it starts, from 0 to 1. `speed` is 1 for the clip's own speed and negative
    /// for backward playback.
    #[must_use]
    #[inline]
    pub fn looping(bound_clip: u32, tick: u64, duration_secs: f32, phase: f64, speed: f32) -> Self {
        Self {
            start_phase: fraction(phase),
            phase_rate: phase_rate(duration_secs, speed),
            ..Self::still(bound_clip, tick, SLOT_LOOP)
        }
    }

    /// Creates a slot that plays a clip once, from its start (from its end if `speed` is negative),
    /// and then holds the last pose.
    ///
    /// The end is reached at `ticks_from_secs(duration_secs / speed.abs())` after `tick`; this is
    /// exact for durations of up to an hour and a half. A duration of 3 ticks (4 microseconds) or
    /// less takes 3 ticks. A speed of 0 never reaches the end.
    #[must_use]
    pub fn once(bound_clip: u32, tick: u64, duration_secs: f32, speed: f32) -> Self {
        Self {
            phase_rate: once_rate(duration_secs, speed),
            ..Self::still(bound_clip, tick, SLOT_ONCE)
        }
    }

    /// Creates a slot that samples one fixed time on the clip's own axis. Before the first key the
    /// first value holds, after the last key the last.
    #[must_use]
    pub fn held(bound_clip: u32, tick: u64, held_secs: f32) -> Self {
        Self { start_phase: held_secs.to_bits(), ..Self::still(bound_clip, tick, SLOT_HELD) }
    }

    /// Creates a slot that plays a live clip with a delay of `delay_ticks`.
    #[must_use]
    pub fn live(bound_clip: u32, tick: u64, delay_ticks: u64) -> Self {
        Self { phase_rate: delay_ticks, ..Self::still(bound_clip, tick, SLOT_LIVE) }
    }

    /// Creates one of the two slots of a state machine; `which` is 0 or 1. See
    /// [`Tables::add_machine_instance`](crate::Tables::add_machine_instance).
    #[must_use]
    pub fn machine(machine_instance: u32, which: u32, tick: u64) -> Self {
        Self::still(machine_instance << 1 | which, tick, SLOT_MACHINE)
    }

    /// The machine instance that the slot refers to, if its mode is [`SLOT_MACHINE`].
    #[inline]
    #[must_use]
    pub const fn machine_instance(&self) -> Option<u32> {
        if self.mode() == SLOT_MACHINE { Some(self.bound_clip >> 1) } else { None }
    }

    /// Creates a looping slot with a given phase at `tick`, in 2^-64 of a cycle, and a rate of
    /// `cycles_per_sec` that is independent of the clip's length. The slots of a blend space share
    /// their phase this way.
    #[must_use]
    pub fn in_phase(bound_clip: u32, tick: u64, phase: u64, cycles_per_sec: f64) -> Self {
        Self {
            start_phase: upper_half(phase),
            phase_rate: rate_from_cycles(cycles_per_sec),
            ..Self::still(bound_clip, tick, SLOT_LOOP)
        }
    }

    #[inline]
    fn still(bound_clip: u32, tick: u64, mode: u32) -> Self {
        Self {
            start_tick: tick,
            bound_clip,
            layer_and_mode: mode,
            start_weight: 1.0,
            end_weight: 1.0,
            weight_tick: tick,
            ..Self::default()
        }
    }

    /// Moves the slot to a layer. Layers of 2^24 or above, which no member has, become the last one
    /// below that.
    #[inline]
    #[must_use]
    pub fn on_layer(mut self, layer: u32) -> Self {
        self.layer_and_mode = layer.min(u32::MAX >> SLOT_MODE_BITS) << SLOT_MODE_BITS | self.mode();
        self
    }

    /// The layer that the slot is mixed in.
    #[inline]
    #[must_use]
    pub const fn layer(&self) -> u32 {
        self.layer_and_mode >> SLOT_MODE_BITS
    }

    /// The `SLOT_` mode.
    #[inline]
    #[must_use]
    pub const fn mode(&self) -> u32 {
        self.layer_and_mode & ((1 << SLOT_MODE_BITS) - 1)
    }

    /// The time at which a slot of [`SLOT_HELD`] samples its clip, in seconds on the clip's own
    /// axis. Meaningless for other slots. Twin of `slot_held_secs` in `kernels/slot.cl`.
    #[inline]
    #[must_use]
    pub const fn held_secs(&self) -> f32 {
        f32::from_bits(self.start_phase)
    }

    /// The delay in ticks of a slot of [`SLOT_LIVE`]. Meaningless for other slots. Twin of
    /// `slot_delay_ticks` in `kernels/slot.cl`.
    #[inline]
    #[must_use]
    pub const fn delay_ticks(&self) -> u64 {
        self.phase_rate
    }

    /// Gives the slot a constant weight.
    #[must_use]
    pub fn with_weight(mut self, weight: f32) -> Self {
        self.ramp_weight(self.start_tick, weight, weight, 0.0);
        self
    }

    /// Changes the weight `from` one value `to` another in `secs`, at least one tick, beginning at
    /// `tick`. The change is immediate if `secs` is not above zero.
    #[inline]
    pub fn ramp_weight(&mut self, tick: u64, from: f32, to: f32, secs: f32) {
        let rate = ramp_rate(from, to, secs);
        // A weight that falls immediately keeps the earlier weight in `start_weight`.
        self.start_weight = if rate != 0.0 || from > to { from } else { to };
        self.end_weight = to;
        self.weight_rate = rate;
        self.weight_tick = tick;
    }

    /// Returns whether the weight is on, or at the end of, a ramp to `to` that was created with
    /// this `secs`.
    #[must_use]
    pub fn ramps_to(&self, to: f32, secs: f32) -> bool {
        is_ramp_to([self.start_weight, self.weight_rate, self.end_weight], to, secs)
    }

    /// The weight at a clock tick; 0 before the slot begins and for inertialization slots. Twin of
    /// `slot_weight` in `kernels/slot.cl`.
    #[inline]
    #[must_use]
    pub fn weight_at(&self, tick: u64) -> f32 {
        if tick < self.start_tick || self.is_inertialization() {
            return 0.0;
        }
        ramp(
            tick.saturating_sub(self.weight_tick),
            self.start_weight,
            self.weight_rate,
            self.end_weight,
        )
    }

    /// The mean weight between two clock ticks. `from_tick` must not be before the slot begins.
    /// Twin of `slot_mean_weight` in `kernels/slot.cl`.
    #[inline]
    #[must_use]
    pub fn mean_weight(&self, from_tick: u64, to_tick: u64) -> f32 {
        let end = self.weight_at(to_tick);
        let start = if from_tick < self.weight_tick {
            self.start_weight
        } else {
            self.weight_at(from_tick)
        };
        if start == end || self.is_inertialization() {
            return end;
        }
        // Ticks before the ramp, and half the ticks of the ramp.
        let still = self.weight_tick.saturating_sub(from_tick) as f32;
        let per_tick = self.weight_rate * TICK_SECS;
        let half = if per_tick == 0.0 { 0.0 } else { 0.5 * ((end - start) / per_tick) };
        end + (start - end) * ((still + half) / (to_tick - from_tick) as f32)
    }

    /// The time on the clip's own axis at a clock tick that is not before the start, for a clip
    /// whose axis begins at `start_secs`. Meaningless for live and inertialization slots. Twin of
    /// `slot_time` in `kernels/slot.cl`.
    #[inline]
    #[must_use]
    pub fn time_at(&self, tick: u64, start_secs: f32, duration_secs: f32) -> f32 {
        if self.mode() == SLOT_HELD {
            return self.held_secs();
        }
        let elapsed = tick.wrapping_sub(self.start_tick);
        let mut phase = self.phase_at(tick);
        if self.mode() == SLOT_ONCE {
            let backwards = self.phase_rate >> 63 != 0;
            let rate = if backwards { self.phase_rate.wrapping_neg() } else { self.phase_rate };
            if (u128::from(elapsed) * u128::from(rate)) >> 64 != 0 {
                return if backwards { start_secs } else { start_secs + duration_secs };
            }
            // A whole cycle would wrap to none, so backward playback begins one step below it.
            phase =
                if backwards { !elapsed.wrapping_mul(rate) } else { elapsed.wrapping_mul(rate) };
        }
        // The upper 24 bits are exact in single precision and never round up to a whole cycle.
        start_secs + (phase >> 40) as f32 * (1.0 / 16_777_216.0) * duration_secs
    }

    /// Number of times that a looping slot passes an end of its clip between two clock ticks; 0 for
    /// other slots. `from_tick` must not be before the slot's start. Twin of `slot_cycles` in
    /// `kernels/slot.cl`.
    #[inline]
    #[must_use]
    pub fn cycles_between(&self, from_tick: u64, to_tick: u64) -> u64 {
        if self.mode() != SLOT_LOOP {
            return 0;
        }
        let backwards = self.phase_rate >> 63 != 0;
        let rate = if backwards { self.phase_rate.wrapping_neg() } else { self.phase_rate };
        let (elapsed, phase) = (to_tick.wrapping_sub(from_tick), self.phase_at(from_tick));
        let whole = (u128::from(elapsed) * u128::from(rate)) >> 64;
        let part = elapsed.wrapping_mul(rate);
        let passes = if backwards { part > phase } else { phase.wrapping_add(part) < part };
        u64::try_from(whole).unwrap_or(u64::MAX) + u64::from(passes)
    }
}

const fn upper_half(phase: u64) -> u32 {
    (phase >> 32) as u32
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a fraction of 2^32; `as` saturates"
)]
#[inline]
fn fraction(phase: f64) -> u32 {
    // The remainder is slow, and seldom changes the phase.
    let phase = if (0.0..1.0).contains(&phase) { phase } else { phase.rem_euclid(1.0) };
    (phase * 4_294_967_296.0) as u32
}

/// Converts cycles per second to phase per tick, in 2^-64 of a cycle, two's complement.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "two's complement carries the sign"
)]
#[inline]
pub(crate) fn rate_from_cycles(per_sec: f64) -> u64 {
    (per_sec / TICKS_PER_SEC as f64 * 18_446_744_073_709_551_616.0) as i64 as u64
}

#[inline]
fn phase_rate(duration_secs: f32, speed: f32) -> u64 {
    if duration_secs <= 0.0 {
        0
    } else {
        rate_from_cycles(f64::from(speed) / f64::from(duration_secs))
    }
}

/// Returns the phase per tick that completes one cycle in exactly the number of ticks that the
/// duration rounds to. It is rounded up, so that the cycle is full at the last tick. For up to 2^32
/// ticks it is then not yet full at the tick before.
fn once_rate(duration_secs: f32, speed: f32) -> u64 {
    if duration_secs <= 0.0 || speed == 0.0 {
        return 0;
    }
    let ticks = ticks_from_secs(f64::from(duration_secs) / f64::from(speed.abs()));
    // With fewer than three ticks the rate would leave no bit for the sign.
    let ticks = u128::from(ticks.max(3));
    let rate = u64::try_from((1_u128 << 64).div_ceil(ticks)).unwrap_or(0);
    if speed < 0.0 { rate.wrapping_neg() } else { rate }
}

/// Combination of a layer with the layers below it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LayerMode {
    /// The layer's mix replaces the layers below, by layer weight times mask.
    #[default]
    Override,
    /// Each slot's difference from the first row of its clip is added, by slot weight times layer
    /// weight times mask.
    Additive,
}

/// Settings of a layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerSettings {
    /// Combination with the layers below. Layer 0 covers the rest pose and always overrides.
    pub mode: LayerMode,
    /// Weight from 0 to 1; ignored for layer 0.
    pub weight: f32,
}

impl Default for LayerSettings {
    fn default() -> Self {
        Self { mode: LayerMode::Override, weight: 1.0 }
    }
}

impl Layer {
    /// Creates a layer for all joints, or one with the mask at an offset of
    /// [`Tables::masks`](crate::Tables::masks). Offsets of [`LAYER_MASK`] and above, which no mask
    /// can have, become the last one below that.
    #[must_use]
    pub fn new(settings: LayerSettings, mask: Option<u32>) -> Self {
        let mode = match settings.mode {
            LayerMode::Override => 0,
            LayerMode::Additive => LAYER_ADDITIVE,
        };
        let mask = mask.map_or(LAYER_MASK, |first| first.min(LAYER_MASK - 1));
        Self { weight: settings.weight, mask_and_mode: mask | mode }
    }

    /// Offset of the layer's mask in [`Tables::masks`](crate::Tables::masks); `None` for all
    /// joints.
    #[inline]
    #[must_use]
    pub fn mask(&self) -> Option<u32> {
        Some(self.mask_and_mode & LAYER_MASK).filter(|first| *first != LAYER_MASK)
    }

    /// Returns whether the layer adds to the layers below instead of replacing them.
    #[inline]
    #[must_use]
    pub const fn is_additive(&self) -> bool {
        self.mask_and_mode & LAYER_ADDITIVE != 0
    }
}

#[cfg(test)]
mod tests;
