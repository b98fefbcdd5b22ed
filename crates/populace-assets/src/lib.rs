//! Reads characters and clips from glTF 2.0 files, text or binary, into the types of [`populace_core`].
//!
//! Units and spaces are those of glTF: metres, seconds, radians, Y up, +Z front; nothing is scaled or turned.
//!
//! ```
//! let file = br#"{
//!     "asset": {"version": "2.0"},
//!     "nodes": [{"name": "hips", "children": [1]}, {"name": "head", "translation": [0, 0.6, 0]}],
//!     "skins": [{"joints": [0, 1]}]
//! }"#;
//! let imported = populace_assets::load_from_slice(file, None)?;
//! let skeleton = &imported.character.skeleton;
//! let head = skeleton.find("head").expect("the file names it");
//! assert_eq!(skeleton.parent(head), skeleton.find("hips"));
//! assert_eq!(skeleton.rest(head).translation, [0.0, 0.6, 0.0]);
//!
//! // Everything that is wrong with a file is listed, each with its place.
//! let broken = br#"{
//!     "asset": {"version": "2.0"},
//!     "nodes": [{"children": [7]}],
//!     "skins": [{"joints": [0, "1"]}]
//! }"#;
//! let error = populace_assets::load_from_slice(broken, None).unwrap_err();
//! assert_eq!(error.to_string(), "glTF data is refused:\n\
//!     nodes[0].children[0]: names node 7, but there is only node 0\n\
//!     skins[0].joints[1]: must be a whole number, but is a string");
//! # Ok::<(), populace_assets::Error>(())
//! ```
//!
//! What becomes of a file: nodes that are joints, stand above or below one, carry a mesh of their own or are moved by
//! an animation form the skeleton. The meshes of the default scene become parts, animations become clips. What the
//! file holds beyond that is ignored, and [`Imported::notes`] says what and why.
//!
//! The main decision: JSON is read through a cursor that knows its own path and a log that gathers problems, rather
//! than into declared structures that fail at the first surprise. A file is refused with all of its problems or taken
//! whole; memory stays in proportion to the file, whatever counts it claims.

mod accessor;
mod animations;
mod data;
mod error;
mod extensions;
mod geometry;
mod glb;
mod images;
mod import;
mod influences;
mod json;
mod log;
mod materials;
mod nodes;
mod parts;
mod primitive;
mod rig;
mod skins;
mod uri;

use std::path::{Path, PathBuf};

use populace_core::Character;

pub use error::{Error, Note, Problem};

/// A file, as far as crowds are concerned.
#[derive(Clone, Debug)]
pub struct Imported {
    /// The skeleton, what is drawn on it, and its clips. A file of clips alone gives a character without parts, whose
    /// clips bind to other skeletons by joint name.
    pub character: Character,
    /// What was ignored and why, and what was repaired.
    pub notes: Vec<Note>,
    /// What wrote the file, if it says so.
    pub generator: Option<String>,
    /// The skins of the file, used or not, in its order.
    pub skins: Vec<SkinInfo>,
    /// For each joint, in level order, the file's index of the node that it is; `None` for a joint that was made up.
    pub node_from_joint: Vec<Option<usize>>,
    /// Every file that the file's buffers and images name, read or not, below its folder.
    pub named_files: Vec<PathBuf>,
}

/// A skin, for people to read of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SkinInfo {
    /// Its name; may be empty.
    pub name: String,
    /// How many joints it has.
    pub joint_count: usize,
}

/// Loads a `.gltf` or `.glb` file; which of the two it is, its content tells. Buffers and images that it names are
/// read from its folder or by a path relative to that.
///
/// # Errors
///
/// [`Error::Io`] if the file cannot be read, [`Error::Rejected`] if it is not what it should be.
pub fn load(path: impl AsRef<Path>) -> Result<Imported, Error> {
    let path = path.as_ref();
    let bytes = std::fs::read(path).map_err(|source| Error::Io { path: path.to_owned(), source })?;
    let base_folder = path.parent().unwrap_or(Path::new(""));
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    import::import(&bytes, Some(base_folder), &name)
        .map_err(|problems| Error::Rejected { file: path.display().to_string(), problems })
}

/// Loads the bytes of a `.gltf` or `.glb` file. Files that it names are looked for below `base_folder`; without one
/// they count as missing. The character is called `character`.
///
/// # Errors
///
/// [`Error::Rejected`] if the bytes are not what they should be.
pub fn load_from_slice(bytes: &[u8], base_folder: Option<&Path>) -> Result<Imported, Error> {
    import::import(bytes, base_folder, "character")
        .map_err(|problems| Error::Rejected { file: "glTF data".into(), problems })
}
