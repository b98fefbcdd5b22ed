//! Blocks of 16 columns and their locations within a row.

use populace_model::Property;

/// Columns in a block. Devices read rows in blocks of this size.
pub const COLUMNS_PER_BLOCK: u32 = 16;
/// [`COLUMNS_PER_BLOCK`] as an index.
pub(crate) const BLOCK: usize = COLUMNS_PER_BLOCK as usize;
/// First word of a property that does not move in a block.
pub const NO_PLANES: u32 = u32::MAX;
/// Flag in a [`RowBlock`]'s lanes: the planes hold floats, one for each component.
pub const ROW_FLOATS: u32 = 1 << 31;

/// Location of a block of 16 columns within a row.
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
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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

    /// Returns whether a property is stored as floats.
    #[must_use]
    pub fn has_floats(&self) -> bool {
        let lanes = self.rotation_lanes | self.translation_lanes | self.scale_lanes;
        lanes & ROW_FLOATS != 0
    }

    /// Returns the block with the planes of those properties alone for which `moves` is true.
    #[must_use]
    pub fn with_planes_of(mut self, moves: impl Fn(Property) -> bool) -> Self {
        for (property, first, lanes) in [
            (Property::Rotation, &mut self.rotation_first, &mut self.rotation_lanes),
            (Property::Translation, &mut self.translation_first, &mut self.translation_lanes),
            (Property::Scale, &mut self.scale_first, &mut self.scale_lanes),
        ] {
            if !moves(property) {
                (*first, *lanes) = (NO_PLANES, 0);
            }
        }
        self
    }
}
