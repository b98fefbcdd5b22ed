//! Gaits of clips: contacts of feet, ground speed, stride and cadence, on any body.

pub mod avoidance;
mod contacts;
mod feet;
mod gait;
mod mix;
mod soles;

pub use contacts::Contact;
pub use gait::Gait;
pub use mix::MixedClip;
