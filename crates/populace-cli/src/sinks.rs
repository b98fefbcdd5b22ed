//! Files that take frames: PNG files, or a film.

use std::path::{Path, PathBuf};

use populace_film::{Encoder, Film, FilmSettings, Format, Pixels, encode_png};

use crate::failure::Failure;
use crate::frame_loop::{FrameSink, Shot};
use crate::output::{self, Form, Outputs};
use crate::report::message;
use crate::unfinished;

/// The files of a run that is going on.
pub(crate) struct Sink<'a> {
    outputs: &'a Outputs,
    /// The film, if it is one.
    film: Option<Film>,
    /// True to leave out frames whose files exist.
    skip_existing: bool,
}

impl<'a> Sink<'a> {
    /// Begins to write the outputs. A film that cannot be encoded fails here.
    pub(crate) fn open(
        outputs: &'a Outputs,
        settings: &FilmSettings,
        skip_existing: bool,
    ) -> Result<Self, Failure> {
        let is_mp4 = Format::of(&outputs.first()) == Some(Format::Mp4);
        if settings.encoder != Encoder::default() && !is_mp4 {
            return Err(Failure::usage("--encoder is for MP4 films; name --out FILE.mp4"));
        }
        let film = match outputs.form() {
            Form::Film if skip_existing => {
                return Err(Failure::usage(
                    "--skip-existing leaves out numbered PNG files, and a film is written as a \
                     whole; name --out FILE.png",
                ));
            }
            Form::Film => {
                let film = Film::create(output::target(&outputs.first()), settings)?;
                unfinished::begin_film(&film);
                Some(film)
            }
            Form::Picture | Form::Numbered => None,
        };
        Ok(Self { outputs, film, skip_existing })
    }

    /// Returns the number of frames that are left out.
    pub(crate) fn skipped(&self) -> usize {
        self.outputs.frames().filter(|frame| !self.wants(*frame)).count()
    }

    /// Completes the film, if it is one, and returns the path of the result.
    pub(crate) fn finish(mut self) -> Result<PathBuf, Failure> {
        let Some(film) = self.film.take() else { return Ok(self.outputs.first()) };
        let part = film.part().to_owned();
        let draft = film.draft().to_owned();
        let finished = unfinished::draft(&draft, || film.finish());
        unfinished::end_film();
        match finished {
            Ok(_) => Ok(self.outputs.first()),
            Err(error) => {
                report_part(&part);
                Err(error.into())
            }
        }
    }
}

/// Says where the film is as far as it goes.
fn report_part(part: &Path) {
    if let Some(text) = unfinished::describe_part(part) {
        message!("{text}");
    }
}

impl FrameSink for Sink<'_> {
    fn wants(&self, frame: u32) -> bool {
        let mut files = std::iter::once(self.outputs.path(frame))
            .chain(self.outputs.images(frame).map(|i| i.1));
        !(self.skip_existing && files.all(|file| file.is_file()))
    }

    fn needs_facts(&self) -> bool {
        self.outputs.has_images()
    }

    fn take(&mut self, frame: u32, Shot { picture, facts }: Shot) -> Result<(), Failure> {
        let size = [picture.width, picture.height];
        if let Some(facts) = facts {
            for (kind, path) in self.outputs.images(frame) {
                output::write(&path, &facts.png(kind, size)?)?;
            }
        }
        match &mut self.film {
            Some(film) => Ok(film.push(picture.rgba)?),
            None => {
                let png = encode_png(size, Pixels::Rgba(&picture.rgba))?;
                output::write_frame(&self.outputs.path(frame), &png)
            }
        }
    }
}

impl Drop for Sink<'_> {
    /// Says where the film is that an error has ended.
    fn drop(&mut self) {
        if let Some(film) = self.film.take() {
            let (part, has_frames) = (film.part().to_owned(), film.frame_count() > 0);
            drop(film);
            unfinished::end_film();
            if has_frames {
                report_part(&part);
            }
        }
    }
}
