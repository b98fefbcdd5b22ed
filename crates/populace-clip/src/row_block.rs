//! Blocks of 16 columns and their locations within a row.

/// Columns in a block. Devices read rows in blocks of this size.
pub const COLUMNS_PER_BLOCK: u32 = 16;
/// [`COLUMNS_PER_BLOCK`] as an index.
pub(crate) const BLOCK: usize = COLUMNS_PER_BLOCK as usize;
/// First word of a property that does not move in a block.
pub const NO_PLANES: u32 = u32::MAX;
/// Flag in a [`RowBlock`]'s lanes: the planes hold floats, one for each component.
pub const ROW_FLOATS: u32 = 1 << 31;

/// Location of a block of 16 columns within a row. Devices read the same bytes.
///
/// A row is a run of 32-bit words. For each property that moves in the block, planes of words
/// follow each other from the property's first word:
///
/// | Format | Property | Plane | Words | Lane `i` |
/// |---|---|---|---|---|
/// | 16-bit | rotation | 0 | `lanes` | word `i`: `x` in bits 0 to 15, `y` in 16 to 31 |
/// | 16-bit | rotation | 1 | `lanes` | word `i`: `z` in bits 0 to 15, `w` in 16 to 31 |
/// | 16-bit | others | 0 | `lanes` | word `i`: `x` in bits 0 to 15, `y` in 16 to 31 |
/// | 16-bit | others | 1 | `lanes / 2` | word `i / 2`: `z`, low half for even `i`, else high |
/// | float | rotation | 0 to 3 | 16 each | word `i`: `x`, `y`, `z`, `w` as `f32` |
/// | float | others | 0 to 2 | 16 each | word `i`: `x`, `y`, `z` as `f32` |
///
/// *Others* are translation and scale; `lanes / 2` is rounded up.
///
/// The fields of each property:
///
/// | Field | Bits | Content |
/// |---|---|---|
/// | `*_first` | 0 to 31 | first word within the row, or [`NO_PLANES`] if nothing moves |
/// | `*_lanes` | 31 | [`ROW_FLOATS`]: the planes hold floats |
/// | `*_lanes` | 0 to 30 | columns per plane, up to the last column that moves |
///
/// A signed 16-bit number `n` stands for `offset + step * n`, see [`Range`](crate::Range).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct RowBlock {
    /// First word of the rotations, or [`NO_PLANES`].
    pub rotation_first: u32,
    /// Columns per rotation plane, and [`ROW_FLOATS`].
    pub rotation_lanes: u32,
    /// First word of the translations, or [`NO_PLANES`].
    pub translation_first: u32,
    /// Columns per translation plane, and [`ROW_FLOATS`].
    pub translation_lanes: u32,
    /// First word of the scales, or [`NO_PLANES`].
    pub scale_first: u32,
    /// Columns per scale plane, and [`ROW_FLOATS`].
    pub scale_lanes: u32,
}

impl RowBlock {
    /// A block without any moving property.
    pub const STILL: Self = Self {
        rotation_first: NO_PLANES,
        rotation_lanes: 0,
        translation_first: NO_PLANES,
        translation_lanes: 0,
        scale_first: NO_PLANES,
        scale_lanes: 0,
    };

    /// Merges two blocks into one that only tells what moves in either, and whether either stores
    /// it as floats ([`ROW_FLOATS`]). First words are those of one of the two.
    #[must_use]
    pub const fn or_moving(mut self, other: &Self) -> Self {
        if other.rotation_first != NO_PLANES {
            (self.rotation_first, self.rotation_lanes) =
                (other.rotation_first, self.rotation_lanes | other.rotation_lanes);
        }
        if other.translation_first != NO_PLANES {
            (self.translation_first, self.translation_lanes) =
                (other.translation_first, self.translation_lanes | other.translation_lanes);
        }
        if other.scale_first != NO_PLANES {
            (self.scale_first, self.scale_lanes) =
                (other.scale_first, self.scale_lanes | other.scale_lanes);
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn merged_blocks_keep_float_flags_in_either_order() {
        let block = |lanes| RowBlock {
            rotation_first: 0,
            rotation_lanes: lanes,
            translation_first: 8,
            translation_lanes: lanes,
            scale_first: 16,
            scale_lanes: lanes,
        };
        let (floats, halves) = (block(ROW_FLOATS | 16), block(3));
        for merged in [floats.or_moving(&halves), halves.or_moving(&floats)] {
            let lanes = [merged.rotation_lanes, merged.translation_lanes, merged.scale_lanes];
            assert!(lanes.iter().all(|lanes| lanes & ROW_FLOATS != 0), "{merged:?}");
        }
    }
}
