//! Root motion: where its clips move a member, frame after frame; the twin of `kernels/motion.cl`.
//!
//! Each clip says how far it moves the body between the last frame and this one, seen from where it had it; these moves are
//! mixed as poses are, and the mix goes on from where the member was.

use populace_core::Affine;
use populace_core::layout::{
    BoundClip, ClipRows, FEET_MOST, Float4, Layer, MOTION_ELEMENTS, MOTION_STATE, NONE, SLOT_LOOP, SLOT_ONCE,
    Slot, Step,
};
use populace_core::math::{Real, vec3};

use super::{Models, Steering};
use crate::machines::slot_now;
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

/// A weighted sum of moves.
#[derive(Default)]
struct Sum {
    shift: [f32; 3],
    heading: [f32; 2],
    total: f32,
}

impl Sum {
    fn mean(&self) -> Move {
        let k = 1.0 / self.total;
        Move::new(vec3::scale(self.shift, k), self.heading.map(|h| h * k))
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

    /// The mix of what all clips do since the frame before. Layers that add to what lies beneath move nobody.
    fn move_of_frame(&self) -> Move {
        let mut moved = Move::NONE;
        for (index, layer) in (0..).zip(member_layers(self.tables, self.control.member)) {
            let sum = self.sum_of_layer(index);
            if index == 0 {
                moved = if sum.total > 1e-3 { sum.mean() } else { moved };
            } else if sum.total > 0.0 && !layer.is_additive() {
                let part = self.weight_at_root(layer) * if sum.total < 1.0 { sum.total } else { 1.0 };
                moved = moved.mix(&sum.mean(), part);
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
            let slot = &slot_now(self.tables, &self.keeping.running, slot, self.tick);
            let weight = if slot.bound_clip == NONE { 0.0 } else { slot.weight_at(self.tick) };
            if weight <= 0.0 || slot.layer() != layer {
                continue;
            }
            let bound = &self.tables.bound_clips().as_slice()[slot.bound_clip as usize];
            let moved = self.move_of_slot(slot, bound);
            sum.shift = vec3::add_scaled(sum.shift, moved.shift, weight * bound.motion_scale);
            sum.heading = [0, 1].map(|i: usize| sum.heading[i] + moved.heading[i] * weight);
            sum.total += weight;
        }
        sum
    }

    /// How far a slot's clip moves its own body since the frame before, seen from where it had it.
    fn move_of_slot(&self, slot: &Slot, bound: &BoundClip) -> Move {
        let clip = &self.tables.clips().as_slice()[bound.clip as usize];
        let from_tick = self.tick.saturating_sub(u64::from(self.clock.elapsed_ticks)).max(slot.start_tick);
        if clip.motion_count == 0 || from_tick >= self.tick || !matches!(slot.mode(), SLOT_LOOP | SLOT_ONCE) {
            return Move::NONE;
        }
        let at = |tick| self.motion_at(clip, slot.time_at(tick, clip.start_secs, clip.duration_secs));
        let (from, to) = (at(from_tick), at(self.tick));
        let cycle = self.motion_at(clip, clip.start_secs + clip.duration_secs);
        let whole = match (slot.cycles_between(from_tick, self.tick), slot.phase_rate >> 63 != 0) {
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
