//! Tests that draw small scenes and compare pixels. They need OpenGL: see `POPULACE_SKIP` in
//! `build.rs`.
#![expect(clippy::unwrap_used, reason = "a failing set-up fails the test")]

mod calls;
mod crowds;
mod fixture;
mod looks;
mod materials;
mod palettes;
mod refusals;
mod rig;
mod surfaces;
mod surroundings;
