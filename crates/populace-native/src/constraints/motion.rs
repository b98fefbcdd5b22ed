//! Root motion: moves members by their clips, frame after frame. Twin of `kernels/motion.cl`.
//!
//! Reads the member's slots and layers, clips, motions and masks, and the member's motion state as
//! of the frame before. Writes the motion state, and the model transforms of roots.
//!
//! Each clip tells how far it moves the body from the last frame to this one, relative to the
//! body's last position. These moves are mixed as poses are, and the mix is applied to the member's
//! last position. A clip that plays for a part of the frame moves the body for that part, by its
//! mean weight over it, so that no motion is lost when a clip ends between two frames. During an
//! inertialized transition, the velocity of the frame before fades into that of the new clips.

use populace_device::layout::{
    BoundClip, ClipRows, FOOT_STATE, Float4, InertializationSlot, LEAST_TOTAL, LEAST_WEIGHT,
    MAX_FEET, MOTION_ELEMENTS, MOTION_STATE, NONE, SLOT_LOOP, SLOT_MACHINE, SLOT_ONCE,
    STATES_PER_CONTROL, Slot,
};
use populace_model::Affine;
use populace_model::math::{Real, vec3};

use super::targets::Solver;
use crate::hierarchy::Hierarchy;
use crate::machines::machine_slot;
use crate::members::{member_layers, member_slots};

/// A rotation about +Y, then a translation, in metres.
#[derive(Clone, Copy)]
struct Move {
    shift: [f32; 3],
    /// Sine and cosine of the rotation.
    heading: [f32; 2],
}

impl Move {
    const NONE: Self = Self { shift: [0.0; 3], heading: [0.0, 1.0] };

    fn new(shift: [f32; 3], [sin, cos]: [f32; 2]) -> Self {
        let squared = sin * sin + cos * cos;
        if squared > 1e-20 {
            let k = squared.inverse_sqrt();
            Self { shift, heading: [sin * k, cos * k] }
        } else {
            Self { shift, ..Self::NONE }
        }
    }

    fn rotated(&self, [x, y, z]: [f32; 3]) -> [f32; 3] {
        let [sin, cos] = self.heading;
        [cos * x + sin * z, y, cos * z - sin * x]
    }

    /// Combines two moves: `next`, relative to where this one leads.
    fn then(&self, next: &Self) -> Self {
        let ([s, c], [t, d]) = (self.heading, next.heading);
        Self::new(vec3::add(self.shift, self.rotated(next.shift)), [s * d + c * t, c * d - s * t])
    }

    /// Adds a move to this one and to the rest that rounding has left out of it so far. Returns the
    /// sum and its rest: single precision alone would lose part of each of many small moves.
    fn followed_by(&self, next: &Self, rest: [f32; 3]) -> (Self, [f32; 3]) {
        let far = vec3::add(self.rotated(next.shift), rest);
        let shift = vec3::add(self.shift, far);
        (Self { shift, ..self.then(next) }, vec3::sub(far, vec3::sub(shift, self.shift)))
    }

    /// Returns the inverse.
    fn undone(&self) -> Self {
        let back = Self { shift: [0.0; 3], heading: [-self.heading[0], self.heading[1]] };
        Self { shift: vec3::scale(back.rotated(self.shift), -1.0), ..back }
    }

    /// Repeats the move `count` times.
    fn times(mut self, mut count: u64) -> Self {
        let mut all = Self::NONE;
        while count > 0 {
            if count & 1 == 1 {
                all = all.then(&self);
            }
            self = self.then(&self);
            count >>= 1;
        }
        all
    }

    /// Returns the mean velocity of a move that took `ticks`.
    fn speed(&self, ticks: u64) -> Speed {
        let ([x, y, z], [turn, _]) = (self.shift, self.heading);
        [x, y, z, turn].map(|far| far / ticks as f32)
    }

    fn mix(&self, to: &Self, part: f32) -> Self {
        let [s, c] = [0, 1].map(|i: usize| self.heading[i].mix(to.heading[i], part));
        Self::new([0, 1, 2].map(|i: usize| self.shift[i].mix(to.shift[i], part)), [s, c])
    }
}

/// Time from one tick to a later one.
#[derive(Clone, Copy)]
struct Span {
    from: u64,
    until: u64,
}

/// Weighted sum of moves.
#[derive(Default)]
struct Moves {
    shift: [f32; 3],
    heading: [f32; 2],
    /// Sum of the weights, each averaged over the time in which its clip played.
    weight: f32,
    /// Sum of the weights, each averaged over the frame.
    total: f32,
    /// Time in which any clip played.
    span: Option<Span>,
}

impl Moves {
    /// Divides the sum by a total weight. Clips that play one after the other within the frame have
    /// a `weight` above the total. The surplus is taken off the cosine, so that the rotation of
    /// each counts from straight ahead.
    fn over(&self, total: f32) -> Move {
        let ([sin, cos], k) = (self.heading, 1.0 / total);
        Move::new(vec3::scale(self.shift, k), [sin * k, (cos + (total - self.weight)) * k])
    }
}

/// Velocity of a member: translation in metres, and sine of the rotation about +Y, per tick.
type Speed = [f32; 4];

/// Motion state of a member as of a frame.
#[derive(Clone, Copy)]
struct Last {
    /// Root-motion offset of the member, in model space.
    offset: Move,
    /// The part of the offset that rounding has left out, in metres.
    rest: [f32; 3],
    speed: Speed,
    /// Velocity at the start of the newest inertialization, less that of the incoming clips.
    excess: Speed,
}

impl Last {
    const NONE: Self =
        Self { offset: Move::NONE, rest: [0.0; 3], speed: [0.0; 4], excess: [0.0; 4] };
}

/// Returns the part of a span in which a slot plays. A slot that was cut plays up to its cut.
fn span_of(slot: &Slot, within: Span) -> Option<Span> {
    let is_cut = slot.end_weight <= 0.0 && slot.weight_rate == 0.0;
    let until = if is_cut { within.until.min(slot.weight_tick) } else { within.until };
    let from = within.from.max(slot.start_tick);
    (slot.bound_clip != NONE && from < until).then_some(Span { from, until })
}

/// Returns the part of `all` that a span takes.
fn span_part(all: Span, span: Span) -> f32 {
    (span.until - span.from) as f32 / (all.until - all.from) as f32
}

/// Returns the integral, from 0 to a part of an inertialization's time, of the quintic by which
/// differences in pose decay.
fn still_until(inertialized: f32) -> f32 {
    let s = if inertialized < 1.0 { inertialized } else { 1.0 };
    s - s * s * s * s * (2.5 - 3.0 * s + s * s)
}

/// Returns the move within a span that comes of a difference in velocity, while it decays as a slot
/// inertializes.
fn inertialized_within(slot: &InertializationSlot, excess: Speed, within: Span) -> Move {
    let [from, until] =
        [within.from, within.until].map(|tick| still_until(slot.inertialized_at(tick)));
    let ticks = (until - from) / slot.per_tick;
    let [x, y, z, turn] = excess.map(|per_tick| per_tick * ticks);
    Move::new([x, y, z], [turn, 1.0])
}

impl Solver<'_> {
    /// Returns the position of a clip's body at a time on the clip's axis.
    fn motion_at(&self, clip: &ClipRows, secs: f32) -> Move {
        let last = (clip.motion_count - 1) as f32;
        let at_row = (secs - clip.start_secs) * clip.motion_rows_per_sec;
        let at_row = if at_row > 0.0 { if at_row < last { at_row } else { last } } else { 0.0 };
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped to the rows"
        )]
        let row = at_row as u32;
        let rows = self.tables.motions().as_slice();
        let at = |row: u32| {
            let first = ((clip.motion_first + row) * MOTION_ELEMENTS) as usize;
            let [sin, cos, ..] = rows[first + 1].0;
            Move { shift: rows[first].xyz(), heading: [sin, cos] }
        };
        let next = if row + 1 < clip.motion_count { row + 1 } else { row };
        at(row).mix(&at(next), at_row - row as f32)
    }

    /// Returns a slot, or for a machine's slot the one that plays in its place, and the part of a
    /// span in which it plays.
    fn slot_within(&self, slot: &Slot, within: Span) -> Option<(Slot, Span)> {
        let span = span_of(slot, within)?;
        if slot.mode() != SLOT_MACHINE {
            return Some((*slot, span));
        }
        let weight = slot.mean_weight(span.from, span.until);
        let slot = machine_slot(self.tables, &self.inputs.history.running, slot, weight);
        Some((slot, span_of(&slot, span)?))
    }

    /// Returns the move of a slot's clip within a span, relative to the clip's own position at its
    /// start.
    fn move_of_slot(&self, slot: &Slot, bound: &BoundClip, span: Span) -> Move {
        let clip = &self.tables.clips().as_slice()[bound.rows as usize];
        if clip.motion_count == 0 || !matches!(slot.mode(), SLOT_LOOP | SLOT_ONCE) {
            return Move::NONE;
        }
        let at =
            |tick| self.motion_at(clip, slot.time_at(tick, clip.start_secs, clip.duration_secs));
        let (from, to) = (at(span.from), at(span.until));
        let cycle = self.motion_at(clip, clip.start_secs + clip.duration_secs);
        let whole = match (slot.cycles_between(span.from, span.until), slot.phase_rate >> 63 != 0) {
            (count, true) => cycle.undone().times(count),
            (count, false) => cycle.times(count),
        };
        from.undone().then(&whole.then(&to))
    }

    /// Sums the moves of a layer's slots within a span.
    fn moves_of_layer(&self, layer: u32, within: Span) -> Moves {
        let mut sum = Moves::default();
        for slot in member_slots(self.tables, self.control.member) {
            let Some((slot, span)) = self.slot_within(slot, within) else { continue };
            let weight = slot.mean_weight(span.from, span.until);
            if weight <= 0.0 || slot.layer() != layer {
                continue;
            }
            let bound = &self.tables.bound_clips().as_slice()[slot.bound_clip as usize];
            let moved = self.move_of_slot(&slot, bound, span);
            sum.shift = vec3::add_scaled(sum.shift, moved.shift, weight * bound.motion_scale);
            sum.heading = [0, 1].map(|i: usize| sum.heading[i] + moved.heading[i] * weight);
            sum.weight += weight;
            sum.total += weight * span_part(within, span);
            sum.span = sum.span.map_or(Some(span), |all| {
                let (from, until) = (all.from.min(span.from), all.until.max(span.until));
                Some(Span { from, until })
            });
        }
        sum
    }

    /// Returns a layer's weight at the first joint; 0 for additive layers.
    fn weight_at_root(&self, layer: u32) -> f32 {
        let layers = member_layers(self.tables, self.control.member);
        match layers.get(layer as usize) {
            _ if layer == 0 => 1.0,
            Some(layer) if !layer.is_additive() => match layer.mask() {
                Some(mask) => layer.weight * self.tables.masks().as_slice()[mask as usize],
                None => layer.weight,
            },
            _ => 0.0,
        }
    }

    /// Mixes the moves of all clips within a span, each for the time that it plays. Additive layers
    /// do not move the member.
    fn move_within(&self, span: Span) -> Move {
        let mut moved = Move::NONE;
        for (layer, _) in (0..).zip(member_layers(self.tables, self.control.member)) {
            let (sum, weight) = (self.moves_of_layer(layer, span), self.weight_at_root(layer));
            if layer == 0 {
                let part = sum.span.map_or(1.0, |played| span_part(span, played));
                moved = if sum.total > LEAST_TOTAL { sum.over(sum.total / part) } else { moved };
            } else if sum.total > LEAST_WEIGHT && weight > 0.0 {
                let part = weight * if sum.total < 1.0 { sum.total } else { 1.0 };
                moved = moved.mix(&sum.over(sum.total), part);
            }
        }
        moved
    }

    /// Returns the member's newest inertialization of the root that began before a tick.
    fn newest_inertialization(&self, before: u64) -> Option<&InertializationSlot> {
        let slots = member_slots(self.tables, self.control.member);
        let begun = |slot: &&Slot| {
            slot.bound_clip != NONE
                && slot.start_tick < before
                && self.weight_at_root(slot.layer()) > 0.0
        };
        let slots = slots.iter().filter(|slot| slot.is_inertialization()).filter(begun);
        slots.filter_map(Slot::as_inertialization).max_by_key(|slot| slot.start_tick)
    }

    /// Returns the member's motion state after this frame.
    fn next(&self, last: Option<Last>) -> Last {
        let (tick, elapsed_ticks) = (self.inputs.frame.tick, self.inputs.frame.elapsed_ticks);
        let elapsed = u64::from(elapsed_ticks);
        let Last { offset, rest, speed, mut excess } = last.unwrap_or(Last::NONE);
        if elapsed == 0 {
            return Last { offset, rest, speed, excess };
        }
        let before = tick.saturating_sub(elapsed);
        let mut moved = self.move_within(Span { from: before, until: tick });
        let newest = self.newest_inertialization(tick);
        let begun = newest.filter(|slot| slot.start_tick >= before);
        // An earlier inertialization goes on until the newest one begins.
        let (inertialization, until) = match begun {
            Some(slot) => (self.newest_inertialization(before), slot.start_tick),
            None => (newest, tick),
        };
        if let Some(slot) = inertialization {
            let span = Span { from: before, until };
            moved = moved.then(&inertialized_within(slot, excess, span));
        }
        if let (Some(slot), Some(_)) = (begun, last) {
            let from = slot.start_tick;
            let incoming = self.move_within(Span { from, until: from + elapsed }).speed(elapsed);
            excess = [0, 1, 2, 3].map(|i: usize| speed[i] - incoming[i]);
            moved = moved.then(&inertialized_within(slot, excess, Span { from, until: tick }));
        }
        excess = if newest.is_some_and(|slot| slot.inertialized_at(tick) < 1.0) {
            excess
        } else {
            [0.0; 4]
        };
        let (offset, rest) = offset.followed_by(&moved, rest);
        Last { offset, rest, speed: moved.speed(elapsed), excess }
    }

    /// Moves a root to where clips have moved the member.
    #[inline(never)]
    pub(super) fn moves(&mut self, joints: &mut impl Hierarchy, joint: usize) {
        let [shift, heading, speed, excess, rest] =
            [0, 1, 2, 3, 4].map(|element| self.state(MOTION_STATE + element).0);
        let epoch = self.control.motion_epoch;
        // The state of another epoch belongs to an earlier use of root motion.
        let last = (shift[3].to_bits() == epoch).then(|| Last {
            offset: Move {
                shift: [shift[0], shift[1], shift[2]],
                heading: [heading[0], heading[1]],
            },
            rest: [rest[0], rest[1], rest[2]],
            speed,
            excess,
        });
        let Last { offset: now, rest, speed, excess } = self.next(last);
        if joint == 0 {
            let [x, y, z] = now.shift;
            let shift = [x, y, z, f32::from_bits(epoch)];
            let heading = [now.heading[0], now.heading[1], 0.0, 0.0];
            let rest = [rest[0], rest[1], rest[2], 0.0];
            self.keep_states(MOTION_STATE, &[shift, heading, speed, excess, rest].map(Float4));
        }
        let ([x, y, z], [s, c]) = (now.shift, now.heading);
        let carried = Affine { rows: [[c, 0.0, s, x], [0.0, 1.0, 0.0, y], [-s, 0.0, c, z]] };
        joints.keep_model(joint, carried.mul(&joints.model_of(joint)));
    }
}

const _: () = assert!(
    MOTION_STATE == FOOT_STATE + 2 * MAX_FEET && MOTION_STATE + 5 <= STATES_PER_CONTROL,
    "the state of the pelvis comes first, then those of feet, then that of root motion"
);
