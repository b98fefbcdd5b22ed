//! Simplification of one part.

use std::collections::HashMap;
use std::ops::Range;

use glam::{Vec3, Vec4};
use meshopt::{SimplifyOptions, SimplifyVertex, optimize_vertex_cache, simplify_with_update};
use populace_character::{Character, Influences, Mesh};
use populace_model::convert::{single, u32_from};

use crate::features::features;
use crate::groups::JointGroups;

/// Distance that a difference of 1 between unit normals counts as, as a fraction of the part's longest
/// side along an axis.
const NORMAL: f32 = 0.0155;
/// The same between linear colours.
const COLOR: f32 = 0.07;
/// The same where faces count.
const COLOR_OF_FACES: f32 = 0.23;
/// Error of features where faces count, as a fraction of the character's size: they are seen by their
/// colours, not by their shapes.
const FEATURE_ERROR: f32 = 0.0015;
/// The same between the weights of two groups of joints.
const WEIGHT: f32 = 0.062;
/// Part of the distance on the surface that a shift of the texture counts as, in a part as long as the
/// character's size. In a shorter part it is less by the same factor.
const TEXTURE: f32 = 0.23;
/// The normal in a vertex's attributes.
const NORMALS: Range<usize> = 0..3;
/// The texture coordinates.
const UVS: Range<usize> = 3..5;
/// The colour. Weights of groups of joints follow.
const COLORS: Range<usize> = 5..8;
/// Weights below this part of a vertex's greatest are dropped where influences are limited.
const LEAST_WEIGHT: f32 = 0.02;

/// A part that becomes coarser step by step.
#[derive(Clone)]
pub(crate) struct Simplifier<'a> {
    source: &'a Mesh,
    /// How much each attribute counts, in the simplifier's unit: the part's longest side along an
    /// axis.
    weights: Vec<f32>,
    /// The simplified surface.
    now: Surface,
    /// The surface of the level before, from which `now` is simplified.
    before: Surface,
    /// Vertices that stay.
    locked: Vec<SimplifyVertex>,
    /// For each vertex of a feature the direction in which the feature faces.
    features: Vec<Option<Vec3>>,
    /// True if the rest pose mirrors the part.
    is_mirrored: bool,
    /// Size of the character in metres.
    size_m: f32,
    /// Features and colours stay longer.
    faces_count: bool,
}

/// A simplified surface. Its vertices are numbered as those of the source.
#[derive(Clone, Default)]
pub(crate) struct Surface {
    /// At rest, in metres.
    pub(crate) positions: Vec<[f32; 3]>,
    /// For each vertex its normal, texture coordinates, colour and weights of groups of joints.
    attributes: Vec<f32>,
    /// Counter-clockwise seen from the front at rest.
    indices: Vec<u32>,
}

impl Surface {
    pub(crate) fn triangles(&self) -> &[[u32; 3]] {
        self.indices.as_chunks().0
    }

    /// Returns the vertices of the triangles, in order.
    pub(crate) fn vertices(&self) -> Vec<usize> {
        let mut vertices: Vec<usize> = self.indices.iter().map(|index| *index as usize).collect();
        vertices.sort_unstable();
        vertices.dedup();
        vertices
    }
}

impl<'a> Simplifier<'a> {
    pub(crate) fn new(character: &'a Character, part: usize, groups: &JointGroups) -> Self {
        let source = &character.parts[part].mesh;
        let positions = character.rest_positions(part);
        let size_m = character.size_m();
        let sizes_per_uv = (metres_per_uv(source, &positions) / size_m).min(1.0);
        let mut weights = vec![NORMAL; 3];
        weights.extend([TEXTURE * sizes_per_uv; 2]);
        weights.extend([COLOR; 3]);
        weights.extend(vec![WEIGHT; groups.count]);
        let mut attributes = Vec::with_capacity(positions.len() * weights.len());
        for vertex in 0..positions.len() {
            attributes.extend(source.normals[vertex]);
            attributes.extend(source.uvs.get(vertex).copied().unwrap_or_default());
            attributes.extend(source.colors.get(vertex).map_or([1.0; 3], |c| [c[0], c[1], c[2]]));
            let first = attributes.len();
            attributes.resize(first + groups.count, 0.0);
            groups.add_weights(&source.influences, vertex, &mut attributes[first..]);
        }
        let locked = vec![SimplifyVertex::None; positions.len()];
        let is_mirrored = character.is_mirrored(part);
        let mut indices = welded(source, &positions);
        if is_mirrored {
            flip(&mut indices);
        }
        let now = Surface { positions, attributes, indices };
        let features = features(&now.positions, now.triangles(), size_m);
        let before = Surface::default();
        Self {
            source,
            weights,
            now,
            before,
            locked,
            features,
            is_mirrored,
            size_m,
            faces_count: false,
        }
    }

    pub(crate) fn surface(&self) -> &Surface {
        &self.now
    }

    /// Returns the same part, of which features and colours stay longer.
    pub(crate) fn with_faces(&self) -> Self {
        let mut faces = self.clone();
        faces.faces_count = true;
        faces.weights[COLORS].iter_mut().for_each(|weight| *weight *= COLOR_OF_FACES / COLOR);
        faces
    }

    /// Returns for each vertex of a feature the direction in which the feature faces.
    pub(crate) fn features(&self) -> &[Option<Vec3>] {
        &self.features
    }

    /// Returns the surface at the last call of [`Self::begin`].
    pub(crate) fn before(&self) -> &Surface {
        &self.before
    }

    /// Starts to simplify the present surface. No vertex is locked.
    pub(crate) fn begin(&mut self) {
        self.before.clone_from(&self.now);
        self.locked.fill(SimplifyVertex::None);
    }

    /// Keeps a vertex until the next call of [`Self::begin`], with the largest of its triangles: a
    /// vertex alone vanishes where its neighbours merge.
    pub(crate) fn lock(&mut self, vertex: usize) {
        let of_vertex = |triangle: &&[u32; 3]| triangle.iter().any(|i| *i as usize == vertex);
        let area = |triangle: &&[u32; 3]| {
            let [a, b, c] = triangle.map(|i| Vec3::from(self.before.positions[i as usize]));
            (b - a).cross(c - a).length_squared()
        };
        let triangles = self.before.triangles().iter().filter(of_vertex);
        for index in triangles.max_by(|s, t| area(s).total_cmp(&area(t))).into_iter().flatten() {
            self.locked[*index as usize] = SimplifyVertex::Lock;
        }
    }

    /// Simplifies the surface of the last call of [`Self::begin`] until it is `error_m` off.
    pub(crate) fn collapse(&mut self, error_m: f32) {
        self.now.clone_from(&self.before);
        let is_feature =
            |[vertex, ..]: &[u32; 3]| self.faces_count && self.features[*vertex as usize].is_some();
        let (features, rest): (Vec<[u32; 3]>, Vec<[u32; 3]>) =
            self.before.triangles().iter().partition(|triangle| is_feature(triangle));
        self.now.indices.clear();
        self.collapse_some(rest, error_m);
        self.collapse_some(features, error_m.min(FEATURE_ERROR * self.size_m));
        // Vertices that slide along the surface would take their joints with them, and the texture
        // would slide.
        self.now.positions.clone_from(&self.before.positions);
        let stride = self.weights.len();
        let vertices = self.now.attributes.chunks_exact_mut(stride);
        for (now, before) in vertices.zip(self.before.attributes.chunks_exact(stride)) {
            now[UVS].copy_from_slice(&before[UVS]);
        }
    }

    /// Simplifies some triangles, and adds what is left of them to the present surface.
    fn collapse_some(&mut self, triangles: Vec<[u32; 3]>, error_m: f32) {
        let mut indices = triangles.into_flattened();
        if indices.is_empty() {
            return;
        }
        let options =
            SimplifyOptions::ErrorAbsolute | SimplifyOptions::Prune | SimplifyOptions::Permissive;
        let count = simplify_with_update(
            &mut indices,
            &mut self.now.positions,
            &mut self.now.attributes,
            &self.weights,
            self.weights.len() * size_of::<f32>(),
            Some(&self.locked),
            0,
            error_m,
            options,
            None,
        );
        self.now.indices.extend(&indices[..count]);
    }

    /// Returns the present mesh, with at most `influences` joints for each vertex. `offset` is what
    /// moves a vertex in bind space, if anything does.
    pub(crate) fn mesh(
        &self,
        influences: usize,
        offset: &dyn Fn(usize) -> Option<[f32; 3]>,
    ) -> Mesh {
        let (source, now) = (self.source, &self.now);
        let mut indices = optimize_vertex_cache(&now.indices, now.positions.len());
        if self.is_mirrored {
            flip(&mut indices);
        }
        let mut new_of_old = HashMap::new();
        let mut kept: Vec<usize> = Vec::new();
        let indices = indices
            .iter()
            .map(|&old| {
                *new_of_old.entry(old).or_insert_with(|| {
                    kept.push(old as usize);
                    u32_from(kept.len() - 1)
                })
            })
            .collect();
        let attributes = |vertex: usize| &now.attributes[vertex * self.weights.len()..];
        let normal = |vertex: &usize| {
            let normal = Vec3::from_slice(&attributes(*vertex)[NORMALS]).try_normalize();
            normal.map_or(source.normals[*vertex], |n| n.to_array())
        };
        let position = |vertex: &usize| {
            let (place, offset) = (source.positions[*vertex], offset(*vertex).unwrap_or_default());
            [0, 1, 2].map(|i| place[i] + offset[i])
        };
        let [least, most] = color_range(source);
        let color = |vertex: &usize| {
            let [.., alpha] = *source.colors.get(*vertex)?;
            let color = Vec3::from_slice(&attributes(*vertex)[COLORS]).clamp(least, most);
            Some(color.extend(alpha).to_array())
        };
        Mesh {
            positions: kept.iter().map(position).collect(),
            normals: kept.iter().map(normal).collect(),
            uvs: kept.iter().filter_map(|vertex| source.uvs.get(*vertex).copied()).collect(),
            colors: kept.iter().filter_map(color).collect(),
            influences: fewer_influences(&source.influences, &kept, influences),
            indices,
        }
    }
}

/// Returns the least and the most of red, green and blue that a mesh's vertices have.
fn color_range(mesh: &Mesh) -> [Vec3; 2] {
    let colors = mesh.colors.iter().map(|color| Vec4::from(*color).truncate());
    colors.fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[least, most], color| {
        [least.min(color), most.max(color)]
    })
}

/// Returns the strongest influences of some vertices. Weights keep their sum.
fn fewer_influences(source: &Influences, kept: &[usize], most: usize) -> Influences {
    let per_vertex = if most <= 4 { 4 } else { source.per_vertex };
    let (mut entries, mut weights) = (Vec::new(), Vec::new());
    for vertex in kept {
        let range = vertex * source.per_vertex..(vertex + 1) * source.per_vertex;
        let mut pairs: Vec<(u16, f32)> = source.entries[range.clone()]
            .iter()
            .copied()
            .zip(source.weights[range].iter().copied())
            .collect();
        pairs.sort_by(|a, b| b.1.total_cmp(&a.1));
        let sum: f32 = pairs.iter().map(|pair| pair.1).sum();
        let least = pairs[0].1 * LEAST_WEIGHT;
        pairs.retain(|pair| pair.1 >= least);
        pairs.truncate(most.min(per_vertex));
        let left: f32 = pairs.iter().map(|pair| pair.1).sum();
        pairs.resize(per_vertex, (pairs[0].0, 0.0));
        entries.extend(pairs.iter().map(|pair| pair.0));
        let scale = if left > 0.0 { sum / left } else { 1.0 };
        weights.extend(pairs.iter().map(|pair| pair.1 * scale));
    }
    Influences { per_vertex, entries, weights }
}

/// Reverses the winding of every triangle.
fn flip(indices: &mut [u32]) {
    indices.as_chunks_mut::<3>().0.iter_mut().for_each(|triangle| triangle.swap(1, 2));
}

/// Returns the indices of the triangles, with one index for vertices that are equal in all ways.
fn welded(mesh: &Mesh, positions: &[[f32; 3]]) -> Vec<u32> {
    let per_vertex = mesh.influences.per_vertex;
    let key = |vertex: usize| {
        let floats = positions[vertex]
            .iter()
            .chain(&mesh.normals[vertex])
            .chain(mesh.uvs.get(vertex).into_iter().flatten())
            .chain(mesh.colors.get(vertex).into_iter().flatten())
            .chain(&mesh.influences.weights[vertex * per_vertex..(vertex + 1) * per_vertex]);
        let bits: Vec<u32> = floats.map(|f| (f + 0.0).to_bits()).collect();
        let entries = &mesh.influences.entries[vertex * per_vertex..(vertex + 1) * per_vertex];
        (bits, entries)
    };
    let mut first = HashMap::new();
    let same: Vec<u32> = (0..positions.len())
        .map(|vertex| *first.entry(key(vertex)).or_insert(u32_from(vertex)))
        .collect();
    mesh.indices.iter().map(|index| same[*index as usize]).collect()
}

/// Returns how many metres of surface a unit of texture coordinates covers; 0 without a texture.
fn metres_per_uv(mesh: &Mesh, positions: &[[f32; 3]]) -> f32 {
    if mesh.uvs.is_empty() {
        return 0.0;
    }
    let (mut surface, mut texture) = (0.0_f64, 0.0_f64);
    for triangle in mesh.indices.as_chunks::<3>().0 {
        let [a, b, c] = triangle.map(|index| index as usize);
        let edge =
            |to: usize| [0, 1, 2].map(|i: usize| f64::from(positions[to][i] - positions[a][i]));
        let ([ux, uy, uz], [vx, vy, vz]) = (edge(b), edge(c));
        let cross = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
        surface += cross.iter().map(|x| x * x).sum::<f64>().sqrt();
        let edge = |to: usize| [0, 1].map(|i: usize| f64::from(mesh.uvs[to][i] - mesh.uvs[a][i]));
        let ([ux, uy], [vx, vy]) = (edge(b), edge(c));
        texture += (ux * vy - uy * vx).abs();
    }
    if texture > 0.0 { single((surface / texture).sqrt()) } else { 0.0 }
}
