//! Poses from the keys of source clips, and skinning of the whole surface.

use std::collections::HashMap;

use glam::{DAffine3, DMat3, DQuat, DVec3};
use populace_character::{Character, Part};
use populace_clip::Clip;
use populace_model::{Affine, Property, Track};

/// Surface of a character, with vertices of equal position welded across parts.
pub(crate) struct Surface<'a> {
    character: &'a Character,
    pub(crate) rest: Vec<DVec3>,
    /// Four influences of each vertex: joint in level order, and weight.
    pub(crate) influences: Vec<[(usize, f64); 4]>,
    pub(crate) triangles: Vec<[usize; 3]>,
}

impl<'a> Surface<'a> {
    /// Welds the vertices of a character. Panics if vertices of equal position differ in normal or
    /// influences, since a seam or a gap would be visible.
    pub(crate) fn welded(character: &'a Character) -> Self {
        Self::of_parts(character, |_| true)
    }

    /// Welds the vertices of body and hair: without hats, glasses and bags.
    pub(crate) fn bare(character: &'a Character) -> Self {
        Self::of_parts(character, |part| {
            populace_cast::option_of(&part.node_name).is_none_or(|(group, _)| group == "hair")
        })
    }

    /// Welds the vertices of some parts, as [`Self::welded`].
    pub(crate) fn of_parts(character: &'a Character, wanted: impl Fn(&Part) -> bool) -> Self {
        let mut surface = Self { character, rest: vec![], influences: vec![], triangles: vec![] };
        let mut welded: HashMap<[u32; 3], (usize, [f32; 3])> = HashMap::new();
        for part in character.parts.iter().filter(|part| wanted(part)) {
            let mesh = &part.mesh;
            let own: Vec<usize> = (0..mesh.positions.len())
                .map(|v| {
                    let influences = std::array::from_fn(|i| {
                        let entry = usize::from(mesh.influences.entries[4 * v + i]);
                        let joint = character.palette[entry].joint.index();
                        (joint, f64::from(mesh.influences.weights[4 * v + i]))
                    });
                    let next = surface.rest.len();
                    let (at, normal) = *welded
                        .entry(mesh.positions[v].map(f32::to_bits))
                        .or_insert((next, mesh.normals[v]));
                    if at == next {
                        surface.rest.push(DVec3::from_array(mesh.positions[v].map(f64::from)));
                        surface.influences.push(influences);
                    }
                    assert_eq!(
                        surface.influences[at], influences,
                        "{} has a gap: influences differ at a border",
                        character.name
                    );
                    assert_eq!(
                        normal, mesh.normals[v],
                        "{} has a seam: normals differ",
                        character.name
                    );
                    at
                })
                .collect();
            surface
                .triangles
                .extend(mesh.indices.chunks(3).map(|t| [0, 1, 2].map(|i| own[t[i] as usize])));
        }
        surface
    }

    /// Returns the positions of all vertices for the joint transforms `model_from_joint`.
    pub(crate) fn skinned(&self, models: &[DAffine3]) -> Vec<DVec3> {
        let mut palette = vec![DAffine3::IDENTITY; models.len()];
        for entry in &self.character.palette {
            let joint = entry.joint.index();
            palette[joint] = models[joint] * wide(&entry.joint_from_bind);
        }
        let image = |(rest, influences): (&DVec3, &[(usize, f64); 4])| {
            influences.iter().map(|&(j, w)| palette[j].transform_point3(*rest) * w).sum()
        };
        self.rest.iter().zip(&self.influences).map(image).collect()
    }

    /// Returns the weight of the joint named `joint` at a vertex.
    pub(crate) fn weight(&self, vertex: usize, joint: &str) -> f64 {
        let joint = self.character.skeleton.find(joint).unwrap().index();
        self.influences[vertex].iter().filter(|(j, _)| *j == joint).map(|(_, w)| w).sum()
    }
}

/// Returns `model_from_joint` of all joints in level order, at a time of `clip` in seconds, or at
/// rest.
pub(crate) fn models(character: &Character, clip: Option<(&Clip, f64)>) -> Vec<DAffine3> {
    let skeleton = &character.skeleton;
    let mut models: Vec<DAffine3> = vec![];
    for joint in skeleton.joints() {
        let rest = skeleton.rest(joint);
        let mut rotation = DQuat::from_array(rest.rotation.map(f64::from));
        let mut translation = DVec3::from_array(rest.translation.map(f64::from));
        for (track, secs) in clip.iter().flat_map(|(clip, secs)| {
            clip.source()
                .tracks
                .iter()
                .filter(|t| t.joint == skeleton.name(joint))
                .map(|t| (t, *secs))
        }) {
            match track.property {
                Property::Rotation => rotation = rotation_at(track, secs),
                Property::Translation => translation = translation_at(track, secs),
                Property::Scale => panic!("clips of people have no scale tracks"),
            }
        }
        let local = DAffine3::from_rotation_translation(rotation, translation);
        models.push(skeleton.parent(joint).map_or(local, |p| models[p.index()] * local));
    }
    models
}

/// Returns the times in seconds of a clip's keys, except the last, and the midpoints between keys.
pub(crate) fn times(clip: &Clip) -> Vec<f64> {
    let keys: Vec<f64> = clip.source().tracks[0].times.iter().map(|t| f64::from(*t)).collect();
    keys.windows(2).flat_map(|pair| [pair[0], 0.5 * (pair[0] + pair[1])]).collect()
}

/// Returns the index of the last key at or before `secs`, and the fraction of the way to the next.
fn around(track: &Track, secs: f64) -> (usize, f64) {
    let last = track.times.len() - 2;
    let key = track.times.iter().rposition(|t| f64::from(*t) <= secs).unwrap_or(0).min(last);
    let [from, to] = [track.times[key], track.times[key + 1]].map(f64::from);
    (key, (secs - from) / (to - from))
}

fn rotation_at(track: &Track, secs: f64) -> DQuat {
    let (key, part) = around(track, secs);
    let value = |k: usize| {
        DQuat::from_slice(&[0, 1, 2, 3].map(|i| f64::from(track.value(k)[i]))).normalize()
    };
    value(key).slerp(value(key + 1), part)
}

fn translation_at(track: &Track, secs: f64) -> DVec3 {
    let (key, part) = around(track, secs);
    let value = |k: usize| DVec3::from_array([0, 1, 2].map(|i| f64::from(track.value(k)[i])));
    value(key).lerp(value(key + 1), part)
}

fn wide(affine: &Affine) -> DAffine3 {
    let rows = affine.rows.map(|row| row.map(f64::from));
    let column = |c: usize| DVec3::new(rows[0][c], rows[1][c], rows[2][c]);
    DAffine3 { matrix3: DMat3::from_cols(column(0), column(1), column(2)), translation: column(3) }
}
