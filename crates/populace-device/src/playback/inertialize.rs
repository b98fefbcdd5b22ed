//! Inertialization: the difference in pose and velocity between an outgoing clip and the clip that
//! replaces it at once, which then decays by itself (Bollo, "Inertialization: high-performance
//! animation transitions in Gears of War", GDC 2018).

use populace_clip::TICKS_PER_SEC;

use crate::layout::{
    InertializationSlot, NONE, SLOT_HELD, SLOT_INERTIALIZATION, SLOT_LOOP, SLOT_ONCE, Slot,
};

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
    /// clip that replaces it. See [`InertializationSlot::new`].
    #[must_use]
    pub fn inertialization(
        tick: u64,
        ticks: u64,
        states: [SampledState; 2],
        share: [f32; 2],
    ) -> Self {
        InertializationSlot::new(tick, ticks, states, share).into()
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

    /// The same bytes as an inertialization slot; `None` for a slot of another mode. Twin of
    /// `as_inertialization` in `kernels/slot.cl`, whose callers check the mode.
    #[inline]
    #[must_use]
    pub fn as_inertialization(&self) -> Option<&InertializationSlot> {
        self.is_inertialization().then(|| bytemuck::must_cast_ref(self))
    }

    /// Returns whether the slot is an inertialization slot that still has an effect. Twin of
    /// `slot_inertializes` in `kernels/slot.cl`.
    #[inline]
    #[must_use]
    pub fn inertializes(&self, tick: u64) -> bool {
        self.as_inertialization()
            .is_some_and(|slot| slot.outgoing_clip != NONE && slot.inertialized_at(tick) < 1.0)
    }
}

impl From<InertializationSlot> for Slot {
    /// Takes over the bytes. The mode becomes [`SLOT_INERTIALIZATION`], whatever it was.
    fn from(inertialization: InertializationSlot) -> Self {
        let slot: Self = bytemuck::must_cast(inertialization);
        Self { layer_and_mode: SLOT_INERTIALIZATION, ..slot }.on_layer(slot.layer())
    }
}

impl InertializationSlot {
    /// Creates a slot of layer 0 that holds the difference at `tick` between an outgoing clip and
    /// the incoming clip that replaces it. The difference decays in `ticks`, at least 1. `share` is
    /// the weight of the outgoing clip in the layer's mix, and the change of that weight per
    /// second. The shares of all clips that are replaced at once sum to 1, in an additive layer to
    /// their total weight.
    #[must_use]
    pub fn new(
        tick: u64,
        ticks: u64,
        [outgoing, incoming]: [SampledState; 2],
        share: [f32; 2],
    ) -> Self {
        let secs = secs_of(ticks);
        Self {
            start_tick: tick,
            outgoing_row: outgoing.row,
            outgoing_pace: outgoing.pace * secs,
            incoming_row: incoming.row,
            incoming_pace: incoming.pace * secs,
            incoming_clip: incoming.bound_clip,
            outgoing_clip: outgoing.bound_clip,
            layer_and_mode: SLOT_INERTIALIZATION,
            share: share[0],
            share_change: share[1] * secs,
            per_tick: per_tick(ticks),
        }
    }

    /// Returns the slot with another incoming clip and another duration in ticks. The start tick
    /// stays. Meant for a slot whose incoming clip has never been evaluated.
    #[must_use]
    pub fn with_incoming(&self, incoming: SampledState, ticks: u64) -> Self {
        let (outgoing, before) = (self.outgoing_state(), secs_of(1) / self.per_tick);
        let outgoing = SampledState { pace: outgoing.pace / before, ..outgoing };
        let share = [self.share, self.share_change / before];
        let slot = Self::new(self.start_tick, ticks, [outgoing, incoming], share);
        Self { layer_and_mode: self.layer_and_mode, ..slot }
    }

    /// The elapsed fraction of the duration. The slot has no effect from 1 on, nor before its
    /// start. Twin of `inertialized_at` in `kernels/slot.cl`.
    #[inline]
    #[must_use]
    pub const fn inertialized_at(&self, tick: u64) -> f32 {
        tick.wrapping_sub(self.start_tick) as f32 * self.per_tick
    }

    /// A tick at which the slot has no effect any more, at most a few ticks after the first such
    /// tick.
    #[must_use]
    pub fn end_tick(&self) -> u64 {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "`as` saturates"
        )]
        let ticks = (1.0 / f64::from(self.per_tick)).ceil() as u64;
        self.start_tick.saturating_add(ticks)
    }

    /// The sampled state of the outgoing clip. Its pace is per duration of the inertialization, not
    /// per second. Twin of `outgoing_state` in `kernels/inertialize.cl`.
    #[inline]
    #[must_use]
    pub const fn outgoing_state(&self) -> SampledState {
        SampledState {
            bound_clip: self.outgoing_clip,
            row: self.outgoing_row,
            pace: self.outgoing_pace,
        }
    }

    /// The sampled state of the incoming clip, with the pace per duration as well. Twin of
    /// `incoming_state` in `kernels/inertialize.cl`.
    #[inline]
    #[must_use]
    pub const fn incoming_state(&self) -> SampledState {
        SampledState {
            bound_clip: self.incoming_clip,
            row: self.incoming_row,
            pace: self.incoming_pace,
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{SLOT_LIVE, SLOT_MACHINE, SLOT_MODE_BITS};
    use populace_clip::FIRST_TICK;

    #[test]
    fn inertialization_slot_has_no_weight_and_ends_on_its_tick() {
        for ticks in [1, 3, 7, 211_680, 705_600, 1_000_003] {
            let states =
                [1, 2].map(|clip| SampledState { bound_clip: clip, row: 3.25, pace: -2.0 });
            let slot = Slot::inertialization(FIRST_TICK, ticks, states, [0.5, 4.0]).on_layer(2);
            let view = *slot.as_inertialization().unwrap();
            for (view, ticks) in [(view, ticks), (view.with_incoming(states[0], 7), 7)] {
                let end = FIRST_TICK + ticks;
                assert!(view.inertialized_at(end) >= 1.0);
                assert!(view.inertialized_at(FIRST_TICK - 1) >= 1.0);
                assert!(view.inertialized_at(end - 1) < 1.0, "{ticks}");
                assert!(view.end_tick().abs_diff(end) <= 1, "{ticks}");
                let slot = Slot::from(view);
                assert!(slot.inertializes(end - 1) && !slot.inertializes(end), "{ticks}");
                assert_eq!(
                    (slot.weight_at(FIRST_TICK + 1), slot.layer(), slot.is_inertialization()),
                    (0.0, 2, true)
                );
                let secs = ticks as f32 / TICKS_PER_SEC as f32;
                let near = |found: f32, wanted: f32| (found - wanted).abs() <= wanted.abs() * 1e-5;
                assert!(
                    near(view.outgoing_pace, -2.0 * secs) && near(view.share_change, 4.0 * secs)
                );
                assert_eq!((view.outgoing_clip, view.incoming_row), (1, 3.25));
            }
            assert_eq!(view.with_incoming(states[0], ticks).incoming_clip, 1);
        }
    }

    #[test]
    fn inertialization_slot_is_the_bytes_of_a_slot() {
        let states = [1, 2].map(|clip| SampledState {
            bound_clip: clip,
            row: clip as f32 + 0.25,
            pace: -1.5 * clip as f32,
        });
        let slot = Slot::inertialization(9, TICKS_PER_SEC, states, [0.5, 4.0]).on_layer(3);
        let view = slot.as_inertialization().unwrap();
        assert_eq!([view.outgoing_state(), view.incoming_state()], states);
        assert_eq!(Slot::from(*view), slot);
        let halves =
            |low: f32, high: f32| u64::from(high.to_bits()) << 32 | u64::from(low.to_bits());
        let same = Slot {
            start_tick: 9,
            phase_rate: halves(1.25, -1.5),
            weight_tick: halves(2.25, -3.0),
            start_phase: 2,
            bound_clip: 1,
            layer_and_mode: 3 << SLOT_MODE_BITS | SLOT_INERTIALIZATION,
            start_weight: 0.5,
            weight_rate: 4.0,
            end_weight: view.per_tick,
        };
        assert_eq!(slot, same);
        let other_mode = InertializationSlot { layer_and_mode: 3 << SLOT_MODE_BITS, ..*view };
        assert_eq!(Slot::from(other_mode), slot, "the conversion sets the mode");
        for mode in [SLOT_LOOP, SLOT_ONCE, SLOT_HELD, SLOT_LIVE, SLOT_MACHINE] {
            assert_eq!(Slot { layer_and_mode: mode, ..slot }.as_inertialization(), None);
        }
    }

    #[test]
    fn rates_are_the_least_that_end_on_their_tick() {
        for ticks in (1..200_000).step_by(7) {
            let (found, whole) = (per_tick(ticks), ticks as f32);
            assert!(whole * found >= 1.0 && whole * found.next_down() < 1.0, "{ticks}: {found}");
        }
        assert!(per_tick(0) >= 1.0);
    }

    #[test]
    fn clips_of_the_clock_alone_can_be_inertialized() {
        let all = [SLOT_LOOP, SLOT_ONCE, SLOT_HELD, SLOT_LIVE, SLOT_MACHINE, SLOT_INERTIALIZATION];
        let can =
            all.map(|mode| Slot { layer_and_mode: mode, ..Slot::default() }.can_inertialize());
        assert_eq!(can, [true, true, true, false, false, false]);
    }

    #[test]
    fn far_row_is_never_the_nearest() {
        for (at, far) in [(0.0, 1), (0.4, 1), (0.5, 0), (2.75, 2), (4.0, 3), (9.0, 4)] {
            assert_eq!(far_row(at, 4), far, "{at}");
        }
        assert_eq!((far_row(0.0, 0), far_row(f32::NAN, 2)), (0, 1));
    }
}
