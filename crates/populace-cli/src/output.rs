//! Output files: their paths, the check that they do not overwrite inputs, and atomic writing.

use std::ffi::OsStr;
use std::fs::OpenOptions;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use populace_film::Format;

use crate::cli::ImageKind;
use crate::failure::Failure;
use crate::unfinished::Unfinished;

/// Symbolic links followed from an output's name; more are taken for a cycle.
const MAX_LINKS: usize = 40;

/// The files of one run: a picture, numbered pictures, or a film, and images beside them.
pub(crate) struct Outputs {
    out: PathBuf,
    form: Form,
    /// Numbers of the frames.
    frames: RangeInclusive<u32>,
    images: Vec<ImageKind>,
}

/// How frames are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    /// One PNG file.
    Picture,
    /// A PNG file for each frame, with its number.
    Numbered,
    /// A film.
    Film,
}

impl Outputs {
    /// Names the files of `frames` after `out`. Its extension decides between PNG files, numbered
    /// if `is_series`, and a film, which must be a series.
    pub(crate) fn new(
        out: &Path,
        frames: RangeInclusive<u32>,
        is_series: bool,
        images: &[ImageKind],
    ) -> Result<Self, Failure> {
        let is_png = out.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
        let form = match (Format::of(out), is_series) {
            (Some(_), true) => Form::Film,
            (Some(_), false) => {
                return Err(Failure::usage(format!(
                    "{} is a film; say with --frames N how many frames it has",
                    out.display()
                )));
            }
            (None, true) if is_png => Form::Numbered,
            (None, false) if is_png => Form::Picture,
            (None, _) => {
                return Err(Failure::usage(format!(
                    "{} does not end in .png, .mp4 or .gif; the output is written as PNG, MP4 or \
                     GIF",
                    out.display()
                )));
            }
        };
        Ok(Self { out: out.to_owned(), form, frames, images: images.to_owned() })
    }

    pub(crate) fn form(&self) -> Form {
        self.form
    }

    pub(crate) fn frames(&self) -> RangeInclusive<u32> {
        self.frames.clone()
    }

    /// Returns true if there are images beside the pictures.
    pub(crate) fn has_images(&self) -> bool {
        !self.images.is_empty()
    }

    /// Returns the path of a frame's picture, or of the film.
    pub(crate) fn path(&self, frame: u32) -> PathBuf {
        match self.form {
            Form::Numbered => numbered(&self.out, frame),
            Form::Picture | Form::Film => self.out.clone(),
        }
    }

    /// Returns the path of the first picture, or of the film.
    pub(crate) fn first(&self) -> PathBuf {
        self.path(*self.frames.start())
    }

    /// Returns the images beside a frame's picture: `film_0007.depth.png`.
    pub(crate) fn images(&self, frame: u32) -> impl Iterator<Item = (ImageKind, PathBuf)> {
        let beside = match self.form {
            Form::Picture => self.out.clone(),
            Form::Numbered | Form::Film => numbered(&self.out, frame),
        };
        self.images
            .iter()
            .map(move |kind| (*kind, beside.with_extension(format!("{}.png", kind.name()))))
    }

    /// Returns the paths of all files.
    pub(crate) fn paths(&self) -> impl Iterator<Item = PathBuf> {
        self.frames().flat_map(|frame| {
            let images = self.images(frame).map(|(_, path)| path);
            std::iter::once(self.path(frame)).chain(images)
        })
    }
}

/// Returns the path of a frame: `crowd.png` becomes `crowd_0007.png`.
pub(crate) fn numbered(path: &Path, frame: u32) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(format!("_{frame:04}."));
    name.push(path.extension().unwrap_or_default());
    path.with_file_name(name)
}

/// Refuses a path whose extension is not `kind`.
#[cfg(feature = "bench")]
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
    write_and(path, bytes, Unfinished::finish)
}

/// Writes the last file of a frame as [`write`] does, and counts the frame as complete.
pub(crate) fn write_frame(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    write_and(path, bytes, Unfinished::finish_frame)
}

fn write_and(
    path: &Path,
    bytes: &[u8],
    finish: impl FnOnce(Unfinished, &Path) -> std::io::Result<()>,
) -> Result<(), Failure> {
    let target = target(path);
    check_target(path, &target)?;
    let written = || {
        let mut file = Unfinished::beside(&target)?;
        file.write_all(bytes)?;
        if let Ok(before) = target.metadata() {
            file.set_permissions(before.permissions())?;
        }
        finish(file, &target)
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
pub(crate) fn target(path: &Path) -> PathBuf {
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
        assert_eq!(numbered(Path::new("a/crowd.png"), 7), Path::new("a/crowd_0007.png"));
        assert_eq!(numbered(Path::new("b.c.png"), 12345), Path::new("b.c_12345.png"));
    }

    #[cfg(unix)]
    #[test]
    fn numbered_path_keeps_non_utf8_bytes() {
        use std::os::unix::ffi::OsStrExt;
        let [name, frame] =
            [&b"f\xFF.png"[..], b"f\xFF_0002.png"].map(|b| Path::new(OsStr::from_bytes(b)));
        assert_eq!(numbered(name, 2), frame);
    }
}
