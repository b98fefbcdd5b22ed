//! Arguments of calls, drawn at random and told where a sequence is printed.

use std::fmt::{Debug, Write};

use populace_testkit::Rng;

/// Numbers that come from careless code.
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
    /// Whether numbers can be odd.
    odd: bool,
    /// The arguments so far, where they are to be told.
    told: Option<String>,
}

impl Draw {
    pub(crate) fn new(seed: u64, odd: bool, is_told: bool) -> Self {
        Self { rng: Rng::new(seed), odd, told: is_told.then(String::new) }
    }

    pub(crate) fn told(self) -> String {
        self.told.unwrap_or_default()
    }

    /// Notes an argument.
    pub(crate) fn tell<T: Debug>(&mut self, name: &str, value: T) -> T {
        if let Some(told) = &mut self.told {
            let comma = if told.is_empty() { "" } else { ", " };
            // Writing to a string cannot fail.
            let _ = write!(told, "{comma}{name}: {value:?}");
        }
        value
    }

    pub(crate) fn chance(&mut self, name: &str, share: f64) -> bool {
        let chosen = self.rng.chance(share);
        self.tell(name, chosen)
    }

    /// An index below `count`, which is not 0.
    pub(crate) fn index(&mut self, name: &str, count: usize) -> usize {
        let index = self.rng.below(count);
        self.tell(name, index)
    }

    /// A number from `low` to `high`, or an odd one.
    pub(crate) fn number(&mut self, name: &str, low: f64, high: f64) -> f32 {
        let number = self.plain(low, high);
        self.tell(name, number)
    }

    #[expect(clippy::cast_possible_truncation, reason = "any number near does")]
    fn plain(&mut self, low: f64, high: f64) -> f32 {
        if self.odd && self.rng.chance(0.1) {
            return ODD[self.rng.below(ODD.len())];
        }
        self.rng.between(low, high) as f32
    }

    pub(crate) fn vector(&mut self, name: &str, low: f64, high: f64) -> [f32; 3] {
        let vector = [(); 3].map(|()| self.plain(low, high));
        self.tell(name, vector)
    }

    /// A unit quaternion, but for odd numbers.
    pub(crate) fn rotation(&mut self, name: &str) -> [f32; 4] {
        let mut rotation = self.rng.rotation().as_quat().to_array();
        if self.odd && self.rng.chance(0.1) {
            rotation[self.rng.below(4)] = ODD[self.rng.below(ODD.len())];
        }
        self.tell(name, rotation)
    }

    /// A time in seconds for fades and eases: often none.
    pub(crate) fn secs(&mut self, name: &str) -> f32 {
        if self.rng.chance(0.3) { self.tell(name, 0.0) } else { self.number(name, 0.0, 1.0) }
    }
}
