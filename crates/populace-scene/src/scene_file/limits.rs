//! The ranges of the numbers of scene files. `docs/scenes.md` has them too.

use std::fmt::Display;

use super::fault::Fault;

pub(super) const COORDINATE: Limits<f32> = Limits::new(-1e6, 1e6, " metres");
pub(super) const HEADING: Limits<f32> = Limits::new(-3600.0, 3600.0, " degrees");
/// A share of members, a weight or a part of a colour.
pub(super) const PART: Limits<f32> = Limits::new(0.0, 1.0, "");

pub(super) const MEMBERS: Limits<usize> = Limits::new(1, 10_000_000, " members");
pub(super) const BODY_HEIGHT: Limits<f32> = Limits::new(0.1, 100.0, " metres");
/// People decide two times in a second.
pub(super) const RATE: Limits<f32> = Limits::new(0.0, 120.0, " times in a minute");
pub(super) const WALKING_SPEED: Limits<f32> = Limits::new(0.1, 10.0, " metres in a second");
pub(super) const WAVE_SPEED: Limits<f32> = Limits::new(0.1, 1000.0, " metres in a second");
pub(super) const WAVE_EVERY: Limits<f32> = Limits::new(0.0, 1e6, " seconds");
pub(super) const START: Limits<f32> = Limits::new(0.0, 1e6, " seconds");
pub(super) const SPACING: Limits<f32> = Limits::new(0.1, 1000.0, " metres");
pub(super) const ADVANCE: Limits<f32> = Limits::new(0.0, 10_000.0, " metres");

pub(super) const WIDTH: Limits<f32> = Limits::new(0.2, 1000.0, " metres");
pub(super) const LIGHTS_AHEAD: Limits<f32> = Limits::new(-1e6, 1e6, " seconds");
/// The speeds at which vehicles drive.
pub(super) const DRIVING_SPEED: Limits<f32> = Limits::new(0.1, 40.0, " metres in a second");

pub(super) const SUN_HEIGHT: Limits<f32> = Limits::new(-90.0, 90.0, " degrees");
pub(super) const PIXELS: Limits<u32> = Limits::new(1, 16384, " pixels");
pub(super) const FPS: Limits<f64> = Limits::new(0.001, 1000.0, " frames in a second");
pub(super) const FILM_SECS: Limits<f32> = Limits::new(0.0, 10_000.0, " seconds");
pub(super) const KEY_SECS: Limits<f64> = Limits::new(0.0, 1e6, " seconds");
pub(super) const FIELD_OF_VIEW: Limits<f32> = Limits::new(1.0, 170.0, " degrees");

/// The numbers that a key may have.
#[derive(Clone, Copy)]
pub(super) struct Limits<N> {
    least: N,
    most: N,
    /// With a space before it, or empty.
    unit: &'static str,
}

impl<N: Copy + PartialOrd + Display> Limits<N> {
    pub(super) const fn new(least: N, most: N, unit: &'static str) -> Self {
        Self { least, most, unit }
    }

    /// Returns the rule that a number breaks. NaN breaks all.
    pub(super) fn broken(&self, value: N) -> Option<String> {
        let Self { least, most, unit } = self;
        let is_within = *least <= value && value <= *most;
        (!is_within).then(|| format!("from {least} to {most}{unit}, not {value}"))
    }

    /// Refuses a number out of range.
    pub(super) fn check(&self, key: &'static str, value: N) -> Option<Fault> {
        self.broken(value).map(|rule| Fault::of(key, rule))
    }

    /// Refuses a list with a number out of range.
    pub(super) fn check_all(&self, key: &'static str, values: &[N]) -> Option<Fault> {
        let rule = values.iter().find_map(|value| self.broken(*value))?;
        Some(Fault::of(key, format!("of numbers {rule}")))
    }
}
