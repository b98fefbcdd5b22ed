//! Characters: a skeleton, the meshes on it, materials, and the clips that came with it.
//!
//! [`Character::new`] checks a [`CharacterSource`], as an importer finds it: every index points at
//! something, every number is finite. [`vertex_reach_m`] and [`sole_points`] tell the skeleton what
//! its vertices reach and which may touch the ground.

mod character;
mod error;
mod rehang;
mod sole_points;

pub use character::{
    AlphaMode, Bounds, Character, CharacterSource, Image, Influences, Material, Mesh, PaletteEntry,
    Part, SkinInstance, Texture, TextureFilter, Wrap, vertex_reach_m,
};
pub use error::Error;
pub use sole_points::sole_points;
