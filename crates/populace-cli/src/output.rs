//! Output files: their paths, the check that they do not overwrite inputs, and atomic writing.

use std::ffi::OsStr;
use std::fs::OpenOptions;
use std::path::{Path, PathBuf};

use crate::failure::Failure;
use crate::unfinished::Unfinished;

/// Symbolic links followed from an output's name; more are taken for a cycle.
const MAX_LINKS: usize = 40;

/// The picture files of one run: a single file, or numbered files.
pub(crate) struct Pictures {
    out: PathBuf,
    frames: Option<u32>,
}

impl Pictures {
    /// Names `frames` numbered pictures after `out`, or the single picture `out` if `frames` is
    /// `None`. Refuses names that do not end in `.png`.
    pub(crate) fn new(out: &Path, frames: Option<u32>) -> Result<Self, Failure> {
        check_kind(out, "png")?;
        Ok(Self { out: out.to_owned(), frames })
    }

    pub(crate) fn count(&self) -> u32 {
        self.frames.unwrap_or(1)
    }

    /// Returns the path of picture `index`.
    pub(crate) fn path(&self, index: u32) -> PathBuf {
        if self.frames.is_some() { frame_path(&self.out, index) } else { self.out.clone() }
    }

    pub(crate) fn paths(&self) -> impl Iterator<Item = PathBuf> {
        (0..self.count()).map(|index| self.path(index))
    }
}

/// Returns the path of frame `index`: `crowd.png` becomes `crowd_0007.png`.
fn frame_path(path: &Path, index: u32) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(format!("_{index:04}."));
    name.push(path.extension().unwrap_or_default());
    path.with_file_name(name)
}

/// Refuses a path whose extension is not `kind`.
pub(crate) fn check_kind(path: &Path, kind: &str) -> Result<(), Failure> {
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case(kind)) {
        return Ok(());
    }
    let (path, kind_name) = (path.display(), kind.to_uppercase());
    Err(Failure::usage(format!(
        "{path} does not end in .{kind}; the output is written as {kind_name}"
    )))
}

/// Refuses outputs that are also inputs: by the same path, through links, or as another name of the
/// same file.
pub(crate) fn check_inputs(
    outputs: impl Iterator<Item = PathBuf>,
    inputs: &[impl AsRef<Path>],
) -> Result<(), Failure> {
    let known: Vec<_> = inputs
        .iter()
        .filter_map(|input| Some((identity(input.as_ref())?, input.as_ref())))
        .collect();
    if known.is_empty() {
        return Ok(());
    }
    for output in outputs {
        let Some(found) = identity(&output) else { continue };
        if let Some((_, input)) = known.iter().find(|(one, _)| *one == found) {
            return Err(Failure::usage(format!(
                "writing {} would destroy the input {}, since both are the same file; choose \
                 another output",
                output.display(),
                input.display()
            )));
        }
    }
    Ok(())
}

/// Returns the identity of an existing file, which is the same for all its names: its device and
/// inode.
#[cfg(unix)]
fn identity(path: &Path) -> Option<impl PartialEq + use<>> {
    use std::os::unix::fs::MetadataExt;
    let metadata = std::fs::metadata(path).ok()?;
    Some((metadata.dev(), metadata.ino()))
}

/// Returns the identity of an existing file: its path without links. Two hard links to one file are
/// not recognised.
#[cfg(not(unix))]
fn identity(path: &Path) -> Option<impl PartialEq + use<>> {
    std::fs::canonicalize(path).ok()
}

/// Refuses an output that cannot be written. Called before the work, so that a wrong path fails at
/// once. Leaves an existing file unchanged.
pub(crate) fn check_writable(path: &Path) -> Result<(), Failure> {
    let target = target(path);
    if let Some(folder) = folder(&target).filter(|folder| !folder.exists()) {
        let (path, folder) = (path.display(), folder.display());
        return Err(Failure::Run(anyhow::anyhow!(
            "cannot write {path}: the folder {folder} does not exist; create it first"
        )));
    }
    check_target(path, &target)?;
    Unfinished::beside(&target).map(drop).map_err(|e| cannot_write(path, &e))
}

/// Writes a file atomically: the bytes go to a temporary file beside the target, which is renamed
/// once it is complete. If writing fails, an existing file is kept. A symbolic link stays, and the
/// file that it points to is replaced.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let target = target(path);
    check_target(path, &target)?;
    let written = || {
        let mut file = Unfinished::beside(&target)?;
        file.write_all(bytes)?;
        if let Ok(before) = target.metadata() {
            file.set_permissions(before.permissions())?;
        }
        file.finish(&target)
    };
    written().map_err(|e| cannot_write(path, &e))
}

/// Refuses targets that must not be replaced: folders, devices, and files that this user may not
/// change.
fn check_target(path: &Path, target: &Path) -> Result<(), Failure> {
    let Ok(metadata) = target.metadata() else { return Ok(()) };
    if !metadata.is_file() {
        let reason = if metadata.is_dir() { "it is a folder" } else { "it is not a regular file" };
        return Err(cannot_write(path, reason));
    }
    OpenOptions::new().append(true).open(target).map(drop).map_err(|e| cannot_write(path, e))
}

fn cannot_write(path: &Path, reason: impl std::fmt::Display) -> Failure {
    Failure::Run(anyhow::anyhow!("cannot write {}: {reason}", path.display()))
}

/// Follows symbolic links to the final path, which need not exist.
fn target(path: &Path) -> PathBuf {
    let mut target = path.to_owned();
    for _ in 0..MAX_LINKS {
        let Ok(next) = target.read_link() else { break };
        target = target.parent().unwrap_or(Path::new("")).join(next);
    }
    target
}

/// Returns the folder part of a path, if it is not empty.
fn folder(path: &Path) -> Option<&Path> {
    path.parent().filter(|folder| *folder.as_os_str() != *OsStr::new(""))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_number_is_added_to_the_name() {
        assert_eq!(frame_path(Path::new("a/crowd.png"), 7), Path::new("a/crowd_0007.png"));
        assert_eq!(frame_path(Path::new("b.c.png"), 12345), Path::new("b.c_12345.png"));
    }

    #[cfg(unix)]
    #[test]
    fn frame_path_keeps_non_utf8_bytes() {
        use std::os::unix::ffi::OsStrExt;
        let [name, frame] =
            [&b"f\xFF.png"[..], b"f\xFF_0002.png"].map(|b| Path::new(OsStr::from_bytes(b)));
        assert_eq!(frame_path(name, 2), frame);
    }
}
