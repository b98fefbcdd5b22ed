//! Bindings of clips to skeletons that they were not made for.
//!
//! A [`Binding`] tells what each joint of a skeleton follows in a clip's rows. If the clip has other
//! joints, or the same in another order, its rows are [converted](Converted), by name or by
//! humanoid role. By role, both bodies are brought to a common pose, each joint rotates from it as
//! its counterpart rotates from rest, and the feet are kept out of the ground. [`BindingReport`]
//! tells how well a clip fits.

mod binding;
mod common;
mod error;
mod fit;
mod retarget;

pub use binding::{Binding, Converted};
pub use error::{BindingFault, Error};
pub use fit::{BindingMethod, BindingReport};
pub use retarget::Retarget;
