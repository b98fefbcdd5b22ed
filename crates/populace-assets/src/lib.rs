//! Reads characters and clips from glTF 2.0 files, text or binary, into the types of
//! [`populace_character`], and writes characters with their levels of detail ([`to_glb`]).
//!
//! Units and axes are those of glTF: metres, seconds, radians, +Y up, +Z front. Nothing is scaled
//! or rotated.
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
//! // The error lists every problem of the file with its location.
//! let broken = br#"{
//!     "asset": {"version": "2.0"},
//!     "nodes": [{"children": [7]}],
//!     "skins": [{"joints": [0, "1"]}]
//! }"#;
//! let error = populace_assets::load_from_slice(broken, None).unwrap_err();
//! assert_eq!(error.to_string(), "glTF data is refused:\n\
//!     nodes[0].children[0]: refers to node 7, but the last one is node 0\n\
//!     skins[0].joints[1]: must be a whole number, but is a string");
//! # Ok::<(), populace_assets::Error>(())
//! ```
//!
//! # Mapping
//!
//! A node becomes a joint of the skeleton if it is a skin joint, an ancestor or descendant of one,
//! carries a mesh of its own, or is animated. The meshes of the default scene become parts, and
//! animations become clips. Other data is ignored; [`Imported::notes`] lists it with the reasons.
//!
//! Levels of detail are read from files that name the coarser nodes of each mesh node by MSFT_lod,
//! and in `extras.error_m` of that node how far each is off in metres. [`to_glb`] writes such files.
//!
//! # Errors
//!
//! JSON is read through a cursor that tracks its own path and a log that collects problems. Serde
//! structures would stop at the first mismatch. A file is either loaded completely or refused with
//! a list of all of its problems.
//!
//! # Untrusted files
//!
//! By default, URIs must stay inside the folder of the file, and one load may use at most 1 GiB of
//! memory, which is estimated before each allocation ([`LoadOptions`]). The size of arrays and
//! clips, and with it the loading time, is limited in proportion to the size of the file. At most
//! 131,072 nodes are read. The magnitude of numbers in transforms, keys and vertices is limited to
//! 1e9, and that of products and sums along a chain of nodes to 1e18, so that palettes stay finite.

mod accessor;
mod animations;
mod bind_pose;
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
mod levels;
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
mod write;

use std::io::Read;
use std::path::{Path, PathBuf};

use populace_character::Character;

use budget::Budget;
use folder::Folder;
use log::{Checked, Log};

pub use error::{Error, Note, Problem};
pub use options::LoadOptions;
pub use write::{WriteOptions, to_glb};

/// The result of loading a file.
#[derive(Clone, Debug)]
pub struct Imported {
    /// Skeleton, parts, materials and clips. A file that holds only clips gives a character without
    /// parts. Its clips bind to other skeletons by joint name.
    pub character: Character,
    /// Data that was ignored or repaired, with the reasons.
    pub notes: Vec<Note>,
    /// The program that wrote the file (`asset.generator`), if the file says so.
    pub generator: Option<String>,
    /// All skins in file order, including unused ones.
    pub skins: Vec<SkinInfo>,
    /// The node index in the file of each joint, in level order. `None` for a joint that was added
    /// by the importer.
    pub node_from_joint: Vec<Option<usize>>,
    /// Paths of all files that buffers and images refer to, joined to the folder of the file,
    /// whether they were read or not.
    pub named_files: Vec<PathBuf>,
    /// The number of vertices that the file has for each part. These vertices come first and keep
    /// their order. If the file has no normals, copies of some of them follow, which carry the flat
    /// normals of further triangles.
    pub vertex_counts: Vec<usize>,
}

/// Name and size of a skin, for display.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SkinInfo {
    /// The name; empty if the file gives none.
    pub name: String,
    /// The number of joints.
    pub joint_count: usize,
}

/// Loads a `.gltf` or `.glb` file with the default [`LoadOptions`].
///
/// # Errors
///
/// See [`load_with`].
pub fn load(path: impl AsRef<Path>) -> Result<Imported, Error> {
    load_with(path, &LoadOptions::default())
}

/// Loads a `.gltf` or `.glb` file. The format is detected from the content, not from the file name.
/// Buffers and images that the file refers to are read from its folder.
///
/// # Errors
///
/// [`Error::Io`] if the file cannot be read or is not a regular file. [`Error::Rejected`] if it is
/// not valid glTF, uses an unsupported feature, or exceeds the limits of `options`.
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

/// Loads a `.gltf` or `.glb` file from a stream such as standard input. Reads up to the end of the
/// stream, or up to the length in the header of a binary file. Files that the data refers to count
/// as missing. `name` identifies the stream in messages and becomes the name of the character.
///
/// # Errors
///
/// See [`load_with`].
pub fn load_from_reader(
    reader: impl Read,
    name: &str,
    options: &LoadOptions,
) -> Result<Imported, Error> {
    let folder = Folder::new(None, options.allow_outside);
    let job = Job { name: name.into(), file: name.into(), folder, options };
    job.run(|budget, log| read::stream(reader, None, budget, log))
}

/// Loads a `.gltf` or `.glb` file from memory with the default [`LoadOptions`]. Files that the data
/// refers to are looked up in `base_folder`; if that is `None`, they count as missing. The name of
/// the character is `character`.
///
/// # Errors
///
/// [`Error::Rejected`] if the bytes are not valid glTF, use an unsupported feature, or exceed the
/// default limits.
pub fn load_from_slice(bytes: &[u8], base_folder: Option<&Path>) -> Result<Imported, Error> {
    load_from_slice_with(bytes, base_folder, &LoadOptions::default())
}

/// Loads a `.gltf` or `.glb` file from memory like [`load_from_slice`], with the given options.
/// `bytes` itself does not count towards the memory limit.
///
/// # Errors
///
/// [`Error::Rejected`] if the bytes are not valid glTF, use an unsupported feature, or exceed the
/// limits of `options`.
pub fn load_from_slice_with(
    bytes: &[u8],
    base_folder: Option<&Path>,
    options: &LoadOptions,
) -> Result<Imported, Error> {
    let folder = Folder::new(base_folder, options.allow_outside);
    let job = Job { name: "character".into(), file: "glTF data".into(), folder, options };
    job.run(|_, _| Ok(Ok(bytes)))
}

/// The inputs of one load, without the bytes.
struct Job<'a> {
    /// Name of the character.
    name: String,
    /// Path or name of the input in messages.
    file: PathBuf,
    folder: Folder,
    options: &'a LoadOptions,
}

impl Job<'_> {
    /// Reads the bytes, imports them, and turns the log into notes or an error.
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
        // A failed import always logs a problem. If it did not, it must still not look like
        // success.
        let unlogged = || Problem { place: "file".into(), what: "cannot be imported".into() };
        built.map(|imported| Imported { notes, ..imported }).map_err(|_| rejected(vec![unlogged()]))
    }
}
