//! A character on the graphics device: its meshes, materials and textures.

mod baked;
mod contacts;
mod maps;
mod shared;
mod sides;
mod together;

use std::rc::Rc;

use glam::{Vec3, Vec4};
use populace_character::{AlphaMode, Character, Image, Material, Mesh, Part, RegionFinder};

use crate::Error;
use crate::batch::ModelInfo;
use crate::gl::{Buffer, Coding, Cull, Gl, MeshPlace, Sampling, Texture};
use crate::layout::{Bytes4, Surface, Vector4};

pub(crate) use contacts::Contacts;
pub(crate) use maps::{MapTextures, Maps};
pub(crate) use shared::Shared;
use together::{DrawnTogether, Likeness, byte};

/// Alpha mode of a material, without its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Alpha {
    Opaque,
    Masked,
    Blended,
}

/// Parts of a character at one level of detail that are drawn together: triangles with the same
/// textures and one way to draw them. Factors of materials are in the vertices.
pub(crate) struct ModelPart {
    pub(crate) mesh: MeshPlace,
    /// Most influences of a vertex that have a weight: 1, 2, 4 or 8.
    pub(crate) influences: u32,
    pub(crate) surface: Rc<Buffer<Surface>>,
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
    /// True if its triangles are so small in pictures that light at their corners is enough.
    pub(crate) is_coarse: bool,
}

/// A level with at least this error, in heights of the character, is coarse. It is drawn where a
/// body covers fewer than 200 pixels, if errors are below a pixel.
const COARSE: f32 = 0.005;

/// A level with at least this error, in heights of the character, has opaque textures in the colours
/// of its vertices. It is drawn where a body covers fewer than 50 pixels, and an eye less than one,
/// if errors are below a pixel.
const BAKED: f32 = 0.02;

/// Radius in metres beyond which a character is a place, such as a house.
const PLACE_M: f32 = 4.0;
/// Radius in heights from which on a place is a floor.
const FLOOR: f32 = 8.0;

/// A character on the graphics device.
pub(crate) struct Model {
    /// Levels of detail, finest first; at least one.
    pub(crate) levels: Vec<ModelLevel>,
    pub(crate) contacts: Contacts,
    pub(crate) info: ModelInfo,
}

impl Model {
    /// Uploads all parts with triangles for which `hide` returns false, at all levels.
    pub(crate) fn new(
        gl: &Rc<Gl>,
        shared: &mut Shared,
        character: &Character,
        hide: &dyn Fn(&Part) -> bool,
    ) -> Result<Self, Error> {
        let mut textures = Textures { gl, uploaded: Vec::new() };
        let surfaces = Surfaces::of(character);
        let shown: Vec<usize> =
            (0..character.parts.len()).filter(|part| !hide(&character.parts[*part])).collect();
        let own = shown.iter().map(|part| (*part, &character.parts[*part].mesh)).collect();
        let mut meshes: Vec<(f32, Vec<(usize, &Mesh)>)> = vec![(0.0, own)];
        for level in character.levels() {
            let of_level = shown.iter().map(|part| (*part, &level.meshes[*part])).collect();
            meshes.push((level.error_m, of_level));
        }
        let level_errors_m = meshes.iter().map(|(error_m, _)| *error_m).collect();
        let mut levels = Vec::with_capacity(meshes.len());
        for (error_m, meshes) in meshes {
            let is_coarse = error_m >= COARSE * character.size_m() && error_m > 0.0;
            let is_baked = is_coarse && error_m >= BAKED * character.size_m();
            let drawn = surfaces.drawn_together(&meshes, is_coarse, is_baked);
            let mut parts = Vec::with_capacity(drawn.len());
            for together in &drawn {
                let (texture, maps) = textures.of(&together.like, &character.images)?;
                parts.push(together.upload(shared, texture, maps)?);
            }
            levels.push(ModelLevel { parts, is_coarse });
        }
        let blended = levels[0].parts.iter().any(|part| part.alpha == Alpha::Blended);
        let (mut sphere, mut height_m) = ((Vec3::ZERO, 0.0), 0.0);
        if let Some(bounds) = character.rest_bounds() {
            let (low, high) = (Vec3::from(bounds.low), Vec3::from(bounds.high));
            sphere = (0.5 * (low + high), 0.5 * low.distance(high));
            height_m = high.y - low.y;
        }
        let info = ModelInfo {
            entry_count: character.palette.len(),
            level_errors_m,
            blended,
            is_place: sphere.1 > PLACE_M,
            is_floor: sphere.1 > PLACE_M.max(FLOOR * height_m),
            sphere,
        };
        let contacts = Contacts::new(shared, character, hide)?;
        Ok(Self { levels, contacts, info })
    }
}

/// What a character's parts look like at all levels of detail.
struct Surfaces<'a> {
    character: &'a Character,
    regions: RegionFinder<'a>,
    /// For each part, whether the rest pose mirrors it.
    mirrored: Vec<bool>,
}

impl<'a> Surfaces<'a> {
    fn of(character: &'a Character) -> Self {
        let mirrored = (0..character.parts.len()).map(|part| character.is_mirrored(part)).collect();
        Self { character, regions: RegionFinder::new(character), mirrored }
    }

    /// Sorts meshes of parts by how they are drawn. With `is_baked`, colours of vertices replace
    /// opaque textures.
    fn drawn_together(
        &self,
        meshes: &[(usize, &Mesh)],
        is_coarse: bool,
        is_baked: bool,
    ) -> Vec<DrawnTogether> {
        let character = self.character;
        let mut drawn: Vec<DrawnTogether> = Vec::new();
        for &(part, mesh) in meshes.iter().filter(|(_, mesh)| !mesh.indices.is_empty()) {
            let material = character.parts[part].material;
            let mut material =
                material.map_or_else(Material::default, |m| character.materials[m].clone());
            if is_coarse {
                material = without_details(material);
            }
            let colors = self.colors(mesh, &mut material, is_baked);
            let regions = self.regions.regions(part, mesh);
            let option = character.option_of(part).map_or(0, |option| option + 1);
            let option = u8::try_from(option).unwrap_or(0);
            let [metallic, roughness] = [material.metallic, material.roughness].map(byte);
            let marks: Vec<Bytes4> =
                regions.iter().map(|r| [r.number(), option, metallic, roughness]).collect();
            let like = Likeness::of(part, mesh, &material, self.mirrored[part]);
            for (like, indices) in like.by_sides(mesh, is_coarse) {
                let index = drawn.iter().position(|d| d.like == like).unwrap_or_else(|| {
                    drawn.push(DrawnTogether::new(like));
                    drawn.len() - 1
                });
                drawn[index].append(mesh, &indices, &colors, &marks);
            }
        }
        drawn
    }

    /// Returns the colours of a mesh's vertices: those of the material times those of the mesh.
    /// With `is_baked`, an opaque texture is in them too, and is taken out of the material.
    fn colors(&self, mesh: &Mesh, material: &mut Material, is_baked: bool) -> Vec<Vector4> {
        let base = Vec4::from(material.base_color);
        let of_vertex = |vertex| mesh.colors.get(vertex).map_or(base, |c| base * Vec4::from(*c));
        let mut colors: Vec<Vec4> = (0..mesh.positions.len()).map(of_vertex).collect();
        let is_replaced = is_baked && material.alpha == AlphaMode::Opaque && !mesh.uvs.is_empty();
        if let Some(texture) = material.base_color_texture.take_if(|_| is_replaced) {
            let image = &self.character.images[texture.image];
            for (color, baked) in colors.iter_mut().zip(baked::colors(mesh, &texture, image)) {
                *color *= baked.extend(1.0);
            }
        }
        colors.into_iter().map(|color| color.to_array()).collect()
    }
}

/// Takes out of a material what only light at each pixel needs.
fn without_details(material: Material) -> Material {
    Material {
        metallic_roughness_texture: None,
        normal_texture: None,
        normal_scale: 1.0,
        occlusion_texture: None,
        occlusion_strength: 1.0,
        ..material
    }
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
