//! Simplification that keeps thin pieces which stick out, such as brims of hats.
//!
//! Quadrics average distances over the area. The brim of a hat weighs little beside the rest of its
//! surface, so an error that is small on average can cost all of it. Vertices that end up far from
//! the simplified surface are therefore locked, and the parts are simplified again.

use parry3d::math::Vector;
use parry3d::query::PointQuery;
use parry3d::shape::TriMesh;
use populace_model::convert::u32_from;

use crate::mesh::Simplifier;

/// Distance from the simplified surface, in errors of the level, from which a vertex is locked.
const MOST_ERRORS: f32 = 1.5;
/// Least distance between vertices that one round locks, in errors of the level.
const APART_ERRORS: f32 = 8.0;
/// How often a part is simplified for one level, at most.
const ROUNDS: usize = 4;

/// Simplifies the `wanted` parts until their surface is `error_m` off. Locks vertices that end up far
/// off and simplifies their parts again, up to `ROUNDS` times in all. Separate pieces smaller than
/// the error vanish whole.
pub(crate) fn simplify(
    parts: &mut [Simplifier<'_>],
    error_m: f32,
    wanted: impl Fn(&Simplifier<'_>) -> bool,
) {
    let mut again: Vec<usize> = (0..parts.len()).filter(|part| wanted(&parts[*part])).collect();
    again.iter().for_each(|part| parts[*part].begin());
    again.iter().for_each(|part| parts[*part].collapse(error_m));
    for _ in 1..ROUNDS {
        if again.is_empty() {
            return;
        }
        let surface = surface(parts);
        again.retain(|part| lock_far(&mut parts[*part], surface.as_ref(), error_m));
        again.iter().for_each(|part| parts[*part].collapse(error_m));
    }
}

/// Returns the surface of all parts; `None` if nothing is left.
pub(crate) fn surface(parts: &[Simplifier<'_>]) -> Option<TriMesh> {
    let mut places = Vec::new();
    let mut triangles = Vec::new();
    for part in parts {
        let first = u32_from(places.len());
        let surface = part.surface();
        places.extend(surface.positions.iter().map(|p| Vector::from_array(*p)));
        triangles.extend(surface.triangles().iter().map(|t| t.map(|index| first + index)));
    }
    TriMesh::new(places, triangles).ok()
}

/// Locks some of a part's vertices that are far from the surface; without one, all are. Returns true
/// if there are any.
fn lock_far(part: &mut Simplifier<'_>, surface: Option<&TriMesh>, error_m: f32) -> bool {
    let (most_m, apart_m) = (MOST_ERRORS * error_m, APART_ERRORS * error_m);
    let mut locked: Vec<Vector> = Vec::new();
    for vertex in part.before().vertices() {
        let place = Vector::from_array(part.before().positions[vertex]);
        let is_near = |surface: &TriMesh| {
            surface.project_local_point_with_max_dist(place, false, most_m).is_some()
        };
        if !surface.is_some_and(is_near)
            && locked.iter().all(|other| other.distance(place) > apart_m)
        {
            locked.push(place);
            part.lock(vertex);
        }
    }
    !locked.is_empty()
}
