//! Reads characters and clips from glTF 2.0 files, text or binary, into the types of
//! [`populace_character`].
//!
//! Units and spaces are those of glTF: metres, seconds, radians, Y up, +Z front; nothing is scaled
//! or turned.
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
//! What becomes of a file: nodes that are joints, stand above or below one, carry a mesh of their
//! own or are moved by an animation form the skeleton. The meshes of the default scene become
//! parts, animations become clips. What the file holds beyond that is ignored, and
//! [`Imported::notes`] says what and why.
//!
//! The main decision: JSON is read through a cursor that knows its own path and a log that gathers
//! problems, rather than into declared structures that fail at the first surprise. A file is
//! refused with all of its problems or taken whole.
//!
//! Files need not be trusted. By default URIs stay inside the folder of the file, and one load
//! takes at most 1 GiB, which is estimated before it is allocated ([`LoadOptions`]). Arrays and
//! clips stay in proportion to the size of the file, and so does the time that loading takes; at
//! most 131,072 nodes are read. Numbers of transforms, keys and vertices may be up to 1e9 in size,
//! and 1e18 where they are multiplied and added up along a chain of nodes, so that palettes stay
//! finite.

mod accessor;
mod animations;
mod budget;
mod data;
mod error;
mod extensions;
mod extents;
mod folder;
mod geometry;
mod glb;
mod images;
mod import;
mod influences;
mod json;
mod log;
mod materials;
mod nodes;
mod options;
mod parts;
mod primitive;
mod read;
mod rig;
mod skins;
mod tree;
mod uri;

use std::io::Read;
use std::path::{Path, PathBuf};

use populace_character::Character;

use budget::Budget;
use folder::Folder;
use log::{Checked, Log};

pub use error::{Error, Note, Problem};
pub use options::LoadOptions;

/// A file, as far as crowds are concerned.
#[derive(Clone, Debug)]
pub struct Imported {
    /// The skeleton, what is drawn on it, and its clips. A file of clips alone gives a character
    /// without parts, whose clips bind to other skeletons by joint name.
    pub character: Character,
    /// What was ignored and why, and what was repaired.
    pub notes: Vec<Note>,
    /// What wrote the file, if it says so.
    pub generator: Option<String>,
    /// The skins of the file, used or not, in its order.
    pub skins: Vec<SkinInfo>,
    /// For each joint, in level order, the file's index of the node that it is; `None` for a joint
    /// that was made up.
    pub node_from_joint: Vec<Option<usize>>,
    /// Every file that the file's buffers and images name, read or not, below its folder.
    pub named_files: Vec<PathBuf>,
    /// For each part of the character the number of vertices that the file has. They come first and
    /// keep their order; those after them repeat some with the normals of other triangles, where
    /// the file has no normals.
    pub vertex_counts: Vec<usize>,
}

/// A skin, for people to read of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SkinInfo {
    /// Its name; may be empty.
    pub name: String,
    /// How many joints it has.
    pub joint_count: usize,
}

/// Loads a `.gltf` or `.glb` file with the default [`LoadOptions`].
///
/// # Errors
///
/// As [`load_with`].
pub fn load(path: impl AsRef<Path>) -> Result<Imported, Error> {
    load_with(path, &LoadOptions::default())
}

/// Loads a `.gltf` or `.glb` file; which of the two it is, its content tells. Buffers and images
/// that it names are read from its folder.
///
/// # Errors
///
/// [`Error::Io`] if the file cannot be read or is no regular file, [`Error::Rejected`] if it is not
/// what it should be or goes beyond `options`.
pub fn load_with(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Imported, Error> {
    let path = path.as_ref();
    let job = Job {
        name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        file: path.to_owned(),
        folder: Folder::new(Some(path.parent().unwrap_or(Path::new(""))), options.allow_outside),
        options,
    };
    job.run(|budget, log| read::file(path, budget, log))
}

/// Loads the bytes of a `.gltf` or `.glb` file from a stream, as standard input. It ends with the
/// stream, or where the header of a binary file says. Other files that it names count as missing.
/// `name` stands for the stream in messages and is the name of the character.
///
/// # Errors
///
/// As [`load_with`].
pub fn load_from_reader(
    reader: impl Read,
    name: &str,
    options: &LoadOptions,
) -> Result<Imported, Error> {
    let folder = Folder::new(None, options.allow_outside);
    let job = Job { name: name.into(), file: name.into(), folder, options };
    job.run(|budget, log| read::stream(reader, None, budget, log))
}

/// Loads the bytes of a `.gltf` or `.glb` file with the default [`LoadOptions`]. Files that it
/// names are looked for below `base_folder`; without one they count as missing. The character is
/// called `character`.
///
/// # Errors
///
/// [`Error::Rejected`] if the bytes are not what they should be.
pub fn load_from_slice(bytes: &[u8], base_folder: Option<&Path>) -> Result<Imported, Error> {
    load_from_slice_with(bytes, base_folder, &LoadOptions::default())
}

/// [`load_from_slice`] with other options. The bytes themselves do not count as memory that the
/// load takes.
///
/// # Errors
///
/// [`Error::Rejected`] if the bytes are not what they should be or go beyond `options`.
pub fn load_from_slice_with(
    bytes: &[u8],
    base_folder: Option<&Path>,
    options: &LoadOptions,
) -> Result<Imported, Error> {
    let folder = Folder::new(base_folder, options.allow_outside);
    let job = Job { name: "character".into(), file: "glTF data".into(), folder, options };
    job.run(|_, _| Ok(Ok(bytes)))
}

/// One load.
struct Job<'a> {
    /// The character's name.
    name: String,
    /// For messages.
    file: PathBuf,
    folder: Folder,
    options: &'a LoadOptions,
}

impl Job<'_> {
    fn run<B: AsRef<[u8]>>(
        &self,
        bytes: impl FnOnce(&Budget, &Log) -> std::io::Result<Checked<B>>,
    ) -> Result<Imported, Error> {
        let log = Log::default();
        let budget = Budget::new(self.options.memory_limit_bytes, &log);
        let bytes =
            bytes(&budget, &log).map_err(|source| Error::Io { path: self.file.clone(), source })?;
        let built =
            bytes.and_then(|b| import::import(b.as_ref(), &self.name, &self.folder, &budget, &log));
        let rejected =
            |problems| Error::Rejected { file: self.file.display().to_string(), problems };
        let notes = log.finish().map_err(rejected)?;
        // Whoever gives up has said why; should one not have, that must not look like success.
        let silent = || vec![Problem { place: "file".into(), what: "cannot be imported".into() }];
        built.map(|imported| Imported { notes, ..imported }).map_err(|_| rejected(silent()))
    }
}
