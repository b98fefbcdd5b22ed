//! A window in which a crowd is watched, picked, posed and driven.
//!
//! The window knows no files: an [`Opener`] builds a [`Show`], a crowd with what moves it, and the
//! window plays it in real time. People move the camera, pick members, change what they play, look
//! at and reach for, let them fall, and drive one of them by the keyboard, all by the public calls
//! of the crates below. A [`Script`] drives a window in place of a person, by the same events.

mod aims;
mod camera;
mod clock;
mod desk;
mod error;
mod falls;
mod film;
mod input;
mod keys;
mod layout;
mod marks;
mod pad;
mod paint;
mod panels;
mod pick;
mod script;
mod show;
mod stage;
mod theme;
mod viewer;
mod window;
mod you;

pub use error::Error;
pub use layout::Layout;
pub use script::{InputTime, Script, ScriptReport};
pub use show::{Opened, Opener, Show, ShowError, Wish};
pub use window::{Closed, WindowSettings, run};
