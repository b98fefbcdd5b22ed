//! Films of what the window shows.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use populace::character::Image;
use populace_film::{Error, Film, FilmSettings, FrameRate, part_of};

/// A film that is being made.
pub(crate) struct Recording {
    film: Film,
    size: [u32; 2],
    path: PathBuf,
}

impl Recording {
    /// Begins a film beside `wanted`, with a number in its name so that no file is lost.
    pub(crate) fn begin(wanted: &Path, size: [u32; 2], rate: FrameRate) -> Result<Self, Error> {
        let path = free(wanted);
        let film = Film::create(&path, &FilmSettings::new(size, rate))?;
        Ok(Self { film, size, path })
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    pub(crate) fn frames(&self) -> u32 {
        self.film.frame_count()
    }

    /// Returns true if pictures of this size can be added.
    pub(crate) fn takes(&self, size: [u32; 2]) -> bool {
        self.size == size
    }

    pub(crate) fn push(&mut self, picture: Image) -> Result<(), Error> {
        self.film.push(picture.rgba)
    }

    /// Completes the film and returns its path; `None` for one without frames, which leaves no
    /// file.
    pub(crate) fn end(self) -> Result<Option<PathBuf>, Error> {
        match self.film.finish() {
            Err(Error::NoFrames { .. }) => Ok(None),
            path => path.map(Some),
        }
    }
}

/// Returns the first path of name-1, name-2 and so on that does not exist, and of which no part
/// does: films that were interrupted have parts alone.
fn free(wanted: &Path) -> PathBuf {
    let numbered = |nth: u32| {
        let mut name = OsString::from(wanted.file_stem().unwrap_or_default());
        name.push(format!("-{nth}."));
        name.push(wanted.extension().unwrap_or_default());
        wanted.with_file_name(name)
    };
    let is_free = |path: &PathBuf| !path.exists() && !part_of(path).exists();
    (1..=u32::MAX).map(numbered).find(is_free).unwrap_or_else(|| wanted.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn films_that_were_interrupted_keep_their_parts() {
        let folder = tempfile::tempdir().expect("a folder");
        let wanted = folder.path().join("mine.gif");
        let rate = FrameRate::new(25, 1).expect("a rate");
        for nth in 1..=3 {
            let mut film = Recording::begin(&wanted, [8, 8], rate).expect("a film");
            let picture = Image { width: 8, height: 8, rgba: vec![255; 256] };
            film.push(picture).expect("a frame");
            assert_eq!(film.path(), folder.path().join(format!("mine-{nth}.gif")));
        }
    }

    #[test]
    fn films_without_frames_leave_no_file() {
        let folder = tempfile::tempdir().expect("a folder");
        let wanted = folder.path().join("mine.gif");
        let rate = FrameRate::new(25, 1).expect("a rate");
        let film = Recording::begin(&wanted, [8, 8], rate).expect("a film");
        assert!(film.end().expect("no error").is_none());
        assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0);
    }
}
