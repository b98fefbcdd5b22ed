//! Random numbers that stay the same for a seed, on every machine and in every version: pictures,
//! replays and random tests depend on them.

use glam::{DQuat, DVec3};

/// The odd number nearest to 2^64 over the golden ratio.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

/// Returns 64 bits that look random and depend on all of `bits` (variant 13 of D. Stafford, "Better
/// bit mixing", 2011).
#[must_use]
pub const fn mixed(bits: u64) -> u64 {
    let a = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let b = (a ^ (a >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    b ^ (b >> 31)
}

/// Returns 64 bits that look random and depend on all of a text (FNV-1a, mixed).
#[must_use]
pub fn mixed_text(text: &str) -> u64 {
    let add = |bits: u64, byte: u8| (bits ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    mixed(text.bytes().fold(0xcbf2_9ce4_8422_2325, add))
}

/// Returns the multiple of 2^-24 in `0..1` that the upper 24 bits give.
#[must_use]
pub fn unit_of(bits: u64) -> f32 {
    (bits >> 40) as f32 / (1u32 << 24) as f32
}

/// A random stream: SplitMix64 (Steele, Lea and Flood, "Fast splittable pseudorandom number
/// generators", OOPSLA 2014) with the mixing function of Java's `SplittableRandom`.
#[derive(Clone, Debug)]
pub struct Rng(u64);

impl Rng {
    /// Starts the stream of a seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(STEP) ^ 0x5851_f42d_4c95_7f2d)
    }

    /// Continues the stream that has this state.
    #[must_use]
    pub const fn from_state(state: u64) -> Self {
        Self(state)
    }

    /// Starts the stream `number` of a seed, such as that of one member.
    #[must_use]
    pub fn stream(seed: u64, number: u64) -> Self {
        let mut stream = Self(seed ^ number.wrapping_mul(0xd134_2543_de82_ef95));
        stream.bits();
        stream
    }

    /// Returns the next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(STEP);
        mixed(self.0)
    }

    /// Returns a uniformly distributed number from `low` to `high`, which rounding can give.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.bits() >> 11) as f64 / 9_007_199_254_740_992.0)
    }

    /// Returns a uniformly distributed multiple of 2^-24 in `0..1`.
    pub fn unit(&mut self) -> f32 {
        unit_of(self.bits())
    }

    /// Returns a uniformly distributed number from `low` to `high`, from 24 bits. Rounding can
    /// give `high`.
    pub fn between_f32(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// Returns a uniformly distributed multiple of 2^-23 in `-1..1`.
    pub fn signed(&mut self) -> f32 {
        self.unit() * 2.0 - 1.0
    }

    /// Returns a whole number below `count`; 0 if that is 0.
    pub fn below(&mut self, count: usize) -> usize {
        // The remainder is below a usize, so it always is one.
        usize::try_from(self.bits() % count.max(1) as u64).unwrap_or_default()
    }

    /// Returns true with probability `share`.
    pub fn chance(&mut self, share: impl Into<f64>) -> bool {
        self.between(0.0, 1.0) < share.into()
    }

    /// Returns a vector with all components from `low` to `high`.
    pub fn vector(&mut self, low: f64, high: f64) -> DVec3 {
        DVec3::new(self.between(low, high), self.between(low, high), self.between(low, high))
    }

    /// Returns a unit vector.
    pub fn direction(&mut self) -> DVec3 {
        loop {
            let v = self.vector(-1.0, 1.0);
            if (0.01..=1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }

    /// Returns a rotation by `angle_rad` around a random axis.
    pub fn turn(&mut self, angle_rad: f64) -> DQuat {
        DQuat::from_axis_angle(self.direction(), angle_rad)
    }

    /// Returns a rotation by 0.2 to 3 rad around a random axis.
    pub fn rotation(&mut self) -> DQuat {
        let angle = self.between(0.2, 3.0);
        self.turn(angle)
    }

    /// Shuffles a list (Fisher and Yates).
    pub fn shuffle<T>(&mut self, list: &mut [T]) {
        for end in (1..list.len()).rev() {
            list.swap(end, self.below(end + 1));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pictures and random scenes depend on the exact numbers.
    #[test]
    fn streams_stay_as_they_are() {
        let mut zero = Rng::from_state(0);
        assert_eq!([zero.bits(), zero.bits()], [0xe220_a839_7b1d_cdaf, 0x6e78_9e6a_a1b9_65f4]);
        let streams = [Rng::new(1), Rng::stream(1, 2), Rng::stream(2, 1)];
        let first = streams.map(|mut rng| rng.bits());
        assert_eq!(first, [0x1dfd_cec4_ec04_f63f, 0xc50f_2c2a_1b32_9d4b, 0x162d_1cd5_1c20_b20c]);
    }

    #[test]
    fn texts_stay_as_they_are() {
        assert_eq!(mixed_text(""), mixed(0xcbf2_9ce4_8422_2325));
        assert_eq!(mixed_text("a"), mixed(0xaf63_dc4c_8601_ec8c));
        assert_ne!(mixed_text("ab"), mixed_text("ba"));
    }

    #[test]
    fn numbers_stay_in_their_ranges() {
        let mut rng = Rng::new(3);
        for _ in 0..1000 {
            assert!((0.0..1.0).contains(&rng.unit()) && (-1.0..1.0).contains(&rng.signed()));
            assert!(rng.below(7) < 7 && rng.below(0) == 0);
            assert!((2.0..5.0).contains(&rng.between(2.0, 5.0)));
        }
    }
}
