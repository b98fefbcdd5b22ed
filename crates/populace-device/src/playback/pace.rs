//! Closed-form queries that only the host needs: a slot's speed, its end, and a change of speed.

use populace_clip::TICKS_PER_SEC;

use super::{once_rate, phase_rate, upper_half};
use crate::layout::{
    SLOT_HELD, SLOT_INERTIALIZATION, SLOT_LIVE, SLOT_LOOP, SLOT_MACHINE, SLOT_MODE_BITS, SLOT_ONCE,
    Slot,
};

/// A whole cycle in the unit of phases.
const CYCLE: u128 = 1 << 64;

impl Slot {
    /// The phase of a looping slot at a clock tick, in 2^-64 of a cycle.
    #[inline]
    #[must_use]
    pub fn phase_at(&self, tick: u64) -> u64 {
        let elapsed = tick.wrapping_sub(self.start_tick);
        (u64::from(self.start_phase) << 32).wrapping_add(elapsed.wrapping_mul(self.phase_rate))
    }

    /// Returns whether the slot has no speed of its own: it is held, live, a state machine's slot,
    /// or an inertialization slot.
    #[must_use]
    pub fn is_tied(&self) -> bool {
        matches!(self.mode(), SLOT_HELD | SLOT_LIVE | SLOT_MACHINE | SLOT_INERTIALIZATION)
    }

    /// The speed relative to a clip of length `duration_secs`; negative for backward playback. Held
    /// slots, and slots of state machines, have speed 0, live slots 1.
    #[must_use]
    pub fn speed(&self, duration_secs: f32) -> f32 {
        if self.is_tied() {
            return if self.mode() == SLOT_LIVE { 1.0 } else { 0.0 };
        }
        let rate = self.phase_rate.cast_signed();
        let cycles_per_tick = rate as f64 / CYCLE as f64;
        #[expect(
            clippy::cast_possible_truncation,
            reason = "rounding to the nearest f32 is what is wanted"
        )]
        let speed = (cycles_per_tick * TICKS_PER_SEC as f64 * f64::from(duration_secs)) as f32;
        speed
    }

    /// The tick at which a slot that plays once ends, or at which a looping slot reaches its next
    /// cycle end after `tick`. `None` if the slot stands still, is live or belongs to a state
    /// machine.
    #[must_use]
    pub fn end_tick(&self, tick: u64) -> Option<u64> {
        let rate = u128::from(self.phase_rate.cast_signed().unsigned_abs());
        if rate == 0 || self.is_tied() {
            return None;
        }
        let (from, left) = match self.mode() {
            SLOT_ONCE => (self.start_tick, CYCLE),
            _ if self.phase_rate >> 63 == 0 => (tick, CYCLE - u128::from(self.phase_at(tick))),
            _ => (tick, u128::from(self.phase_at(tick).wrapping_sub(1)) + 1),
        };
        Some(from.saturating_add(u64::try_from(left.div_ceil(rate)).unwrap_or(u64::MAX)))
    }

    /// Changes the speed from `tick` on. The sampled time continues where it is, to within one
    /// tick. `once` says that the slot plays once, which a slot of speed 0 does not record. Held
    /// and live slots and those of state machines stay as they are.
    ///
    /// The slot stops if the new speed is so low that its start would be before clock tick 0.
    pub fn set_speed(&mut self, tick: u64, duration_secs: f32, speed: f32, once: bool) {
        if self.is_tied() {
            return;
        }
        if !once {
            self.start_phase = upper_half(self.phase_at(tick));
            self.start_tick = tick;
            self.phase_rate = phase_rate(duration_secs, speed);
            return;
        }
        let position = self.position_in_cycle(tick);
        let rate = once_rate(duration_secs, speed);
        let done = if rate >> 63 == 0 { position } else { CYCLE - position };
        let ticks = done.checked_div_euclid(u128::from(rate.cast_signed().unsigned_abs()));
        let ticks = ticks.and_then(|whole| u64::try_from(whole).ok());
        // One tick more than the rounded-down quotient, so that a slot that has ended stays ended.
        let start = ticks.and_then(|ticks| tick.checked_sub(ticks)?.checked_sub(1));
        let (start_tick, start_phase, phase_rate, mode) = match start {
            Some(_) if done == 0 => (tick, 0, rate, SLOT_ONCE),
            Some(start) => (start, 0, rate, SLOT_ONCE),
            // A slot that plays once cannot hold a phase, so a stopped one becomes a looping slot.
            None => (tick, upper_half(u64::try_from(position).unwrap_or(u64::MAX)), 0, SLOT_LOOP),
        };
        (self.start_tick, self.start_phase, self.phase_rate) =
            (start_tick, start_phase, phase_rate);
        self.layer_and_mode = self.layer() << SLOT_MODE_BITS | mode;
    }

    /// The position within the cycle of a slot that plays once, from 0 to [`CYCLE`].
    fn position_in_cycle(&self, tick: u64) -> u128 {
        if self.mode() != SLOT_ONCE {
            return u128::from(self.phase_at(tick));
        }
        let elapsed = u128::from(tick.saturating_sub(self.start_tick));
        let rate = u128::from(self.phase_rate.cast_signed().unsigned_abs());
        let done = elapsed.saturating_mul(rate).min(CYCLE);
        if self.phase_rate >> 63 == 0 { done } else { CYCLE - done }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SEC: u64 = TICKS_PER_SEC;
    /// Clocks begin far from 0, so that a slot can be rewritten as one that started long ago.
    const NOW: u64 = 1 << 44;

    #[track_caller]
    fn assert_time(slot: &Slot, tick: u64, wanted: f32) {
        let found = slot.time_at(tick, 0.0, 2.0);
        assert!((found - wanted).abs() < 1e-5, "{found} is not {wanted}");
    }

    #[test]
    fn tied_slots_have_the_speed_of_their_stream_or_none() {
        let tied = [Slot::live(0, NOW, 9), Slot::held(0, NOW, 0.5), Slot::machine(0, 0, NOW)];
        assert_eq!(tied.map(|slot| slot.speed(2.0)), [1.0, 0.0, 0.0]);
    }

    #[test]
    fn backward_loops_end_when_their_phase_is_used_up() {
        let still = Slot::looping(0, NOW, 2.0, 0.0, 0.0);
        // 2^32 of 2^64 parts of a cycle are left, and one passes in each tick.
        let slow = Slot { start_phase: 1, phase_rate: 1_u64.wrapping_neg(), ..still };
        assert_eq!(slow.end_tick(NOW), Some(NOW + (1 << 32)));
        let halves = Slot { phase_rate: (1_u64 << 63).wrapping_neg(), ..still };
        assert_eq!(halves.end_tick(NOW), Some(NOW + 2), "a whole cycle from phase 0");
    }

    #[test]
    fn once_turns_back_on_its_way_and_starts_anew_at_its_start() {
        let mut slot = Slot::once(0, NOW, 2.0, 1.0);
        slot.set_speed(NOW, 2.0, 0.5, true);
        assert_eq!((slot.start_tick, slot.end_tick(NOW)), (NOW, Some(NOW + 4 * SEC)));
        slot.set_speed(NOW + SEC, 2.0, -1.0, true);
        assert_time(&slot, NOW + SEC, 0.5);
        assert_time(&slot, NOW + SEC + SEC / 4, 0.25);
        assert_time(&slot, NOW + 2 * SEC, 0.0);
    }

    #[test]
    fn loop_continues_from_its_time_at_any_speed() {
        let mut slot = Slot::looping(0, NOW, 2.0, 0.25, 1.0);
        let before = slot.time_at(NOW + SEC, 0.0, 2.0);
        slot.set_speed(NOW + SEC, 2.0, -0.5, false);
        assert_eq!(slot.time_at(NOW + SEC, 0.0, 2.0), before, "to the bit");
        assert_time(&slot, NOW + 2 * SEC, 1.0);
        assert!((slot.speed(2.0) + 0.5).abs() < 1e-6);
        slot.set_speed(NOW + 2 * SEC, 2.0, 0.0, false);
        assert_time(&slot, NOW + 77 * SEC, 1.0);
        assert_eq!((slot.end_tick(NOW), slot.speed(2.0)), (None, 0.0));
    }

    #[test]
    fn once_continues_reverses_stops_and_ends_on_time() {
        let mut slot = Slot::once(0, NOW, 2.0, 1.0).on_layer(3);
        let mut at = |tick: u64, speed: f32, then: &[(u64, f32)]| {
            let before = slot.time_at(tick, 0.0, 2.0);
            slot.set_speed(tick, 2.0, speed, true);
            assert_time(&slot, tick, before);
            then.iter().for_each(|(tick, wanted)| assert_time(&slot, *tick, *wanted));
            assert_eq!(slot.layer(), 3);
            slot.end_tick(tick)
        };
        let near = |found: Option<u64>, wanted: u64| found.is_some_and(|f| f.abs_diff(wanted) <= 2);
        assert!(near(at(NOW + SEC / 2, 3.0, &[(NOW + SEC, 2.0), (NOW + 9 * SEC, 2.0)]), NOW + SEC));
        // Ended; now backwards from there.
        assert!(near(at(NOW + 9 * SEC, -1.0, &[(NOW + 10 * SEC, 1.0)]), NOW + 11 * SEC));
        assert_eq!(at(NOW + 10 * SEC, 0.0, &[(NOW + 20 * SEC, 1.0)]), None);
        assert!(near(
            at(NOW + 20 * SEC, 0.5, &[(NOW + 21 * SEC, 1.5), (NOW + 30 * SEC, 2.0)]),
            NOW + 22 * SEC
        ));
        assert!(
            at(NOW + 30 * SEC, 0.001, &[(NOW + 40 * SEC, 2.0)]) <= Some(NOW + 30 * SEC),
            "ended stays ended"
        );
        at(NOW + 40 * SEC, -2.0, &[(NOW + 41 * SEC, 0.0), (NOW + 50 * SEC, 0.0)]);
        at(NOW + 50 * SEC, 1.0, &[(NOW + 51 * SEC, 1.0)]);
    }

    #[test]
    fn end_ticks_are_known_in_advance() {
        assert_eq!(Slot::once(0, NOW, 2.0, -0.5).end_tick(NOW + 1), Some(NOW + 4 * SEC));
        let near =
            |slot: Slot, tick, wanted| slot.end_tick(tick).is_some_and(|t| t.abs_diff(wanted) <= 2);
        assert!(near(Slot::looping(0, NOW, 2.0, 0.25, 1.0), NOW + 2 * SEC, NOW + 7 * SEC / 2));
        assert!(near(Slot::looping(0, NOW, 2.0, 0.25, -1.0), NOW, NOW + SEC / 2));
        assert!(near(Slot::looping(0, NOW, 2.0, 0.0, -1.0), NOW, NOW + 2 * SEC));
        assert_eq!(Slot::held(0, NOW, 0.3).end_tick(NOW), None);
        assert_eq!(Slot::once(0, NOW, 0.0, 1.0).end_tick(NOW), None);
    }

    #[test]
    fn start_before_clock_zero_stops_the_slot() {
        let mut slot = Slot::once(0, 0, 2.0, 1.0);
        slot.set_speed(SEC, 2.0, 1e-6, true);
        assert_time(&slot, SEC, 1.0);
        assert_time(&slot, 100 * SEC, 1.0);
        let mut held = Slot::held(0, 0, 0.7);
        held.set_speed(SEC, 2.0, 3.0, false);
        assert_eq!(held, Slot::held(0, 0, 0.7));
    }

    #[test]
    fn slots_of_equal_phase_agree_for_all_clips() {
        let quarter = 1_u64 << 62;
        let slots = [0, 1].map(|bound| Slot::in_phase(bound, NOW, quarter, 0.5));
        assert_eq!(slots[0].phase_at(NOW + SEC), slots[1].phase_at(NOW + SEC));
        assert_time(&slots[0], NOW + SEC, 1.5);
    }
}
