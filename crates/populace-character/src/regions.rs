//! Regions of a character's surface, which members can have in colours of their own.

mod names;
mod surface;

pub use surface::RegionFinder;

/// A region of a character's surface. Members can tint each one apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Region {
    /// Bare skin, with lips and nails.
    Skin,
    /// Hair, beard and brows.
    Hair,
    /// Clothes above the hips, and clothes that are worn over all.
    Top,
    /// Clothes below the hips.
    Trousers,
    /// Shoes and socks.
    Shoes,
    /// Hats, bags, glasses and other things that are worn.
    Accessory,
    /// All else, such as eyes and teeth.
    #[default]
    Other,
}

impl Region {
    /// Number of regions.
    pub const COUNT: usize = 7;
    /// All regions, in the order of their numbers.
    pub const ALL: [Self; Self::COUNT] = [
        Self::Skin,
        Self::Hair,
        Self::Top,
        Self::Trousers,
        Self::Shoes,
        Self::Accessory,
        Self::Other,
    ];

    /// The region's number, from 0 to 6, as shaders know it.
    #[must_use]
    pub const fn number(self) -> u8 {
        self as u8
    }

    /// Returns the region that a material's name tells; `None` if it tells none.
    ///
    /// A name that begins with the word Skin, Hair, Top, Trousers, Shoes, Accessory or Eyes is of
    /// that region; eyes are [`Other`](Self::Other). Otherwise common English words decide. They
    /// may end a longer word (`Sunglasses`), and case does not matter. If a name has words of
    /// several regions, what is worn counts before what wears it: `Body_Shirt` is a top.
    #[must_use]
    pub fn of_material(name: &str) -> Option<Self> {
        names::region(name)
    }
}
