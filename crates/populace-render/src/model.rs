//! A character on the graphics device: its meshes, materials and textures.

mod contacts;
mod maps;

use std::rc::Rc;

use glam::Vec3;
use populace_character::{
    AlphaMode, Character, Image, Influences, Material, Mesh, Part, RegionFinder,
};
use populace_device::layout::Float4;
use populace_model::Affine;

use crate::Error;
use crate::batch::{ModelInfo, determinant};
use crate::gl::{Buffer, BufferUse, Coding, Cull, Gl, Sampling, Texture};
use crate::layout::{Bytes4, Influences4, Influences8, Surface, Vertex};

pub(crate) use contacts::Contacts;
pub(crate) use maps::{MapTextures, Maps};

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

/// Parts of a character at one level of detail that are drawn together: triangles with the same
/// textures and one way to draw them. Factors of materials are in the vertices.
pub(crate) struct ModelPart {
    pub(crate) vertices: Buffer<Vertex>,
    pub(crate) skin: Skin,
    /// Most influences of a vertex that have a weight: 1, 2, 4 or 8.
    pub(crate) influences: u32,
    pub(crate) indices: Buffer<u32>,
    pub(crate) surface: Buffer<Surface>,
    pub(crate) texture: Option<Rc<Texture>>,
    pub(crate) maps: MapTextures,
    /// True if the surface emits light.
    emits: bool,
    pub(crate) alpha: Alpha,
    pub(crate) double_sided: bool,
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

/// A character's meshes at one level of detail.
pub(crate) struct ModelLevel {
    pub(crate) parts: Vec<ModelPart>,
    /// See [`Level::error_m`](populace_character::Level::error_m); 0 for the character itself.
    pub(crate) error_m: f32,
    /// True if its triangles are so small in pictures that light at their corners is enough.
    pub(crate) is_coarse: bool,
}

/// A level with at least this error, in heights of the character, is coarse. It is drawn where a
/// body covers fewer than 200 pixels, if errors are below a pixel.
const COARSE: f32 = 0.005;

/// Radius in metres beyond which a character is a place, such as a house.
const PLACE_M: f32 = 4.0;

/// A character on the graphics device.
pub(crate) struct Model {
    /// Levels of detail, finest first; at least one.
    pub(crate) levels: Vec<ModelLevel>,
    pub(crate) contacts: Contacts,
    pub(crate) info: ModelInfo,
    /// Centre and radius in metres of the rest pose's bounding sphere, in model space.
    pub(crate) sphere: (Vec3, f32),
}

impl Model {
    /// Uploads all parts with triangles for which `hide` returns false, at all levels.
    pub(crate) fn new(
        gl: &Rc<Gl>,
        character: &Character,
        hide: &dyn Fn(&Part) -> bool,
    ) -> Result<Self, Error> {
        let mut textures = Textures { gl, uploaded: Vec::new() };
        let mirrored = mirrored_entries(character);
        let regions = RegionFinder::new(character);
        let shown: Vec<usize> =
            (0..character.parts.len()).filter(|part| !hide(&character.parts[*part])).collect();
        let own = shown.iter().map(|part| (*part, &character.parts[*part].mesh)).collect();
        let mut meshes: Vec<(f32, Vec<(usize, &Mesh)>)> = vec![(0.0, own)];
        for level in character.levels() {
            let of_level = shown.iter().map(|part| (*part, &level.meshes[*part])).collect();
            meshes.push((level.error_m, of_level));
        }
        let mut levels = Vec::with_capacity(meshes.len());
        for (error_m, meshes) in meshes {
            let mut drawn: Vec<DrawnTogether> = Vec::new();
            for (part, mesh) in meshes.into_iter().filter(|(_, mesh)| !mesh.indices.is_empty()) {
                let material = character.parts[part].material;
                let material =
                    material.map_or_else(Material::default, |m| character.materials[m].clone());
                let like = Likeness::of(part, mesh, &material, is_mirrored(mesh, &mirrored));
                let index = drawn.iter().position(|d| d.like == like).unwrap_or_else(|| {
                    drawn.push(DrawnTogether::new(like));
                    drawn.len() - 1
                });
                let regions = regions.regions(part, mesh);
                let option = character.option_of(part).map_or(0, |option| option + 1);
                let option = u8::try_from(option).unwrap_or(0);
                let [metallic, roughness] = [material.metallic, material.roughness].map(byte);
                let marks = regions.iter().map(|r| [r.number(), option, metallic, roughness]);
                drawn[index].append(mesh, &material, marks);
            }
            let mut parts = Vec::with_capacity(drawn.len());
            for together in &drawn {
                let (texture, maps) = textures.of(&together.like, &character.images)?;
                parts.push(together.upload(gl, texture, maps)?);
            }
            let is_coarse = error_m >= COARSE * character.height_m() && error_m > 0.0;
            levels.push(ModelLevel { parts, error_m, is_coarse });
        }
        let blended = levels[0].parts.iter().any(|part| part.alpha == Alpha::Blended);
        let sphere = character.rest_bounds().map_or((Vec3::ZERO, 0.0), |bounds| {
            let (low, high) = (Vec3::from(bounds.low), Vec3::from(bounds.high));
            (0.5 * (low + high), 0.5 * low.distance(high))
        });
        let info = ModelInfo {
            entry_count: character.palette.len(),
            level_count: u32::try_from(levels.len()).unwrap_or(u32::MAX),
            blended,
            is_place: sphere.1 > PLACE_M,
        };
        let contacts = Contacts::new(gl, character, hide)?;
        Ok(Self { levels, contacts, info, sphere })
    }

    /// Returns the coarsest level with an error of at most `error_m`.
    pub(crate) fn level_within(&self, error_m: f32) -> u32 {
        let finer = self.levels.iter().filter(|level| level.error_m <= error_m).count();
        u32::try_from(finer.saturating_sub(1)).unwrap_or_default()
    }
}

/// What parts have in common that are drawn together.
#[derive(Clone, Copy, PartialEq)]
struct Likeness {
    texture: Option<populace_character::Texture>,
    /// Substance, normal, occlusion and emitted light.
    maps: [Option<populace_character::Texture>; 4],
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
    fn of(part: usize, mesh: &Mesh, material: &Material, mirrored: bool) -> Self {
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
}

/// The triangles of parts that are drawn together.
struct DrawnTogether {
    like: Likeness,
    vertices: Vec<Vertex>,
    influences: Influences,
    indices: Vec<u32>,
}

impl DrawnTogether {
    fn new(like: Likeness) -> Self {
        let (entries, weights) = (Vec::new(), Vec::new());
        let influences = Influences { per_vertex: like.per_vertex, entries, weights };
        Self { like, vertices: Vec::new(), influences, indices: Vec::new() }
    }

    fn append(&mut self, mesh: &Mesh, material: &Material, marks: impl Iterator<Item = Bytes4>) {
        // Saturation is out of reach: indices of 2^32 vertices are refused on upload.
        let first = u32::try_from(self.vertices.len()).unwrap_or(u32::MAX);
        self.vertices.extend((0..mesh.positions.len()).zip(marks).map(|(vertex, marks)| {
            let color = mesh.colors.get(vertex).copied().unwrap_or([1.0; 4]);
            Vertex {
                position: mesh.positions[vertex],
                normal: mesh.normals[vertex],
                uv: mesh.uvs.get(vertex).copied().unwrap_or_default(),
                color: [0, 1, 2, 3].map(|c: usize| material.base_color[c] * color[c]),
                marks,
            }
        }));
        self.influences.entries.extend(&mesh.influences.entries);
        self.influences.weights.extend(normalized_weights(&mesh.influences));
        self.indices.extend(mesh.indices.iter().map(|index| first.saturating_add(*index)));
    }

    fn upload(
        &self,
        gl: &Rc<Gl>,
        texture: Option<Rc<Texture>>,
        maps: MapTextures,
    ) -> Result<ModelPart, Error> {
        let (size, limit) = (self.indices.len() as u64, u64::from(i32::MAX.unsigned_abs()));
        if size > limit {
            return Err(Error::TooLarge { what: "the number of indices of a mesh", size, limit });
        }
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
        let (vertices, indices) = (&self.vertices, &self.indices);
        Ok(ModelPart {
            vertices: Buffer::with(gl, BufferUse::Static, vertices, "upload a mesh's vertices")?,
            skin: upload_skin(gl, &self.influences)?,
            influences: most_influences(&self.influences),
            indices: Buffer::with(gl, BufferUse::Static, indices, "upload a mesh's triangles")?,
            surface: Buffer::with(gl, BufferUse::Static, &[surface], "upload a material")?,
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
fn byte(factor: f32) -> u8 {
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

fn upload_skin(gl: &Rc<Gl>, influences: &Influences) -> Result<Skin, Error> {
    let operation = "upload a mesh's influences";
    let (entries, _) = influences.entries.as_chunks::<4>();
    let (weights, _) = influences.weights.as_chunks::<4>();
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
    uploaded: Vec<((populace_character::Texture, Coding), Rc<Texture>)>,
}

impl Textures<'_> {
    /// Returns the texture of the base colour, and the others.
    fn of(
        &mut self,
        like: &Likeness,
        images: &[Image],
    ) -> Result<(Option<Rc<Texture>>, MapTextures), Error> {
        let mut get = |wanted: Option<populace_character::Texture>, coding| {
            wanted.map(|wanted| self.get((wanted, coding), images)).transpose()
        };
        let [substance, normal, occlusion, emissive] = like.maps;
        let maps = [
            get(substance, Coding::Linear)?,
            get(normal, Coding::Linear)?,
            get(occlusion, Coding::Linear)?,
            get(emissive, Coding::Srgb)?,
        ];
        Ok((get(like.texture, Coding::Srgb)?, maps))
    }

    fn get(
        &mut self,
        wanted: (populace_character::Texture, Coding),
        images: &[Image],
    ) -> Result<Rc<Texture>, Error> {
        if let Some((_, texture)) = self.uploaded.iter().find(|(known, _)| *known == wanted) {
            return Ok(Rc::clone(texture));
        }
        let (texture, coding) = wanted;
        let wrap = [texture.wrap_u, texture.wrap_v];
        let sampling = Sampling { wrap, filter: texture.filter, coding };
        let texture = Rc::new(Texture::new(self.gl, &images[texture.image], sampling)?);
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
