//! Characters: a skeleton with its meshes, materials and clips.
//!
//! [`Character::new`] checks a [`CharacterSource`], as an importer builds it: all indices exist and
//! all numbers are finite. [`vertex_reach_m`] and [`sole_points`] tell the skeleton how far its
//! vertices reach and which may touch the ground. [`Region`] and [`PartOption`] are what members of a
//! crowd can vary: colours of skin, hair and clothes, and parts that are shown or not.

mod character;
mod error;
mod image;
mod joints_needed;
mod material;
mod mesh;
mod mirrored;
mod options;
mod pieces;
mod regions;
mod rehang;
mod sole_points;

pub use character::{
    Bounds, Character, CharacterSource, Level, PaletteEntry, Part, SkinInstance, vertex_reach_m,
};
pub use error::Error;
pub use image::{Image, linear_from_srgb};
pub use joints_needed::joints_needed;
pub use material::{AlphaMode, Material, Texture, TextureFilter, Wrap};
pub use mesh::{Influences, Mesh};
pub use options::{MAX_OPTIONS, PartOption};
pub use pieces::{pieces, welded};
pub use regions::{Region, RegionFinder};
pub use sole_points::sole_points;
