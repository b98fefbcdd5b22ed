//! Bindings: clips brought to skeletons that they were not made for.
//!
//! A [`Binding`] says which column of a clip each joint of a skeleton follows, by name or by
//! humanoid roles. By roles, both bodies are brought to a common pose, and each joint turns away
//! from it as its partner turns away from rest; feet are kept out of the ground.
//! [`BindingReport`] tells how well a clip fits.

mod binding;
mod common;
mod error;
mod fit;

pub use binding::{Binding, Footing, MAP_COLUMN, MAP_ROTATION, MAP_SCALE, MAP_TRANSLATION, Turn};
pub use error::Error;
pub use fit::{BindingMethod, BindingReport};
