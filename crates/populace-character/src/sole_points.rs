//! Which vertices of a mesh may touch the ground.

use std::f64::consts::PI;

use glam::DVec3;
use populace_model::{Skeleton, f64math};

use crate::character::rest_place;
use crate::{PaletteEntry, Part};

/// What is higher than this part of the body at rest is no sole.
const LOW: f64 = 0.25;
/// The part of a vertex's weight that makes it a joint's own.
const MOST: f32 = 0.5;
/// Steps of the directions in which points are the farthest: from heel down over flat to toes down,
/// and to either side.
const PITCHES: i32 = 6;
const ROLLS: i32 = 2;
const STEP_RAD: f64 = PI / 12.0;

/// For each joint, in level order, those of its vertices that come lowest when it stands flat, on
/// the heel, on the toes or on an edge: places at rest in model space, in metres; what
/// [`Skeleton::with_soles`] takes. A vertex is that of the joint that has half of its weight or
/// more; only the lowest quarter of the body counts. Indices past the end are passed over.
#[must_use]
pub fn sole_points(
    skeleton: &Skeleton,
    palette: &[PaletteEntry],
    parts: &[Part],
) -> Vec<Vec<[f32; 3]>> {
    let models = skeleton.rest_models();
    let model = |entry: &PaletteEntry| {
        models.get(entry.joint.index()).map(|m| *m * f64math::affine_from(&entry.joint_from_bind))
    };
    let binds: Vec<_> = palette.iter().map(|entry| model(entry).unwrap_or_default()).collect();
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut carried = vec![Vec::new(); models.len()];
    for mesh in parts.iter().map(|part| &part.mesh) {
        for vertex in 0..mesh.positions.len() {
            let place = rest_place(mesh, vertex, &binds);
            (low, high) = (low.min(place.y), high.max(place.y));
            let shares =
                || mesh.influences.of(vertex).filter_map(|(e, w)| Some((palette.get(e)?.joint, w)));
            let share = |joint| shares().filter(|(j, _)| *j == joint).map(|(_, w)| w).sum::<f32>();
            if let Some((joint, _)) = shares().find(|(joint, _)| share(*joint) >= MOST)
                && let Some(carried) = carried.get_mut(joint.index())
            {
                carried.push(place);
            }
        }
    }
    let is_low = |place: &DVec3| place.y <= low + LOW * (high - low);
    carried
        .iter()
        .map(|all| lowest(&all.iter().copied().filter(is_low).collect::<Vec<_>>()))
        .collect()
}

/// The farthest of some points in each direction that may lead down.
fn lowest(points: &[DVec3]) -> Vec<[f32; 3]> {
    let mut found: Vec<[f32; 3]> = Vec::new();
    if points.is_empty() {
        return found; // most joints of a large file have none, and directions take time
    }
    for pitch in -PITCHES..=PITCHES {
        for roll in -ROLLS..=ROLLS {
            let (pitch, roll) = (f64::from(pitch) * STEP_RAD, f64::from(roll) * STEP_RAD);
            let down = DVec3::new(roll.sin(), -roll.cos() * pitch.cos(), roll.cos() * pitch.sin());
            let farthest = points.iter().max_by(|a, b| a.dot(down).total_cmp(&b.dot(down)));
            let farthest = farthest.map(|place| f64math::to_f32(place.to_array()));
            found.extend(farthest.filter(|place| !found.contains(place)));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Influences, Mesh};
    use populace_model::{Affine, JointIndex, JointSource, Trs};

    #[test]
    fn the_lowest_vertices_of_each_joint_are_found() {
        let joint = |name: &str, parent, y| JointSource {
            name: name.into(),
            parent,
            rest: Trs { translation: [0.0, y, 0.0], ..Trs::IDENTITY },
        };
        let skeleton =
            Skeleton::new(&[joint("shin", None, 0.5), joint("foot", Some(0), -0.25)]).unwrap();
        let mut joint_from_bind = Affine::IDENTITY;
        joint_from_bind.rows[1][3] = -0.25;
        let palette = [
            PaletteEntry { joint: JointIndex(0), joint_from_bind: Affine::IDENTITY },
            PaletteEntry { joint: JointIndex(1), joint_from_bind },
        ];
        // Heel, tip, the top of the foot, what is moved by less than half, by no joint, and by the
        // shin, too high up.
        let positions = vec![
            [0.0, 0.0, -0.1],
            [0.0, 0.0, 0.2],
            [0.0, 0.05, 0.05],
            [0.0, 0.0, 0.0],
            [0.0; 3],
            [0.0; 3],
        ];
        let entries =
            vec![1, 1, 1, 1, 9, 0].into_iter().flat_map(|entry| [entry, 0, 0, 0]).collect();
        let weights =
            [1.0, 1.0, 1.0, 0.4, 1.0, 1.0].into_iter().flat_map(|w| [w, 0.0, 0.0, 0.0]).collect();
        let mesh = Mesh {
            normals: Vec::new(),
            uvs: Vec::new(),
            colors: Vec::new(),
            influences: Influences { per_vertex: 4, entries, weights },
            indices: Vec::new(),
            positions,
        };
        let part = Part { node: 0, node_name: String::new(), primitive: 0, material: None, mesh };
        let mut found = sole_points(&skeleton, &palette, &[part]);
        found[1].sort_by(|a, b| a[2].total_cmp(&b[2]));
        assert_eq!(found, [vec![], vec![[0.0, 0.0, -0.1], [0.0, 0.0, 0.2]]]);
    }
}
