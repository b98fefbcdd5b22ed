//! Random numbers with a seed.

use populace_random::Rng;

/// A sequence of random numbers. Equal seeds give equal sequences.
#[derive(Clone, Debug)]
pub(crate) struct Dice(Rng);

impl Dice {
    /// Returns the sequence of a seed. `stream` gives each kind of thing a sequence of its own.
    pub(crate) fn new(seed: u64, stream: u64) -> Self {
        Self(Rng::from_state(seed ^ stream.wrapping_mul(0xA076_1D64_78BD_642F)))
    }

    /// Returns a number from `low` to `high`.
    pub(crate) fn within(&mut self, low: f64, high: f64) -> f64 {
        self.0.between(low, high)
    }

    /// Returns a whole number below `count`; 0 if that is 0.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        let drawn = self.0.bits() >> 33;
        usize::try_from(drawn).unwrap_or_default() % count.max(1)
    }

    /// Returns true with a probability from 0 to 1.
    pub(crate) fn chance(&mut self, probability: f64) -> bool {
        self.0.chance(probability)
    }

    /// Returns one of the items.
    pub(crate) fn pick<T: Copy, const N: usize>(&mut self, items: [T; N]) -> T {
        const { assert!(N > 0) };
        items[self.below(N)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_in_range_and_spread() {
        let mut dice = Dice::new(3, 1);
        let mut counts = [0; 8];
        for _ in 0..8000 {
            counts[dice.below(8)] += 1;
            assert!((2.0..5.0).contains(&dice.within(2.0, 5.0)));
        }
        assert!(counts.iter().all(|c| (800..1200).contains(c)), "{counts:?}");
        assert_ne!(Dice::new(3, 1).0.bits(), Dice::new(3, 2).0.bits());
    }
}
