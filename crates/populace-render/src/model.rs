//! A character on the graphics device: its meshes, materials and textures.

use std::rc::Rc;

use glam::Vec3;
use populace_character::{AlphaMode, Character, Image, Influences, Material, Mesh, Part};
use populace_model::Affine;

use crate::Error;
use crate::batch::{ModelInfo, determinant};
use crate::gl::{Buffer, BufferUse, Cull, Gl, Sampling, Texture};
use crate::layout::{Influences4, Influences8, Surface, Vertex};
use populace_device::layout::Float4;

/// Alpha mode of a material, without its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Alpha {
    Opaque,
    Masked,
    Blended,
}

/// Skinning influences of a mesh, four or eight per vertex.
pub(crate) enum Skin {
    Four(Buffer<Influences4>),
    Eight(Buffer<Influences8>),
}

/// One part of a character: a mesh with one material.
pub(crate) struct ModelPart {
    pub(crate) vertices: Buffer<Vertex>,
    pub(crate) skin: Skin,
    pub(crate) indices: Buffer<u32>,
    pub(crate) surface: Buffer<Surface>,
    pub(crate) texture: Rc<Texture>,
    pub(crate) alpha: Alpha,
    double_sided: bool,
    /// True if the rest pose mirrors the mesh, as a node with a negative scale does.
    mirrored: bool,
}

impl ModelPart {
    /// Returns the culling mode of the part. `instance_mirrored` is true if the instance's
    /// transform mirrors.
    pub(crate) fn cull(&self, instance_mirrored: bool) -> Cull {
        match (self.double_sided, self.mirrored != instance_mirrored) {
            (true, false) => Cull::Nothing,
            (true, true) => Cull::NothingMirrored,
            (false, false) => Cull::Back,
            (false, true) => Cull::BackMirrored,
        }
    }
}

/// A character on the graphics device.
pub(crate) struct Model {
    pub(crate) parts: Vec<ModelPart>,
    pub(crate) info: ModelInfo,
    /// Centre and radius in metres of the rest pose's bounding sphere, in model space.
    pub(crate) sphere: (Vec3, f32),
}

impl Model {
    /// Uploads all parts with triangles for which `hide` returns false.
    pub(crate) fn new(
        gl: &Rc<Gl>,
        character: &Character,
        hide: &dyn Fn(&Part) -> bool,
    ) -> Result<Self, Error> {
        let mut textures = Textures::new(gl)?;
        let mirrored = mirrored_entries(character);
        let (mut parts, mut triangles) = (Vec::new(), 0);
        for part in &character.parts {
            if part.mesh.indices.is_empty() || hide(part) {
                continue;
            }
            let material =
                part.material.map_or_else(Material::default, |m| character.materials[m].clone());
            let texture = textures.get(&material, &character.images)?;
            triangles += part.mesh.indices.len() / 3;
            parts.push(upload_part(
                gl,
                &part.mesh,
                &material,
                texture,
                is_mirrored(&part.mesh, &mirrored),
            )?);
        }
        let blended = parts.iter().any(|part| part.alpha == Alpha::Blended);
        let sphere = character.rest_bounds().map_or((Vec3::ZERO, 0.0), |bounds| {
            let (low, high) = (Vec3::from(bounds.low), Vec3::from(bounds.high));
            (0.5 * (low + high), 0.5 * low.distance(high))
        });
        Ok(Self {
            parts,
            info: ModelInfo { entry_count: character.palette.len(), triangles, blended },
            sphere,
        })
    }
}

fn upload_part(
    gl: &Rc<Gl>,
    mesh: &Mesh,
    material: &Material,
    texture: Rc<Texture>,
    mirrored: bool,
) -> Result<ModelPart, Error> {
    let limit = i32::MAX.unsigned_abs();
    if mesh.indices.len() as u64 > u64::from(limit) {
        let size = mesh.indices.len() as u64;
        return Err(Error::TooLarge {
            what: "the number of indices of a mesh",
            size,
            limit: u64::from(limit),
        });
    }
    let (alpha, alpha_cutoff) = match material.alpha {
        AlphaMode::Opaque => (Alpha::Opaque, 0.0),
        AlphaMode::Mask { cutoff } => (Alpha::Masked, cutoff),
        AlphaMode::Blend => (Alpha::Blended, 0.0),
    };
    let surface =
        Surface { base_color: Float4(material.base_color), alpha_cutoff, ..Surface::default() };
    let vertices: Vec<Vertex> = (0..mesh.positions.len())
        .map(|vertex| Vertex {
            position: mesh.positions[vertex],
            normal: mesh.normals[vertex],
            uv: mesh.uvs.get(vertex).copied().unwrap_or_default(),
            color: mesh.colors.get(vertex).copied().unwrap_or([1.0; 4]),
        })
        .collect();
    Ok(ModelPart {
        vertices: Buffer::with(gl, BufferUse::Static, &vertices, "upload a mesh's vertices")?,
        skin: upload_skin(gl, &mesh.influences)?,
        indices: Buffer::with(gl, BufferUse::Static, &mesh.indices, "upload a mesh's triangles")?,
        surface: Buffer::with(gl, BufferUse::Static, &[surface], "upload a material")?,
        texture,
        alpha,
        double_sided: material.double_sided,
        mirrored,
    })
}

fn upload_skin(gl: &Rc<Gl>, influences: &Influences) -> Result<Skin, Error> {
    let operation = "upload a mesh's influences";
    let (entries, _) = influences.entries.as_chunks::<4>();
    let weights = normalized_weights(influences);
    let (weights, _) = weights.as_chunks::<4>();
    let fours = entries
        .iter()
        .zip(weights)
        .map(|(&entries0, &weights0)| Influences4 { weights0, entries0 });
    if influences.per_vertex == 4 {
        let data: Vec<_> = fours.collect();
        return Ok(Skin::Four(Buffer::with(gl, BufferUse::Static, &data, operation)?));
    }
    let data: Vec<_> = entries
        .chunks_exact(2)
        .zip(weights.chunks_exact(2))
        .map(|(entries, weights)| Influences8 {
            weights0: weights[0],
            weights1: weights[1],
            entries0: entries[0],
            entries1: entries[1],
        })
        .collect();
    Ok(Skin::Eight(Buffer::with(gl, BufferUse::Static, &data, operation)?))
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

/// Cache of one character's textures: each is uploaded once.
struct Textures<'a> {
    gl: &'a Rc<Gl>,
    /// Texture of materials without one.
    white: Rc<Texture>,
    uploaded: Vec<(populace_character::Texture, Rc<Texture>)>,
}

impl<'a> Textures<'a> {
    fn new(gl: &'a Rc<Gl>) -> Result<Self, Error> {
        let pixel = Image { width: 1, height: 1, rgba: vec![255; 4] };
        let white = Rc::new(Texture::new(gl, &pixel, Sampling::default())?);
        Ok(Self { gl, white, uploaded: Vec::new() })
    }

    fn get(&mut self, material: &Material, images: &[Image]) -> Result<Rc<Texture>, Error> {
        let Some(wanted) = material.base_color_texture else {
            return Ok(Rc::clone(&self.white));
        };
        if let Some((_, texture)) = self.uploaded.iter().find(|(known, _)| *known == wanted) {
            return Ok(Rc::clone(texture));
        }
        let sampling = Sampling { wrap: [wanted.wrap_u, wanted.wrap_v], filter: wanted.filter };
        let texture = Rc::new(Texture::new(self.gl, &images[wanted.image], sampling)?);
        self.uploaded.push((wanted, Rc::clone(&texture)));
        Ok(texture)
    }
}

/// Returns for each palette entry if `model_from_bind` mirrors in the rest pose.
fn mirrored_entries(character: &Character) -> Vec<bool> {
    let skeleton = &character.skeleton;
    let mut models: Vec<Affine> = Vec::with_capacity(skeleton.joint_count());
    for joint in skeleton.joints() {
        let local = Affine::from_trs(skeleton.rest(joint));
        let model =
            skeleton.parent(joint).map_or(local, |parent| models[parent.index()].mul(&local));
        models.push(model);
    }
    let mirrors = |m: &Affine| determinant(m) < 0.0;
    character
        .palette
        .iter()
        .map(|e| mirrors(&models[e.joint.index()].mul(&e.joint_from_bind)))
        .collect()
}

/// Returns true if mirroring palette entries have most of the mesh's skinning weight.
fn is_mirrored(mesh: &Mesh, mirrored_entries: &[bool]) -> bool {
    let influences = mesh.influences.entries.iter().zip(&mesh.influences.weights);
    let excess: f32 = influences
        .map(
            |(&entry, &weight)| if mirrored_entries[usize::from(entry)] { weight } else { -weight },
        )
        .sum();
    excess > 0.0
}
