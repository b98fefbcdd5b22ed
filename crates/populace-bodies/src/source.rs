//! The files of a body system, in a wheel or in a folder.

use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::{Path, PathBuf};

use flate2::read::GzDecoder;

use crate::Error;
use crate::archive::Archive;

/// The file by which a body system is found.
const MESH: &str = "3dobjs/base.obj";
/// Files that must lie beside it, under the same root.
const NEEDED: [&str; 3] = [
    "rigs/standard/rig.mixamo.json",
    "rigs/standard/weights.mixamo.json",
    "targets/macrodetails/macro.json",
];
/// How deep in a folder the body system may lie.
const MAX_DEPTH: usize = 6;
/// The most bytes that one file may unpack to; the largest is about 2.4 million.
const MAX_BYTES: u64 = 64 << 20;

enum Place {
    Folder(PathBuf),
    Archive { archive: Archive, root: String },
}

/// The files of one body system. Paths are relative to its root.
pub(crate) struct Source {
    path: PathBuf,
    place: Place,
}

impl Source {
    /// Finds the body system in a wheel, or in a folder or below it.
    pub(crate) fn open(path: &Path) -> Result<Self, Error> {
        let missing = |what: String| Error::NotFound { path: path.to_owned(), what };
        if !path.exists() {
            return Err(missing("the path does not exist".into()));
        }
        let place = if path.is_dir() {
            let root = find_folder(path, MAX_DEPTH)?
                .ok_or_else(|| missing(format!("no folder below it holds {MESH}")))?;
            Place::Folder(root)
        } else {
            let archive = Archive::open(path).map_err(|source| match source.kind() {
                ErrorKind::InvalidData => {
                    missing(format!("it is no folder and no wheel: {source}"))
                }
                _ => Error::Io { path: path.to_owned(), source },
            })?;
            let names = archive.names();
            let root = names.iter().find_map(|name| name.strip_suffix(MESH).map(str::to_owned));
            let root = root.ok_or_else(|| missing(format!("the archive holds no {MESH}")))?;
            Place::Archive { archive, root }
        };
        let source = Self { path: path.to_owned(), place };
        match NEEDED.iter().find(|name| !source.has(name)) {
            Some(name) => Err(missing(format!("{name} is missing beside {MESH}"))),
            None => Ok(source),
        }
    }

    /// The path as given.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    pub(crate) fn has(&self, name: &str) -> bool {
        match &self.place {
            Place::Folder(root) => root.join(name).is_file(),
            Place::Archive { archive, root } => archive.has(&format!("{root}{name}")),
        }
    }

    /// Reads a text file. One whose name ends in `.gz` is unpacked.
    pub(crate) fn text(&mut self, name: &str) -> Result<String, Error> {
        let bytes = self.bytes(name)?;
        let bytes = if name.ends_with(".gz") {
            let unpacked = read_all(GzDecoder::new(&bytes[..]));
            unpacked.map_err(|e| Error::bad(name, format!("cannot be unpacked: {e}")))?
        } else {
            bytes
        };
        String::from_utf8(bytes).map_err(|_| Error::bad(name, "is not text"))
    }

    fn bytes(&mut self, name: &str) -> Result<Vec<u8>, Error> {
        match &mut self.place {
            Place::Folder(root) => {
                let path = root.join(name);
                let read = File::open(&path).and_then(read_all);
                read.map_err(|source| Error::Io { path, source })
            }
            Place::Archive { archive, root } => {
                let read = archive.read(&format!("{root}{name}"), MAX_BYTES);
                read.map_err(|e| Error::bad(name, format!("cannot be unpacked: {e}")))
            }
        }
    }

    /// Checks that the data says that it is CC0: in its licence text, or at the head of the mesh.
    pub(crate) fn check_licence(&mut self, mesh: &str) -> Result<(), Error> {
        let head = mesh.lines().take_while(|line| line.starts_with('#'));
        let mut told = head.into_iter().any(|line| line.contains("CC0"));
        if self.has("LICENSE.md") {
            told |= self.text("LICENSE.md")?.contains("CC0 1.0 Universal");
        }
        if told { Ok(()) } else { Err(Error::Licence { path: self.path.clone() }) }
    }
}

/// Reads a file of at most [`MAX_BYTES`] bytes.
fn read_all(from: impl Read) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    from.take(MAX_BYTES + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(io::Error::new(ErrorKind::InvalidData, "it is too large"));
    }
    Ok(bytes)
}

/// Returns the folder that holds the mesh: `folder` itself or the first below it by name. A folder
/// that cannot be read is an error: it may be the first.
fn find_folder(folder: &Path, depth: usize) -> Result<Option<PathBuf>, Error> {
    if folder.join(MESH).is_file() {
        return Ok(Some(folder.to_owned()));
    }
    if depth == 0 {
        return Ok(None);
    }
    let below = folders(folder).map_err(|source| Error::Io { path: folder.to_owned(), source })?;
    let found = below.iter().map(|below| find_folder(below, depth - 1));
    found.filter_map(Result::transpose).next().transpose()
}

/// Returns the folders in a folder, by name. Symbolic links are left out, so a cycle cannot occur.
fn folders(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut folders = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        if entry.file_type()?.is_dir() {
            folders.push(entry.path());
        }
    }
    folders.sort();
    Ok(folders)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_that_cannot_be_read_are_named() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
        let error = find_folder(&file, 1).expect_err("it is no folder");
        assert!(error.to_string().contains("Cargo.toml: cannot be read: "), "{error}");
    }
}
