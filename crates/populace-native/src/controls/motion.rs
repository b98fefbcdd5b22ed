//! Root motion: where its clips move a member, frame after frame; the twin of `kernels/motion.cl`.
//!
//! Each clip says how far it moves the body between the last frame and this one, seen from where it
//! had it; these moves are mixed as poses are, and the mix goes on from where the member was. A
//! clip that played for a part of the frame moves the body for that part, by the mean of what it
//! weighed then: so nothing is lost of what is left in the midst of a frame. Where something
//! inertializes, the speed of the frame before goes over into that of what plays now, as poses do.

use populace_device::layout::{
    BoundClip, ClipRows, FEET_MOST, Float4, LEAST_WEIGHT, MOTION_ELEMENTS, MOTION_STATE, NONE,
    SLOT_LOOP, SLOT_MACHINE, SLOT_ONCE, STATES_PER_CONTROL, Slot, Step,
};
use populace_model::Affine;
use populace_model::math::{Real, vec3};

use super::{Models, Steering};
use crate::machines::machine_slot;
use crate::pose::member_layers;

/// A turn about +Y, then a shift.
#[derive(Clone, Copy)]
struct Move {
    shift: [f32; 3],
    /// Sine and cosine.
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

    fn turned(&self, [x, y, z]: [f32; 3]) -> [f32; 3] {
        let [sin, cos] = self.heading;
        [cos * x + sin * z, y, cos * z - sin * x]
    }

    /// `next` first, then this one.
    fn then(&self, next: &Self) -> Self {
        let ([s, c], [t, d]) = (self.heading, next.heading);
        Self::new(vec3::add(self.shift, self.turned(next.shift)), [s * d + c * t, c * d - s * t])
    }

    fn undone(&self) -> Self {
        let back = Self { shift: [0.0; 3], heading: [-self.heading[0], self.heading[1]] };
        Self { shift: vec3::scale(back.turned(self.shift), -1.0), ..back }
    }

    /// So many times.
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

    fn speed(&self, ticks: u64) -> Speed {
        let ([x, y, z], [turn, _]) = (self.shift, self.heading);
        [x, y, z, turn].map(|far| far / ticks as f32)
    }

    fn mix(&self, to: &Self, part: f32) -> Self {
        let [s, c] = [0, 1].map(|i: usize| self.heading[i].mix(to.heading[i], part));
        Self::new([0, 1, 2].map(|i: usize| self.shift[i].mix(to.shift[i], part)), [s, c])
    }
}

/// From one time of the clock to a later one.
type Span = (u64, u64);

/// A weighted sum of moves.
#[derive(Default)]
struct Sum {
    shift: [f32; 3],
    heading: [f32; 2],
    /// What each weighed while it played.
    weight: f32,
    /// The mean over the frame of what all weighed.
    total: f32,
    /// When any played.
    span: Option<Span>,
}

impl Sum {
    /// Where moves that weighed so much in all go. Those that each played in a part of the frame
    /// come after each other, so that what all weighed while they played is more: each turns from
    /// straight ahead.
    fn over(&self, total: f32) -> Move {
        let ([sin, cos], k) = (self.heading, 1.0 / total);
        Move::new(vec3::scale(self.shift, k), [sin * k, (cos + (total - self.weight)) * k])
    }
}

/// How far a member goes in a tick: a shift, and the sine of a turn.
type Speed = [f32; 4];

/// Where the frame before left a member, and how fast that moved it.
#[derive(Clone, Copy)]
struct Last {
    place: Move,
    speed: Speed,
    /// How much faster than what it plays it was when something began to inertialize.
    excess: Speed,
}

impl Last {
    const NONE: Self = Self { place: Move::NONE, speed: [0.0; 4], excess: [0.0; 4] };
}

fn span_part((begin, end): Span, (from, until): Span) -> f32 {
    (until - from) as f32 / (end - begin) as f32
}

/// When a slot plays within a span; not once it was cut.
fn span_of(slot: &Slot, (from, until): Span) -> Option<Span> {
    let is_cut = slot.end_weight <= 0.0 && slot.weight_rate == 0.0;
    let until = if is_cut { until.min(slot.weight_tick) } else { until };
    Some((from.max(slot.start_tick), until))
        .filter(|(from, until)| slot.bound_clip != NONE && from < until)
}

/// The integral of what is left of a difference that inertializes: of the quintic by which poses
/// do.
fn still_until(inertialized: f32) -> f32 {
    let s = if inertialized < 1.0 { inertialized } else { 1.0 };
    s - s * s * s * s * (2.5 - 3.0 * s + s * s)
}

/// What is left of a difference in speed within a span, while it inertializes as a slot does.
fn inertialized_within(slot: &Slot, excess: [f32; 4], (from, until): Span) -> Move {
    let [from, until] = [from, until].map(|tick| still_until(slot.inertialized_at(tick)));
    let ticks = (until - from) / slot.end_weight;
    let [x, y, z, turn] = excess.map(|per_tick| per_tick * ticks);
    Move::new([x, y, z], [turn, 1.0])
}

impl Steering<'_> {
    /// Moves a root to where clips have moved the member.
    #[inline(never)]
    pub(super) fn moves(&mut self, models: &mut impl Models, joint: usize, step: &Step) {
        let [place, heading, speed, excess] =
            [0, 1, 2, 3].map(|element| self.state(MOTION_STATE + element).0);
        let last = (place[3].to_bits() == step.turn).then(|| Last {
            place: Move {
                shift: [place[0], place[1], place[2]],
                heading: [heading[0], heading[1]],
            },
            speed,
            excess,
        });
        let Last { place: now, speed, excess } = self.next(last);
        if joint == 0 {
            let [x, y, z] = now.shift;
            self.keep_state(MOTION_STATE, Float4([x, y, z, f32::from_bits(step.turn)]));
            self.keep_state(MOTION_STATE + 1, Float4([now.heading[0], now.heading[1], 0.0, 0.0]));
            self.keep_state(MOTION_STATE + 2, Float4(speed));
            self.keep_state(MOTION_STATE + 3, Float4(excess));
        }
        let ([x, y, z], [s, c]) = (now.shift, now.heading);
        let carried = Affine { rows: [[c, 0.0, s, x], [0.0, 1.0, 0.0, y], [-s, 0.0, c, z]] };
        models.set(joint, carried.mul(&models.model(joint)));
    }

    /// Where the member is after this frame, and how fast it went.
    fn next(&self, last: Option<Last>) -> Last {
        let elapsed = u64::from(self.clock.elapsed_ticks);
        let Last { place, speed, mut excess } = last.unwrap_or(Last::NONE);
        if elapsed == 0 {
            return Last { place, speed, excess };
        }
        let before = self.tick.saturating_sub(elapsed);
        let mut moved = self.move_within((before, self.tick));
        let newest = self.newest_inertialization(self.tick);
        let begun = newest.filter(|slot| slot.start_tick >= before);
        // What inertializes already goes on until something else begins to.
        let (inertialization, until) = match begun {
            Some(slot) => (self.newest_inertialization(before), slot.start_tick),
            None => (newest, self.tick),
        };
        if let Some(slot) = inertialization {
            moved = moved.then(&inertialized_within(slot, excess, (before, until)));
        }
        if let (Some(slot), Some(_)) = (begun, last) {
            let taking =
                self.move_within((slot.start_tick, slot.start_tick + elapsed)).speed(elapsed);
            excess = [0, 1, 2, 3].map(|i: usize| speed[i] - taking[i]);
            moved = moved.then(&inertialized_within(slot, excess, (slot.start_tick, self.tick)));
        }
        excess =
            if newest.is_some_and(|slot| slot.inertializes(self.tick)) { excess } else { [0.0; 4] };
        Last { place: place.then(&moved), speed: moved.speed(elapsed), excess }
    }

    /// Of the member's slots that began to inertialize before a time of the clock, where they move
    /// its root, the last.
    fn newest_inertialization(&self, before: u64) -> Option<&Slot> {
        let slots = &self.tables.slots().as_slice()[self.tables.slot_range(self.control.member)];
        let inertialization = |slot: &&Slot| {
            slot.is_inertialization()
                && slot.bound_clip != NONE
                && slot.start_tick < before
                && self.weight_at_root(slot.layer()) > 0.0
        };
        slots.iter().filter(inertialization).max_by_key(|slot| slot.start_tick)
    }

    /// The mix of what all clips do within a span, each for as long as it plays. Layers that add to
    /// what lies beneath move nobody.
    fn move_within(&self, span: Span) -> Move {
        let mut moved = Move::NONE;
        for (layer, _) in (0..).zip(member_layers(self.tables, self.control.member)) {
            let (sum, weight) = (self.sum_of_layer(layer, span), self.weight_at_root(layer));
            if layer == 0 {
                let part = sum.span.map_or(1.0, |played| span_part(span, played));
                moved = if sum.total > 1e-3 { sum.over(sum.total / part) } else { moved };
            } else if sum.total > LEAST_WEIGHT && weight > 0.0 {
                let part = weight * if sum.total < 1.0 { sum.total } else { 1.0 };
                moved = moved.mix(&sum.over(sum.total), part);
            }
        }
        moved
    }

    /// How much a layer weighs at the first joint, where it moves that: one that adds does not.
    fn weight_at_root(&self, layer: u32) -> f32 {
        let of_member = member_layers(self.tables, self.control.member);
        match of_member.get(layer as usize) {
            _ if layer == 0 => 1.0,
            Some(layer) if !layer.is_additive() => match layer.mask() {
                Some(mask) => layer.weight * self.tables.masks().as_slice()[mask as usize],
                None => layer.weight,
            },
            _ => 0.0,
        }
    }

    fn sum_of_layer(&self, layer: u32, within: Span) -> Sum {
        let mut sum = Sum::default();
        for slot in &self.tables.slots().as_slice()[self.tables.slot_range(self.control.member)] {
            let Some((slot, span)) = self.slot_within(slot, within) else { continue };
            let weight = slot.mean_weight(span.0, span.1);
            if weight <= 0.0 || slot.layer() != layer {
                continue;
            }
            let bound = &self.tables.bound_clips().as_slice()[slot.bound_clip as usize];
            let moved = self.move_of_slot(&slot, bound, span);
            sum.shift = vec3::add_scaled(sum.shift, moved.shift, weight * bound.motion_scale);
            sum.heading = [0, 1].map(|i: usize| sum.heading[i] + moved.heading[i] * weight);
            sum.weight += weight;
            sum.total += weight * span_part(within, span);
            sum.span =
                sum.span.map_or(Some(span), |all| Some((all.0.min(span.0), all.1.max(span.1))));
        }
        sum
    }

    /// A slot that plays within a span, or in place of a machine's the one that it stands for, and
    /// when it does.
    fn slot_within(&self, slot: &Slot, within: Span) -> Option<(Slot, Span)> {
        let span = span_of(slot, within)?;
        if slot.mode() != SLOT_MACHINE {
            return Some((*slot, span));
        }
        let weight = slot.mean_weight(span.0, span.1);
        let slot = machine_slot(self.tables, &self.keeping.running, slot, weight);
        Some((slot, span_of(&slot, span)?))
    }

    /// How far a slot's clip moves its own body from one time of the clock to another, seen from
    /// where it had it.
    fn move_of_slot(&self, slot: &Slot, bound: &BoundClip, (from_tick, until): Span) -> Move {
        let clip = &self.tables.clips().as_slice()[bound.clip as usize];
        if clip.motion_count == 0 || !matches!(slot.mode(), SLOT_LOOP | SLOT_ONCE) {
            return Move::NONE;
        }
        let at =
            |tick| self.motion_at(clip, slot.time_at(tick, clip.start_secs, clip.duration_secs));
        let (from, to) = (at(from_tick), at(until));
        let cycle = self.motion_at(clip, clip.start_secs + clip.duration_secs);
        let whole = match (slot.cycles_between(from_tick, until), slot.phase_rate >> 63 != 0) {
            (count, true) => cycle.undone().times(count),
            (count, false) => cycle.times(count),
        };
        from.undone().then(&whole.then(&to))
    }

    /// Where a clip has its body at a time.
    fn motion_at(&self, clip: &ClipRows, secs: f32) -> Move {
        let last = (clip.motion_count - 1) as f32;
        let place = (secs - clip.start_secs) * clip.motion_rows_per_sec;
        let place = if place > 0.0 { if place < last { place } else { last } } else { 0.0 };
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "held to the rows"
        )]
        let row = place as u32;
        let rows = self.tables.motions().as_slice();
        let at = |row: u32| {
            let first = ((clip.motion_first + row) * MOTION_ELEMENTS) as usize;
            let [sin, cos, ..] = rows[first + 1].0;
            Move { shift: rows[first].xyz(), heading: [sin, cos] }
        };
        let next = if row + 1 < clip.motion_count { row + 1 } else { row };
        at(row).mix(&at(next), place - row as f32)
    }
}

const _: () = assert!(
    MOTION_STATE == FEET_MOST && MOTION_STATE + 4 <= STATES_PER_CONTROL,
    "elements of feet come first, then those of motion"
);
