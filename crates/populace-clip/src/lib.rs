//! Clips: animations as rows of poses within an error bound.
//!
//! A [`Clip`] is built from a [`ClipSource`](populace_model::ClipSource) and the skeleton that it
//! was made for. Its rows are spaced evenly or by need, with 16 bits per component. No point near a
//! joint deviates from the source by more than [`ClipStats::tolerance_m`]. Live clips are rings of
//! rows that arrive during playback. Root motion is taken out of a clip's pose and kept beside it
//! ([`RootMotion`]).

mod clip;
mod clock;
mod contacts;
mod curves;
mod error;
mod gap;
mod probes;
mod row;
mod row_block;
mod rows;
mod storage;

pub use clip::{
    Clip, ClipStats, LiveRing, LiveSettings, MotionOrigin, MotionSettings, MotionSource,
    RootMotion, RowPlace, Streamed,
};
pub use clock::{FIRST_TICK, TICK_SECS, TICKS_PER_SEC, ticks_from_secs};
pub use contacts::Footstep;
pub use curves::Local;
pub use error::{Error, LiveFault, MotionFault};
pub use row_block::{COLUMNS_PER_BLOCK, NO_PLANES, ROW_FLOATS, RowBlock};
pub use rows::FARTHEST_SIZES;
pub use storage::Range;
