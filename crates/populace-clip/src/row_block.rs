//! Blocks of 16 columns and their locations within a row.

/// Columns in a block. Devices read rows in blocks of this size.
pub const COLUMNS_PER_BLOCK: u32 = 16;
/// [`COLUMNS_PER_BLOCK`] as an index.
pub(crate) const BLOCK: usize = COLUMNS_PER_BLOCK as usize;
/// First word of a property that does not move in a block.
pub const NO_PLANES: u32 = u32::MAX;
/// Flag in a [`RowBlock`]'s lanes: the planes hold floats, one for each component.
pub const ROW_FLOATS: u32 = 1 << 31;

/// Location of a block of 16 columns within a row: for each property the first word, or
/// [`NO_PLANES`] if nothing moves, and the lanes: columns per plane, with [`ROW_FLOATS`] if planes
/// hold floats instead of 16-bit steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RowBlock {
    /// First word of the rotations.
    pub rotation_first: u32,
    /// Columns in each of their planes.
    pub rotation_lanes: u32,
    /// First word of the translations.
    pub translation_first: u32,
    /// Columns in each of their planes.
    pub translation_lanes: u32,
    /// First word of the scales.
    pub scale_first: u32,
    /// Columns in each of their planes.
    pub scale_lanes: u32,
}

impl RowBlock {
    /// A block in which nothing moves.
    pub const STILL: Self = Self {
        rotation_first: NO_PLANES,
        rotation_lanes: 0,
        translation_first: NO_PLANES,
        translation_lanes: 0,
        scale_first: NO_PLANES,
        scale_lanes: 0,
    };
}
