//! Who is near whom on a plan.

/// How much wider cells are than the radius, so that rounding takes nobody out of the cells around.
const SPARE: f64 = 1.001;

/// Places on a plan, by square cells. Neighbours are looked for in nine of them, so the work depends
/// on how close together people are, and not on the direction in which a crowd is long.
#[derive(Clone, Debug)]
pub struct Neighbours {
    radius_m: f32,
    /// Cells with the places in them and their indices, in the order of cells.
    places: Vec<([i32; 2], usize, [f32; 2])>,
}

impl Neighbours {
    /// Sorts places `[x, y]` into cells. Neighbours are those up to a radius in metres apart.
    pub fn new(places: impl IntoIterator<Item = [f32; 2]>, radius_m: f32) -> Self {
        let places = places.into_iter().enumerate();
        let mut places: Vec<_> =
            places.map(|(index, at)| (cell(at, radius_m), index, at)).collect();
        places.sort_unstable_by_key(|(cell, index, _)| (*cell, *index));
        Self { radius_m, places }
    }

    /// Returns the indices of the places within the radius around a point, itself included.
    pub fn around(&self, [x, y]: [f32; 2]) -> impl Iterator<Item = usize> + '_ {
        let within = move |at: &[f32; 2]| (at[0] - x).hypot(at[1] - y) <= self.radius_m;
        let near = self.in_cells_around([x, y]).filter(move |(.., at)| within(at));
        near.map(|(_, index, _)| *index)
    }

    fn in_cells_around(&self, at: [f32; 2]) -> impl Iterator<Item = &([i32; 2], usize, [f32; 2])> {
        let [x, y] = cell(at, self.radius_m);
        let column = move |x: i32| {
            let [first, last] = [y.saturating_sub(1), y.saturating_add(1)].map(|y| [x, y]);
            let from = self.places.partition_point(|(cell, ..)| *cell < first);
            let column = &self.places[from..];
            &column[..column.partition_point(|(cell, ..)| *cell <= last)]
        };
        (x.saturating_sub(1)..=x.saturating_add(1)).flat_map(column)
    }
}

fn cell(at: [f32; 2], radius_m: f32) -> [i32; 2] {
    #[expect(clippy::cast_possible_truncation, reason = "floats saturate")]
    at.map(|value| (f64::from(value) / (SPARE * f64::from(radius_m))).floor() as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// People of a corridor along x or y, in the order of a shuffle.
    fn corridor(along: usize) -> Vec<[f32; 2]> {
        let place = |nth: usize| {
            let nth = nth * 37 % 1000;
            let mut at = [0.7 * (nth % 5) as f32 - 1.5; 2];
            at[along] = 0.1 * nth as f32 - 50.0;
            at
        };
        (0..1000).map(place).collect()
    }

    #[test]
    fn neighbours_are_those_within_the_radius() {
        for radius_m in [0.1, 1.5, 4.0, 1000.0] {
            let places = corridor(1);
            let neighbours = Neighbours::new(places.iter().copied(), radius_m);
            for at in &places {
                let mut found: Vec<usize> = neighbours.around(*at).collect();
                found.sort_unstable();
                let off = |other: &[f32; 2]| (other[0] - at[0]).hypot(other[1] - at[1]);
                let near = (0..places.len()).filter(|nth| off(&places[*nth]) <= radius_m);
                assert_eq!(found, near.collect::<Vec<_>>(), "{radius_m} m around {at:?}");
            }
        }
    }

    #[test]
    fn few_places_are_looked_at_in_corridors_of_both_directions() {
        for along in [0, 1] {
            let places = corridor(along);
            let neighbours = Neighbours::new(places.iter().copied(), 1.5);
            let looked_at = |at: &[f32; 2]| neighbours.in_cells_around(*at).count();
            let most = places.iter().map(looked_at).max();
            assert!(most.is_some_and(|most| (10..=60).contains(&most)), "{along}: {most:?}");
        }
    }

    /// The two are as far apart as the radius, after rounding, with a cell's border at each.
    #[test]
    fn places_just_across_two_borders_are_neighbours() {
        let places = [[-1e-9, 0.0], [1.5, 0.0]];
        assert_eq!(Neighbours::new(places, 1.5).around(places[0]).count(), 2);
    }

    #[test]
    fn places_that_are_nowhere_and_far_away_have_no_neighbours() {
        let places = [[f32::NAN, 0.0], [f32::MAX, f32::MIN], [0.0, 0.0]];
        let neighbours = Neighbours::new(places, 1.0);
        assert_eq!(places.map(|at| neighbours.around(at).count()), [0, 1, 1]);
    }
}
