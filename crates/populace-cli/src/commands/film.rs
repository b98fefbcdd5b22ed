//! `populace film`

use std::path::{Path, PathBuf};

use populace::character::Image;
use populace_film::{FilmSettings, decode_png};

use crate::cli::{FrameRange, JoinArgs};
use crate::failure::Failure;
use crate::frame_loop::{FrameSink, Shot};
use crate::output::{Outputs, check_inputs, check_writable};
use crate::progress::Progress;
use crate::report::{self, message};
use crate::series::Series;
use crate::sinks::Sink;
use crate::unfinished;

pub(crate) fn run(args: &JoinArgs) -> Result<(), Failure> {
    if populace_film::Format::of(&args.out).is_none() {
        return Err(populace_film::Error::UnknownFormat { path: args.out.clone() }.into());
    }
    let series = Series::find(&args.pictures)?;
    let frames = match &args.frames {
        Some(FrameRange(frames)) => frames.clone(),
        None => series.frames(),
    };
    series.check_complete(&frames)?;
    let files: Vec<PathBuf> = frames.clone().map(|frame| series.path(frame)).collect();
    check_inputs(std::iter::once(args.out.clone()), &files)?;
    check_writable(&args.out)?;
    // Pictures of an earlier, longer run may follow those of the last one.
    let [first, last] = [frames.start(), frames.end()];
    message!("joining {} pictures, {first} to {last}; --frames chooses others", files.len());
    join(args, &files, Outputs::new(&args.out, frames, true, &[])?)
}

/// Writes the film. All pictures have the size of the first.
fn join(args: &JoinArgs, files: &[PathBuf], outputs: Outputs) -> Result<(), Failure> {
    let Some((first, others)) = files.split_first() else {
        return Err(populace_film::Error::NoFrames { path: args.out.clone() }.into());
    };
    let picture = read(first)?;
    let size = [picture.width, picture.height];
    let settings = FilmSettings { encoder: args.encoder, ..FilmSettings::new(size, args.fps) };
    unfinished::expect_frames(u32::try_from(files.len()).unwrap_or(u32::MAX));
    let mut sink = Sink::open(&outputs, &settings, false)?;
    let mut progress = Progress::new("frames", files.len());
    let mut numbers = outputs.frames();
    let mut take = |picture: Image| {
        progress.step();
        numbers.next().map_or(Ok(()), |frame| sink.take(frame, Shot { picture, facts: None }))
    };
    take(picture)?;
    for file in others {
        let picture = read(file)?;
        let found = [picture.width, picture.height];
        if found != size {
            let [[a, b], [width, height]] = [found, size];
            return Err(Failure::Input(anyhow::anyhow!(
                "{} has {a}x{b} pixels, and {} {width}x{height}; pictures of a film have the same \
                 size",
                file.display(),
                first.display()
            )));
        }
        take(picture)?;
    }
    drop(progress);
    report::path(&sink.finish()?)
}

fn read(file: &Path) -> Result<Image, Failure> {
    let refused = |e: anyhow::Error| Failure::Input(e.context(format!("{}", file.display())));
    let bytes = std::fs::read(file).map_err(|e| refused(e.into()))?;
    let ([width, height], rgba) = decode_png(&bytes).map_err(|e| refused(e.into()))?;
    Ok(Image { width, height, rgba })
}
