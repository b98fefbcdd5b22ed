//! The show of a window, provided by the program that opens it.

use std::path::{Path, PathBuf};

use populace::character::Image;
use populace::{Crowd, Devices, MemberId, Schedule};
use populace_film::FrameRate;
use populace_render::{Camera, Renderer, Scene};

/// An error of a show: any that can be described.
pub type ShowError = Box<dyn std::error::Error + Send + Sync>;

/// A crowd that moves through time, and the camera and the light that it is seen in.
pub trait Show {
    /// Returns the words in the window's title.
    fn title(&self) -> String;

    /// Returns the rate of its frames. Frame k shows the time k / rate.
    fn rate(&self) -> FrameRate;

    /// Returns its length in seconds; `None` if it goes on for ever.
    fn length_secs(&self) -> Option<f64>;

    /// Returns light and surroundings. They may depend on the cameras, see
    /// [`set_aspect`](Self::set_aspect).
    fn scene(&self) -> Scene;

    /// Returns the height in metres at which people stand and come to lie. The ground of the
    /// [`scene`](Self::scene) may be drawn lower, beneath roads.
    fn floor_m(&self) -> f32;

    /// Returns the error of levels of detail in pixels; `None` to evaluate and draw everyone in
    /// full detail.
    fn detail_px(&self) -> Option<f32>;

    /// Chooses the cameras of pictures whose width is `aspect` times their height.
    ///
    /// # Errors
    ///
    /// A camera that cannot be had.
    fn set_aspect(&mut self, aspect: f32) -> Result<(), ShowError>;

    /// Returns the camera of the show at a time in seconds since frame 0.
    ///
    /// # Errors
    ///
    /// A camera that cannot be had.
    fn camera(&self, secs: f64) -> Result<Camera, ShowError>;

    /// Moves everybody on by `secs`, 0 for frame 0. May do so in several steps and evaluate all but
    /// the last; returns its seconds, which are left to [`evaluate`](Self::evaluate). The window
    /// sets the view of the crowd in between, by the [`camera`](Self::camera) of the new time.
    ///
    /// # Errors
    ///
    /// Errors of the crowd, and those of the show.
    fn behave(&mut self, crowd: &mut Crowd, secs: f32) -> Result<f32, ShowError>;

    /// Evaluates the crowd by [`Crowd::update`], `secs` after the last evaluation.
    ///
    /// # Errors
    ///
    /// Errors of the crowd, and those of the show.
    fn evaluate(&mut self, crowd: &mut Crowd, secs: f32) -> Result<(), ShowError>;

    /// Returns to the time before frame 0. The crowd has been brought back to it.
    fn rewind(&mut self);

    /// Returns true if it draws over pictures.
    fn has_overlay(&self) -> bool {
        false
    }

    /// Draws over a picture of the present time that was taken by a camera.
    ///
    /// # Errors
    ///
    /// A picture that cannot be drawn over.
    fn overlay(&self, _picture: &mut Image, _camera: &Camera) -> Result<(), ShowError> {
        Ok(())
    }

    /// Returns the number of the person that a member is, as the command line counts people;
    /// `None` for other things.
    fn person(&self, member: MemberId) -> Option<u64>;

    /// Returns true if it places its members in each frame, so that nobody else can.
    fn leads_members(&self) -> bool;
}

/// A show that is ready to begin. Nothing was evaluated yet.
pub struct Opened {
    /// The crowd, whose palettes go to the renderer of the window.
    pub crowd: Crowd,
    /// What moves it.
    pub show: Box<dyn Show>,
}

/// The wishes of a window.
#[derive(Clone, Debug, Default)]
pub struct Wish {
    /// A file that was dropped on the window, to show in place of the inputs; `None` for what was
    /// shown last.
    pub dropped: Option<PathBuf>,
    /// Number of members; `None` for what was given or is usual.
    pub members: Option<u32>,
    /// Devices to evaluate on; `None` for those that were given.
    pub devices: Option<Devices>,
    /// Mapping of the pipeline to devices; `None` for the one that was given.
    pub schedule: Option<Schedule>,
}

/// Opens shows, and writes what is kept of them.
pub trait Opener {
    /// Builds a crowd for the renderer of a window, and what moves it.
    ///
    /// # Errors
    ///
    /// Files that cannot be read, and devices that cannot be used. The window goes on with what it
    /// shows, if it shows something.
    fn open(&mut self, wish: &Wish, renderer: &mut Renderer) -> Result<Opened, ShowError>;

    /// Writes the file of a picture. It appears whole or not at all.
    ///
    /// # Errors
    ///
    /// A file that cannot be written. One that is there stays as it is.
    fn write(&mut self, path: &Path, bytes: &[u8]) -> Result<(), ShowError>;
}
