//! Instances of characters, and the source of instances and palettes that a renderer draws from.

use std::fmt;
use std::sync::Arc;

use populace_character::Character;
use populace_model::Affine;

use crate::interop::PaletteSource;
use crate::look::MemberLook;
use crate::view::Visibility;

/// One instance of a character.
#[derive(Clone, Copy)]
pub struct Instance<'a> {
    /// The character. A renderer keeps what it uploads for each, known by its address.
    pub character: &'a Arc<Character>,
    /// The placement in the world.
    pub world_from_model: Affine,
    /// The root-motion offset from the placement, in metres in world space. The palette includes
    /// it.
    pub moved: [f32; 3],
    /// The first palette entry: page times [`PAGE_ENTRIES`](crate::layout::PAGE_ENTRIES) plus the
    /// index within the page, as in [`Member`](crate::layout::Member).
    pub palette_first: u32,
    /// Its tints, and the options of the character that it does not show.
    pub look: MemberLook,
    /// Level of detail: 0 for the character's own meshes, else one more than the index of its
    /// [`levels`](Character::levels). The coarsest level stands for all above it.
    pub level: u32,
    /// The part of the view that it takes. A hidden instance is not drawn.
    pub visibility: Visibility,
}

impl fmt::Debug for Instance<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Instance")
            .field("character", &self.character.name)
            .field("world_from_model", &self.world_from_model)
            .field("moved", &self.moved)
            .field("palette_first", &self.palette_first)
            .field("look", &self.look)
            .field("level", &self.level)
            .field("visibility", &self.visibility)
            .finish()
    }
}

/// A source of palettes that knows what to draw with them, such as a crowd.
pub trait DrawSource: PaletteSource {
    /// The instances to draw with the palettes that were last handed over.
    fn instances(&self) -> Vec<Instance<'_>>;
}
