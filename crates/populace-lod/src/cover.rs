//! Surfaces beneath others, such as a scalp beneath hair, and features on them, such as eyes.
//!
//! Two surfaces that lie close together cross once each is off by more than the distance between
//! them. Levels therefore draw in the vertices that lie beneath, which nobody sees, and draw out
//! features.

use std::collections::HashMap;

use glam::{DMat3, Vec3};
use parry3d::math::Vector;
use parry3d::query::{Ray, RayCast};
use parry3d::shape::TriMesh;
use populace_character::{Character, Mesh};
use populace_model::convert::place_bits;
use populace_model::f64math;

use crate::bound;
use crate::mesh::Simplifier;

/// Greatest depth of a vertex that is drawn in, in errors of the level.
const DEEPEST_ERRORS: f32 = 2.0;
/// Greatest distance by which a vertex is drawn in, as a fraction of the character's size.
const FARTHEST: f32 = 0.03;
/// Least thickness beneath a vertex that is drawn in, as a fraction of the size. Shafts and fingers
/// stay as they are, also where a hand or a blade surrounds them.
const THINNEST: f32 = 0.04;
/// Start of a ray before its vertex, which lies on its own surface, as a fraction of the size.
const CLEAR: f32 = 1e-4;
/// How far features are drawn out, in errors of the level.
const FEATURE_ERRORS: f32 = 0.5;

/// A vertex that levels move: one beneath another surface against its normal, one of a feature to where
/// the feature faces.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shift {
    /// Distance in metres to the surface above, along the normal; 0 for a feature.
    depth_m: f32,
    /// Greatest error in metres that counts.
    farthest_m: f32,
    /// Offset in bind space for an error of a metre.
    per_m: [f32; 3],
}

impl Shift {
    /// `per_m` is the offset at rest for an error of a metre. `None` if no offset in bind space
    /// gives it.
    fn new(depth_m: f32, farthest_m: f32, rest_from_bind: &DMat3, per_m: [f32; 3]) -> Option<Self> {
        let per_m = f64math::to_f32((rest_from_bind.inverse() * f64math::vec3(per_m)).to_array());
        per_m.iter().all(|c| c.is_finite()).then_some(Self { depth_m, farthest_m, per_m })
    }

    /// Returns the offset in bind space at a level.
    pub(crate) fn offset(&self, error_m: f32) -> [f32; 3] {
        let is_close = self.depth_m <= DEEPEST_ERRORS * error_m;
        let by_m = if is_close { error_m.min(self.farthest_m) } else { 0.0 };
        self.per_m.map(|component| by_m * component)
    }
}

/// Returns for each vertex of each part how levels of up to `most_m` metres draw it in, if it lies
/// beneath the outer side of another surface. `parts` are those of the character, not yet simplified.
/// Parts that are options have no such vertices: members who wear them do not wear the other options
/// above.
pub(crate) fn beneath(
    character: &Character,
    parts: &[Simplifier<'_>],
    most_m: f32,
) -> Vec<Vec<Option<Shift>>> {
    let nothing = |part: &Simplifier<'_>| vec![None; part.surface().positions.len()];
    let Some(surface) = bound::surface(parts) else { return parts.iter().map(nothing).collect() };
    let normals = normals(&surface);
    let binds = binds(character);
    let size_m = character.size_m();
    let of_vertex = |mesh: &Mesh, vertex: usize, place: [f32; 3]| {
        let normal = normals.get(&place_bits(place))?.try_normalize()?;
        let depth_m = depth_m(&surface, place, normal, CLEAR * size_m, DEEPEST_ERRORS * most_m)?;
        let into = Ray::new(Vector::from_array(place) - CLEAR * size_m * normal, -normal);
        if surface.cast_local_ray(&into, THINNEST * size_m, false).is_some() {
            return None;
        }
        let inwards = (-normal).to_array();
        Shift::new(depth_m, FARTHEST * size_m, &rest_from_bind(mesh, vertex, &binds), inwards)
    };
    let of_part = |(index, part): (usize, &Simplifier<'_>)| {
        if character.option_of(index).is_some() {
            return nothing(part);
        }
        let mesh = &character.parts[index].mesh;
        let places = part.surface().positions.iter().enumerate();
        places.map(|(vertex, place)| of_vertex(mesh, vertex, *place)).collect()
    };
    parts.iter().enumerate().map(of_part).collect()
}

/// Returns for each vertex of each part how levels draw it out, if it is one of a feature that faces
/// somewhere.
pub(crate) fn out(character: &Character, parts: &[Simplifier<'_>]) -> Vec<Vec<Option<Shift>>> {
    let (binds, farthest_m) = (binds(character), FARTHEST * character.size_m());
    let of_vertex = |mesh: &Mesh, (vertex, facing): (usize, &Option<Vec3>)| {
        let facing = facing.filter(|facing| *facing != Vec3::ZERO)?;
        let outwards = (FEATURE_ERRORS * facing).to_array();
        Shift::new(0.0, farthest_m, &rest_from_bind(mesh, vertex, &binds), outwards)
    };
    let of_part = |(index, part): (usize, &Simplifier<'_>)| {
        let mesh = &character.parts[index].mesh;
        part.features().iter().enumerate().map(|vertex| of_vertex(mesh, vertex)).collect()
    };
    parts.iter().enumerate().map(of_part).collect()
}

/// Returns the matrix of each palette entry at rest.
fn binds(character: &Character) -> Vec<DMat3> {
    character.rest_binds().iter().map(|bind| bind.matrix3).collect()
}

/// Returns the blended matrix of a vertex at rest. `binds` holds that of each palette entry.
fn rest_from_bind(mesh: &Mesh, vertex: usize, binds: &[DMat3]) -> DMat3 {
    let shares = mesh.influences.shares(vertex);
    shares.fold(DMat3::ZERO, |sum, (entry, share)| sum + binds[entry] * f64::from(share))
}

/// Returns the sum of the normals of the triangles around each place, by their area. Vertices at
/// one place have one normal, so that they stay together.
fn normals(surface: &TriMesh) -> HashMap<[u32; 3], Vector> {
    let mut normals = HashMap::new();
    for triangle in surface.triangles() {
        let [a, b, c] = [triangle.a, triangle.b, triangle.c];
        let normal = (b - a).cross(c - a);
        for corner in [a, b, c] {
            *normals.entry(place_bits(corner.to_array())).or_insert(Vector::ZERO) += normal;
        }
    }
    normals
}

/// Returns the distance along `normal` to the inner side of a surface; `None` if there is none
/// within `most_m`, or if an outer side is nearer.
fn depth_m(
    surface: &TriMesh,
    place: [f32; 3],
    normal: Vector,
    clear_m: f32,
    most_m: f32,
) -> Option<f32> {
    let ray = Ray::new(Vector::from_array(place) + clear_m * normal, normal);
    let hit = surface.cast_local_ray_and_get_normal(&ray, most_m, false)?;
    let above = surface.triangle(hit.subshape);
    let outwards = (above.b - above.a).cross(above.c - above.a);
    (outwards.dot(normal) > 0.0).then_some(clear_m + hit.time_of_impact)
}

#[cfg(test)]
mod tests {
    use populace_cast::{Look, person};
    use populace_character::{CharacterSource, Influences};

    use super::*;

    const MIDDLE: Vec3 = Vec3::new(3.0, 0.5, 0.0);

    /// Returns a cube beside the body that palette entry 0 moves.
    fn cube(half_m: f32) -> Mesh {
        let sides = [-half_m, half_m];
        let corner = |i: usize| MIDDLE + Vec3::new(sides[i & 1], sides[i >> 1 & 1], sides[i >> 2]);
        let faces =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let positions: Vec<[f32; 3]> = (0..8).map(|i| corner(i).to_array()).collect();
        Mesh {
            normals: vec![[0.0, 1.0, 0.0]; positions.len()],
            uvs: Vec::new(),
            colors: Vec::new(),
            influences: Influences {
                per_vertex: 4,
                entries: vec![0; 4 * positions.len()],
                weights: [1.0, 0.0, 0.0, 0.0].repeat(positions.len()),
            },
            indices: faces.iter().flat_map(|[a, b, c, d]| [a, b, c, a, c, d]).copied().collect(),
            positions,
        }
    }

    /// Returns the vertices of a cube around which another one is 5 mm larger.
    fn beneath_larger(half_m: f32) -> Vec<Option<Shift>> {
        let mut source = CharacterSource::clone(&person(&Look::girl()).unwrap());
        source.parts.iter_mut().for_each(|part| part.node_name = "body".into());
        source.parts[0].mesh = cube(half_m);
        source.parts[1].mesh = cube(half_m + 0.005);
        let character = Character::new(source).unwrap();
        beneath(&character, &crate::simplifiers(&character), 0.05).swap_remove(0)
    }

    #[test]
    fn thick_things_beneath_others_are_drawn_in_and_thin_ones_are_not() {
        let thick = beneath_larger(0.1);
        for (place, vertex) in cube(0.1).positions.into_iter().zip(&thick) {
            let offset = Vec3::from(vertex.unwrap().offset(0.01));
            assert!((offset.length() - 0.01).abs() < 1e-5, "{offset}");
            assert!(offset.dot(Vec3::from(place) - MIDDLE) < 0.0, "{offset}");
            assert_eq!(vertex.unwrap().offset(0.003), [0.0; 3], "8.7 mm beneath the other");
        }
        assert!(beneath_larger(0.01).iter().all(Option::is_none));
    }
}
