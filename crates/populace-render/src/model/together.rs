//! Parts that are drawn together.

use std::borrow::Cow;
use std::collections::HashMap;
use std::rc::Rc;

use populace_character::{AlphaMode, Influences, Material, Mesh};
use populace_device::layout::Float4;

use super::sides::Sides;
use super::{Alpha, MapTextures, ModelPart, Shared};
use crate::Error;
use crate::gl::Texture;
use crate::layout::{Bytes4, Influences4, Influences8, Surface, Vector4, Vertex};

/// Part of a surface that holes take at most for its back to be left out of a coarse level.
const COARSE_HOLES: f64 = 0.1;

/// What parts have in common that are drawn together.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Likeness {
    pub(super) texture: Option<populace_character::Texture>,
    /// Substance, normal, occlusion and emitted light.
    pub(super) maps: [Option<populace_character::Texture>; 4],
    normal_scale: f32,
    occlusion_strength: f32,
    emissive: [f32; 3],
    alpha: AlphaMode,
    double_sided: bool,
    mirrored: bool,
    per_vertex: usize,
    /// Blended parts are drawn one by one, in the character's order.
    blended_part: Option<usize>,
}

impl Likeness {
    pub(super) fn of(part: usize, mesh: &Mesh, material: &Material, mirrored: bool) -> Self {
        Self {
            texture: material.base_color_texture,
            maps: [
                material.metallic_roughness_texture,
                material.normal_texture,
                material.occlusion_texture,
                material.emissive_texture,
            ],
            normal_scale: material.normal_scale,
            occlusion_strength: material.occlusion_strength,
            emissive: material.emissive,
            alpha: material.alpha,
            double_sided: material.double_sided,
            mirrored,
            per_vertex: mesh.influences.per_vertex,
            blended_part: (material.alpha == AlphaMode::Blend).then_some(part),
        }
    }

    /// Returns the triangles of a mesh by whether both sides of them are drawn. Backs that nobody
    /// can see are left out; small holes are no reason to see them in a coarse level.
    pub(super) fn by_sides(
        self,
        mesh: &Mesh,
        is_coarse: bool,
    ) -> impl Iterator<Item = (Self, Cow<'_, [u32]>)> {
        let whole = (self, Cow::Borrowed(&mesh.indices[..]));
        if !self.double_sided || self.alpha != AlphaMode::Opaque {
            return [Some(whole), None].into_iter().flatten();
        }
        let most_open = if is_coarse { COARSE_HOLES } else { 0.0 };
        let Sides { solid, sheets } = Sides::of(mesh, most_open);
        let solid_like = Self { double_sided: false, ..self };
        let some =
            |like, indices: Vec<u32>| (!indices.is_empty()).then_some((like, Cow::Owned(indices)));
        [some(solid_like, solid), some(self, sheets)].into_iter().flatten()
    }
}

/// The triangles of parts that are drawn together.
pub(super) struct DrawnTogether {
    pub(super) like: Likeness,
    vertices: Vec<Vertex>,
    influences: Influences,
    indices: Vec<u32>,
}

impl DrawnTogether {
    pub(super) fn new(like: Likeness) -> Self {
        let (entries, weights) = (Vec::new(), Vec::new());
        let influences = Influences { per_vertex: like.per_vertex, entries, weights };
        Self { like, vertices: Vec::new(), influences, indices: Vec::new() }
    }

    /// Appends triangles of a mesh with the vertices that they use. `colors` and `marks`
    /// are those of all its vertices.
    pub(super) fn append(
        &mut self,
        mesh: &Mesh,
        indices: &[u32],
        colors: &[Vector4],
        marks: &[Bytes4],
    ) {
        let width = mesh.influences.per_vertex;
        let weights = normalized_weights(&mesh.influences);
        let mut new_of_old = HashMap::new();
        for old in indices.iter().map(|index| *index as usize) {
            let new = *new_of_old.entry(old).or_insert_with(|| {
                self.vertices.push(Vertex {
                    position: mesh.positions[old],
                    normal: mesh.normals[old],
                    uv: mesh.uvs.get(old).copied().unwrap_or_default(),
                    color: colors[old],
                    marks: marks[old],
                });
                let range = old * width..(old + 1) * width;
                self.influences.entries.extend(&mesh.influences.entries[range.clone()]);
                self.influences.weights.extend(&weights[range]);
                // Saturation is out of reach: indices of 2^32 vertices are refused on upload.
                u32::try_from(self.vertices.len() - 1).unwrap_or(u32::MAX)
            });
            self.indices.push(new);
        }
    }

    pub(super) fn upload(
        &self,
        shared: &mut Shared,
        texture: Option<Rc<Texture>>,
        maps: MapTextures,
    ) -> Result<ModelPart, Error> {
        let (alpha, alpha_cutoff) = match self.like.alpha {
            AlphaMode::Opaque => (Alpha::Opaque, 0.0),
            AlphaMode::Mask { cutoff } => (Alpha::Masked, cutoff),
            AlphaMode::Blend => (Alpha::Blended, 0.0),
        };
        let [red, green, blue] = self.like.emissive;
        let surface = Surface {
            alpha_cutoff,
            normal_scale: self.like.normal_scale,
            occlusion_strength: self.like.occlusion_strength,
            unused: 0.0,
            emissive: Float4([red, green, blue, 0.0]),
        };
        let influences = most_influences(&self.influences);
        let skin = skin_bytes(&self.influences, influences);
        let vertices = [bytemuck::cast_slice(&self.vertices), &skin[..]];
        Ok(ModelPart {
            mesh: shared.skinned_mut(influences).add(&vertices, &self.indices)?,
            influences,
            surface: shared.surface(surface)?,
            texture,
            maps,
            emits: self.like.emissive != [0.0; 3],
            alpha,
            double_sided: self.like.double_sided,
            mirrored: self.like.mirrored,
        })
    }
}

/// Returns a factor from 0 to 1 in 1/255.
pub(super) fn byte(factor: f32) -> u8 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to a byte; a character's numbers are finite"
    )]
    let byte = (factor * 255.0).round().clamp(0.0, 255.0) as u8;
    byte
}

/// Returns the most influences of a vertex that have a weight, rounded up to 1, 2, 4 or 8.
/// Influences without weight must come last to be left out.
fn most_influences(influences: &Influences) -> u32 {
    let last = |weights: &[f32]| weights.iter().rposition(|w| *w != 0.0).map_or(1, |at| at + 1);
    let most = influences.weights.chunks(influences.per_vertex).map(last).max().unwrap_or(1);
    if most > 4 { 8 } else { u32::try_from(most.next_power_of_two()).unwrap_or(4) }
}

/// Returns the bytes of [`Influences4`], or of [`Influences8`] if a vertex has `most` > 4
/// influences with a weight.
fn skin_bytes(influences: &Influences, most: u32) -> Vec<u8> {
    let fours = influences.per_vertex / 4;
    let (entries, _) = influences.entries.as_chunks::<4>();
    let (weights, _) = influences.weights.as_chunks::<4>();
    let vertices = entries.chunks_exact(fours).zip(weights.chunks_exact(fours));
    if most > 4 {
        let data = vertices.map(|(entries, weights)| Influences8 {
            weights0: weights[0],
            weights1: weights[1],
            entries0: entries[0],
            entries1: entries[1],
        });
        bytemuck::pod_collect_to_vec(&data.collect::<Vec<_>>())
    } else {
        let data = vertices
            .map(|(entries, weights)| Influences4 { weights0: weights[0], entries0: entries[0] });
        bytemuck::pod_collect_to_vec(&data.collect::<Vec<_>>())
    }
}

/// Returns the weights, divided by their sum per vertex. In some files the sum is not 1, which
/// would scale the vertex towards the model's origin.
fn normalized_weights(influences: &Influences) -> Vec<f32> {
    let mut weights = influences.weights.clone();
    for vertex in weights.chunks_mut(influences.per_vertex) {
        let sum: f32 = vertex.iter().sum();
        if sum > 0.0 {
            vertex.iter_mut().for_each(|weight| *weight /= sum);
        }
    }
    weights
}
