//! Encoding of components in a clip's rows. Twin of `kernels/rows.cl`.

use populace_device::layout::{NONE, ROW_FLOATS, ROW_PARTS, RowBlock, SlotSample};
use populace_model::Property;
use populace_model::math::Real;

use crate::lanes::Lanes;

/// Position of a property's planes in a row.
#[derive(Clone, Copy)]
pub(crate) struct Planes {
    /// First word; [`NONE`] if the property does not move.
    first: u32,
    /// Words from one plane to the next, and [`ROW_FLOATS`] if components are floats.
    lanes: u32,
}

impl Planes {
    #[inline(always)]
    pub(crate) fn of(block: &RowBlock, property: Property) -> Self {
        let (first, lanes) = match property {
            Property::Rotation => (block.rotation_first, block.rotation_lanes),
            Property::Translation => (block.translation_first, block.translation_lanes),
            Property::Scale => (block.scale_first, block.scale_lanes),
        };
        Self { first, lanes }
    }

    /// Returns whether the property does not move.
    #[inline(always)]
    pub(crate) fn are_still(self) -> bool {
        self.first == NONE
    }

    /// Returns whether components are floats.
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    pub(crate) fn are_floats(self) -> bool {
        self.lanes & ROW_FLOATS != 0
    }

    /// Tells the compiler that the planes hold 16-bit numbers.
    #[inline(always)]
    pub(crate) fn of_halves(self) -> Self {
        Self { lanes: self.lanes & !ROW_FLOATS, ..self }
    }

    /// Returns the first word of the plane that holds a component, and its encoding.
    #[inline(always)]
    pub(crate) fn plane_at(
        self,
        property: Property,
        row: u32,
        component: usize,
    ) -> (usize, Encoding) {
        let start = (row + self.first) as usize;
        let lanes = (self.lanes & !ROW_FLOATS) as usize;
        if self.lanes & ROW_FLOATS != 0 {
            return (start + component * lanes, Encoding::Float);
        }
        let encoding = match component {
            2 if property != Property::Rotation => Encoding::Packed,
            0 | 2 => Encoding::LowHalf,
            _ => Encoding::HighHalf,
        };
        (start + component / 2 * lanes, encoding)
    }
}

/// Encoding of a component in its plane.
#[derive(Clone, Copy)]
pub(crate) enum Encoding {
    Float,
    /// The low 16 bits of each lane's word.
    LowHalf,
    /// The high 16 bits of each lane's word.
    HighHalf,
    /// 16 bits for each lane, two lanes in a word.
    Packed,
}

/// Two rows, and their weights.
#[derive(Clone, Copy, Default)]
pub(crate) struct Rows {
    pub(crate) from: u32,
    pub(crate) to: u32,
    /// Part of the way from the first row to the second, for rows of floats.
    pub(crate) between: f32,
    /// Weights for rows of 16-bit numbers, in [`ROW_PARTS`]: the first row's in the lower half, the
    /// second row's in the upper half.
    pub(crate) halves: u32,
}

impl Rows {
    #[inline(always)]
    pub(crate) fn of(at: &SlotSample) -> Self {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "the cast saturates"
        )]
        let (all, second) = (ROW_PARTS as u32, (at.between * ROW_PARTS + 0.5) as u32);
        // Places that callers give may lie past the last row.
        let second = second.min(all);
        let halves = (all - second) | second << 16;
        Self { from: at.row0, to: at.row1, between: at.between, halves }
    }

    /// Returns the weighted sum of two 16-bit numbers, which are signed.
    #[inline(always)]
    fn mix_halves(&self, from: u32, to: u32) -> f32 {
        #[expect(clippy::cast_possible_truncation, reason = "takes the lower half")]
        let [from, to, first, second] =
            [from, to, self.halves, self.halves >> 16].map(|half| i32::from(half as i16));
        (from * first + to * second) as f32
    }
}

impl Encoding {
    /// Decodes a lane between two planes, in [`ROW_PARTS`] of a step.
    #[inline(always)]
    pub(crate) fn parts_in(self, from: &[u32], to: &[u32], lane: usize, rows: &Rows) -> f32 {
        match self {
            Self::Float => {
                let (from, to) = (f32::from_bits(from[lane]), f32::from_bits(to[lane]));
                from.mix(to, rows.between) * ROW_PARTS
            }
            Self::LowHalf => rows.mix_halves(from[lane], to[lane]),
            Self::HighHalf => rows.mix_halves(from[lane] >> 16, to[lane] >> 16),
            Self::Packed => {
                let shift = 16 * (lane % 2);
                rows.mix_halves(from[lane / 2] >> shift, to[lane / 2] >> shift)
            }
        }
    }

    /// Decodes sixteen lanes between two planes.
    #[inline(always)]
    pub(crate) fn parts(self, from: &[u32], to: &[u32], rows: &Rows) -> Lanes {
        Lanes::from_fn(|lane| self.parts_in(from, to, lane, rows))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_rows_are_whole_and_never_leave_their_halves() {
        let halves = |between: f32| {
            let rows = Rows::of(&SlotSample { row0: 0, row1: 0, between, weight: 1.0 });
            (rows.halves & 0xffff, rows.halves >> 16)
        };
        assert_eq!(halves(0.0), (32_767, 0));
        assert_eq!(halves(0.25), (24_575, 8_192));
        assert_eq!(halves(1.0_f32.next_down()), (0, 32_767));
        // A place past the last row, between that row and itself.
        assert_eq!(halves(5.0), (0, 32_767));
        assert_eq!(halves(f32::NAN), (32_767, 0));
    }
}
