//! Random numbers of one person: equal seeds give equal numbers on every machine.

/// A sequence of random numbers (S. Vigna's SplitMix64).
#[derive(Clone, Debug)]
pub(crate) struct Random(u64);

impl Random {
    /// Starts the sequence of the person `nth` of a scene.
    pub(crate) fn new(seed: u64, nth: u64) -> Self {
        let mut random = Self(seed ^ nth.wrapping_mul(0xd134_2543_de82_ef95));
        random.next();
        random
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ mixed >> 31
    }

    /// Returns a number from 0 to below 1.
    pub(crate) fn part(&mut self) -> f32 {
        // 24 bits are exact in an f32.
        let bits = u32::try_from(self.next() >> 40).unwrap_or(0);
        bits as f32 / 16_777_216.0
    }

    /// Returns a number between two others.
    pub(crate) fn between(&mut self, from: f32, to: f32) -> f32 {
        from + (to - from) * self.part()
    }

    /// Returns true with a chance.
    pub(crate) fn chance(&mut self, chance: f32) -> bool {
        self.part() < chance
    }
}
