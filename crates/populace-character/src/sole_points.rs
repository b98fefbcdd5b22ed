//! Vertices of a mesh that may touch the ground.

use std::f64::consts::PI;

use glam::DVec3;
use populace_model::{Skeleton, f64math};

use crate::mesh::rest_place;
use crate::{PaletteEntry, Part};

/// Vertices higher than this fraction of the body at rest are not part of a sole.
const LOW: f64 = 0.25;
/// Fraction of a vertex's weights from which it belongs to a joint.
const MOST: f32 = 0.5;
/// Steps of the directions in which the farthest points are searched: from heel down over flat to
/// toes down, and to either side.
const PITCHES: i32 = 6;
const ROLLS: i32 = 2;
const STEP_RAD: f64 = PI / 12.0;

/// Returns for each joint, in level order, its lowest vertices when the foot is flat, on the heel,
/// on the toes or on an edge: positions in the bind pose in model space, in metres. This is the input of
/// [`Skeleton::with_soles`]. A vertex belongs to the joint with at least half of its weight. Only
/// the lowest quarter of the body is considered. Indices out of range are ignored.
#[must_use]
pub fn sole_points(
    skeleton: &Skeleton,
    palette: &[PaletteEntry],
    parts: &[Part],
) -> Vec<Vec<[f32; 3]>> {
    let models = skeleton.in_bind_pose().rest_models();
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
            let shares = || {
                mesh.influences.shares(vertex).filter_map(|(e, w)| Some((palette.get(e)?.joint, w)))
            };
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

/// Returns the farthest points in each direction that may point down.
fn lowest(points: &[DVec3]) -> Vec<[f32; 3]> {
    let mut found: Vec<[f32; 3]> = Vec::new();
    if points.is_empty() {
        return found; // most joints of a large file have no points, and directions take time
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
    fn lowest_vertices_of_each_joint_are_found() {
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
        // Heel, tip, the top of the foot, a vertex with less than half of the weight, one without a
        // joint, and one of the shin that is too high up.
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
        let mut weights = [1.0, 0.0, 0.0, 0.0].repeat(6);
        weights[3 * 4..][..2].copy_from_slice(&[0.4, 0.6]);
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
