//! Random numbers that stay the same for a seed, whatever other code changes.

/// A generator (SplitMix64: G. Steele et al., "Fast splittable pseudorandom number generators",
/// OOPSLA 2014).
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64, stream: u64) -> Self {
        let mut random = Self(seed ^ stream.wrapping_mul(0xD134_2543_DE82_EF95));
        random.next();
        random
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// From 0 to 1.
    pub(crate) fn unit(&mut self) -> f32 {
        (self.next() >> 40) as f32 / (1_u32 << 24) as f32
    }

    pub(crate) fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// Around the middle of 0 to 1: the mean of three numbers.
    pub(crate) fn middling(&mut self) -> f32 {
        (self.unit() + self.unit() + self.unit()) / 3.0
    }

    pub(crate) fn chance(&mut self, part: f32) -> bool {
        self.unit() < part
    }

    pub(crate) fn pick<'a, T>(&mut self, from: &'a [T]) -> &'a T {
        let at = (self.next() >> 32) as usize % from.len();
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
