//! Levels of detail: coarser meshes of a character, for small pictures of it.
//!
//! Each level is simplified from one before it until its surface is a given distance off
//! (edge collapse by quadric error with attributes: M. Garland and P. S. Heckbert, "Simplifying
//! surfaces with color and texture using quadric error metrics", IEEE Visualization 1998). Normals,
//! texture coordinates, colours and joint weights count as distances, so that folds, seams and bends
//! stay. Pieces that stick out much farther than the error, such as the brim of a hat, stay too.
//!
//! Features, such as eyes and brows, and colours stay longer in fine levels, in which faces count.
//! Features are drawn out by half an error, so that a coarser face does not cover them. Coarse levels
//! are simplified from a chain that drops both by their sizes.
//!
//! Palettes, textures and materials stay as they are. Vertices are a subset of the character's, with
//! normals and colours that stand for the surface around them. Those that lie beneath another surface
//! by less than two errors, such as a scalp beneath hair, are drawn in by one, so that they stay
//! hidden.
//!
//! Each level evaluates only the first joints, in level order, up to the last one that moves vertices
//! farther away from it than four times the level's error. The other joints, such as those of
//! fingers, hang from the first as at rest.

mod bound;
mod cover;
mod features;
mod groups;
mod mesh;

use std::ops::Range;

use populace_character::{Character, CharacterSource, Error, Level, Mesh, joints_needed};

use crate::groups::JointGroups;
use crate::mesh::Simplifier;

/// Errors of the levels, as fractions of the character's size ([`Character::size_m`]); the most influences of a vertex; and
/// whether the next levels are simplified from it. Small members are many, and between errors far
/// apart they would be drawn much finer than they need. Errors add up along the chain, so it has none
/// of the levels between.
const LEVELS: [(f32, usize, bool); 12] = [
    (0.001, 4, true),
    (0.0018, 4, true),
    (0.0032, 4, true),
    (0.0056, 2, true),
    (0.0075, 2, false),
    (0.01, 2, true),
    (0.0134, 2, false),
    (0.018, 2, true),
    (0.024, 2, false),
    (0.032, 1, true),
    (0.042, 1, false),
    (0.056, 1, true),
];
/// Errors of levels in which faces count, as fractions of the character's size. Finer levels keep
/// them by their sizes alone.
const FACES_COUNT: Range<f32> = 0.0015..0.012;
/// Errors that [`reduced`] tries, as fractions of the character's size: each this much greater
/// than the one before.
const FIRST_REDUCTION: f32 = 0.0001;
const REDUCTION_STEP: f32 = 1.3;
/// [`reduced`] leaves parts as they are that have less than this fraction of the triangles allowed.
const SMALL_PART: usize = 16;
/// A level must save at least this part of the triangles of the level before it.
const LEAST_SAVED: f32 = 0.2;

/// Returns the character with levels of detail, which replace those that it has. A mesh too small
/// to simplify gives none.
///
/// # Errors
///
/// [`Error::BadCharacter`] if a level is invalid, which no character gives rise to.
pub fn with_levels(character: Character) -> Result<Character, Error> {
    let levels = levels_of(&character);
    character.with_levels(levels)
}

/// Returns levels of detail for a character, finest first.
#[must_use]
pub fn levels_of(character: &Character) -> Vec<Level> {
    let size_m = character.size_m();
    // A point has no errors.
    if !size_m.is_normal() {
        return Vec::new();
    }
    let mut simplifiers = simplifiers(character);
    let most_m = LEVELS.map(|(fraction, ..)| fraction).into_iter().fold(0.0, f32::max);
    let beneath = cover::beneath(character, &simplifiers, most_m * size_m);
    let out = cover::out(character, &simplifiers);
    let mut faces: Option<Vec<Simplifier>> = None;
    let mut levels: Vec<Level> = Vec::new();
    let mut shown = count(&simplifiers);
    for (fraction, influences, leads) in LEVELS {
        let error_m = fraction * size_m;
        let faces_count = FACES_COUNT.contains(&fraction);
        if faces_count {
            let with_faces = || simplifiers.iter().map(Simplifier::with_faces).collect();
            bound::simplify(faces.get_or_insert_with(with_faces), error_m, |_| true);
        }
        let mut between = (!leads).then(|| simplifiers.clone());
        let coarse = between.as_mut().unwrap_or(&mut simplifiers);
        bound::simplify(coarse, error_m, |_| true);
        let own = faces.as_ref().filter(|_| faces_count).unwrap_or(coarse);
        let left = count(own);
        if left == 0 {
            break;
        }
        if left as f32 > (1.0 - LEAST_SAVED) * shown as f32 {
            continue;
        }
        shown = left;
        let meshes = own.iter().zip(beneath.iter().zip(&out)).map(|(part, (beneath, out))| {
            let shift = |vertex: usize| out[vertex].filter(|_| faces_count).or(beneath[vertex]);
            part.mesh(influences, &|vertex| shift(vertex).map(|shift| shift.offset(error_m)))
        });
        let meshes: Vec<Mesh> = meshes.collect();
        let joint_count = joints_needed(&character.skeleton, error_m);
        levels.push(Level { error_m, meshes, joint_count });
    }
    levels
}

fn count(simplifiers: &[Simplifier<'_>]) -> usize {
    simplifiers.iter().map(triangles_of).sum()
}

/// Returns the character's parts, not yet simplified.
fn simplifiers(character: &Character) -> Vec<Simplifier<'_>> {
    let groups = JointGroups::of(character);
    let parts = 0..character.parts.len();
    parts.map(|part| Simplifier::new(character, part, &groups)).collect()
}

fn triangles_of(simplifier: &Simplifier<'_>) -> usize {
    simplifier.surface().triangles().len()
}

/// Returns the character with its meshes simplified as little as needed to have at most `triangles`
/// triangles, but by no more than `error_m` metres. Small parts, such as eyes, stay as they are. It
/// has no levels of detail.
///
/// # Errors
///
/// [`Error::BadCharacter`] if the character is invalid, which no character gives rise to.
pub fn reduced(character: &Character, triangles: usize, error_m: f32) -> Result<Character, Error> {
    let mut source = CharacterSource::clone(character);
    let mut simplifiers = simplifiers(character);
    let small = triangles / SMALL_PART;
    let size_m = character.size_m();
    let mut next_m = FIRST_REDUCTION * size_m;
    // Nothing is left to reduce at an error as large as the character.
    while 0.0 < next_m && next_m < size_m && next_m <= error_m && count(&simplifiers) > triangles {
        bound::simplify(&mut simplifiers, next_m, |s| triangles_of(s) > small);
        next_m *= REDUCTION_STEP;
    }
    for (part, simplifier) in source.parts.iter_mut().zip(&simplifiers) {
        part.mesh = simplifier.mesh(part.mesh.influences.per_vertex, &|_| None);
    }
    Character::new(source)
}

#[cfg(test)]
mod tests {
    use populace_cast::{Look, person};

    use super::*;

    #[test]
    fn eyes_stay_in_levels_in_which_faces_count() {
        let girl = person(&Look::girl()).unwrap();
        let height = girl.height_m();
        let mut parts: Vec<Simplifier> =
            simplifiers(&girl).iter().map(Simplifier::with_faces).collect();
        bound::simplify(&mut parts, 0.01 * height, |_| true);
        let of_face = |part: &Simplifier<'_>| {
            let is_of_face = |vertex: usize| {
                part.features()[vertex].is_some()
                    && part.surface().positions[vertex][1] > 0.85 * height
            };
            part.surface().triangles().iter().filter(|t| is_of_face(t[0] as usize)).count()
        };
        let (face, all) = (parts.iter().map(of_face).sum::<usize>(), count(&parts));
        assert!((20..all / 4).contains(&face), "{face} of {all} triangles");
    }
}
