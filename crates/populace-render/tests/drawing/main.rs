//! Draws small things and looks at the pixels. Needs OpenGL: see `POPULACE_SKIP` in `build.rs`.
#![expect(clippy::unwrap_used, reason = "what fails while a test prepares fails the test")]

mod fixture;
mod palettes;
mod refusals;
mod rig;
mod surfaces;
mod surroundings;
