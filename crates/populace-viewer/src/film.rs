//! Films of what the window shows.

use std::path::{Path, PathBuf};

use populace::character::Image;
use populace_film::{Error, Film, FilmSettings, FrameRate};

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

    /// Completes the film and returns its path.
    pub(crate) fn end(self) -> Result<PathBuf, Error> {
        self.film.finish()
    }
}

/// Returns the first path of name-1, name-2 and so on that does not exist.
fn free(wanted: &Path) -> PathBuf {
    let stem = wanted.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let extension = wanted.extension().unwrap_or_default().to_string_lossy().into_owned();
    let numbered = |nth: u32| wanted.with_file_name(format!("{stem}-{nth}.{extension}"));
    (1..=u32::MAX).map(numbered).find(|path| !path.exists()).unwrap_or_else(|| wanted.to_owned())
}
