//! Which vertices of a mesh may touch the ground.

use std::f64::consts::PI;

use glam::DVec3;

use crate::character::rest_place;
use crate::{PaletteEntry, Part, Skeleton, f64math};

/// What is higher than this part of the body at rest is no sole.
const LOW: f64 = 0.25;
/// The part of a vertex's weight that makes it a joint's own.
const MOST: f32 = 0.5;
/// Steps of the directions in which points are the farthest: from heel down over flat to toes down, and to either side.
const PITCHES: i32 = 6;
const ROLLS: i32 = 2;
const STEP_RAD: f64 = PI / 12.0;

/// For each joint, in level order, those of its vertices that come lowest when it stands flat, on the heel, on the toes or
/// on an edge: places at rest in model space, in metres; what [`Skeleton::with_soles`] takes. A vertex is that of the joint
/// that has half of its weight or more; only the lowest quarter of the body counts. Indices past the end are passed over.
#[must_use]
pub fn sole_points(skeleton: &Skeleton, palette: &[PaletteEntry], parts: &[Part]) -> Vec<Vec<[f32; 3]>> {
    let models = f64math::rest_models(skeleton);
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
            let shares = || mesh.influences.of(vertex).filter_map(|(e, w)| Some((palette.get(e)?.joint, w)));
            let share = |joint| shares().filter(|(j, _)| *j == joint).map(|(_, w)| w).sum::<f32>();
            if let Some((joint, _)) = shares().find(|(joint, _)| share(*joint) >= MOST)
                && let Some(carried) = carried.get_mut(joint.index())
            {
                carried.push(place);
            }
        }
    }
    let is_low = |place: &DVec3| place.y <= low + LOW * (high - low);
    carried.iter().map(|all| lowest(&all.iter().copied().filter(is_low).collect::<Vec<_>>())).collect()
}

/// The farthest of some points in each direction that may lead down.
fn lowest(points: &[DVec3]) -> Vec<[f32; 3]> {
    let mut found: Vec<[f32; 3]> = Vec::new();
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
