//! Positions of members: apart from each other, in loose rows.

use populace_testkit::Rng;

/// Half the width of a row per unit of distance from the apex of the rows.
const WIDENING: f32 = 0.55;
/// Distance of the first row from the apex, in rows.
const FIRST_ROW: f32 = 4.0;

/// Returns ground positions for `count` members, about `spacing` metres apart. The rows widen away
/// from the camera at +Z, as its view does. Each position is jittered, so that no grid shows. A
/// single member is placed at the origin.
pub(crate) fn positions(count: usize, spacing: f32, random: &mut Rng) -> Vec<[f32; 3]> {
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
            let jittered = |at: f32, random: &mut Rng| (at + random.signed() * 0.18) * spacing;
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
            let positions = positions(count, 1.0, &mut Rng::new(7));
            assert_eq!(positions.len(), count);
            for (i, a) in positions.iter().enumerate() {
                for b in &positions[..i] {
                    let distance = (a[0] - b[0]).hypot(a[2] - b[2]);
                    assert!(distance > 0.5, "{distance} m between two of {count}");
                }
            }
        }
    }
}
