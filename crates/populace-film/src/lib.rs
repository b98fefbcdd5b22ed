//! Films from frames: MP4 with H.264 and animated GIF, and pictures as PNG.
//!
//! ```no_run
//! use populace_film::{Error, Film, FilmSettings, FrameRate};
//!
//! fn film(frames: impl Iterator<Item = Vec<u8>>) -> Result<(), Error> {
//!     let settings = FilmSettings::new([1280, 720], FrameRate::new(25, 1)?);
//!     let mut film = Film::create("crowd.mp4", &settings)?;
//!     for rgba in frames {
//!         film.push(rgba)?;
//!     }
//!     film.finish()?;
//!     Ok(())
//! }
//! ```
//!
//! The same frames and settings give the same bytes, on any number of cores; with `ffmpeg`, as far
//! as that program does.

mod animation;
mod colors;
mod error;
mod ffmpeg;
mod film;
#[cfg(feature = "openh264")]
mod h264;
#[cfg(feature = "openh264")]
mod mp4;
mod output;
mod png;
mod settings;
mod writer;
#[cfg(feature = "openh264")]
mod yuv;

pub use error::Error;
pub use film::{Film, FilmProgress};
pub use output::part_of;
pub use png::{Pixels, decode_png, encode_png, write_png};
pub use settings::{Encoder, FilmSettings, Format, FrameRate};
