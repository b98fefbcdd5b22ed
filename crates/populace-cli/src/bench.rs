//! What `populace bench` measures: its scene, the timing, and the check against the oracle.

mod baked;
mod changes;
mod chart;
mod check;
mod constraints;
mod document;
mod memory;
mod rigs;
mod runs;
mod scene;
mod table;
mod timing;

pub(crate) use chart::as_svg;
pub(crate) use document::Document;
pub(crate) use runs::{Run, Way, median};
pub(crate) use scene::{Load, Scene, Setup};
pub(crate) use table::as_table;
pub(crate) use timing::{Subject, measure, ms_since};
