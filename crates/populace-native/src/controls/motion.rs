//! Root motion: where its clips move a member, frame after frame; the twin of `kernels/motion.cl`.
//!
//! Each clip says how far it moves the body between the last frame and this one, seen from where it had it; these moves are
//! mixed as poses are, and the mix goes on from where the member was. A clip that played for a part of the frame moves the
//! body for that part, by the mean of what it weighed then: so nothing is lost of what is left in the midst of a frame.

use populace_core::Affine;
use populace_core::layout::{
    BoundClip, ClipRows, FEET_MOST, Float4, Layer, MOTION_ELEMENTS, MOTION_STATE, NONE, SLOT_LOOP,
    SLOT_MACHINE, SLOT_ONCE, Slot, Step,
};
use populace_core::math::{Real, vec3};

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
    /// Where moves that weighed so much in all go. Those that each played in a part of the frame come after each other, so
    /// that what all weighed while they played is more: each turns from straight ahead.
    fn over(&self, total: f32) -> Move {
        let ([sin, cos], k) = (self.heading, 1.0 / total);
        Move::new(vec3::scale(self.shift, k), [sin * k, (cos + (total - self.weight)) * k])
    }
}

impl Steering<'_> {
    /// Moves a root to where clips have moved the member.
    #[inline(never)]
    pub(super) fn moves(&mut self, models: &mut impl Models, joint: usize, step: &Step) {
        let [place, heading] = [0, 1].map(|element| self.state(MOTION_STATE + element).0);
        let ours = place[3].to_bits() == step.turn;
        let last = if ours {
            Move { shift: [place[0], place[1], place[2]], heading: [heading[0], heading[1]] }
        } else {
            Move::NONE
        };
        let now = last.then(&self.move_of_frame());
        if joint == 0 {
            let [x, y, z] = now.shift;
            self.keep_state(MOTION_STATE, Float4([x, y, z, f32::from_bits(step.turn)]));
            self.keep_state(MOTION_STATE + 1, Float4([now.heading[0], now.heading[1], 0.0, 0.0]));
        }
        let ([x, y, z], [s, c]) = (now.shift, now.heading);
        let carried = Affine { rows: [[c, 0.0, s, x], [0.0, 1.0, 0.0, y], [-s, 0.0, c, z]] };
        models.set(joint, carried.mul(&models.model(joint)));
    }

    /// The mix of what all clips do since the frame before, each for as long as it played. Layers that add to what lies
    /// beneath move nobody.
    fn move_of_frame(&self) -> Move {
        let mut moved = Move::NONE;
        for (index, layer) in (0..).zip(member_layers(self.tables, self.control.member)) {
            let sum = self.sum_of_layer(index);
            if index == 0 {
                let part = sum.span.map_or(1.0, |span| self.part_of_frame(span));
                moved = if sum.total > 1e-3 { sum.over(sum.total / part) } else { moved };
            } else if sum.total > 0.0 && !layer.is_additive() {
                let part = self.weight_at_root(layer) * if sum.total < 1.0 { sum.total } else { 1.0 };
                moved = moved.mix(&sum.over(sum.total), part);
            }
        }
        moved
    }

    /// How much a layer weighs at the first joint.
    fn weight_at_root(&self, layer: &Layer) -> f32 {
        match layer.mask() {
            Some(mask) => layer.weight * self.tables.masks().as_slice()[mask as usize],
            None => layer.weight,
        }
    }

    fn sum_of_layer(&self, layer: u32) -> Sum {
        let mut sum = Sum::default();
        for slot in &self.tables.slots().as_slice()[self.tables.slot_range(self.control.member)] {
            let Some((slot, span)) = self.slot_of_frame(slot) else { continue };
            let weight = slot.mean_weight(span.0, span.1);
            if weight <= 0.0 || slot.layer() != layer {
                continue;
            }
            let bound = &self.tables.bound_clips().as_slice()[slot.bound_clip as usize];
            let moved = self.move_of_slot(&slot, bound, span);
            sum.shift = vec3::add_scaled(sum.shift, moved.shift, weight * bound.motion_scale);
            sum.heading = [0, 1].map(|i: usize| sum.heading[i] + moved.heading[i] * weight);
            sum.weight += weight;
            sum.total += weight * self.part_of_frame(span);
            sum.span = sum.span.map_or(Some(span), |all| Some((all.0.min(span.0), all.1.max(span.1))));
        }
        sum
    }

    fn part_of_frame(&self, (from, until): Span) -> f32 {
        (until - from) as f32 / self.clock.elapsed_ticks as f32
    }

    /// When a slot plays within a span; not once it was cut.
    fn span_of(slot: &Slot, (from, until): Span) -> Option<Span> {
        let is_cut = slot.end_weight <= 0.0 && slot.weight_rate == 0.0;
        let until = if is_cut { until.min(slot.weight_tick) } else { until };
        Some((from.max(slot.start_tick), until))
            .filter(|(from, until)| slot.bound_clip != NONE && from < until)
    }

    /// A slot that plays within the frame, or in place of a machine's the one that it stands for, and when it does.
    fn slot_of_frame(&self, slot: &Slot) -> Option<(Slot, Span)> {
        let before = self.tick.saturating_sub(u64::from(self.clock.elapsed_ticks));
        let span = Self::span_of(slot, (before, self.tick))?;
        if slot.mode() != SLOT_MACHINE {
            return Some((*slot, span));
        }
        let weight = slot.mean_weight(span.0, span.1);
        let slot = machine_slot(self.tables, &self.keeping.running, slot, weight);
        Some((slot, Self::span_of(&slot, span)?))
    }

    /// How far a slot's clip moves its own body from one time of the clock to another, seen from where it had it.
    fn move_of_slot(&self, slot: &Slot, bound: &BoundClip, (from_tick, until): Span) -> Move {
        let clip = &self.tables.clips().as_slice()[bound.clip as usize];
        if clip.motion_count == 0 || !matches!(slot.mode(), SLOT_LOOP | SLOT_ONCE) {
            return Move::NONE;
        }
        let at = |tick| self.motion_at(clip, slot.time_at(tick, clip.start_secs, clip.duration_secs));
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
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "held to the rows")]
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

const _: () = assert!(MOTION_STATE == FEET_MOST, "elements of feet come first");
