//! Nearest members on the ground, by a grid.

use std::collections::HashMap;

/// Returns the numbers of the `count` nearest other members of each member, nearest first. Of equally
/// near ones the lower number comes first.
pub(crate) fn nearest(members: &[(usize, [f32; 3])], count: usize) -> Vec<Vec<usize>> {
    let mut places: Vec<[f64; 2]> =
        members.iter().map(|(_, [x, _, z])| [f64::from(*x), f64::from(*z)]).collect();
    // Counted from the corner, numbers of cells stay below twice the number of members.
    let corner = places.iter().copied().reduce(|a, b| [a[0].min(b[0]), a[1].min(b[1])]);
    let [low_x, low_z] = corner.unwrap_or_default();
    places.iter_mut().for_each(|[x, z]| (*x, *z) = (*x - low_x, *z - low_z));
    let Some(cell) = cell_m(&places) else { return vec![Vec::new(); members.len()] };
    let cell_of = |place: [f64; 2]| {
        place.map(|along| {
            #[expect(clippy::cast_possible_truncation, reason = "a small number, see above")]
            let number = (along / cell).floor() as i64;
            number
        })
    };
    let mut cells: HashMap<[i64; 2], Vec<usize>> = HashMap::new();
    for (member, place) in places.iter().enumerate() {
        cells.entry(cell_of(*place)).or_default().push(member);
    }
    let wanted = count.min(members.len() - 1);
    let around = |member: usize| {
        let [cx, cz] = cell_of(places[member]);
        let mut found: Vec<(f64, usize)> = Vec::new();
        for ring in 0.. {
            for x in cx - ring..=cx + ring {
                let edge = (x - cx).abs() == ring;
                let step = if edge || ring == 0 { 1 } else { 2 * ring };
                for z in (cz - ring..=cz + ring).step_by(usize::try_from(step).unwrap_or(1)) {
                    let there = cells.get(&[x, z]).into_iter().flatten();
                    found.extend(there.filter(|other| **other != member).map(|other| {
                        let [dx, dz] =
                            [0, 1].map(|axis: usize| places[*other][axis] - places[member][axis]);
                        (dx * dx + dz * dz, *other)
                    }));
                }
            }
            // All members within `ring` cells are known by now.
            let known_m = ring as f64 * cell;
            let near = found.iter().filter(|(squared, _)| *squared <= known_m * known_m).count();
            if near >= wanted || found.len() == members.len() - 1 {
                break;
            }
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found.into_iter().take(wanted).map(|(_, other)| other).collect()
    };
    (0..members.len()).map(around).collect()
}

/// Returns the side of cells of which nine hold some 20 members, in metres; `None` for fewer than two
/// members and for positions that are not finite.
fn cell_m(places: &[[f64; 2]]) -> Option<f64> {
    if places.len() < 2 || places.as_flattened().iter().any(|x| !x.is_finite()) {
        return None;
    }
    let extent = |axis: usize| {
        let values = || places.iter().map(|place| place[axis]);
        values().fold(f64::MIN, f64::max) - values().fold(f64::MAX, f64::min)
    };
    let (width, depth) = (extent(0), extent(1));
    let by_area = (width * depth / places.len() as f64 * 2.5).max(0.0).sqrt();
    let by_length = width.max(depth) / places.len() as f64;
    Some(by_area.max(by_length).max(1e-3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grid_finds_the_members_that_a_search_of_all_finds() {
        let mut random = fastrand::Rng::with_seed(3);
        for (count, width) in [(1, 1.0), (2, 1.0), (15, 3.0), (300, 40.0), (300, 0.0)] {
            let at = |random: &mut fastrand::Rng| random.f32() * width;
            let members: Vec<_> =
                (0..count).map(|_| (0, [at(&mut random), 0.0, 5.0 * at(&mut random)])).collect();
            for (member, found) in nearest(&members, 20).into_iter().enumerate() {
                let squared = |other: usize| {
                    let ([x, _, z], [ox, _, oz]) = (members[member].1, members[other].1);
                    let [dx, dz] = [x - ox, z - oz].map(f64::from);
                    dx * dx + dz * dz
                };
                let mut expected: Vec<f64> =
                    (0..count).filter(|other| *other != member).map(squared).collect();
                expected.sort_by(f64::total_cmp);
                expected.truncate(20);
                assert_eq!(found.len(), expected.len());
                for (found, expected) in found.into_iter().map(squared).zip(expected) {
                    assert!((found - expected).abs() < 1e-4, "{found} {expected}");
                }
            }
        }
    }
}
