//! Random arguments of calls, recorded for reports.

use std::fmt::{Debug, Write};

use populace_testkit::Rng;

/// Unusual numbers.
const ODD: [f32; 14] = [
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MAX,
    1e38,
    -1e38,
    1e20,
    1e9,
    0.0,
    -0.0,
    -1.0,
    f32::MIN_POSITIVE,
    1e-45,
    -1e-20,
];

/// Draws the arguments of one call.
pub(crate) struct Draw {
    rng: Rng,
    /// Whether numbers may be unusual.
    odd: bool,
    /// The arguments so far, if they are recorded.
    recorded: Option<String>,
}

impl Draw {
    pub(crate) fn new(seed: u64, odd: bool, is_recorded: bool) -> Self {
        Self { rng: Rng::new(seed), odd, recorded: is_recorded.then(String::new) }
    }

    pub(crate) fn recorded(self) -> String {
        self.recorded.unwrap_or_default()
    }

    /// Records an argument.
    pub(crate) fn record<T: Debug>(&mut self, name: &str, value: T) -> T {
        if let Some(recorded) = &mut self.recorded {
            let comma = if recorded.is_empty() { "" } else { ", " };
            // Writing to a string cannot fail.
            let _ = write!(recorded, "{comma}{name}: {value:?}");
        }
        value
    }

    pub(crate) fn chance(&mut self, name: &str, share: f64) -> bool {
        let chosen = self.rng.chance(share);
        self.record(name, chosen)
    }

    /// Draws an index below `count`, which must not be 0.
    pub(crate) fn index(&mut self, name: &str, count: usize) -> usize {
        let index = self.rng.below(count);
        self.record(name, index)
    }

    /// Draws a number from `low` to `high`, or an unusual one.
    pub(crate) fn number(&mut self, name: &str, low: f64, high: f64) -> f32 {
        let number = self.plain(low, high);
        self.record(name, number)
    }

    #[expect(clippy::cast_possible_truncation, reason = "the exact number does not matter")]
    fn plain(&mut self, low: f64, high: f64) -> f32 {
        if self.odd && self.rng.chance(0.1) {
            return ODD[self.rng.below(ODD.len())];
        }
        self.rng.between(low, high) as f32
    }

    pub(crate) fn vector(&mut self, name: &str, low: f64, high: f64) -> [f32; 3] {
        let vector = [(); 3].map(|()| self.plain(low, high));
        self.record(name, vector)
    }

    /// Draws a unit quaternion, perhaps with an unusual component.
    pub(crate) fn rotation(&mut self, name: &str) -> [f32; 4] {
        let mut rotation = self.rng.rotation().as_quat().to_array();
        if self.odd && self.rng.chance(0.1) {
            rotation[self.rng.below(4)] = ODD[self.rng.below(ODD.len())];
        }
        self.record(name, rotation)
    }

    /// Draws a time in seconds for fades and eases: often 0.
    pub(crate) fn secs(&mut self, name: &str) -> f32 {
        if self.rng.chance(0.3) { self.record(name, 0.0) } else { self.number(name, 0.0, 1.0) }
    }
}
