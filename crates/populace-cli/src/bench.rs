//! What `populace bench` measures: its scene, the timing, and the check against the oracle.

mod check;
mod scene;
mod timing;

pub(crate) use scene::Scene;
pub(crate) use timing::{Run, measure};
