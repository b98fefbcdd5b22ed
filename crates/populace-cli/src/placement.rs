//! Positions and directions of members: in groups that stand or walk together, apart from each
//! other.
#![expect(
    clippy::disallowed_methods,
    reason = "sines and roots of the host alone; no device computes them again"
)]

use std::collections::HashMap;
use std::f32::consts::{PI, TAU};

use populace_random::Rng;

/// Half the width of the crowd per unit of distance from its apex, which lies before the crowd. It
/// is about that of the picture.
const WIDENING: f32 = 0.6;
/// Distance of the nearest groups from the apex, in spacings.
const FIRST: f32 = 3.5;
/// Ground per member in squared spacings, groups and what lies between them.
const AREA: f32 = 1.7;
/// Distance between members of a group in spacings, from middle to middle.
const CLOSE: f32 = 0.9;
/// Gap between groups, in spacings.
const GAP: f32 = 0.35;
/// Places that are tried for a group before the crowd grows deeper.
const TRIES: usize = 30;
/// Share of groups that stand, in percent.
const STANDING: usize = 45;

/// Place of one member.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    pub(crate) position: [f32; 3],
    /// Heading about +Y; 0 faces the camera at +Z.
    pub(crate) yaw_rad: f32,
    /// True if it walks, false if it stands.
    pub(crate) walks: bool,
}

/// A group of members around a middle.
struct Group {
    members: usize,
    walks: bool,
    yaw_rad: f32,
    radius: f32,
}

impl Group {
    fn random(most: usize, random: &mut Rng) -> Self {
        let members = match random.below(100) {
            0..38 => 1,
            38..68 => 2,
            68..86 => 3,
            86..95 => 4,
            _ => 5,
        };
        let members = members.min(most);
        let walks = random.below(100) >= STANDING;
        // Most people come or go along two ways that cross before the camera.
        let way = match random.below(100) {
            0..38 => 0.25,
            38..58 => 0.25 + PI,
            58..76 => 0.25 + 0.45 * PI,
            76..94 => 0.25 - 0.55 * PI,
            _ => random.signed() * PI,
        };
        let radius = match (walks, members) {
            (_, 1) => 0.0,
            (true, _) => 0.5 * CLOSE * (members - 1) as f32,
            (false, _) => 0.5 * CLOSE / (PI / members as f32).sin(),
        };
        Self { members, walks, yaw_rad: way + 0.3 * random.signed(), radius }
    }

    /// Returns the places of the members: side by side if they walk, else in a circle, face to
    /// face.
    fn places(&self, [x, z]: [f32; 2], spacing: f32, random: &mut Rng) -> Vec<Place> {
        let place = |[dx, dz]: [f32; 2], yaw_rad: f32| Place {
            position: [x + dx * spacing, 0.0, z + dz * spacing],
            yaw_rad,
            walks: self.walks,
        };
        let (sin, cos) = self.yaw_rad.sin_cos();
        (0..self.members)
            .map(|member| {
                if self.walks || self.members == 1 {
                    let across = CLOSE * member as f32 - self.radius;
                    let along = if self.members == 1 { 0.0 } else { 0.2 * random.signed() };
                    let offset = [cos * across + sin * along, cos * along - sin * across];
                    place(offset, self.yaw_rad + 0.06 * random.signed())
                } else {
                    let angle = self.yaw_rad + TAU * member as f32 / self.members as f32;
                    let offset = [angle.sin() * self.radius, angle.cos() * self.radius];
                    place(offset, angle + PI + 0.25 * random.signed())
                }
            })
            .collect()
    }
}

/// Returns the places of `count` members that are `spacing` metres wide, with room around them. The
/// crowd widens away from the camera at +Z, as its view does. A single member stands at the origin
/// and faces the camera, as does the group that is nearest to it.
pub(crate) fn places(count: usize, spacing: f32, random: &mut Rng) -> Vec<Place> {
    let mut groups = Vec::new();
    let mut left = count;
    while left > 0 {
        let group = Group::random(left, random);
        left -= group.members;
        groups.push(group);
    }
    // Large groups first, since they fit in fewest places.
    groups.sort_by(|a, b| b.radius.total_cmp(&a.radius));
    let mut middles = middles(&groups, count, random);
    face_camera(&mut groups, &mut middles);
    let mut places: Vec<Place> = groups
        .iter()
        .zip(&middles)
        .flat_map(|(group, middle)| group.places(middle.map(|m| m * spacing), spacing, random))
        .collect();
    if let [one] = places.as_mut_slice() {
        *one = Place { position: [0.0; 3], yaw_rad: 0.3 * random.signed(), walks: one.walks };
    }
    places
}

/// Turns the group nearest to the camera towards it.
fn face_camera(groups: &mut [Group], middles: &mut [[f32; 2]]) {
    let nearest = (0..groups.len()).max_by(|a, b| middles[*a][1].total_cmp(&middles[*b][1]));
    if let Some(group) = nearest.and_then(|nearest| groups.get_mut(nearest)) {
        group.yaw_rad = 0.25;
    }
}

/// Returns the middle of each group on the ground, in spacings, so that groups keep apart.
fn middles(groups: &[Group], count: usize, random: &mut Rng) -> Vec<[f32; 2]> {
    let widest = groups.first().map_or(0.0, |group| group.radius);
    let cell = 2.0 * widest + 1.0 + GAP;
    let mut cells: HashMap<[i64; 2], Vec<usize>> = HashMap::new();
    let mut middles: Vec<[f32; 2]> = Vec::with_capacity(groups.len());
    let mut depth_squared = FIRST * FIRST + AREA * count as f32 / WIDENING;
    for (number, group) in groups.iter().enumerate() {
        let mut tries = 0;
        let (middle, [cx, cz]) = loop {
            // Uniform over the ground: the width grows with the distance.
            let share = random.unit();
            let distance = (FIRST * FIRST + share * (depth_squared - FIRST * FIRST)).sqrt();
            let middle = [random.signed() * WIDENING * distance, FIRST - distance];
            #[expect(clippy::cast_possible_truncation, reason = "a few thousand cells")]
            let [cx, cz] = middle.map(|m| (m / cell).floor() as i64);
            let mut near = (-1..=1)
                .flat_map(|dx| (-1..=1).map(move |dz| [cx + dx, cz + dz]))
                .filter_map(|at| cells.get(&at))
                .flatten();
            let is_free = near.all(|other: &usize| {
                let [x, z] = middles[*other];
                let apart = group.radius + groups[*other].radius + 1.0 + GAP;
                (x - middle[0]).hypot(z - middle[1]) >= apart
            });
            if is_free {
                break (middle, [cx, cz]);
            }
            tries += 1;
            if tries % TRIES == 0 {
                depth_squared *= 1.02;
            }
        };
        cells.entry([cx, cz]).or_default().push(number);
        middles.push(middle);
    }
    middles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_keep_their_distance() {
        for count in [1, 2, 7, 100, 1000] {
            let places = places(count, 1.0, &mut Rng::new(7));
            assert_eq!(places.len(), count);
            for (i, a) in places.iter().enumerate() {
                for b in &places[..i] {
                    let [x, z] = [0, 2].map(|axis: usize| a.position[axis] - b.position[axis]);
                    let distance = x.hypot(z);
                    assert!(distance > 0.75, "{distance} m between two of {count}");
                }
            }
        }
    }

    #[test]
    fn members_stand_and_walk_in_groups_and_face_all_ways() {
        let places = places(1000, 1.0, &mut Rng::new(3));
        let walking = places.iter().filter(|place| place.walks).count();
        assert!((400..700).contains(&walking), "{walking}");
        for quarter in 0..4 {
            let faces = |place: &&Place| {
                let turned = (place.yaw_rad / (PI / 2.0)).rem_euclid(4.0);
                turned >= quarter as f32 && turned < (quarter + 1) as f32
            };
            let count = places.iter().filter(faces).count();
            assert!(count > 100, "{count} of 1000 face quarter {quarter}");
        }
        let has_company = |a: &&Place| {
            let near = |b: &Place| {
                (a.position[0] - b.position[0]).hypot(a.position[2] - b.position[2]) < 1.0
            };
            places.iter().filter(|b| near(b)).count() > 1
        };
        assert!((600..950).contains(&places.iter().filter(has_company).count()));
    }

    #[test]
    fn a_large_crowd_is_placed_in_little_time() {
        assert_eq!(places(100_000, 1.0, &mut Rng::new(1)).len(), 100_000);
    }
}
