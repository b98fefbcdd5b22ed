//! Densities around people.

use populace_scene::Neighbours;

/// Radius in metres of the circle in which people are counted, and the difference of elevations
/// from which on they are on other floors.
const AROUND_M: f32 = 1.5;

/// Returns people per square metre around each place on the plan with its elevation: those within a
/// circle on the same floor, by its area.
pub(super) fn densities(places: &[[f32; 3]]) -> Vec<f64> {
    let neighbours = Neighbours::new(places.iter().map(|[x, y, _]| [*x, *y]), AROUND_M);
    let area = f64::from(std::f32::consts::PI * AROUND_M * AROUND_M);
    let density = |[x, y, z]: &[f32; 3]| {
        let near = neighbours.around([*x, *y]);
        let on_floor = near.filter(|index| (places[*index][2] - z).abs() < AROUND_M);
        on_floor.map(|_| 1.0 / area).sum()
    };
    places.iter().map(density).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn densities_count_people_around() {
        let alone = densities(&[[0.0; 3], [10.0, 0.0, 0.0]]);
        assert!((alone[0] - 1.0 / 7.069).abs() < 1e-3 && alone[0] == alone[1], "{alone:?}");
        let around = [[0.0; 3], [1.0, 0.0, 0.2], [0.0, 1.4, -0.2], [1.4, 1.4, 0.0]];
        let three = densities(&around);
        assert!((three[0] / alone[0] - 3.0).abs() < 1e-6, "{three:?}");
        // The same again one floor above.
        let above = around.map(|[x, y, z]| [x, y, z + 3.0]);
        assert_eq!(densities(&[around, above].concat()), [three.clone(), three].concat());
    }
}
