//! Capsules around a character's bones, whose contact shadows darken the ground.

use glam::{DMat3, DVec3};
use populace_character::{Character, Part};
use populace_model::f64math;

use super::Shared;
use crate::Error;
use crate::gl::{DrawCommand, MeshPlace};
use crate::layout::Contact;

/// Most capsules of a character. Fingers have none.
const MOST: usize = 12;
/// Indices of the capsules of coarse levels: feet and the two largest bones.
const COARSE_INDICES: u32 = 4 * 6;
/// Weight from which a vertex belongs to a palette entry.
const OWN: f32 = 0.5;
/// Least number of vertices of a capsule.
const LEAST_VERTICES: usize = 8;
/// Greatest length of a capsule with its ends, in metres. Anything longer is a place, such as a floor, and not a body.
const LONGEST: f64 = 3.0;
/// Steps of the search for a capsule's axis; each doubles what is known of it.
const AXIS_STEPS: u32 = 24;
/// Corners of a capsule's rectangle on the ground: the end, and the side.
const CORNERS: [[f32; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

/// Capsules on the graphics device, the most important ones first.
pub(crate) struct Contacts {
    mesh: MeshPlace,
}

/// A capsule in the bind space of a palette entry.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Capsule {
    entry: u16,
    from: DVec3,
    to: DVec3,
    radius: f64,
    /// Height in metres of its lower end at rest.
    low_m: f64,
    /// Product of length and radius in square metres: how much of the sky it hides.
    size: f64,
}

impl Contacts {
    /// Uploads the capsules of the parts for which `hide` returns false.
    pub(crate) fn new(
        shared: &mut Shared,
        character: &Character,
        hide: &dyn Fn(&Part) -> bool,
    ) -> Result<Self, Error> {
        let capsules = capsules(character, hide);
        let vertices: Vec<Contact> = capsules.iter().flat_map(corners).collect();
        let firsts = (0u32..).step_by(CORNERS.len()).take(capsules.len());
        let indices: Vec<u32> = firsts.flat_map(|f| [0, 1, 2, 0, 2, 3].map(|i| f + i)).collect();
        Ok(Self { mesh: shared.contacts.add(&[bytemuck::cast_slice(&vertices)], &indices)? })
    }

    /// Returns the command that draws them at a level of detail, for the instances from `first` on;
    /// `None` if there are none.
    pub(crate) fn command(&self, is_coarse: bool, first: u32, count: u32) -> Option<DrawCommand> {
        let all = self.mesh.command(first, count);
        let command = if is_coarse { all.with_indices(COARSE_INDICES) } else { all };
        (command.triangles() > 0).then_some(command)
    }
}

fn corners(capsule: &Capsule) -> impl Iterator<Item = Contact> {
    let [radius] = f64math::to_f32([capsule.radius]);
    let end = |end: DVec3| {
        let [x, y, z] = f64math::to_f32(end.to_array());
        [x, y, z, radius]
    };
    let (from, to, entries0) = (end(capsule.from), end(capsule.to), [capsule.entry, 0, 0, 0]);
    CORNERS.into_iter().map(move |corner| Contact { from, to, corner, entries0 })
}

/// Returns the two lowest capsules at rest, which are the feet of a standing body, and then the
/// largest ones.
fn capsules(character: &Character, hide: &dyn Fn(&Part) -> bool) -> Vec<Capsule> {
    let binds = character.rest_binds();
    let mut points: Vec<Vec<DVec3>> = vec![Vec::new(); character.palette.len()];
    for mesh in character.parts.iter().filter(|part| !hide(part)).map(|part| &part.mesh) {
        let width = mesh.influences.per_vertex;
        let entries = mesh.influences.entries.chunks(width);
        let influences = entries.zip(mesh.influences.weights.chunks(width));
        for (position, (entries, weights)) in mesh.positions.iter().zip(influences) {
            let half = OWN * weights.iter().sum::<f32>();
            let own = entries.iter().zip(weights).find(|(_, weight)| **weight >= half);
            if let Some((entry, _)) = own {
                points[usize::from(*entry)].push(f64math::vec3(*position));
            }
        }
    }
    let entries = (0..=u16::MAX).zip(binds).zip(&points);
    let mut all: Vec<Capsule> = entries
        .filter(|(_, points)| points.len() >= LEAST_VERTICES)
        .filter_map(|((index, model), points)| {
            let capsule = around(index, points);
            let ends = [capsule.from, capsule.to].map(|end| model.transform_point3(end));
            let scale = model.transform_vector3(DVec3::X).length();
            let radius_m = capsule.radius * scale;
            let low_m = ends[0].y.min(ends[1].y);
            let axis_m = ends[0].distance(ends[1]);
            let size = radius_m * (axis_m + radius_m);
            let is_body = low_m.is_finite() && size > 0.0 && axis_m + 2.0 * radius_m <= LONGEST;
            is_body.then_some(Capsule { low_m, size, ..capsule })
        })
        .collect();
    all.sort_by(|a, b| a.low_m.total_cmp(&b.low_m).then(a.entry.cmp(&b.entry)));
    let feet = all.len().min(2);
    all[feet..].sort_by(|a, b| b.size.total_cmp(&a.size).then(a.entry.cmp(&b.entry)));
    all.truncate(MOST);
    all
}

/// Returns a capsule along the longest extent of points. Half of them are within its radius.
fn around(entry: u16, points: &[DVec3]) -> Capsule {
    #[expect(clippy::cast_precision_loss, reason = "a mesh has fewer than 2^52 vertices")]
    let count = points.len() as f64;
    let middle = points.iter().sum::<DVec3>() / count;
    let outer = |p: &DVec3| {
        let d = *p - middle;
        DMat3::from_cols(d * d.x, d * d.y, d * d.z)
    };
    let spread = points.iter().map(outer).fold(DMat3::ZERO, |sum, m| sum + m);
    // Squaring the matrix leaves its largest eigenvalue.
    let power = (0..AXIS_STEPS).fold(spread, |m, _| {
        let largest = m.to_cols_array().into_iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        let m = m * largest.max(f64::MIN_POSITIVE).recip();
        m * m
    });
    let columns = [power.x_axis, power.y_axis, power.z_axis];
    let longest = columns
        .into_iter()
        .reduce(|a, b| if b.length_squared() > a.length_squared() { b } else { a });
    let axis = longest.and_then(DVec3::try_normalize).unwrap_or(DVec3::Y);
    let along = |p: &DVec3| (*p - middle).dot(axis);
    let across = |p: &DVec3| ((*p - middle) - along(p) * axis).length_squared();
    let radius = (points.iter().map(across).sum::<f64>() / count).sqrt();
    let low = points.iter().map(along).fold(f64::INFINITY, f64::min) + radius;
    let high = points.iter().map(along).fold(f64::NEG_INFINITY, f64::max) - radius;
    let [low, high] = if low < high { [low, high] } else { [0.5 * (low + high); 2] };
    let (from, to) = (middle + low * axis, middle + high * axis);
    Capsule { entry, from, to, radius, low_m: 0.0, size: 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn capsule_has_the_axis_and_radius_of_a_tube() {
        let axis = DVec3::new(1.0, 2.0, -1.0).normalize();
        let side = axis.any_orthonormal_vector();
        let other = axis.cross(side);
        let points: Vec<DVec3> = (0..=20)
            .flat_map(|step| {
                (0..12).map(move |turn| {
                    let (sin, cos) = (f64::from(turn) * std::f64::consts::TAU / 12.0).sin_cos();
                    DVec3::Y + 0.1 * f64::from(step) * axis + 0.2 * (sin * side + cos * other)
                })
            })
            .collect();
        let capsule = around(3, &points);
        assert!((capsule.radius - 0.2).abs() < 1e-9);
        let ends = [DVec3::Y + 0.2 * axis, DVec3::Y + 1.8 * axis];
        let off = |a: DVec3, b: DVec3| a.distance(ends[0]) + b.distance(ends[1]);
        let off = off(capsule.from, capsule.to).min(off(capsule.to, capsule.from));
        assert!(off < 1e-6, "{capsule:?}");
    }

    #[test]
    fn points_without_extent_give_a_small_ball() {
        let capsule = around(0, &[DVec3::ONE; 9]);
        assert_eq!((capsule.from, capsule.to, capsule.radius), (DVec3::ONE, DVec3::ONE, 0.0));
    }
}
