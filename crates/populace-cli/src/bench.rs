//! The benchmarks of `populace bench`: scenes, timing, and the check against the oracle.

mod baked;
mod changes;
mod chart;
mod check;
mod constraints;
mod document;
mod measurements;
mod memory;
mod rigs;
mod scene;
mod spec;
mod table;
mod timing;

pub(crate) use chart::as_svg;
pub(crate) use document::Document;
pub(crate) use measurements::median;
pub(crate) use scene::{DeviceSetup, Load, Scene, SceneSettings};
pub(crate) use spec::{Measurement, Method, Subject};
pub(crate) use table::as_table;
pub(crate) use timing::{measure, ms_since};
