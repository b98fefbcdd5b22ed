//! Inertialization: the difference in pose and velocity between an outgoing clip and the clip that
//! replaces it at once, which then decays by itself (Bollo, "Inertialization: high-performance
//! animation transitions in Gears of War", GDC 2018).

use populace_clip::TICKS_PER_SEC;

use crate::layout::{NONE, SLOT_HELD, SLOT_INERTIALIZATION, SLOT_LOOP, SLOT_ONCE, Slot};

/// The sampled state of a clip at one instant: its row and its pace.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SampledState {
    /// Index into `bound_clips`.
    pub bound_clip: u32,
    /// Fractional row: the row at or before the sampled time, plus the fraction of the way to the
    /// next.
    pub row: f32,
    /// Rate per second in units of the difference between `row` and the [`far_row`].
    pub pace: f32,
}

/// Returns the row that a clip's velocity is measured towards: of the two rows around `at`, the one
/// further away. Twin of `far_row` in `kernels/inertialize.cl`.
#[inline]
#[must_use]
pub fn far_row(at: f32, last: u32) -> u32 {
    let row = row_before(at, last);
    match at - row as f32 {
        between if between >= 0.5 => row,
        _ if row < last => row + 1,
        _ => last.saturating_sub(1),
    }
}

/// Returns the row at or before the fractional row `at`.
#[inline]
#[must_use]
pub fn row_before(at: f32, last: u32) -> u32 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "truncation is intended"
    )]
    let row = at as u32;
    row.min(last)
}

impl Slot {
    /// Creates a slot that holds the difference at `tick` between an outgoing clip and the incoming
    /// clip that replaces it. The difference decays in `ticks`, at least 1. `share` is the weight
    /// of the outgoing clip in the layer's mix, and the change of that weight per second. The
    /// shares of all clips that are replaced at once sum to 1, in an additive layer to their total
    /// weight.
    #[must_use]
    pub fn inertialization(
        tick: u64,
        ticks: u64,
        [outgoing, incoming]: [SampledState; 2],
        share: [f32; 2],
    ) -> Self {
        let secs = secs_of(ticks);
        Self {
            start_tick: tick,
            phase_rate: pack(outgoing.row, outgoing.pace * secs),
            weight_tick: pack(incoming.row, incoming.pace * secs),
            start_phase: incoming.bound_clip,
            bound_clip: outgoing.bound_clip,
            layer_and_mode: SLOT_INERTIALIZATION,
            start_weight: share[0],
            weight_rate: share[1] * secs,
            end_weight: per_tick(ticks),
        }
    }

    /// Changes the incoming clip and the duration of a slot of [`SLOT_INERTIALIZATION`] whose
    /// incoming clip has never been evaluated. The start tick stays.
    pub fn inertialize_into(&mut self, incoming: SampledState, ticks: u64) {
        let (outgoing, before) = (self.left(), secs_of(1) / self.end_weight);
        let outgoing = SampledState { pace: outgoing.pace / before, ..outgoing };
        let share = [self.start_weight, self.weight_rate / before];
        *self = Self::inertialization(self.start_tick, ticks, [outgoing, incoming], share)
            .on_layer(self.layer());
    }

    /// Returns whether the slot's clip is a function of the clock alone and can be inertialized: it
    /// loops, plays once or is held.
    #[inline]
    #[must_use]
    pub const fn can_inertialize(&self) -> bool {
        matches!(self.mode(), SLOT_LOOP | SLOT_ONCE | SLOT_HELD)
    }

    /// Returns whether the slot is an inertialization slot.
    #[inline]
    #[must_use]
    pub const fn is_inertialization(&self) -> bool {
        self.mode() == SLOT_INERTIALIZATION
    }

    /// The elapsed fraction of an inertialization slot's duration. The slot has no effect from 1
    /// on, nor before its start. Twin of `slot_inertialized` in `kernels/slot.cl`.
    #[inline]
    #[must_use]
    pub const fn inertialized_at(&self, tick: u64) -> f32 {
        tick.wrapping_sub(self.start_tick) as f32 * self.end_weight
    }

    /// Returns whether the slot is an inertialization slot that still has an effect. Twin of
    /// `slot_inertializes` in `kernels/slot.cl`.
    #[inline]
    #[must_use]
    pub const fn inertializes(&self, tick: u64) -> bool {
        self.is_inertialization() && self.bound_clip != NONE && self.inertialized_at(tick) < 1.0
    }

    /// A tick at which an inertialization slot has no effect any more, at most a few ticks after
    /// the first such tick.
    #[must_use]
    pub fn inertialization_tick(&self) -> u64 {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "`as` saturates"
        )]
        let ticks = (1.0 / f64::from(self.end_weight)).ceil() as u64;
        self.start_tick.saturating_add(ticks)
    }

    /// The sampled state of the outgoing clip of an inertialization slot. Its pace is per duration
    /// of the inertialization, not per second.
    #[inline]
    #[must_use]
    pub const fn left(&self) -> SampledState {
        let [row, pace] = unpack(self.phase_rate);
        SampledState { bound_clip: self.bound_clip, row, pace }
    }

    /// The sampled state of the incoming clip of an inertialization slot, with the pace per
    /// duration as well.
    #[inline]
    #[must_use]
    pub const fn taking(&self) -> SampledState {
        let [row, pace] = unpack(self.weight_tick);
        SampledState { bound_clip: self.start_phase, row, pace }
    }
}

fn secs_of(ticks: u64) -> f32 {
    ticks as f32 / TICKS_PER_SEC as f32
}

/// Returns 1 divided by `ticks`, rounded so that `ticks` times the result is at least 1.
fn per_tick(ticks: u64) -> f32 {
    let per_tick = 1.0 / ticks.max(1) as f32;
    if ticks as f32 * per_tick < 1.0 { per_tick.next_up() } else { per_tick }
}

fn pack(low: f32, high: f32) -> u64 {
    u64::from(high.to_bits()) << 32 | u64::from(low.to_bits())
}

#[expect(clippy::cast_possible_truncation, reason = "its two halves")]
const fn unpack(packed: u64) -> [f32; 2] {
    [f32::from_bits(packed as u32), f32::from_bits((packed >> 32) as u32)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use populace_clip::FIRST_TICK;

    #[test]
    fn inertialization_slot_has_no_weight_and_ends_on_its_tick() {
        for ticks in [1, 3, 7, 211_680, 705_600, 1_000_003] {
            let states =
                [1, 2].map(|clip| SampledState { bound_clip: clip, row: 3.25, pace: -2.0 });
            let mut slot = Slot::inertialization(FIRST_TICK, ticks, states, [0.5, 4.0]).on_layer(2);
            for ticks in [ticks, 2 * ticks] {
                assert!(
                    slot.inertialized_at(FIRST_TICK + ticks) >= 1.0
                        && slot.inertialized_at(FIRST_TICK - 1) >= 1.0
                );
                assert!(slot.inertialized_at(FIRST_TICK + ticks - 1) < 1.0, "{ticks}");
                assert!(slot.inertialization_tick().abs_diff(FIRST_TICK + ticks) <= 1, "{ticks}");
                assert_eq!(
                    (slot.weight_at(FIRST_TICK + 1), slot.layer(), slot.is_inertialization()),
                    (0.0, 2, true)
                );
                let secs = ticks as f32 / TICKS_PER_SEC as f32;
                let near = |found: f32, wanted: f32| (found - wanted).abs() <= wanted.abs() * 1e-5;
                assert!(near(slot.left().pace, -2.0 * secs) && near(slot.weight_rate, 4.0 * secs));
                assert_eq!((slot.left().bound_clip, slot.taking().row), (1, 3.25));
                slot.inertialize_into(SampledState { bound_clip: 7, ..states[1] }, 2 * ticks);
                assert_eq!(slot.taking().bound_clip, 7);
            }
        }
    }

    #[test]
    fn far_row_is_never_the_nearest() {
        for (at, far) in [(0.0, 1), (0.4, 1), (0.5, 0), (2.75, 2), (4.0, 3), (9.0, 4)] {
            assert_eq!(far_row(at, 4), far, "{at}");
        }
        assert_eq!((far_row(0.0, 0), far_row(f32::NAN, 2)), (0, 1));
    }
}
