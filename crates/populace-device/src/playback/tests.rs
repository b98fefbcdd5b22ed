use super::*;
use populace_clip::{FIRST_TICK, TICKS_PER_SEC};

use crate::layout::NONE;

#[test]
fn loop_keeps_its_phase_for_a_year() {
    let slot = Slot::looping(0, 0, 1.25, 0.25, 1.0);
    let year = 31_536_000 * TICKS_PER_SEC; // a whole number of 1.25 s cycles
    let time = slot.time_at(year, 0.5, 1.25);
    // The rate is rounded to 2^-64 of a cycle per tick: over a year of ticks, 2^-64 * 2.2e13 of a
    // cycle.
    assert!((time - (0.5 + 0.25 * 1.25)).abs() < 3e-6, "{time}");
}

#[test]
fn backward_playback_starts_at_the_end_and_holds_the_start() {
    let slot = Slot::once(0, 100, 2.0, -2.0);
    assert!((slot.time_at(100, 0.5, 2.0) - 2.5).abs() < 1e-6);
    assert!((slot.time_at(100 + TICKS_PER_SEC / 2, 0.5, 2.0) - 1.5).abs() < 1e-6);
    assert_eq!(slot.time_at(100 + TICKS_PER_SEC, 0.5, 2.0), 0.5);
    assert_eq!(slot.time_at(100 + 50 * TICKS_PER_SEC, 0.5, 2.0), 0.5);
}

#[test]
fn once_reaches_its_end_exactly_and_holds_it() {
    let slot = Slot::once(0, 0, 0.75, 1.0);
    assert_eq!(slot.time_at(ticks_from_secs(0.75), 0.0, 0.75), 0.75);
    assert_eq!(slot.time_at(ticks_from_secs(75.0), 0.0, 0.75), 0.75);
}

#[test]
fn once_ends_on_its_tick_at_any_speed() {
    let start = 0.033_f32;
    for duration in [0.001_f32, 1.0 / 3.0, 0.75, 2.533_333, 59.94, 1_234.567] {
        for speed in [0.01_f32, 0.3, 0.999_999_9, 1.0, 1.000_000_1, 7.3, 1e3] {
            let ticks = ticks_from_secs(f64::from(duration) / f64::from(speed));
            if !(3..=1 << 32).contains(&ticks) {
                continue;
            }
            let what = format!("{duration} s at {speed}");
            let forwards = Slot::once(0, 5, duration, speed);
            assert!(forwards.time_at(5 + ticks - 1, 0.0, duration) < duration, "{what}");
            assert_eq!(forwards.time_at(5, start, duration), start, "{what}");
            assert_eq!(forwards.time_at(5 + ticks, start, duration), start + duration, "{what}");
            let backwards = Slot::once(0, 5, duration, -speed);
            // Times have a resolution of 2^-24 of the clip.
            let one_tick_left = backwards.time_at(5 + ticks - 1, 0.0, duration);
            assert!(one_tick_left > 0.0 || ticks > 1 << 23, "{what}");
            assert!(backwards.time_at(5, 0.0, duration) > duration * 0.999_999, "{what}");
            assert_eq!(backwards.time_at(5 + ticks, start, duration), start, "{what}");
            assert_eq!(backwards.time_at(u64::MAX, start, duration), start, "{what}");
        }
    }
}

#[test]
fn once_advances_evenly() {
    let (duration, speed) = (2.533_333_f32, 0.37);
    let ticks = ticks_from_secs(f64::from(duration) / f64::from(speed));
    for step in 0..=1000 {
        let elapsed = ticks * step / 1000;
        let wanted = duration * (elapsed as f32 / ticks as f32);
        let forwards = Slot::once(0, 0, duration, speed).time_at(elapsed, 0.0, duration);
        assert!((forwards - wanted).abs() < 1e-6, "{forwards} is not {wanted}");
        let backwards = Slot::once(0, 0, duration, -speed).time_at(elapsed, 0.0, duration);
        assert!(
            (backwards - (duration - wanted)).abs() < 1e-6,
            "{backwards} is not {duration} - {wanted}"
        );
    }
}

#[test]
fn once_without_speed_or_length_stays_at_its_start() {
    for (duration, speed) in [(1.5, 0.0), (1.5, -0.0), (0.0, 1.0), (0.0, -1.0), (0.0, 0.0)] {
        for tick in [0, 1, TICKS_PER_SEC, u64::MAX] {
            assert_eq!(Slot::once(0, 0, duration, speed).time_at(tick, 0.25, duration), 0.25);
        }
    }
}

#[test]
fn once_shorter_than_a_tick_ends_and_holds() {
    for speed in [1.0, -1.0] {
        let slot = Slot::once(0, 0, 1e-7, speed);
        let end = if speed < 0.0 { 0.0 } else { 1e-7 };
        assert!(
            [3, 4, 99, u64::MAX].iter().all(|tick| slot.time_at(*tick, 0.0, 1e-7) == end),
            "{speed}"
        );
    }
}

#[test]
fn slot_packs_layer_and_mode() {
    let slot = Slot::held(7, 0, -1.5).on_layer(3);
    assert_eq!((slot.layer(), slot.mode(), slot.held_secs()), (3, SLOT_HELD, -1.5));
    let slot = Slot::once(7, 0, 1.0, 1.0).on_layer(2).on_layer(1);
    assert_eq!((slot.layer(), slot.mode()), (1, SLOT_ONCE));
    assert_eq!(slot.on_layer(u32::MAX).layer(), (1 << 24) - 1);
}

#[test]
fn live_slots_and_those_of_machines_hold_delay_and_instance() {
    let live = Slot::live(5, 70, 48);
    assert_eq!((live.mode(), live.bound_clip, live.delay_ticks()), (SLOT_LIVE, 5, 48));
    assert_eq!((live.start_tick, live.weight_tick, live.weight_at(70)), (70, 70, 1.0));
    for which in [0, 1] {
        let machine = Slot::machine(6, which, 70);
        assert_eq!((machine.machine_instance(), machine.bound_clip & 1), (Some(6), which));
    }
    assert_eq!(live.machine_instance(), None);
}

#[test]
fn looping_slots_count_the_ends_they_pass() {
    for (duration, speed) in [(0.5, 3.0), (1.25, 0.4), (0.5, -2.0), (1.25, -0.7), (1.0, 0.0)] {
        for phase in [0.0, 0.25, 0.999] {
            let slot = Slot::looping(0, 100, duration, phase, speed);
            for secs in [0.0, 0.1, 0.3, 1.0, 1.7, 25.0] {
                let (from, to) = (100 + TICKS_PER_SEC / 3, ticks_from_secs(1.0 + secs));
                let to = to.max(from);
                let at = i128::from(slot.phase_at(from));
                let way = i128::from(to - from) * i128::from(slot.phase_rate.cast_signed());
                // Backwards, the end is passed once the phase falls below 0.
                let passed = ((at + way) >> 64).unsigned_abs();
                let found = slot.cycles_between(from, to);
                assert_eq!(u128::from(found), passed, "{duration} {speed} {phase} {secs}");
            }
        }
    }
    assert_eq!(Slot::once(0, 0, 0.1, 1.0).cycles_between(0, TICKS_PER_SEC), 0);
    // A quarter of a cycle back in each tick, from a quarter: the first tick ends on the start.
    let still = Slot::looping(0, 0, 1.0, 0.25, 0.0);
    let back = Slot { phase_rate: (1_u64 << 62).wrapping_neg(), ..still };
    assert_eq!([1, 2, 5, 6].map(|to| back.cycles_between(0, to)), [0, 1, 1, 2]);
}

#[test]
fn layer_packs_mask_and_mode() {
    for (mode, additive) in [(LayerMode::Override, false), (LayerMode::Additive, true)] {
        for mask in [None, Some(0), Some(77), Some(LAYER_MASK - 1)] {
            let layer = Layer::new(LayerSettings { mode, weight: 0.5 }, mask);
            assert_eq!((layer.weight, layer.mask(), layer.is_additive()), (0.5, mask, additive));
        }
    }
    let beyond = Layer::new(LayerSettings::default(), Some(NONE));
    assert_eq!((beyond.mask(), beyond.is_additive()), (Some(LAYER_MASK - 1), false));
}

#[test]
fn weight_ramps_and_stops() {
    let mut slot = Slot::held(0, 0, 0.0);
    slot.ramp_weight(TICKS_PER_SEC, 1.0, 0.25, 0.5);
    assert_eq!(slot.weight_at(TICKS_PER_SEC), 1.0);
    assert!((slot.weight_at(TICKS_PER_SEC * 5 / 4) - 0.625).abs() < 1e-6);
    assert_eq!(slot.weight_at(TICKS_PER_SEC * 9), 0.25);
}

#[test]
fn weights_that_change_at_once_keep_the_earlier_one_only_to_fall() {
    let mut slot = Slot::held(0, 0, 0.0);
    for (from, to, kept) in [(1.0, 0.25, 1.0), (0.25, 1.0, 1.0)] {
        slot.ramp_weight(100, from, to, 0.0);
        assert_eq!((slot.start_weight, slot.weight_rate, slot.end_weight), (kept, 0.0, to));
        assert_eq!((slot.weight_at(100), slot.mean_weight(100, 200)), (to, to));
        assert_eq!(slot.mean_weight(100, 100), to);
        assert_eq!(slot.mean_weight(50, 150), 0.5 * (kept + to));
    }
}

#[test]
fn ramps_are_known_by_their_end_and_length() {
    let mut slot = Slot::held(0, 0, 0.0);
    slot.ramp_weight(100, 1.0, 0.25, 0.5);
    let known = [(0.25, 0.5), (0.5, 0.5), (0.25, 0.4), (0.5, 0.4)]
        .map(|(to, secs)| slot.ramps_to(to, secs));
    assert_eq!(known, [true, false, false, false]);
}

#[test]
fn future_slot_has_no_weight_before_its_start() {
    let mut slot = Slot::once(0, 100, 1.0, 1.0);
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

#[test]
fn shortest_fade_takes_a_tick_and_stays_finite() {
    for secs in [f32::from_bits(1), f32::MIN_POSITIVE, 1e-20, 1e-7] {
        for (from, to) in [(0.0, 1.0), (1.0, 0.0), (0.25, 0.5)] {
            let mut slot = Slot::looping(0, FIRST_TICK, 1.0, 0.0, 1.0);
            slot.ramp_weight(FIRST_TICK, from, to, secs);
            assert!(slot.weight_rate.is_finite(), "{secs}: {slot:?}");
            assert_eq!(slot.weight_at(FIRST_TICK), from);
            assert!((slot.weight_at(FIRST_TICK + 1) - to).abs() < 1e-6);
            assert_eq!(slot.weight_at(FIRST_TICK + 2), to);
            let target = crate::layout::Target::default().with_ramp(FIRST_TICK, from, to, secs);
            assert_eq!((target.ramp_at(FIRST_TICK), target.ramp_at(FIRST_TICK + 2)), (from, to));
        }
    }
}

#[test]
fn mean_weight_equals_mean_over_ticks() {
    let mean = |slot: &Slot, from: u64, to: u64| {
        let at =
            |tick| if tick < slot.weight_tick { slot.start_weight } else { slot.weight_at(tick) };
        let sum: f64 = (from..to).map(|tick| f64::from(at(tick) + at(tick + 1)) / 2.0).sum();
        sum / (to - from) as f64
    };
    for (from, to, secs) in
        [(0.2, 0.9, 1e-4), (0.9, 0.0, 3e-4), (1.0, 0.0, 0.0), (0.0, 0.5, 0.0), (0.5, 0.5, 1.0)]
    {
        let mut slot = Slot::looping(0, 0, 1.0, 0.0, 1.0);
        slot.ramp_weight(500, from, to, secs);
        for (begin, end) in [(0, 1000), (0, 520), (505, 540), (500, 501), (0, 500), (900, 1000)] {
            let (found, wanted) = (slot.mean_weight(begin, end), mean(&slot, begin, end));
            let near = (f64::from(found) - wanted).abs() < 2e-3;
            assert!(near, "{from} to {to} in {secs} s, {begin}..{end}: {found} is not {wanted}");
        }
    }
}
