//! MemberId positions: apart from each other, in loose rows.

/// A small deterministic random number generator: SplitMix (Steele, Lea and Flood, "Fast
/// splittable pseudorandom number generators", OOPSLA 2014) with the mixing function of Java's
/// `SplittableRandom`.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) const fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Returns the generator number `number` of a seed.
    pub(crate) fn one_of(seed: u64, number: usize) -> Self {
        Self(Self(seed ^ (number as u64).rotate_left(32)).next())
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Returns a uniformly distributed number in `0..1`.
    pub(crate) fn unit(&mut self) -> f32 {
        (self.next() >> 40) as f32 / (1u32 << 24) as f32
    }

    /// Returns a uniformly distributed number in `-1..1`.
    pub(crate) fn signed(&mut self) -> f32 {
        self.unit() * 2.0 - 1.0
    }

    /// Returns a uniformly distributed number below `count`, which must not be 0.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        usize::try_from(self.next() % count as u64).unwrap_or(0)
    }
}

/// Half the width of a row per unit of distance from the apex of the rows.
const WIDENING: f32 = 0.55;
/// Distance of the first row from the apex, in rows.
const FIRST_ROW: f32 = 4.0;

/// Returns ground positions for `count` members, about `spacing` metres apart. The rows widen away
/// from the camera at +Z, as its view does. Each position is jittered, so that no grid shows. A
/// single member is placed at the origin.
pub(crate) fn positions(count: usize, spacing: f32, random: &mut Random) -> Vec<[f32; 3]> {
    let mut positions = Vec::with_capacity(count);
    let mut row = 0.0;
    while positions.len() < count {
        let distance = FIRST_ROW + row;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a small count, not negative"
        )]
        let columns = ((2.0 * WIDENING * distance) as usize).clamp(1, count - positions.len());
        for column in 0..columns {
            let across = column as f32 - (columns as f32 - 1.0) / 2.0;
            let jittered = |at: f32, random: &mut Random| (at + random.signed() * 0.18) * spacing;
            positions.push([jittered(across, random), 0.0, jittered(-row, random)]);
        }
        row += 1.0;
    }
    if let [one] = positions.as_mut_slice() {
        *one = [0.0; 3];
    }
    positions
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_keep_their_distance() {
        for count in [1, 2, 7, 100, 1000] {
            let positions = positions(count, 1.0, &mut Random::new(7));
            assert_eq!(positions.len(), count);
            for (i, a) in positions.iter().enumerate() {
                for b in &positions[..i] {
                    let distance = (a[0] - b[0]).hypot(a[2] - b[2]);
                    assert!(distance > 0.5, "{distance} m between two of {count}");
                }
            }
        }
    }

    #[test]
    fn same_seed_gives_the_same_numbers() {
        let run = |seed| {
            (0..5)
                .map(|_| 0)
                .scan(Random::new(seed), |r, _| Some(r.unit().to_bits()))
                .collect::<Vec<_>>()
        };
        assert_eq!(run(3), run(3));
        assert_ne!(run(3), run(4));
    }
}
