//! Files that the program writes: where they go, that they are none of its inputs, and that no half
//! of one is ever seen.

use std::ffi::OsStr;
use std::fs::OpenOptions;
use std::path::{Path, PathBuf};

use crate::failure::Failure;
use crate::unfinished::Unfinished;

/// Links that are followed from an output's name before they are taken for a circle.
const LINKS: usize = 40;

/// The pictures of one run: a single file, or numbered ones.
pub(crate) struct Pictures {
    out: PathBuf,
    frames: Option<u32>,
}

impl Pictures {
    /// `frames` numbered pictures named after `out`, or `out` itself where there is no number of
    /// frames.
    pub(crate) fn new(out: &Path, frames: Option<u32>) -> Result<Self, Failure> {
        check_kind(out, "png")?;
        Ok(Self { out: out.to_owned(), frames })
    }

    pub(crate) fn count(&self) -> u32 {
        self.frames.unwrap_or(1)
    }

    /// Where picture `index` goes.
    pub(crate) fn path(&self, index: u32) -> PathBuf {
        if self.frames.is_some() { frame_path(&self.out, index) } else { self.out.clone() }
    }

    pub(crate) fn paths(&self) -> impl Iterator<Item = PathBuf> {
        (0..self.count()).map(|index| self.path(index))
    }
}

/// Where frame `index` of a film goes: `crowd.png` becomes `crowd_0007.png`.
fn frame_path(path: &Path, index: u32) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(format!("_{index:04}."));
    name.push(path.extension().unwrap_or_default());
    path.with_file_name(name)
}

/// Refuses names of files of another kind.
pub(crate) fn check_kind(path: &Path, kind: &str) -> Result<(), Failure> {
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case(kind)) {
        return Ok(());
    }
    let (path, kind_name) = (path.display(), kind.to_uppercase());
    Err(Failure::usage(format!(
        "{path} does not end in .{kind}, and {kind_name} is what is written"
    )))
}

/// Refuses outputs that are one of the inputs: by the same path, through links, or as another name
/// of the same file.
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
                "writing {} would destroy {}, which is read: they are one file; write to another \
                 name",
                output.display(),
                input.display()
            )));
        }
    }
    Ok(())
}

/// What tells an existing file from all others, whatever name it is found by: its device and number
/// there.
#[cfg(unix)]
fn identity(path: &Path) -> Option<impl PartialEq + use<>> {
    use std::os::unix::fs::MetadataExt;
    let metadata = std::fs::metadata(path).ok()?;
    Some((metadata.dev(), metadata.ino()))
}

/// What tells an existing file from others: its path without links. Two hard links to one file are
/// not found out.
#[cfg(not(unix))]
fn identity(path: &Path) -> Option<impl PartialEq + use<>> {
    std::fs::canonicalize(path).ok()
}

/// Refuses an output that cannot be written before the work, so that a wrong path costs no waiting.
/// What stands there is left as it is.
pub(crate) fn check_writable(path: &Path) -> Result<(), Failure> {
    let target = target(path);
    if let Some(folder) = folder(&target).filter(|folder| !folder.exists()) {
        let (path, folder) = (path.display(), folder.display());
        return Err(Failure::Run(anyhow::anyhow!(
            "cannot write {path}: there is no folder {folder}; create it first"
        )));
    }
    check_target(path, &target)?;
    Unfinished::beside(&target).map(drop).map_err(|e| cannot_write(path, &e))
}

/// Writes a whole file, or leaves what stood there: the bytes go to a temporary file beside it,
/// which takes its name once it is complete. A link stays one, and the file that it leads to is
/// replaced.
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

/// Refuses what a file must not take the place of: folders and devices, and files that this user
/// may not change.
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

/// What a name leads to in the end, links followed, whether or not it is there.
fn target(path: &Path) -> PathBuf {
    let mut target = path.to_owned();
    for _ in 0..LINKS {
        let Ok(next) = target.read_link() else { break };
        target = target.parent().unwrap_or(Path::new("")).join(next);
    }
    target
}

/// The folder that a path names, if it names one.
fn folder(path: &Path) -> Option<&Path> {
    path.parent().filter(|folder| *folder.as_os_str() != *OsStr::new(""))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_numbered_beside_the_name() {
        assert_eq!(frame_path(Path::new("a/crowd.png"), 7), Path::new("a/crowd_0007.png"));
        assert_eq!(frame_path(Path::new("b.c.png"), 12345), Path::new("b.c_12345.png"));
    }

    #[cfg(unix)]
    #[test]
    fn frames_keep_bytes_that_are_not_utf_8() {
        use std::os::unix::ffi::OsStrExt;
        let [film, frame] =
            [&b"f\xFF.png"[..], b"f\xFF_0002.png"].map(|b| Path::new(OsStr::from_bytes(b)));
        assert_eq!(frame_path(film, 2), frame);
    }
}
