//! What is left of a clip once another has taken its place at once: how the two differed, in pose
//! and in speed, which decays by itself (Bollo, "Inertialization: high-performance animation
//! transitions in Gears of War", GDC 2018).

use populace_clip::TICKS_PER_SEC;

use crate::layout::{NONE, SLOT_HELD, SLOT_INERTIALIZATION, SLOT_LOOP, SLOT_ONCE, Slot};

/// How a clip stands at one instant: where in its rows, and how fast it moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SampledState {
    /// Into `bound_clips`.
    pub bound_clip: u32,
    /// The row at or before it, and how far it is to the next.
    pub row: f32,
    /// How many times the way from there to the [`far_row`] it goes in a second.
    pub pace: f32,
}

/// The row that a clip's speed is measured towards: the end of the gap between rows that is not the
/// nearer one. The twin of `far_row` in `kernels/inertialize.cl`.
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

/// The row at or before a place in a clip's rows.
#[inline]
#[must_use]
pub fn row_before(at: f32, last: u32) -> u32 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "cut off on purpose"
    )]
    let row = at as u32;
    row.min(last)
}

impl Slot {
    /// A slot of which only that remains in which it differed, at `tick`, from what then took its
    /// place, decaying in so many ticks, at least one. `share` is its part of what the layer
    /// showed, and how that changed in a second; the parts of all that are left at once make 1, and
    /// in an additive layer what they weighed in all.
    #[must_use]
    pub fn inertialization(
        tick: u64,
        ticks: u64,
        [left, taking]: [SampledState; 2],
        share: [f32; 2],
    ) -> Self {
        let secs = secs_of(ticks);
        Self {
            start_tick: tick,
            phase_rate: pair(left.row, left.pace * secs),
            weight_tick: pair(taking.row, taking.pace * secs),
            start_phase: taking.bound_clip,
            bound_clip: left.bound_clip,
            layer_and_mode: SLOT_INERTIALIZATION,
            start_weight: share[0],
            weight_rate: share[1] * secs,
            end_weight: per_tick(ticks),
        }
    }

    /// Lets a slot of [`SLOT_INERTIALIZATION`] inertialize into another clip from the same tick on,
    /// in so many ticks: what first took its place was never seen.
    pub fn inertialize_into(&mut self, taking: SampledState, ticks: u64) {
        let (left, before) = (self.left(), secs_of(1) / self.end_weight);
        let left = SampledState { pace: left.pace / before, ..left };
        let share = [self.start_weight, self.weight_rate / before];
        *self = Self::inertialization(self.start_tick, ticks, [left, taking], share)
            .on_layer(self.layer());
    }

    /// Whether its clip runs by the clock alone and can inertialize: it loops, plays once or is
    /// held.
    #[inline]
    #[must_use]
    pub const fn can_inertialize(&self) -> bool {
        matches!(self.mode(), SLOT_LOOP | SLOT_ONCE | SLOT_HELD)
    }

    /// Whether it is of [`SLOT_INERTIALIZATION`]: nothing but a decaying difference.
    #[inline]
    #[must_use]
    pub const fn is_inertialization(&self) -> bool {
        self.mode() == SLOT_INERTIALIZATION
    }

    /// Of [`SLOT_INERTIALIZATION`]: how much of its time has passed; from 1 on nothing is left, nor
    /// before its start. The twin of `slot_inertialized` in `kernels/slot.cl`.
    #[inline]
    #[must_use]
    pub const fn inertialized_at(&self, tick: u64) -> f32 {
        tick.wrapping_sub(self.start_tick) as f32 * self.end_weight
    }

    /// Whether it is one of [`SLOT_INERTIALIZATION`] of which something is left; the twin of
    /// `slot_inertializes` in `kernels/slot.cl`.
    #[inline]
    #[must_use]
    pub const fn inertializes(&self, tick: u64) -> bool {
        self.is_inertialization() && self.bound_clip != NONE && self.inertialized_at(tick) < 1.0
    }

    /// Of [`SLOT_INERTIALIZATION`]: a tick by which nothing is left, at most a few after the first.
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

    /// Of [`SLOT_INERTIALIZATION`]: how its own clip stood; the pace is that in all of the time
    /// that it inertializes in.
    #[inline]
    #[must_use]
    pub const fn left(&self) -> SampledState {
        let [row, pace] = parts(self.phase_rate);
        SampledState { bound_clip: self.bound_clip, row, pace }
    }

    /// Of [`SLOT_INERTIALIZATION`]: how that stood which took its place, alike.
    #[inline]
    #[must_use]
    pub const fn taking(&self) -> SampledState {
        let [row, pace] = parts(self.weight_tick);
        SampledState { bound_clip: self.start_phase, row, pace }
    }
}

fn secs_of(ticks: u64) -> f32 {
    ticks as f32 / TICKS_PER_SEC as f32
}

/// 1 divided by so many ticks, rounded so that they make 1 in all.
fn per_tick(ticks: u64) -> f32 {
    let per_tick = 1.0 / ticks.max(1) as f32;
    if ticks as f32 * per_tick < 1.0 { per_tick.next_up() } else { per_tick }
}

fn pair(low: f32, high: f32) -> u64 {
    u64::from(high.to_bits()) << 32 | u64::from(low.to_bits())
}

#[expect(clippy::cast_possible_truncation, reason = "its two halves")]
const fn parts(pair: u64) -> [f32; 2] {
    [f32::from_bits(pair as u32), f32::from_bits((pair >> 32) as u32)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use populace_clip::FIRST_TICK;

    #[test]
    fn a_inertialization_slot_weighs_nothing_and_ends_on_its_tick() {
        for ticks in [1, 3, 7, 211_680, 705_600, 1_000_003] {
            let stands =
                [1, 2].map(|clip| SampledState { bound_clip: clip, row: 3.25, pace: -2.0 });
            let mut slot = Slot::inertialization(FIRST_TICK, ticks, stands, [0.5, 4.0]).on_layer(2);
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
                slot.inertialize_into(SampledState { bound_clip: 7, ..stands[1] }, 2 * ticks);
                assert_eq!(slot.taking().bound_clip, 7);
            }
        }
    }

    #[test]
    fn the_far_row_is_never_near() {
        for (at, far) in [(0.0, 1), (0.4, 1), (0.5, 0), (2.75, 2), (4.0, 3), (9.0, 4)] {
            assert_eq!(far_row(at, 4), far, "{at}");
        }
        assert_eq!((far_row(0.0, 0), far_row(f32::NAN, 2)), (0, 1));
    }
}
