//! Bindings of clips to skeletons that they were not made for.
//!
//! A [`Binding`] maps each joint of a skeleton to a column of a clip, by name or by humanoid role.
//! By role, both bodies are brought to a common pose, each joint rotates from it as its counterpart
//! rotates from rest, and the feet are kept out of the ground. [`BindingReport`] tells how well a
//! clip fits.

mod binding;
mod common;
mod error;
mod fit;

pub use binding::{
    Binding, Correction, FootCorrection, MAP_COLUMN, MAP_ROTATION, MAP_SCALE, MAP_TRANSLATION,
};
pub use error::{BindingFault, Error};
pub use fit::{BindingMethod, BindingReport};
