//! The files of a film: the part that grows, and the complete film.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};

use crate::Error;

/// Returns the file that holds a film until it is complete, such as `film.part.mp4` for `film.mp4`.
#[must_use]
pub fn part_of(film: &Path) -> PathBuf {
    beside(film, "part")
}

/// The files of a film that is not complete.
pub(crate) struct Part {
    film: PathBuf,
    part: PathBuf,
    draft: PathBuf,
}

impl Part {
    /// Names the files of a film.
    pub(crate) fn of(film: &Path) -> Self {
        Self { film: film.to_owned(), part: part_of(film), draft: beside(film, "draft") }
    }

    /// The part, which grows frame by frame.
    pub(crate) fn path(&self) -> &Path {
        &self.part
    }

    /// The file in which the part is rewritten, if it is.
    pub(crate) fn draft(&self) -> &Path {
        &self.draft
    }

    /// Creates the part, in place of an older one.
    pub(crate) fn create(&self) -> Result<File, Error> {
        OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(true)
            .open(&self.part)
            .map_err(|source| output_error(&self.part, source))
    }

    /// Makes the draft the film, if it was `written`, and removes the part. Otherwise the part
    /// stays and the draft goes.
    pub(crate) fn complete(&self, written: Result<(), Error>) -> Result<PathBuf, Error> {
        let result = written.and_then(|()| self.rename(&self.draft));
        let rest = if result.is_ok() { &self.part } else { &self.draft };
        // A file that cannot be removed changes nothing about the film.
        let _ = fs::remove_file(rest);
        result.map(|()| self.film.clone())
    }

    /// Makes the part the film, as it is.
    pub(crate) fn complete_as_is(&self) -> Result<PathBuf, Error> {
        self.rename(&self.part).map(|()| self.film.clone())
    }

    /// Renames a file to the film. One that is there is replaced, and its permissions stay.
    fn rename(&self, from: &Path) -> Result<(), Error> {
        let renamed = match self.film.metadata() {
            Ok(before) => fs::set_permissions(from, before.permissions()),
            Err(_) => Ok(()),
        };
        let renamed = renamed.and_then(|()| fs::rename(from, &self.film));
        renamed.map_err(|source| output_error(&self.film, source))
    }
}

/// Returns the name of a file with a word before its extension.
fn beside(path: &Path, word: &str) -> PathBuf {
    let mut name = OsString::from(path.file_stem().unwrap_or_default());
    name.push(format!(".{word}."));
    name.push(path.extension().unwrap_or_default());
    path.with_file_name(name)
}

pub(crate) fn output_error(path: &Path, source: io::Error) -> Error {
    Error::Output { path: path.to_owned(), source }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_film_is_complete_though_its_part_cannot_be_removed() {
        let folder = tempfile::tempdir().expect("a folder");
        let film = folder.path().join("film.mp4");
        let files = Part::of(&film);
        fs::write(files.draft(), "all frames").expect("a draft");
        // A folder cannot be removed as a file.
        fs::create_dir(files.path()).expect("a folder in place of the part");
        assert_eq!(files.complete(Ok(())).expect("a film"), film);
        assert_eq!(fs::read(&film).expect("a film"), b"all frames");
    }
}
