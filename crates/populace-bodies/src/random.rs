//! Random numbers that stay the same for a seed, whatever other code changes.

use populace_random::Rng;

/// A sequence of random numbers.
pub(crate) struct Random(Rng);

impl Random {
    pub(crate) fn new(seed: u64, stream: u64) -> Self {
        Self(Rng::stream(seed, stream))
    }

    /// From 0 to 1.
    pub(crate) fn unit(&mut self) -> f32 {
        self.0.unit()
    }

    pub(crate) fn between(&mut self, low: f32, high: f32) -> f32 {
        self.0.between_f32(low, high)
    }

    /// Around the middle of 0 to 1: the mean of three numbers.
    pub(crate) fn middling(&mut self) -> f32 {
        (self.unit() + self.unit() + self.unit()) / 3.0
    }

    pub(crate) fn chance(&mut self, part: f32) -> bool {
        self.0.chance(part)
    }

    pub(crate) fn pick<'a, T>(&mut self, from: &'a [T]) -> &'a T {
        let at = (self.0.bits() >> 32) as usize % from.len();
        &from[at]
    }
}

/// Returns a number from 0 to 1 for a point on a line, smooth along it.
pub(crate) fn noise(at: f32, seed: u64) -> f32 {
    let cell = at.floor();
    let value = |cell: f32| Random::new(seed, u64::from(cell.to_bits())).unit();
    let t = at - cell;
    let t = t * t * (3.0 - 2.0 * t);
    value(cell) * (1.0 - t) + value(cell + 1.0) * t
}
